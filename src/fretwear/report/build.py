"""The report: one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

import fretwear
from fretwear.figures.wording import Unit, cycle_number, parameter
from fretwear.report.computation import computation_facts, study_text, time_facts
from fretwear.report.embed import figure_groups
from fretwear.report.explorer import build_explorer
from fretwear.report.findings import (
    EFFECT_QUANTITIES,
    effects,
    key_numbers,
    summary_sentences,
)
from fretwear.report.numbers import significant
from fretwear.report.parameters import derived_rows, parameter_rows
from fretwear.report.results import (
    FAILED,
    QUANTITIES,
    QUANTITY,
    PointResult,
    Quantity,
    display_unit,
    labels_of,
    point_results,
)
from fretwear.report.scripts import page_scripts
from fretwear.report.section import Section, environment
from fretwear.running.records import log_end, reasons
from fretwear.study.plan import Plan

_MOST_ROWS = 2000


@dataclass(frozen=True)
class Cell:
    """One number of the table of cases: as read, and as sorted by."""

    text: str
    value: str


@dataclass(frozen=True)
class Heading:
    """A heading of the table of cases over one column, or over two: first and last cycle."""

    text: str
    unit: str
    parts: tuple[str, ...]


def build_report(
    plan: Plan,
    summary: xr.Dataset,
    folder: Path,
    *,
    sections: Iterable[Section] = (),
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
    study, cases = plan.study, folder / "cases"
    results = point_results(plan, summary, reasons(folder))
    done = [result for result in results if result.done]
    units = _units(results) if done else {}
    cycles = _cycles_text(plan)
    explorer = build_explorer(plan, results, cases)
    scripts = page_scripts(with_explorer=explorer is not None)
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            title=study.title,
            name=study.name,
            version=fretwear.__version__,
            policy=scripts.policy,
            scripts=scripts.texts,
            explorer=explorer,
            plotly=scripts.plotly,
            lead=_lead(plan, results, cycles),
            key_numbers=key_numbers(results, cycles),
            sentences=list(summary_sentences(results)),
            parameters=parameter_rows(plan),
            derived=derived_rows(plan),
            effects=effects(plan, results),
            effect_labels=[QUANTITY[name].heading for name in EFFECT_QUANTITIES],
            varied=[(axis.coordinate, parameter(axis.coordinate).words) for axis in study.axes],
            choices={a.coordinate: list(dict.fromkeys(labels_of(a))) for a in study.axes},
            headings=_headings(units) if done else [],
            rows=[(result, list(_cells(result, units))) for result in results[:_MOST_ROWS]],
            total=len(results),
            groups=figure_groups(folder / "figures"),
            undone=[(result, _log(folder, result)) for result in results if not result.done][
                :_MOST_ROWS
            ],
            facts=[*computation_facts(plan, results, cases), *time_facts(folder)],
            study_text=study_text(study),
            study_file=study.file.name,
            sections=list(sections),
        )
    )


def _log(folder: Path, result: PointResult) -> str:
    return log_end(folder, result.id) if result.status == FAILED else ""


def _cycles_text(plan: Plan) -> str:
    counts = sorted({case.cycles for case in plan.study.cases().values()})
    texts = [cycle_number(count) for count in counts]
    return texts[0] if len(texts) == 1 else f"{texts[0]} to {texts[-1]}"


def _lead(plan: Plan, results: Sequence[PointResult], cycles: str) -> str:
    """Return one sentence that says what was run, for someone who has not seen the study file."""
    done = sum(result.done for result in results)
    axes = [f"{len(axis.values)} of {parameter(axis.coordinate).words}" for axis in plan.study.axes]
    if axes and plan.study.design.kind == "grid":
        varied = f", every combination of {_and([axes[0].replace(' of', ' values of'), *axes[1:]])}"
    elif axes:
        varied = f" that vary {_and([parameter(a.coordinate).words for a in plan.study.axes])}"
    else:
        varied = ""
    rest = "" if done == len(results) else f" Of {len(results)} points, {done} have results."
    return (
        "A sphere is pressed on a flat by a constant load and rubbed to and fro by a tangential "
        f"force too small to slide it: the middle sticks, a ring around it slips and wears. "
        f"This study follows {cycles} cycles in {len(results)} "
        f"case{'s' if len(results) > 1 else ''}{varied}.{rest}"
    )


def _and(parts: Sequence[str]) -> str:
    return " and ".join([", ".join(parts[:-1]), parts[-1]]) if len(parts) > 1 else parts[0]


def _units(results: Sequence[PointResult]) -> dict[str, Unit]:
    """Return one unit for each heading, so that first and last can be compared."""
    widest: dict[str, Unit] = {}
    for quantity in QUANTITIES:
        unit = display_unit(quantity, results)
        other = widest.get(quantity.heading, unit)
        widest[quantity.heading] = max(unit, other, key=lambda candidate: candidate.size)
    return {quantity.name: widest[quantity.heading] for quantity in QUANTITIES}


def _headings(units: Mapping[str, Unit]) -> list[Heading]:
    grouped: dict[str, list[Quantity]] = {}
    for quantity in QUANTITIES:
        grouped.setdefault(quantity.heading, []).append(quantity)
    return [
        Heading(text, units[group[0].name].name, tuple(quantity.when for quantity in group))
        for text, group in grouped.items()
    ]


def _cells(result: PointResult, units: Mapping[str, Unit]) -> Iterator[Cell]:
    if not result.done:
        return
    for quantity in QUANTITIES:
        value = result.values[quantity.name]
        yield Cell(significant(value / units[quantity.name].size, 4), f"{value:.6g}")
