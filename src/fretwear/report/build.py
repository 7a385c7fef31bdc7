"""The report of a study, put together from its sections."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

import fretwear
from fretwear.figures.study import read_figure_index
from fretwear.figures.wording import parameter, value_text
from fretwear.report.computation import computation_facts, study_text
from fretwear.report.explorer import Explorer, build_explorer
from fretwear.report.findings import EFFECTS_ON, effects, key_numbers, summary_sentences
from fretwear.report.page import Section, embedded, environment, page_scripts
from fretwear.report.results import (
    KEY_RESULTS,
    PointResult,
    display_units,
    labels_of,
    marked_label,
    point_results,
)
from fretwear.running.records import log_end, reasons
from fretwear.study.plan import Plan
from fretwear.study.points import Axis
from fretwear.units import Unit, cycle_text, fixed_digits
from fretwear.vocabulary import RESULTS, PointStatus

_MOST_ROWS = 2000
_MOST_LISTED = 8
_NUMERICS = {"cell_x", "cell_y", "tolerance", "slip_model"}
_DERIVED = ("hertz_radius", "hertz_pressure", "")


@dataclass(frozen=True)
class ParameterRow:
    """A parameter of the study: name in the study file (or none), words, values for people.

    `choices` has each value of a varied parameter; a fixed one has none.
    """

    name: str
    words: str
    values: str
    choices: tuple[str, ...] = ()

    @property
    def varied(self) -> bool:
        """Whether the study varies it."""
        return bool(self.choices)

    @property
    def derived(self) -> bool:
        """Whether it is no parameter of its own."""
        return self.name in _DERIVED


@dataclass(frozen=True)
class Column:
    """A key result in the table of cases: a heading over one cycle or two."""

    label: str
    unit: str
    cycles: tuple[str, ...]


def build_report(
    plan: Plan, summary: xr.Dataset, folder: Path, *, sections: Iterable[Section] = ()
) -> str:
    """Build the report of a study as one self-contained HTML page.

    Parameters
    ----------
    plan : Plan
        The study with its points, from `fretwear.study.plan.plan_study`.
    summary : xarray.Dataset
        The merged study.
    folder : pathlib.Path
        Folder of the study's results: the case files in ``cases``; the figures with their index,
        from `fretwear.figures.study.write_study_figures`, in ``figures``; and, where they are
        there, ``logs`` and ``benchmarks``.
    sections : iterable of Section
        More sections, placed after the figures.

    Returns
    -------
    str
        HTML that loads nothing from anywhere.

    Raises
    ------
    DataFileError
        When `summary` is not that of the plan's study as it is now.
    """
    results = point_results(plan, summary, reasons(folder))
    explorer = build_explorer(plan, results, folder / "cases")
    scripts = page_scripts(with_explorer=explorer is not None)
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            title=plan.study.title,
            name=plan.study.name,
            version=fretwear.__version__,
            lead=_lead(plan, results),
            scripts=scripts,
            sections=list(_sections(plan, results, folder, explorer, scripts.plotly, sections)),
        )
    )


def _sections(
    plan: Plan,
    results: Sequence[PointResult],
    folder: Path,
    explorer: Explorer | None,
    plotly: str,
    more: Iterable[Section],
) -> Iterator[Section]:
    body: Any = environment().get_template("sections.html.j2").module
    parameters = parameter_rows(plan)

    yield Section(
        "summary",
        "Summary",
        body.summary(
            key_numbers(results, _cycles(plan)),
            list(summary_sentences(results)),
            effects(plan, results),
            [RESULTS[name].label for name in EFFECTS_ON],
        ),
    )
    if explorer:
        yield Section("explorer", "Explorer", body.explorer(explorer.data, explorer.note, plotly))
    yield Section("parameters", "Parameters", body.parameters(parameters))
    units = display_units(results) if any(result.done for result in results) else {}
    columns = [
        Column(marked_label(name), unit.name, KEY_RESULTS[name]) for name, unit in units.items()
    ]
    rows = [(result, list(_cells(result, units))) for result in results[:_MOST_ROWS]]
    varied = [row for row in parameters if row.varied]
    table = body.cases(columns, varied, rows, len(results))
    yield Section("cases", "Cases and key results", table, entry="Cases")
    images = embedded(folder / "figures", read_figure_index(folder / "figures"))
    if images:
        yield Section("figures", "Figures", body.figures(images))
    yield from more
    undone = [result for result in results if not result.done][:_MOST_ROWS]
    if undone:
        table = body.undone([(result, _log(folder, result)) for result in undone])
        yield Section("undone", "Points without results", table, entry="Without results")
    facts = computation_facts(plan, results, folder)
    computed = body.computation(facts, plan.study.file.name, study_text(plan.study))
    yield Section("computation", "How it was computed", computed, entry="Computation")
    yield Section("limits", "Limits of the model", body.limits(), entry="Limits")
    yield Section("glossary", "Glossary", body.glossary())


def _log(folder: Path, result: PointResult) -> str:
    return log_end(folder, result.id) if result.status == PointStatus.FAILED else ""


def _cycles(plan: Plan) -> str:
    counts = {case.cycles for case in plan.study.cases().values()}
    return " to ".join(dict.fromkeys(cycle_text(end(counts)) for end in (min, max)))


def _lead(plan: Plan, results: Sequence[PointResult]) -> str:
    """Return what was run, for someone who has not seen the study file."""
    axes = plan.study.axes
    words = [parameter(axis.coordinate).words for axis in axes]
    varied = ""
    if axes and plan.study.design.kind == "grid":
        first, *others = [f"{len(axis.values)}" for axis in axes]
        counts = [f"{first} values of {words[0]}"]
        counts += [f"{count} of {name}" for count, name in zip(others, words[1:], strict=True)]
        varied = f", every combination of {_and(counts)}"
    elif axes:
        varied = f" that vary {_and(words)}"
    done = sum(result.done for result in results)
    rest = "" if done == len(results) else f" Of {len(results)} points, {done} have results."
    return (
        "A sphere is pressed against a flat by a constant load. A tangential force, too small to "
        "make it slide, acts to and fro: the centre of the contact sticks, while a ring around it "
        f"slips and wears. This study covers {_cycles(plan)} cycles in {len(results)} "
        f"case{'s' if len(results) > 1 else ''}{varied}.{rest}"
    )


def _and(parts: Sequence[str]) -> str:
    return " and ".join([", ".join(parts[:-1]), parts[-1]]) if len(parts) > 1 else parts[0]


# --- the table of parameters --------------------------------------------------------------------


def parameter_rows(plan: Plan) -> list[ParameterRow]:
    """Return the varied parameters in the order of the study, the others, and derived values."""
    varied = [_varied_row(axis) for axis in plan.study.axes]
    cases = list(plan.study.cases().values())
    values: dict[str, list[float | str]] = {}
    for case in cases:
        for name, (value, *_) in case.scalar_coordinates().items():
            # The slopes of a smooth surface say nothing.
            if case.roughness or not name.startswith("roughness_slope"):
                values.setdefault(name, []).append(value)
    left_out = {row.name for row in varied} | _NUMERICS
    stick = _values_text("hertz_radius", [case.stick_radius for case in cases])
    return [
        *varied,
        *(
            ParameterRow(name, parameter(name).words, _values_text(name, known))
            for name, known in values.items()
            if name not in left_out
        ),
        ParameterRow("", "stick radius of the smooth elastic sphere", stick),
    ]


def _varied_row(axis: Axis) -> ParameterRow:
    name, choices = axis.coordinate, tuple(dict.fromkeys(labels_of(axis)))
    if len(choices) <= 2 * _MOST_LISTED:
        text = ", ".join(choices)
    elif all(isinstance(value, float | int) for value in axis.values):
        low, high = (value_text(name, end(axis.values)) for end in (min, max))
        text = f"{low} to {high} ({len(choices)} values)"
    else:
        text = f"{choices[0]}, {choices[1]}, … {choices[-1]} ({len(choices)} values)"
    return ParameterRow(name, parameter(name).words, text, choices)


def _values_text(name: str, values: Sequence[float | str]) -> str:
    """Return the distinct values in order, or their range when there are many."""
    distinct = list(dict.fromkeys(value_text(name, value) for value in values))
    if len(distinct) <= _MOST_LISTED:
        return ", ".join(distinct)
    numbers = [value for value in values if not isinstance(value, str) and math.isfinite(value)]
    return f"{value_text(name, min(numbers))} to {value_text(name, max(numbers))}"


def _cells(result: PointResult, units: Mapping[str, Unit]) -> Iterator[tuple[str, str]]:
    """Yield the key results of a point as shown and as sorted by; dashes where it has none."""
    for name, unit in units.items():
        for cycle in KEY_RESULTS[name]:
            if result.done:
                value = result.values[name, cycle]
                yield fixed_digits(value / unit.size, 4), f"{value:.6g}"
            else:
                yield "–", ""
