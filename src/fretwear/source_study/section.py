"""Sections of a report on the source study: its claims judged, and what simpler slip costs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from markupsafe import Markup

from fretwear.data.dataset import compared_results
from fretwear.report import Section, environment
from fretwear.source_study.cases import RUN_IN, TITLES, Evolution, ReferenceCases, reference_cases
from fretwear.source_study.claims import CLAIMS, Judgement, judge
from fretwear.source_study.measures import percent, short
from fretwear.study.parameters import value_text
from fretwear.units import cycle_text

_MOST = 1000.0
_MODELS = {
    "cattaneo_mindlin": "as the study describes it",
    "jaeger": "slip that follows the worn shape",
}


@dataclass(frozen=True)
class Judged:
    """The cases of one sphere radius and one slip model, and what they say to the claims."""

    group: ReferenceCases
    cases: dict[str, Evolution]
    judgements: tuple[Judgement, ...]

    @property
    def radius(self) -> str:
        """The sphere radius, with its unit."""
        return value_text("radius", self.group.radius)

    @property
    def model(self) -> str:
        """How slip is computed, in words."""
        return _MODELS.get(self.group.slip_model, self.group.slip_model.replace("_", " "))


def source_sections(summary: xr.Dataset, folder: Path) -> Iterator[Section]:
    """Yield the sections on the source study.

    Parameters
    ----------
    summary : xarray.Dataset
        A merged study.
    folder : pathlib.Path
        Folder of its case files.

    Yields
    ------
    Section
        None when the study does not hold the four cases of the source study.
    """
    judged = []
    for group in reference_cases(summary, folder):
        cases = group.load()
        judged.append(Judged(group, cases, judge(cases)))
    if not judged:
        return
    yield _claims(sorted(judged, key=lambda one: one.group.slip_model), judged[0].group.radius)
    if len(judged) > 1 and judged[1].group.radius == judged[0].group.radius:
        yield _slip_models(judged[0].cases, judged[1].cases)


def _claims(judged: Sequence[Judged], radius: float) -> Section:
    """The section on the claims: judged at one radius, and compared with others if there are."""
    columns = {one.group.slip_model: one for one in judged if one.group.radius == radius}
    radii = sorted(judged, key=lambda one: (one.group.slip_model, one.group.radius))
    others: list[list[tuple[Judgement, bool]]] = []
    for index in range(len(CLAIMS) if len(radii) > len(columns) else 0):
        row = [(one.judgements[index], columns.get(one.group.slip_model, one)) for one in radii]
        others.append([(mine, mine.answers != one.judgements[index].answers) for mine, one in row])
    varied = [str(row[0][0].claim.number) for row in others if any(differs for _, differs in row)]
    body = (
        environment("fretwear.source_study")
        .get_template("claims.html.j2")
        .render(
            columns=list(columns.values()),
            claims=list(zip(*(one.judgements for one in columns.values()), strict=True)),
            radii=radii,
            others=others,
            varied=", ".join(varied),
        )
    )
    return Section("claims", "Claims of the source study", Markup(body))


def _slip_models(cases: Mapping[str, Evolution], simple: Mapping[str, Evolution]) -> Section:
    smooth = cases[TITLES[0]]
    tables = {
        cycle_text(cycle): _ratios(cases, simple, cycle)
        for cycle in dict.fromkeys((smooth.nearest(RUN_IN), smooth.last))
    }
    excess = {title: percent(excess_shear(case, smooth.last)) for title, case in simple.items()}
    body = (
        environment("fretwear.source_study")
        .get_template("slip_models.html.j2")
        .render(subjects=TITLES, tables=tables, excess=excess)
    )
    return Section("slip-models", "What the simpler slip model costs", Markup(body))


def _ratios(
    cases: Mapping[str, Evolution], simple: Mapping[str, Evolution], cycle: int
) -> dict[str, list[str]]:
    """Results of the simple model as multiples of the others', a column for each case."""
    rows: dict[str, list[str]] = {}
    for title, case in cases.items():
        both = [one.dataset.sel(cycle=[cycle]) for one in (case, simple[title])]
        ratios = {result.variable.label: result.ratio for result in compared_results(*both)}
        means = [
            float(one.field("pressure", cycle)[one.zones(cycle).stick].mean())
            for one in (case, simple[title])
        ]
        ratios["Mean pressure in the stick zone"] = means[1] / means[0]
        for label, ratio in ratios.items():
            # Next to nothing is nothing to compare with.
            rows.setdefault(label, []).append(short(ratio if ratio < _MOST else math.nan))
    return rows


def excess_shear(case: Evolution, cycle: int) -> float:
    """Share of the tangential load that a case carries against Coulomb's law.

    Where the shear traction exceeds µp, valleys without pressure included, friction cannot
    carry it: the integral of that excess, as a share of Q. The slip of the worn shape has none.
    """
    shear = np.abs(case.field("shear_traction", cycle))
    excess = np.maximum(shear - case.parameter("friction") * case.field("pressure", cycle), 0.0)
    quarters = 1.0 if case.dataset.attrs["symmetry"] == "none" else 4.0
    force = quarters * math.prod(case.sides) * float(excess.sum())
    return force / case.parameter("tangential_load")
