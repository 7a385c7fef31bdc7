"""The report of a study, put together from its sections."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup
from ruamel.yaml import YAML

import fretwear
from fretwear.data.effects import Points, results_table
from fretwear.figures.index import ANSWER_CATEGORY, read_figure_index
from fretwear.report.above import read_above
from fretwear.report.answer import answers, companions
from fretwear.report.cases import computation_facts, examine
from fretwear.report.explorer import build_explorer, evenly, held_points, read_curves
from fretwear.report.page import Image, Section, embedded, environment, page_scripts
from fretwear.report.results import (
    PointResult,
    display_units,
    levels_of,
    over_seeds,
    point_results,
    variable_of,
)
from fretwear.running.workflow import failures, log_end, spent_on_simulations
from fretwear.study.case import Case
from fretwear.study.doubts import SMALL_ERROR, finer
from fretwear.study.parameters import parameter, value_text
from fretwear.study.plan import Plan
from fretwear.study.problems import StudyError
from fretwear.study.study import Study
from fretwear.study.yamlfile import read_document
from fretwear.units import (
    cycle_text,
    duration_text,
    fixed_digits,
    listed,
    size_text,
    span,
    with_error,
)
from fretwear.vocabulary import RESULTS, PointStatus

if TYPE_CHECKING:
    from fretwear.data.effects import Merged

_MOST_ROWS = 2000
_MOST_EXAMINED = 12
_MOST_LISTED = 12
_NUMERICS = {"cell_x", "cell_y", "tolerance", "slip_model", "error_estimate"}
_DERIVED = ("hertz_radius", "hertz_pressure", "")


def build_report(
    plan: Plan, summary: Merged, folder: Path, *, sections: Iterable[Section] = ()
) -> str:
    """Build the report of a study as one self-contained HTML page, which loads nothing.

    `folder` is that of the results: the case files in ``cases``; the figures with their index, from
    `fretwear.figures.study.write_study_figures`, in ``figures``; and, where they are there,
    ``logs`` and ``benchmarks``. More `sections` come after the figures.

    It is a `DataFileError` when the summary is not that of the plan's study as it is now, or a file
    is missing.
    """
    reasons = {case_id: str(failure) for case_id, failure in failures(folder).items()}
    results = point_results(plan, summary, reasons)
    places = held_points(plan, results)
    done = [place for place in places if results[place].done]
    curves = read_curves(folder / "summary.nc", plan, done) if done else {}
    known = plan.study.cases()
    above = {
        case_id: read_above(folder / "cases" / f"{case_id}.nc", known[case_id], each.cycles)
        for case_id, each in curves.items()
    }
    explorer = build_explorer(plan, results, places, curves, above)
    ids = list(dict.fromkeys(result.id for result in results if result.done))
    examined = [ids[place] for place in evenly(len(ids), _MOST_EXAMINED)]
    numerics = [examine(folder / "cases" / f"{case_id}.nc") for case_id in examined]
    scripts = page_scripts(with_explorer=explorer is not None)
    cases, parameters = known.values(), parameter_rows(plan)
    images = embedded(folder / "figures", read_figure_index(folder / "figures"))
    undone = [
        (result, log_end(folder, result.id) if result.status == PointStatus.FAILED else "")
        for result in [result for result in results if not result.done][:_MOST_ROWS]
    ]
    facts = {
        "Slip model": ", ".join(sorted({case.slip_model.kind for case in cases})),
        **computation_facts(numerics, len(ids)),
        **_time_facts(folder),
    }
    body: Any = environment().get_template("sections.html.j2").module
    table = base64.b64encode(results_table(summary).encode("utf-8")).decode("ascii")
    kinds = _kinds(cases)
    answering = [image for image in images if image.entry.category == ANSWER_CATEGORY]
    others = [image for image in images if image not in answering]
    heading, entry = ("What mattered", "Answer") if len(ids) > 1 else ("Results", "Results")
    answer = _answer(body, plan, summary, results, answering)
    computation = body.computation(facts, plan.study.file.name, study_text(plan.study), kinds)
    listed_cases = _cases(body, parameters, results, table)
    page = [Section("answer", heading, answer, entry)]
    if explorer:
        content = body.explorer(*explorer, scripts.plotly, "point" not in kinds, len(results))
        page.append(Section("explorer", "Explorer", content))
    page.append(Section("parameters", "Parameters", body.parameters(parameters)))
    page.append(Section("cases", "Cases and key results", listed_cases, "Cases"))
    if others:
        page.append(Section("figures", "Figures", body.figures(others, len(answering))))
    page += sections
    if undone:
        content = body.undone(undone)
        page.append(Section("undone", "Points without results", content, "Without results"))
    page += [
        Section("computation", "How it was computed", computation, "Computation"),
        Section("limits", "Limits of the model", body.limits(kinds), "Limits"),
        Section("glossary", "Glossary", body.glossary(kinds)),
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
    body: Any,
    plan: Plan,
    summary: Merged,
    results: Sequence[PointResult],
    images: Sequence[Image],
) -> Markup:
    warnings = [
        {
            "cases": f"{len(cases)} case{'s' * (len(cases) != 1)}",
            "what": doubt.what,
            "first": next(iter(cases)),
            "detail": doubt.detail,
            "remedy": doubt.remedy,
        }
        for doubt, cases in plan.doubts.items()
    ]
    found, together = list(answers(summary)), companions(Points.of(summary))
    if len(summary.variables["status"].values.ravel()) > 1 and not any(a.headline for a in found):
        together = "There are no two cases that differ in one parameter alone."
    if found and "stick_half_width_x" not in {answer.name for answer in found}:
        which = "Nothing sticks" if len(results) == 1 else "In no case does anything stick"
        together = f"{together} {which} after the last cycle.".strip()
    remarks = [*summary.attrs.get("warnings", "").splitlines(), *_uncertain(plan, results)]
    return Markup(body.answer(warnings, remarks, found, together, images))


def _mark(error: float) -> str:
    """Return how uncertain a value is, where that is worth showing."""
    return f"± {100.0 * error:.2g} %" if error > SMALL_ERROR else ""


def _uncertain(plan: Plan, results: Sequence[PointResult]) -> list[str]:
    """Return a remark on the values that are marked, and what would mend them; or none."""
    errors = [
        (error, name, result.id) for result in results for name, error in result.errors.items()
    ]
    marked = [each for each in errors if each[0] > SMALL_ERROR]
    if not marked:
        return []
    error, name, case_id = max(marked)
    case = plan.study.cases()[case_id]
    return [
        f"{len(marked)} of {len(errors)} key results have estimated errors above "
        f"{100.0 * SMALL_ERROR:g} %: marked in the table of cases. The largest is "
        f"{100.0 * error:.0f} %, of the {RESULTS[name].words} of {case_id}; "
        f"{finer(case, error)} would reduce it"
    ]


def _kinds(cases: Iterable[Case]) -> set[str]:
    """Return the kinds of cases of which texts differ."""
    known: set[str] = set()
    for case in cases:
        known.add("debris" if case.debris_fraction else "no debris")
        known.add(case.roughness.kind if case.roughness else "smooth")
        known.add("line" if case.indenter.is_line else "point")
        known.add("stroke" if case.loading.stroke else "force" if case.force_is_held else "varying")
        if not case.indenter.is_line:
            known.add("rings" if case.is_on_rings else "grid")
    return known


def _lead(plan: Plan, results: Sequence[PointResult]) -> str:
    """Return what was run, in a sentence or two."""
    words = [parameter(axis.coordinate).words for axis in plan.study.axes]
    varied = ""
    if words and plan.study.design.kind == "grid":
        counts = [len(axis.values) for axis in plan.study.axes]
        values = [f"{name} ({n} values)" for name, n in zip(words, counts, strict=True)]
        varied = f": {'all combinations of' if len(words) > 1 else 'one for each'} {listed(values)}"
    elif words:
        varied = f", in which {listed(words)} {'vary' if len(words) > 1 else 'varies'}"
    done = sum(result.done for result in results)
    rest = "" if done == len(results) else f" Of {len(results)} points, {done} have results."
    count = f"{len(results)} case{'s' if len(results) > 1 else ''}"
    return f"{count} of {_cycles(plan)} cycles{varied}.{rest}"


def _cycles(plan: Plan) -> str:
    counts = {case.cycles for case in plan.study.cases().values()}
    return span(counts, cycle_text)


@dataclass(frozen=True)
class ParameterRow:
    """A parameter of the study."""

    name: str  # in the study file; may be empty
    words: str
    values: str  # as many as can be listed
    choices: tuple[str, ...] = ()  # the distinct values of a varied parameter

    @property
    def derived(self) -> bool:
        """Whether it follows from other parameters."""
        return self.name in _DERIVED


def parameter_rows(plan: Plan) -> list[ParameterRow]:
    """Return the varied parameters in the order of the study, the others, and derived values."""
    rows = []
    for axis in plan.study.axes:
        name, labels = axis.coordinate, [level.label for level in levels_of(axis)]
        choices = tuple(dict.fromkeys(labels))
        text = _listed(name, axis.values, labels)
        rows.append(ParameterRow(name, parameter(name).words, text, choices))
    values: dict[str, dict[Any, None]] = {}
    words: dict[str, str] = {}
    cases = list(plan.study.cases().values())
    for case in cases:
        for name, (value, _, meaning) in case.scalar_coordinates().items():
            # The slopes of a smooth surface are meaningless.
            if case.roughness or not name.startswith("roughness_slope"):
                values.setdefault(name, {})[value] = None
                words.setdefault(name, meaning)
    left_out = {row.name for row in rows} | _NUMERICS
    for name, known in values.items():
        if name not in left_out:
            rows.append(ParameterRow(name, words[name], _listed(name, list(known))))
    derived = [ParameterRow("", what, text) for what, text in plan.derived()]
    stick: dict[str, dict[float, None]] = {}
    for case in cases:
        if case.indenter.is_hertzian:
            what = f"stick {case.indenter.extent_words} of the smooth elastic contact"
            stick.setdefault(what, {})[case.stick_radius] = None
    derived += [ParameterRow("", w, _listed("hertz_radius", [*all_])) for w, all_ in stick.items()]
    return [*rows, *derived]


def _listed(name: str, values: Sequence[Any], labels: Sequence[str] = ()) -> str:
    """Return the distinct values in order, or the range of the numbers when there are many."""
    distinct = list(dict.fromkeys(labels or [value_text(name, value) for value in values]))
    if len(distinct) <= _MOST_LISTED:
        return ", ".join(distinct)
    numbers = [v for v in values if isinstance(v, float | int) and math.isfinite(v)]
    if numbers:
        return f"{span(numbers, partial(value_text, name))} ({len(distinct)} values)"
    return f"{distinct[0]}, {distinct[1]}, … {distinct[-1]} ({len(distinct)} values)"


def _cases(
    body: Any, parameters: Sequence[ParameterRow], results: Sequence[PointResult], table: str
) -> Markup:
    """Return the table of cases; each number as it is shown and as the column is sorted by it."""
    units = display_units(results) if any(result.done for result in results) else {}
    rows = []
    for result in results[:_MOST_ROWS]:
        cells = [("–", "", "")] * len(units)
        if result.done:
            values = [(result.values[name], unit) for name, unit in units.items()]
            marks = [_mark(result.errors.get(name, 0.0)) for name in units]
            cells = [
                (fixed_digits(unit.of(v), 4), f"{v:.6g}", mark)
                for (v, unit), mark in zip(values, marks, strict=True)
            ]
        rows.append((result, cells))
    columns = [(variable_of(name, results).label, unit.name) for name, unit in units.items()]
    varied = [row for row in parameters if row.choices]
    ensembles = []
    for levels, count, spread in over_seeds(results):
        cells = []
        for name, unit in units.items():
            shown, deviation = (unit.of(each) for each in spread[name])
            part = f" ({100 * deviation / abs(shown):.2g} %)" if shown else ""
            cells.append((f"{with_error(shown, deviation)}{part}", "", ""))
        ensembles.append((levels, count, cells))
    return Markup(body.cases(columns, varied, rows, len(results), table, ensembles))


def _time_facts(folder: Path) -> Mapping[str, str]:
    """Return what the simulations took, as far as it was measured."""
    spent = spent_on_simulations(folder)
    if spent is None:
        return {}
    jobs = f"{spent.jobs} job{'s' if spent.jobs > 1 else ''}"
    facts = {
        "Time of all simulations": f"{_time(spent.seconds)}, the sum over {jobs}",
        "Their processor time": _time(spent.processor_seconds),
    }
    if math.isfinite(spent.memory_bytes):
        facts["Memory of the largest job"] = size_text(round(spent.memory_bytes))
    return facts


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 600.0 else duration_text(seconds)


def study_text(study: Study) -> str:
    """Return the study file as it stands, or its content where that was changed when loaded."""
    with suppress(OSError, UnicodeDecodeError, StudyError):
        if read_document(study.file).data == study.content:
            return study.file.read_text(encoding="utf-8")
    yaml, text = YAML(), StringIO()
    yaml.dump(dict(study.content), text)
    return text.getvalue()
