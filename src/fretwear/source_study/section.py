"""Sections on the source study: its claims, judged, and what a simpler slip model costs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import xarray as xr
from markupsafe import Markup

from fretwear.figures.wording import value_text
from fretwear.report import Section, environment
from fretwear.source_study.judge import judge
from fretwear.source_study.models import QUANTITIES, Cost, costs, excess_shear
from fretwear.source_study.quartet import Quartet
from fretwear.source_study.source import SourceCases, reference_cases, source_cases
from fretwear.source_study.verdict import Judgement, joined, percent, short
from fretwear.units import cycle_text

_RUN_IN = 7000


@dataclass(frozen=True)
class Judged:
    """The claims by the cases of one sphere radius and one slip model."""

    cases: SourceCases
    quartet: Quartet
    judgements: tuple[Judgement, ...]

    @property
    def title(self) -> str:
        """Radius and slip model, in words."""
        model = self.cases.slip_model.replace("_", " ")
        return f"R = {value_text('radius', self.cases.radius)}, {model}"


@dataclass(frozen=True)
class CostRow:
    """Ratios of one quantity, one for each case."""

    label: str
    ratios: tuple[str, ...]


def source_sections(summary: xr.Dataset, cases: Path) -> Iterator[Section]:
    """Yield the sections on the source study.

    Parameters
    ----------
    summary : xarray.Dataset
        A merged study.
    cases : pathlib.Path
        Folder of its case files.

    Yields
    ------
    Section
        None when the study does not hold the four cases of the source study.
    """
    reference = reference_cases(summary)
    if reference is None:
        return
    judged = []
    for group in source_cases(summary):
        quartet = group.load(cases)
        judged.append(Judged(group, quartet, judge(quartet)))
    main = next(one for one in judged if one.cases == reference)
    yield _claims(main, judged)
    simple = [one for one in judged if _differs_in_model(one.cases, reference)]
    yield from (_slip_models(main, one) for one in simple[:1])


def _claims(main: Judged, judged: Sequence[Judged]) -> Section:
    body = (
        environment("fretwear.source_study")
        .get_template("claims.html.j2")
        .render(
            radius=value_text("radius", main.cases.radius),
            judgements=main.judgements,
            groups=[one.title for one in judged] if len(judged) > 1 else [],
            depending=_depending_on_radius(main, judged),
            verdicts=[
                (number + 1, [one.judgements[number] for one in judged])
                for number in range(len(main.judgements))
            ],
        )
    )
    return Section("claims", "Claims of the source study", Markup(body))


def _depending_on_radius(main: Judged, judged: Sequence[Judged]) -> str:
    """Say which claims get other answers at other radii; nothing when there is one radius."""
    others = [one for one in judged if one.cases.slip_model == main.cases.slip_model]
    if len(others) < 2:
        return ""
    numbers = [
        str(judgement.number)
        for index, judgement in enumerate(main.judgements)
        if len({one.judgements[index].answers for one in others}) > 1
    ]
    if not numbers:
        return "No claim gets another answer at another radius."
    return (
        f"Other radii give other answers to claim{'s' if len(numbers) > 1 else ''} "
        f"{joined(numbers)}, and the same to the rest."
    )


def _slip_models(main: Judged, simple: Judged) -> Section:
    cycles = [main.quartet.smooth_elastic.nearest(_RUN_IN), main.quartet.smooth_elastic.last]
    subjects = [subject for subject, _ in main.quartet.each()]
    tables = {
        cycle_text(cycle): _rows(costs(main.quartet, simple.quartet, cycle), subjects)
        for cycle in dict.fromkeys(cycles)
    }
    last = cycles[-1]
    body = (
        environment("fretwear.source_study")
        .get_template("slip_models.html.j2")
        .render(subjects=subjects, tables=tables, excess=_excess(simple.quartet, last))
    )
    return Section("slip-models", "What the simpler slip model costs", Markup(body))


def _rows(found: Sequence[Cost], subjects: Sequence[str]) -> list[CostRow]:
    by_place: Mapping[tuple[str, str], Cost] = {(cost.label, cost.subject): cost for cost in found}
    return [
        CostRow(
            quantity.label,
            tuple(short(by_place[quantity.label, subject].ratio) for subject in subjects),
        )
        for quantity in QUANTITIES
    ]


def _excess(quartet: Quartet, cycle: int) -> list[tuple[str, str]]:
    return [(subject, percent(excess_shear(case, cycle))) for subject, case in quartet.each()]


def _differs_in_model(cases: SourceCases, reference: SourceCases) -> bool:
    return cases.radius == reference.radius and cases.slip_model != reference.slip_model
