"""The report of a study, assembled from its sections."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from markupsafe import Markup
from ruamel.yaml import YAML

import fretwear
from fretwear.data.effects import results_table
from fretwear.data.merge import remarks_on_summary
from fretwear.figures.index import ANSWER_CATEGORY, read_figure_index
from fretwear.report.answer import answers, regimes
from fretwear.report.explorer import build_explorer, evenly
from fretwear.report.page import Section, embedded, environment, macros, page_scripts
from fretwear.report.results import (
    PointResult,
    computation_facts,
    display_units,
    examine,
    levels_of,
    over_seeds,
    point_results,
    result_variable,
)
from fretwear.run.cases import failures
from fretwear.study.case import Case
from fretwear.study.doubts import SMALL_ERROR, Doubt, finer
from fretwear.study.parameters import parameter, value_text
from fretwear.study.plan import Plan
from fretwear.study.problems import StudyError
from fretwear.study.study import Study
from fretwear.study.yamlfile import read_document
from fretwear.units import (
    cycle_text,
    fixed_digits,
    in_unit,
    listed,
    number_text,
    span,
    with_error,
)
from fretwear.vocabulary import RESULTS

if TYPE_CHECKING:
    import xarray as xr

_MOST_ROWS = 2000
_MOST_EXAMINED = 12
_MOST_LISTED = 12
_NUMERICS = {"cell_x", "cell_y", "tolerance", "slip_model", "error_estimate"}


def build_report(
    plan: Plan,
    summary: xr.Dataset,
    folder: Path,
    *,
    sections: Iterable[Section] = (),
    tell: Callable[[str], None] = lambda _: None,
) -> str:
    """Build the report of a study as one self-contained HTML page, which loads no other file.

    The results `folder` holds the merged study; the case files in ``cases``; the figures with their
    index, from `fretwear.figures.study.write_study_figures`, in ``figures``; and perhaps ``logs``
    and ``benchmarks``. More `sections` come after the figures. `tell` takes every doubt.

    Raises a `DataFileError` if a file is missing, or the summary belongs to another study or to an
    earlier state of the study of the plan.
    """
    reasons = failures(folder / "cases")
    results = point_results(plan, summary, reasons)
    explorer = build_explorer(plan, results, folder)
    scripts = page_scripts(with_explorer=explorer is not None)
    cases, parameters = plan.study.cases().values(), parameter_rows(plan)
    kinds = _kinds(cases)
    ids = list(dict.fromkeys(result.id for result in results if result.done))
    examined = [ids[place] for place in evenly(len(ids), _MOST_EXAMINED)]
    numerics = [examine(folder / "cases" / f"{case_id}.nc") for case_id in examined]
    facts = {
        "Slip model": ", ".join(sorted({case.slip_model.kind for case in cases})),
        **computation_facts(numerics, len(ids)),
    }
    images = embedded(folder / "figures", read_figure_index(folder / "figures"))
    answering = [image for image in images if image.entry.category == ANSWER_CATEGORY]
    if not any(image.uri for image in answering):
        # The scar of a case or, in a line contact, its wear over the cycles.
        by_name = {image.entry.name: image for image in images if image.uri}
        scars = [image for name, image in by_name.items() if name.startswith("wear_map")]
        lead = next(iter(scars), by_name.get("wear_volume"))
        answering = [image for image in (lead, *answering) if image is not None]
    others = [image for image in images if image not in answering]
    undone = [result for result in results if not result.done][:_MOST_ROWS]
    bodies = macros()

    def section(name: str, title: str, *content: object, entry: str = "") -> Section:
        return Section(name, title, Markup(bodies[name](*content)), entry)

    heading, entry = ("What mattered", "Answer") if len(ids) > 1 else ("Results", "Results")
    doubts, remarks, *answered = _answer(plan, summary, results)
    page = [section("answer", heading, doubts, remarks, *answered, answering, entry=entry)]
    for doubt, numbers in doubts.items():
        cases_of = f"{len(numbers)} case{'s' * (len(numbers) != 1)}"
        tell(f"doubt: in {cases_of} the contact {doubt.what}; {doubt.remedy}")
    for remark in remarks:
        tell(f"doubt: {remark}")
    if explorer:
        page.append(section("explorer", "Explorer", explorer, scripts.plotly, kinds, len(results)))
    explored = explorer.numbers if explorer else ()
    varied = [row for row in parameters if row.choices]
    csv = base64.b64encode(results_table(summary).encode("utf-8")).decode("ascii")
    table = (varied, *_cases(results), explored, csv)
    page += [
        section("parameters", "Parameters", parameters),
        section("cases", "Cases and key results", *table, entry="Cases"),
    ]
    if others:
        page.append(section("figures", "Figures", others, len(answering)))
    page += sections
    if undone:
        page.append(section("undone", "Points without results", undone, entry="Without results"))
    how = (facts, plan.study.file.name, study_text(plan.study), kinds)
    page += [
        section("computation", "How it was computed", *how, entry="Computation"),
        section("limits", "Limits of the model", kinds, entry="Limits"),
        section("glossary", "Glossary", kinds),
    ]
    shell = environment().get_template("report.html.j2")
    return shell.render(
        title=plan.study.title,
        name=plan.study.name,
        version=fretwear.__version__,
        lead=_lead(plan, results),
        scripts=scripts,
        sections=page,
    )


def _answer(
    plan: Plan, summary: xr.Dataset, results: Sequence[PointResult]
) -> tuple[Mapping[Doubt, Mapping[str, str]], list[str], object, object]:
    """Return doubts, remarks, the answers of the study, and a note on the regimes of slip."""
    by_result, together = list(answers(summary)), regimes(summary)
    if len(results) > 1 and not any(answer.headline or answer.lines for answer in by_result):
        together = f"There are no two cases that differ in one parameter alone. {together}".strip()
    remarks = remarks_on_summary(summary)
    errors = [
        (error, name, result.id) for result in results for name, error in result.errors.items()
    ]
    if marked := [entry for entry in errors if entry[0] > SMALL_ERROR]:
        error, name, case_id = max(marked)
        remarks.append(
            f"{len(marked)} of {len(errors)} key results have estimated errors above "
            f"{100.0 * SMALL_ERROR:g} %: they are marked in the table of cases. The largest is "
            f"{100.0 * error:.0f} %, in the {RESULTS[name].words} of {case_id}; "
            f"{finer(plan.study.cases()[case_id], error)}"
        )
    return plan.doubts, remarks, by_result, together


def _kinds(cases: Iterable[Case]) -> set[str]:
    """Return the kinds of cases that need texts of their own."""
    kinds: set[str] = set()
    for case in cases:
        kinds.add("debris" if case.debris_fraction else "no debris")
        kinds.add(case.roughness.kind if case.roughness else "smooth")
        kinds.add(case.frame.name)
        is_vector = case.slip_model.couples and len(case.frame.axes) > 1
        kinds.add("two directions" if is_vector else "one direction")
        kinds.add("stroke" if case.loading.stroke else "force" if case.force_is_held else "varying")
        kinds.add(case.geometry.__name__.lower())
    return kinds


def _lead(plan: Plan, results: Sequence[PointResult]) -> str:
    """Return the cases that were run, in a sentence or two."""
    words = [parameter(axis.coordinate).words for axis in plan.study.axes]
    varied = ""
    if words and plan.study.design.kind == "grid":
        counts = [len(axis.values) for axis in plan.study.axes]
        values = [f"{name} ({n} values)" for name, n in zip(words, counts, strict=True)]
        varied = f": {'all combinations of' if len(words) > 1 else 'one for each'} {listed(values)}"
    elif words:
        varied = f", in which {listed(words)} {'vary' if len(words) > 1 else 'varies'}"
    done = sum(result.done for result in results)
    rest = "" if done == len(results) else f" Results exist for {done} of {len(results)} points."
    cycles = span({case.cycles for case in plan.study.cases().values()}, cycle_text)
    return f"{len(results)} case{'s' * (len(results) > 1)} of {cycles} cycles{varied}.{rest}"


class ParameterRow(NamedTuple):
    """A parameter of the study."""

    name: str  # in the study file; may be empty
    words: str
    values: str  # as many as can be listed
    choices: tuple[str, ...] = ()  # the distinct values of a varied parameter

    @property
    def derived(self) -> bool:
        """Whether it follows from other parameters."""
        return self.name in ("hertz_radius", "hertz_pressure", "")


def parameter_rows(plan: Plan) -> list[ParameterRow]:
    """Return the varied parameters in the order of the study, the others, and derived values."""
    rows = []
    for axis in plan.study.axes:
        name, labels = axis.coordinate, [level.label for level in levels_of(axis)]
        choices = tuple(dict.fromkeys(labels))
        text = _listed(name, axis.values, labels)
        rows.append(ParameterRow(name, parameter(name).words, text, choices))
    left_out = {row.name for row in rows} | _NUMERICS
    values: dict[tuple[str, str], dict[float | str, None]] = {}
    words: dict[str, str] = {}
    stick: dict[str, dict[float | str, None]] = {}
    for case in plan.study.cases().values():
        for name, (value, units, meaning) in case.scalar_coordinates().items():
            # The slopes of a smooth surface are meaningless.
            if name not in left_out and (case.roughness or not name.startswith("roughness_slope")):
                named = name, words.setdefault(name, meaning)
                values.setdefault(named, {})[in_unit(value, units)] = None
        if case.indenter.is_hertzian:
            what = f"stick {case.frame.extent} of the smooth elastic contact"
            stick.setdefault(what, {})[case.stick_radius] = None
    rows += [ParameterRow(*named, _listed(named[0], [*given])) for named, given in values.items()]
    rows += [ParameterRow("", what, text) for what, text in plan.derived()]
    rows += [ParameterRow("", w, _listed("hertz_radius", [*radii])) for w, radii in stick.items()]
    return rows


def _listed(name: str, values: Sequence[object], labels: Sequence[str] = ()) -> str:
    """Return the distinct values in order, or the range of the numbers when there are many."""
    distinct = list(dict.fromkeys(labels or [value_text(name, value) for value in values]))
    if len(distinct) <= _MOST_LISTED:
        return ", ".join(distinct)
    numbers = [v for v in values if isinstance(v, float | int) and math.isfinite(v)]
    if numbers:
        return f"{span(numbers, partial(value_text, name))} ({len(distinct)} values)"
    return f"{distinct[0]}, {distinct[1]}, … {distinct[-1]} ({len(distinct)} values)"


def _cases(results: Sequence[PointResult]) -> tuple[object, ...]:
    """Return the columns and rows of the table of cases, their number, and means over seeds.

    A cell has the text of a number, the value that sorts its column, and its uncertainty.
    """
    units = display_units(results) if any(result.done for result in results) else {}
    undefined = ("–", "", "")
    rows = []
    for result in results[:_MOST_ROWS]:
        cells = [undefined] * len(units)
        for place, (name, unit) in enumerate(units.items() if result.done else ()):
            value, error = result.values[name], result.errors.get(name, 0.0)
            mark = f"± {number_text(100.0 * error, 2)} %" if error > SMALL_ERROR else ""
            if not math.isnan(value):
                cells[place] = fixed_digits(unit.of(value), 4), f"{value:.6g}", mark
        rows.append((result, cells))
    ensembles = []
    for ensemble in over_seeds(results):
        cells = []
        for name, unit in units.items():
            shown, deviation = (unit.of(value) for value in ensemble.spread[name])
            part = f" ({number_text(100 * deviation / abs(shown), 2)} %)" if shown else ""
            text = f"{with_error(shown, deviation)}{part}"
            cells.append(undefined if math.isnan(shown) else (text, "", ""))
        ensembles.append((ensemble, [(ensemble.seeds, "", ""), *cells]))
    columns = [(result_variable(name, results).label, unit.name) for name, unit in units.items()]
    return columns, rows, len(results), ensembles


def study_text(study: Study) -> str:
    """Return the study file as it stands, or its content if loading changed it."""
    with suppress(OSError, UnicodeDecodeError, StudyError):
        if read_document(study.file).data == study.content:
            return study.file.read_text(encoding="utf-8")
    yaml, text = YAML(), StringIO()
    yaml.dump(dict(study.content), text)
    return text.getvalue()
