"""Sections of the report on the source study: its claims, and the simpler slip model."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from fretwear.report import Section, environment
from fretwear.source_study.cases import RUN_IN, TITLES, Evolution, ReferenceCases, reference_cases
from fretwear.source_study.claims import CLAIMS, Judgement, judge, percent, short
from fretwear.study.parameters import value_text
from fretwear.units import cycle_text
from fretwear.vocabulary import SYMMETRIES

if TYPE_CHECKING:
    from fretwear.data.effects import Merged

_MOST = 1000.0
_MODELS = {
    "cattaneo_mindlin": "as the study describes it",
    "jaeger": "slip that follows the worn shape",
}


@dataclass(frozen=True)
class Judged:
    """The verdicts of the cases with one sphere radius and one slip model."""

    group: ReferenceCases
    judgements: tuple[Judgement, ...]

    @property
    def model(self) -> str:
        """The slip model in words."""
        return _MODELS.get(self.group.slip_model, self.group.slip_model.replace("_", " "))


def source_sections(summary: Merged, folder: Path) -> Iterator[Section]:
    """Yield the sections on the source study, of a merged study's case files.

    There are none where the study does not hold the four cases of the source study.
    """
    judged, models = [], []
    for group in reference_cases(summary, folder):
        cases = group.load()
        judged.append(Judged(group, judge(cases)))
        # Those of other radii are not needed any more.
        models += [cases] if group.radius == judged[0].group.radius else []
    if judged:
        yield _claims(judged, judged[0].group.radius)
    if len(models) > 1:
        yield _slip_models(models[0], models[1])


def _claims(judged: Sequence[Judged], radius: float) -> Section:
    """The section on the claims: judged at one radius, and compared with others if there are."""
    radii = sorted(judged, key=lambda one: (one.group.slip_model, one.group.radius))
    columns = {one.group.slip_model: one for one in radii if one.group.radius == radius}
    others: list[list[tuple[Judgement, bool]]] = []
    for index in range(len(CLAIMS) if len(radii) > len(columns) else 0):
        row = [(one.judgements[index], columns.get(one.group.slip_model, one)) for one in radii]
        others.append([(mine, mine.answers != one.judgements[index].answers) for mine, one in row])
    varied = [str(row[0][0].claim.number) for row in others if any(differs for _, differs in row)]
    content = {
        "radius": value_text("radius", radius),
        "claims": list(zip(*(one.judgements for one in columns.values()), strict=True)),
        "models": [one.model for one in columns.values()],
        "headings": [f"R = {value_text('radius', one.group.radius)}, {one.model}" for one in radii],
        "others": others,
        "varied": ", ".join(varied),
    }
    return _section("claims", "Claims of the source study", "claims.html.j2", content)


def _slip_models(cases: Mapping[str, Evolution], simple: Mapping[str, Evolution]) -> Section:
    smooth = cases[TITLES[0]]
    tables = {
        cycle_text(cycle): _ratios(cases, simple, cycle)
        for cycle in dict.fromkeys((smooth.nearest(RUN_IN), smooth.last))
    }
    excess = {title: percent(excess_shear(case, smooth.last)) for title, case in simple.items()}
    content = {"subjects": TITLES, "tables": tables, "excess": excess}
    title = "What the simpler slip model costs"
    return _section("slip-models", title, "slip_models.html.j2", content)


def _section(anchor: str, title: str, template: str, content: Mapping[str, object]) -> Section:
    body = environment("fretwear.source_study").get_template(template).render(content)
    return Section(anchor, title, Markup(body))


def _ratios(
    cases: Mapping[str, Evolution], simple: Mapping[str, Evolution], cycle: int
) -> dict[str, list[str]]:
    """Results of the simple model as multiples of the others', a column for each case."""
    from fretwear.data.dataset import compared_results

    rows: dict[str, list[str]] = {}
    for title, case in cases.items():
        both = (case, simple[title])
        compared = compared_results(*(one.dataset.sel(cycle=[cycle]) for one in both))
        # The pressure of a single cell is meaningless on a rough surface.
        ratios = {r.variable.label: r.ratio for r in compared if r.variable.is_headline}
        first, second = (one.field("pressure", cycle)[one.zones(cycle).stick] for one in both)
        ratios["Mean pressure in the stick zone"] = float(second.mean() / first.mean())
        for label, ratio in ratios.items():
            # Vanishing values cannot be compared.
            rows.setdefault(label, []).append(short(ratio if ratio < _MOST else math.nan))
    return rows


def excess_shear(case: Evolution, cycle: int) -> float:
    """Share of the tangential load that a case carries against Coulomb's law.

    Where the shear traction exceeds µp, valleys without pressure included, friction cannot
    carry it: the integral of that excess, as a share of Q. The slip of the worn shape has none.
    """
    shear = np.abs(case.field("shear_traction", cycle))
    excess = np.maximum(shear - case.parameter("friction") * case.field("pressure", cycle), 0.0)
    copies = 1 << sum(SYMMETRIES[case.dataset.attrs["symmetry"]])
    force = copies * math.prod(case.sides) * float(excess.sum())
    return force / case.parameter("tangential_load")
