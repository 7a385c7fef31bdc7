"""From a YAML file to a study, with all mistakes reported at once."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from operator import attrgetter
from pathlib import Path

from fretwear.study.case import Case, case_keys
from fretwear.study.designs import Axis, axes_of
from fretwear.study.materials import MATERIAL
from fretwear.study.mistakes import Mistake, Mistakes, StudyError, few_of, nearest_key
from fretwear.study.sections import study_form, study_schema, study_sections
from fretwear.study.short_forms import long_form
from fretwear.study.study import Point, Study, as_mapping
from fretwear.study.yamlfile import parse_value, read_document
from fretwear.units import QuantityError, did_you_mean

OPTION = "--set"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")


def load_study(path: str | Path, assignments: Sequence[str] = ()) -> Study:
    """Read and check a study file (YAML), changed by assignments ``name=value``.

    Raises
    ------
    StudyError
        If the file or the assignments are invalid; the message lists all mistakes.
    """
    file = Path(path)
    document = read_document(file)
    mistakes = Mistakes(document.mistakes)
    if not _NAME.fullmatch(file.stem):
        rule = "must have up to 100 letters, digits, '.', '_' and '-', a letter or digit first"
        mistakes.add("", None, f"the name of the file {rule}")
    if not isinstance(document.data, Mapping):
        raise StudyError(file, [Mistake("", document.data, "must hold keys such as base and vary")])
    return _checked(file, document.data, assignments, mistakes, document.lines)


def select_point(
    study: Study, case_id: str | None = None, assignments: Sequence[str] = ()
) -> Point:
    """Return the point of a case, changed by assignments ``name=value``.

    An id, or the beginning of exactly one id, chooses the case; the assignments then change it.
    Without an id the study must have a single case. Raises `StudyError` if the changed case is
    invalid, or there is no such case.
    """
    points = {point.id: point for point in study.points() if point.id}
    matching = [n for n in points if n.startswith(case_id or "")]
    if case_id in points:
        matching = [case_id]
    if len(matching) == 1:
        point = points[matching[0]]
        if case_id and assignments:
            content = content_of(point)
            (point,) = _checked(study.file, content, assignments).points()
        return point
    rule = f"chooses {len(matching)} of the {len(points)} cases of this study"
    ids = "".join(f"\n    {n}" for n in few_of(matching))
    hint = f"give --case ID, one of{ids}\n    all of them: snakemake --config study={study.name}"
    if not matching:
        hint = did_you_mean(case_id, points) or "fretwear plan lists the cases"
    raise StudyError(study.file, [Mistake("--case", case_id, rule, hint)])


def content_of(point: Point) -> dict[str, object]:
    """The plain content of a study with a single point."""
    content = {**point.study.content}
    for axis, position in zip(point.study.axes, point.index, strict=True):
        assign(content, axis.name, axis.written[position])
    return {key: value for key, value in content.items() if key not in point.study.added}


def case_of_content(file: Path, content: Mapping[str, object]) -> Case:
    """The case from the plain content of a single point; `StudyError` if it is invalid."""
    (point,) = _checked(file, content, ()).points()
    assert point.case is not None
    return point.case


def override(
    raw: Mapping[str, object], assignments: Iterable[str]
) -> tuple[dict[str, object], Mistakes]:
    """Return plain content changed by assignments ``name=value``, and mistakes of the assignments.

    The new value replaces the value in `base`, and the parameter is no longer varied. Setting one
    of several alternative keys, such as the two tangential ones, drops the others; keys that belong
    to both, such as `rig_stiffness`, stay. ``output.cycles`` and ``title`` can be set too.
    """
    changed, mistakes = {**raw}, Mistakes()
    valid = (*case_keys().all_names, MATERIAL, "output.cycles", "title")
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        name = name.strip()
        if not equals:
            mistakes.add(OPTION, assignment, "must have the form name=value")
        elif name not in valid:
            hint = nearest_key(name, valid)
            mistakes.add(f"{OPTION} {name}", text, "is not a parameter", hint)
        else:
            try:
                assign(changed, name, parse_value(text))
            except QuantityError as error:
                mistakes.add(f"{OPTION} {name}", text, error.rule, error.hint)
    return changed, mistakes


def assign(content: dict[str, object], name: str, value: object) -> None:
    """Set a parameter in the plain content of a study file to one value, as `override` does."""
    whole, _, part = name.partition(".")
    if whole in ("title", "output"):
        content[whole] = {**as_mapping(content.get(whole)), part: value} if part else value
        return
    gone = case_keys().replaced_by(name)
    replaced = tuple(f"{key}." for key in (*gone, name))
    base, vary = (as_mapping(content.get(section)) for section in ("base", "vary"))
    base = {key: entry for key, entry in base.items() if key not in gone}
    vary = {key: entry for key, entry in vary.items() if not f"{key}.".startswith(replaced)}
    if part and whole in vary:
        raise QuantityError(f"cannot be set while vary.{whole} varies the whole of it")
    base[whole] = {**as_mapping(base.get(whole)), part: value} if part else value
    content |= {"base": base, "vary": vary}
    if not vary:  # a sampled design without parameters would be an error
        content.pop("design", None)


def _checked(
    file: Path,
    plain: Mapping[str, object],
    assignments: Sequence[str],
    earlier: Sequence[Mistake] = (),
    lines: Mapping[str, int] | None = None,
) -> Study:
    """Turn the plain content of a study file, changed by assignments, into a `Study`."""
    content, mistakes = override(plain, assignments)
    mistakes[:0] = earlier
    base, vary = (as_mapping(content.get(section)) for section in ("base", "vary"))
    for place, section in study_sections():
        *outer, key = place.split(".")
        enclosing = as_mapping(content.get(outer[0])) if outer else content
        if key in enclosing:
            base = section.complete_base(enclosing[key], base, vary, mistakes)
    content |= {"base": base} if base else {}
    full = long_form(base, vary)
    written = {**content, "base": full} if base or "base" not in content else content
    found, form = Mistakes(), study_form(vary)
    sections = found.read(form, written, study_schema, file.parent, ("base", "vary"))
    mistakes += _at_varied(found, vary)
    axes: tuple[Axis, ...] = ()
    if "design" in sections.model_fields_set or "design" not in content:
        axes = axes_of(sections.vary, vary, sections.design, mistakes)
    fixed = {n: value for n, value in sections.base.items() if n not in {*vary, MATERIAL}}
    keys = {*full, *(name.partition(".")[0] for name in vary)}
    known = {*fixed, *(axis.name for axis in axes)}
    unread = case_keys().unread(keys, known)
    read = {place: attrgetter(place)(sections) for place, _ in study_sections()}
    added = {place: section for place, section in read.items() if section is not None}
    snapshots = sections.output.cycles
    if needed := [section.cycles for section in added.values() if section.cycles is not None]:
        snapshots = tuple(sorted({*(snapshots or ()), *chain(*needed)}))
    settings = snapshots, sections.batch, added
    title = sections.title or file.stem
    study = Study(file, title, axes, sections.design, fixed, content, *settings, unread=unread)
    _try_points(study, mistakes, sections.invalid == "skip")
    if not mistakes and len(study.invalid) == study.size:
        mistakes.add("vary", None, f"leaves no point to run: {next(iter(study.invalid.values()))}")
    for given_section in added.values() if not mistakes else ():
        given_section.check([point.case for point in study.points()], mistakes)
    if mistakes:
        raise StudyError(file, _in_order(mistakes, lines or {}, assignments))
    return study


def _at_varied(mistakes: Mistakes, vary: Mapping[str, object]) -> Iterator[Mistake]:
    """Mistakes in the first value of a varied field, reported once, where it is varied."""
    told = [mistake.key for mistake in mistakes]
    for mistake in mistakes:
        name = mistake.key.removeprefix("base.")
        if name not in vary or "." not in name:
            yield mistake
        elif not any(key.startswith(f"vary.{name}") for key in told):
            yield replace(mistake, key=f"vary.{name}")


def _try_points(study: Study, mistakes: Mistakes, skip: bool) -> None:
    """Check the rules between parameters; with `skip`, mark points that break one as invalid.

    A broken rule is reported once, for the first point.
    """
    broken: dict[tuple[str, str], list[tuple[Mistake, str]]] = {}
    for point in study.points():
        wrong = point.mistakes
        if wrong and skip and study.axes:
            study.invalid[point.index] = wrong[0].sentence
        elif wrong:
            for mistake in wrong:
                placed, where = _placed(mistake, point)
                kind = placed.key.partition("[")[0], re.sub(r"[\d.e+-]+", "#", mistake.rule)
                broken.setdefault(kind, []).append((placed, where))
    for (first, where), *others in broken.values():
        more = f" and at {len(others)} more points" if others else ""
        is_everywhere = not where or len(others) + 1 == study.size
        rule = first.rule if is_everywhere else f"{first.rule} (at {where}{more})"
        mistakes.append(replace(first, rule=rule))


def _placed(mistake: Mistake, point: Point) -> tuple[Mistake, str]:
    """The mistake under the key that set the value, with the point's other varied values."""
    name = mistake.key
    key = "output.cycles" if name == "output_cycles" else f"base.{name}"
    others = []
    for axis, position in zip(point.study.axes, point.index, strict=True):
        if f"{name}.".startswith(f"{axis.name.partition('.')[0]}."):
            key = f"vary.{axis.name}" + (f"[{position}]" if axis.drawn_from is None else "")
        else:
            others.append(f"{axis.name} = {axis.labels[position]}")
    return replace(mistake, key=key), ", ".join(others)


def _in_order(
    mistakes: Iterable[Mistake], lines: Mapping[str, int], assignments: Sequence[str]
) -> list[Mistake]:
    """Give each mistake the line of its key or the option that set it, and sort them by line."""
    names = [assignment.partition("=")[0].strip() for assignment in assignments]
    shown = {place: f"{OPTION} {name}" for name in names for place in (f"base.{name}", name)}
    told: dict[tuple[str, str], Mistake] = {}
    for mistake in mistakes:
        key = mistake.key
        for place, name in shown.items():
            if f"{key}.".startswith((f"{place}.", f"{place}[")):
                key = name + key.removeprefix(place)
        line, whole = mistake.line or lines.get(key), key
        while line is None and whole:  # the line of the mapping that lacks a key
            whole = whole[: max(whole.rfind("."), whole.rfind("["), 0)]
            line = lines.get(whole) if whole else None
        told[key, mistake.rule] = replace(mistake, key=key, line=line)
    return sorted(told.values(), key=lambda one: one.line or len(lines) * 1000)
