"""The claims of the source study, in its words and as they are read (claims.csv), and judged."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd
from markupsafe import Markup

from fretwear.arrays import Array
from fretwear.report import Section, table_html
from fretwear.results import RESULTS
from fretwear.study.parameters import value_text
from fretwear.units import cycle_text, number_text
from fretwear.variable import ContactState
from fretwear_source_study.parameters import TITLES
from fretwear_source_study.reference_cases import (
    MODELS,
    RUN_IN,
    Cases,
    StudyCase,
    amplitude_left,
    asperities_like_the_whole,
    deviation_from_hertz,
    differences,
    growth,
    late_growth,
    place_on_rings,
    reference_cases,
    unevenness,
    zone_means,
)

if TYPE_CHECKING:
    import xarray as xr

_NEGLIGIBLE = 1e-4
_NOISE = 1e-3
_PEAK_CELLS = 2.0
_ALMOST = 0.05
_OUTER_PART = 0.75
_MIDDLE_THIRD = (1.0 / 3.0, 2.0 / 3.0)
_MIDDLE_HALF = (0.25, 0.75)
_EVEN = 0.1
_ALIKE, _MOST_ASPERITIES = 0.1, 0.9
_STILL_WEARING = 0.01
_ON_TIPS = 0.9
_WORN_OFF = 0.1
_EARLY, _MUCH = 100.0, 1.5


class Verdict(Enum):
    """Whether a claim holds, in words."""

    HOLDS = "holds"
    IN_PART = "in part"
    FAILS = "does not hold"


class Finding(NamedTuple):
    """The verdict on a claim by one case, or by a smooth and a rough one together."""

    answer: Verdict
    numbers: Mapping[str, str]  # the measured numbers behind it, with units, by their words

    @classmethod
    def graded(cls, holds: bool, in_part: bool, numbers: Mapping[str, str]) -> Finding:
        """The finding on a claim that holds, or holds in part."""
        answer = Verdict.HOLDS if holds else Verdict.IN_PART if in_part else Verdict.FAILS
        return cls(answer, numbers)

    @property
    def text(self) -> str:
        """Verdict and numbers."""
        numbers = [f"{what}: {number}" for what, number in self.numbers.items()]
        return "; ".join([self.answer.value, *numbers])


@dataclass(frozen=True)
class PublishedClaim:
    """A claim of the source study."""

    number: int
    words: str
    criterion: str  # how the words are read, fixed without regard to the result
    subjects: Mapping[str, Sequence[str]]  # titles of the cases of each subject of judgement
    measure: Callable[..., Finding]  # takes the cases of one subject

    def judge(self, cases: Cases) -> dict[str, Finding]:
        """The findings on the claim by subject, from the four cases."""
        return {
            subject: self.measure(*(cases[title] for title in titles))
            for subject, titles in self.subjects.items()
        }


def common_verdict(findings: Mapping[str, Finding]) -> Verdict:
    """The answer common to all subjects; if they differ, the claim holds in part."""
    answers = {finding.answer for finding in findings.values()}
    return answers.pop() if len(answers) == 1 else Verdict.IN_PART


def short(value: float) -> str:
    """Return a number with three significant digits, or a dash for NaN."""
    if math.isnan(value):
        return "–"
    return number_text(0.0 if abs(value) < _NEGLIGIBLE else value, 3)


def percent(share: float) -> str:
    """Return a share in percent, as `short` writes it."""
    return f"{short(100.0 * share)} %"


def _steps(values: Array) -> Array:
    """Return whether a series rises (1), falls (-1) or stays (0) from each snapshot to the next."""
    change = np.diff(values)
    steps: Array = np.where(np.abs(change) > _NOISE * abs(values[0]), np.sign(change), 0.0)
    return steps


def _last_to_first(stick: Array, slip: Array) -> dict[str, str]:
    return {
        "stick zone, last to first": short(stick[-1] / stick[0]),
        "slip zone, last to first": short(slip[-1] / slip[0]),
    }


def _pressure_moves_inward(case: StudyCase) -> Finding:
    stick, slip = zone_means(case, "pressure")
    against = (_steps(stick) < 0.0).any() or (_steps(slip) > 0.0).any()
    in_all = bool(stick[-1] > stick[0] and slip[-1] < slip[0])
    return Finding.graded(in_all and not against, in_all, _last_to_first(stick, slip))


def _peak_at_stick_edge(case: StudyCase) -> Finding:
    pressure = case.field("pressure", case.last)
    peak = case.radius[np.unravel_index(int(pressure.argmax()), pressure.shape)]
    distance = float(peak - case.zones(case.last).stick_radius) / max(case.sides)
    growth_of_peak = float(pressure.max() / case.field("pressure", 0).max())
    numbers = {
        "peak beyond the edge": f"{short(distance)} cells",
        "peak, last to first": short(growth_of_peak),
    }
    return Finding.graded(abs(distance) <= _PEAK_CELLS, False, numbers)


def _rough_becomes_smooth(smooth: StudyCase, rough: StudyCase) -> Finding:
    cycle = smooth.nearest(RUN_IN)
    pressure, mean_pressure, _ = differences(smooth, rough, "pressure", cycle)
    slip, mean_slip, largest_slip = differences(smooth, rough, "slip", cycle)
    hertz = smooth.parameter("hertz_pressure")
    in_figure = pressure <= _ALMOST * hertz and slip <= _ALMOST * largest_slip
    numbers = {
        "snapshot": cycle_text(cycle),
        "pressure apart": f"{percent(pressure / mean_pressure)} of the mean",
        "slip apart": f"{percent(slip / mean_slip)} of the mean",
        "pressure apart, to Hertz": percent(pressure / hertz),
        "slip apart, to the largest": percent(slip / largest_slip),
    }
    alike = pressure <= _ALMOST * mean_pressure and slip <= _ALMOST * mean_slip
    return Finding.graded(alike, in_figure, numbers)


def _stick_zone(case: StudyCase) -> Finding:
    area = case.dataset["stick_area"].values
    if math.isinf(case.parameter("plastic_limit")):
        sticks, slips = (
            np.any([case.field("contact_state", n) == state for n in case.cycles], axis=0)
            for state in (ContactState.STICK, ContactState.SLIP)
        )
        changed = int((sticks & slips).sum())
        numbers = {
            "cells that go from stick to slip or back": str(changed),
            "stick area left": percent(area[-1] / area[0]),
        }
        return Finding.graded(not changed, False, numbers)
    zones = {cycle: case.zones(cycle) for cycle in case.cycles}
    outer = {c: z.stick & (case.radius >= _OUTER_PART * z.stick_radius) for c, z in zones.items()}
    yields = [c for c, edge in outer.items() if (case.field("plastic_depth", c)[edge] > 0.0).any()]
    elastic = [cycle for cycle in case.cycles if case.largest("plastic_volume", cycle) == 0.0]
    rises = np.flatnonzero(np.diff(area) >= 0.0)
    falls = case.cycles[rises[-1] + 1] if rises.size else 0
    reduces = bool(yields) and falls < case.last and bool(area[-1] < area[0])
    extent = zones[case.last].stick_radius / zones[0].stick_radius
    numbers = {
        "stick area left": percent(area[-1] / area[0]),
        "largest on the way": percent(area.max() / area[0]),
        "radius of the zone left": percent(extent),
        "edge yields by cycle": cycle_text(yields[0]) if yields else "–",
        "area falls from cycle": cycle_text(falls) if falls < case.last else "–",
    }
    return Finding.graded(reduces and falls <= max(elastic, default=0), reduces, numbers)


def _wears_most_in_the_middle(case: StudyCase) -> Finding:
    first = place_on_rings(case, "wear_rate", 0)
    places = {c: place_on_rings(case, "wear_depth", c) for c in case.cycles[1:]}
    start, end = _MIDDLE_THIRD
    middle = [cycle_text(cycle) for cycle, place in places.items() if start <= place <= end]
    numbers = {
        "place of most wear in cycle 0": short(first),
        "deepest wear in the middle third, cycles": f"{middle[0]} to {middle[-1]}"
        if middle
        else "–",
        "place of the deepest wear after the last cycle": short(places[case.last]),
    }
    begins, ends = start <= first <= end, start <= places[case.last] <= end
    return Finding.graded(begins and ends, begins or bool(middle), numbers)


def _even_wear(case: StudyCase) -> Finding:
    means = [case.field("wear_rate", n)[case.zones(n).slip()].mean() for n in case.cycles]
    cycle = case.cycles[np.flatnonzero(np.array(means) >= _STILL_WEARING * means[0])[-1]]
    now, middle = unevenness(case, cycle), unevenness(case, cycle, *_MIDDLE_HALF)
    numbers = {
        "snapshot": cycle_text(cycle),
        "unevenness in cycle 0": percent(unevenness(case, 0)),
        "unevenness there": percent(now),
        "over the middle half": percent(middle),
    }
    return Finding.graded(now <= _EVEN, middle <= _EVEN, numbers)


def _asperities(case: StudyCase) -> Finding:
    wear, pressure = case.field("wear_rate", 0), case.field("pressure", 0)
    on_tips = float(wear[case.waves < 0.0].sum() / wear.sum())
    there = float((pressure * wear).sum() / wear.sum() / pressure[case.zones(0).slip()].mean())
    cycle = case.nearest(RUN_IN)
    zones = case.zones(cycle)
    slip = amplitude_left(case, cycle, zones.slip())
    middle = amplitude_left(case, cycle, zones.slip(*_MIDDLE_HALF))
    first = on_tips >= _ON_TIPS and there > 1.0
    numbers = {
        "wear on tips in cycle 0": percent(on_tips),
        "pressure where it wears, to the slip zone's mean": short(there),
        "snapshot": cycle_text(cycle),
        "amplitude left in the slip zone": percent(slip),
        "in its middle half": percent(middle),
    }
    gone, gone_in_part = abs(slip) <= _WORN_OFF, abs(middle) <= _WORN_OFF
    return Finding.graded(first and gone, first or gone_in_part, numbers)


def _width_grows_faster_when_rough(smooth: StudyCase, rough: StudyCase) -> Finding:
    ratio = growth(rough, _EARLY) / growth(smooth, _EARLY)
    last = [case.at("contact_half_width_x", case.last) for case in (rough, smooth)]
    level = last[0] / last[1] - 1.0
    late = max(late_growth(smooth), late_growth(rough))
    numbers = {
        f"growth by cycle {_EARLY:.0f}, rough to smooth": short(ratio),
        "rough beyond smooth at the end": percent(level),
        "growth in the second half": f"{percent(late)} of all",
    }
    stabilises = abs(level) <= _ALMOST and late <= _ALMOST
    faster = ratio >= _MUCH
    return Finding.graded(faster and stabilises, faster or stabilises, numbers)


def _shear_like_pressure(case: StudyCase) -> Finding:
    shear, pressure = (zone_means(case, name) for name in ("shear_traction", "pressure"))
    opposite = [_steps(q) * _steps(p) < 0.0 for q, p in zip(shear, pressure, strict=True)]
    against, steps = int(np.sum(opposite)), np.size(opposite)
    numbers = {**_last_to_first(*shear), "changes against the pressure": f"{against} of {steps}"}
    return Finding.graded(not against, against < steps // 2, numbers)


def _more_wear_when_rough(smooth: StudyCase, rough: StudyCase) -> Finding:
    cycles = [cycle for cycle in smooth.cycles if 0 < cycle <= RUN_IN and cycle in rough.cycles]
    ratios = {
        what: [rough.largest(name, n) / smooth.largest(name, n) for n in cycles]
        for what, name in (("volume", "wear_volume"), ("largest depth", "wear_depth"))
    }
    numbers = {
        f"{what}, rough to smooth, cycle {cycle_text(cycles[index])}": short(values[index])
        for what, values in ratios.items()
        for index in (0, -1)
    }
    every = [value for values in ratios.values() for value in values]
    return Finding.graded(min(every) > 1.0, max(every) > 1.0, numbers)


def _asperities_behave_as_smooth(case: StudyCase) -> Finding:
    cycle, apart = case.nearest(RUN_IN), deviation_from_hertz(case)
    share, behaving = asperities_like_the_whole(case, cycle)
    numbers = {
        "pressure apart from Hertz's in cycle 0": percent(apart),
        "load on asperities that stick and slip": percent(share),
        "snapshot": cycle_text(cycle),
        "share of that load that behaves as smooth": percent(behaving),
    }
    alike, behave = apart <= _ALIKE, behaving >= _MOST_ASPERITIES
    return Finding.graded(alike and behave, alike or behave, numbers)


def _roughness_matters(smooth: StudyCase, rough: StudyCase) -> Finding:
    names = ("wear_volume", "wear_depth", "stick_area", "contact_area")
    ratios = {}
    for cycle in (smooth.nearest(100), smooth.last):
        for name in names:
            both = (case.largest(name, cycle) for case in (rough, smooth))
            words = f"{RESULTS[name].words}, rough to smooth, cycle {cycle_text(cycle)}"
            ratios[words] = next(both) / next(both)
    apart = [abs(ratio - 1.0) > _ALMOST for ratio in ratios.values()]
    numbers = {words: short(ratio) for words, ratio in ratios.items()}
    return Finding.graded(all(apart), any(apart), numbers)


_MEASURES: tuple[Callable[..., Finding], ...] = (
    _pressure_moves_inward,
    _peak_at_stick_edge,
    _rough_becomes_smooth,
    _stick_zone,
    _wears_most_in_the_middle,
    _even_wear,
    _asperities,
    _width_grows_faster_when_rough,
    _shear_like_pressure,
    _more_wear_when_rough,
    _asperities_behave_as_smooth,
    _roughness_matters,
)
_SUBJECTS: Mapping[str, Mapping[str, Sequence[str]]] = {
    "each": {title: (title,) for title in TITLES},
    "smooth elastic": {"smooth elastic": ("smooth elastic",)},
    "rough": {title: (title,) for title in TITLES if title.startswith("rough")},
    "pairs": {body: (f"smooth {body}", f"rough {body}") for body in ("elastic", "plastic")},
}


def _claims() -> Iterator[PublishedClaim]:
    """The claims of the table beside this module."""
    table = pd.read_csv(Path(__file__).with_suffix(".csv"))
    for row, measure in zip(table.itertuples(), _MEASURES, strict=True):
        subjects = _SUBJECTS[row.subjects]
        yield PublishedClaim(row.number, row.words, row.criterion, subjects, measure)


CLAIMS = tuple(_claims())
"""All claims, in the order of their numbers; 10 to 12 come from the study's conclusions."""


_INTRODUCTION = Markup(
    "<p>The claims of the study “Wear investigation of rough bodies in contact under partial slip "
    "conditions”, judged by numbers measured on the cases that have its parameters. The source "
    "gives no radius R of the sphere. It takes slip and stick zone of the unworn smooth sphere for "
    "every cycle (<code>cattaneo_mindlin</code>); slip can also follow the worn shape, "
    "along x (<code>cerruti</code>), by which verdicts are, or alike in all directions "
    "(<code>jaeger</code>). By <code>jaeger</code> an elastic stick zone is constant by identity: "
    "wear outside it cannot change the contact under the reduced load, which is the stick zone."
    "</p>"
)
_MEASURED = Markup(
    "<h3>What was measured</h3><p>The stick zone is the smallest disc around all cells that stick, "
    "the slip zone the ring around it up to the outermost cell in contact. A place in the slip "
    "zone counts from 0 at the edge of stick to 1 at the rim.</p>"
)


def source_sections(summary: xr.Dataset, folder: Path) -> Iterator[Section]:
    """Yield the section on the source study from a merged study's case files.

    It judges the claims at every radius and with every slip model. A study without the four cases
    of the source study has none.
    """
    judged = {
        f"R = {value_text('radius', radius)}, {MODELS.get(model, model)}": [
            claim.judge(cases) for claim in CLAIMS
        ]
        for model, radius, cases in reference_cases(summary, folder)
    }
    if not judged:
        return
    claims = [
        {"No.": claim.number, "Claim": claim.words, "How it is read": claim.criterion}
        | {column: common_verdict(group[row]).value for column, group in judged.items()}
        for row, claim in enumerate(CLAIMS)
    ]
    measured = [
        {"Claim": claim.number, "Case": subject}
        | {column: group[row][subject].text for column, group in judged.items()}
        for row, claim in enumerate(CLAIMS)
        for subject in claim.subjects
    ]
    body = _INTRODUCTION + table_html(pd.DataFrame(claims))
    body += _MEASURED + table_html(pd.DataFrame(measured))
    yield Section("claims", "Claims of the source study", body)
