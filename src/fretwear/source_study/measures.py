"""What is measured for each claim of the source study, and whether the numbers meet it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from fretwear.source_study.cases import RUN_IN, Array, Evolution, Mask
from fretwear.units import cycle_text, number_text
from fretwear.vocabulary import ContactState

_NEGLIGIBLE = 1e-4
_NOISE = 1e-3
_PEAK_CELLS = 2.0
_ALMOST = 0.05
_OUTER_PART = 0.75
_MIDDLE_THIRD = (1.0 / 3.0, 2.0 / 3.0)
_MIDDLE_HALF = (0.25, 0.75)
_BEGINNING = 0.1
_EVEN = 0.1
_STILL_WEARING = 0.01
_ON_TIPS = 0.9
_WORN_OFF = 0.1
_EARLY, _MUCH = 100.0, 1.5


class Answer(Enum):
    """Whether a claim holds, in words."""

    HOLDS = "holds"
    IN_PART = "in part"
    FAILS = "does not hold"


@dataclass(frozen=True)
class Finding:
    """What one case, or a smooth and a rough one together, say to a claim.

    Attributes
    ----------
    answer : Answer
        Whether the claim holds for them.
    numbers : mapping of str to str
        What the answer rests on: each number with its unit, by what was measured.
    remark : str
        Why it does not hold, or what of it does; empty where it holds.
    """

    answer: Answer
    numbers: Mapping[str, str]
    remark: str


def short(value: float) -> str:
    """Return a number with three significant digits, or a dash for NaN."""
    if math.isnan(value):
        return "–"
    return number_text(0.0 if abs(value) < _NEGLIGIBLE else value, 3)


def percent(share: float) -> str:
    """Return a share in percent, as `short` writes it."""
    return f"{short(100.0 * share)} %"


def _finding(holds: bool, in_part: bool, remark: str, numbers: Mapping[str, str]) -> Finding:
    """Grade a claim; the remark is for where it does not hold as a whole."""
    answer = Answer.HOLDS if holds else Answer.IN_PART if in_part else Answer.FAILS
    return Finding(answer, numbers, "" if holds else remark)


def zone_means(case: Evolution, name: str) -> tuple[Array, Array]:
    """Means of a field over the first stick disc and over the ring around it, each (ncycles,).

    The disc is that of cycle 0 at every snapshot; the ring ends with the contact of the snapshot.
    """
    disc = case.zones(0).stick
    means = []
    for cycle in case.cycles:
        field = case.field(name, cycle)
        ring = ~disc & (case.radius <= case.zones(cycle).contact_radius)
        means.append([float(field[zone].mean()) for zone in (disc, ring)])
    stick, slip = np.array(means).T
    return stick, slip


def _steps(values: Array) -> Array:
    """Whether a series rises (1), falls (-1) or stays (0) from each snapshot to the next."""
    change = np.diff(values)
    steps: Array = np.where(np.abs(change) > _NOISE * abs(values[0]), np.sign(change), 0.0)
    return steps


def _last_to_first(stick: Array, slip: Array) -> dict[str, str]:
    return {
        "stick zone, last to first": short(stick[-1] / stick[0]),
        "slip zone, last to first": short(slip[-1] / slip[0]),
    }


def pressure_moves_inward(case: Evolution) -> Finding:
    """Claim 1: pressure rises in the stick zone and falls in the slip zone."""
    stick, slip = zone_means(case, "pressure")
    against = {
        "falls in the stick zone": _steps(stick) < 0.0,
        "rises in the slip zone": _steps(slip) > 0.0,
    }
    back = [
        f"{what} from cycle {cycle_text(case.cycles[int(steps.argmax())])} on"
        for what, steps in against.items()
        if steps.any()
    ]
    in_all = bool(stick[-1] > stick[0] and slip[-1] < slip[0])
    remark = f"it {' and '.join(back)}" if back else "it does not change"
    return _finding(in_all and not back, in_all, remark, _last_to_first(stick, slip))


def peak_at_stick_edge(case: Evolution) -> Finding:
    """Claim 2: after the last cycle pressure peaks at the edge of the stick zone."""
    pressure = case.field("pressure", case.last)
    peak = case.radius[np.unravel_index(int(pressure.argmax()), pressure.shape)]
    beyond = float(peak - case.zones(case.last).stick_radius) / max(case.sides)
    growth_of_peak = float(pressure.max() / case.field("pressure", 0).max())
    numbers = {
        "peak beyond the edge": f"{short(beyond)} cells",
        "peak, last to first": short(growth_of_peak),
    }
    return _finding(abs(beyond) <= _PEAK_CELLS, False, "the peak is elsewhere", numbers)


def rough_becomes_smooth(smooth: Evolution, rough: Evolution) -> Finding:
    """Claim 3: after about 7000 cycles rough and smooth are almost alike in the slip zone."""
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
    return _finding(
        pressure <= _ALMOST * mean_pressure and slip <= _ALMOST * mean_slip,
        in_figure,
        f"{'equal' if in_figure else 'not equal even'} on the scale of a figure",
        numbers,
    )


def differences(
    smooth: Evolution, rough: Evolution, field: str, cycle: int
) -> tuple[float, float, float]:
    """How far rough and smooth are apart in the slip zone that they have in common.

    Returns
    -------
    apart, mean, largest : float
        Mean of |rough − smooth|, mean and largest value of the smooth one, unit of the field.
    """
    both = [smooth.zones(cycle), rough.zones(cycle)]
    inner = max(zones.stick_radius for zones in both)
    outer = min(zones.contact_radius for zones in both)
    zone = (rough.radius > inner) & (rough.radius <= outer)
    if not zone.any():
        return math.nan, math.nan, math.nan
    # Linear between the cells of the smooth case; nearer the middle its first value holds.
    given = smooth.dataset[field].sel(cycle=cycle).astype(float)
    places = {n: rough.dataset[n].clip(given[n].min(), given[n].max()) for n in ("x", "y")}
    reference = given.interp(places).transpose("x", "y").values[zone]
    apart = np.abs(rough.field(field, cycle)[zone] - reference)
    return float(apart.mean()), float(reference.mean()), float(reference.max())


def stick_zone(case: Evolution) -> Finding:
    """Claim 4: the stick zone of elastic bodies stays, that of yielding ones reduces."""
    if math.isinf(case.parameter("plastic_limit")):
        sticks, slips = (
            np.any([case.is_in(state, cycle) for cycle in case.cycles], axis=0)
            for state in (ContactState.STICK, ContactState.SLIP)
        )
        changed, what = int((sticks & slips).sum()), "cells that go from stick to slip or back"
        return _finding(not changed, False, f"{changed} {what}", {what: str(changed)})
    area = case.dataset["stick_area"].values
    yields = [cycle for cycle in case.cycles if _edge_yields(case, cycle)]
    elastic = [cycle for cycle in case.cycles if case.scalar("plastic_volume", cycle) == 0.0]
    rises = np.flatnonzero(np.diff(area) >= 0.0)
    falls = case.cycles[rises[-1] + 1] if rises.size else 0
    reduces = bool(yields) and falls < case.last and bool(area[-1] < area[0])
    if not yields:
        remark = "its edge does not yield"
    elif not reduces:
        remark = "its edge yields, but it does not reduce"
    else:
        remark = f"the area that sticks falls only from cycle {cycle_text(falls)} on"
    extent = case.zones(case.last).stick_radius / case.zones(0).stick_radius
    numbers = {
        "stick area left": percent(area[-1] / area[0]),
        "largest on the way": percent(area.max() / area[0]),
        "radius of the zone left": percent(extent),
        "edge yields by cycle": cycle_text(yields[0]) if yields else "–",
    }
    return _finding(reduces and falls <= max(elastic, default=0), reduces, remark, numbers)


def _edge_yields(case: Evolution, cycle: int) -> bool:
    """Whether there is plastic depth in the outer quarter of the stick zone."""
    zones = case.zones(cycle)
    edge = zones.stick & (case.radius >= _OUTER_PART * zones.stick_radius)
    return bool(case.field("plastic_depth", cycle)[edge].max(initial=0.0) > 0.0)


def largest_on_rings(case: Evolution, name: str, cycle: int) -> tuple[float, float]:
    """Where in the slip zone a field, averaged over rings, is largest, and its value there.

    The place is 0 at the edge of stick and 1 at the outer rim, the value in the field's unit.
    """
    zones = case.zones(cycle)
    radius, mean, _ = case.rings(case.field(name, cycle), case.radius <= zones.contact_radius)
    largest = int(mean.argmax())
    return float(zones.place(radius[largest])), float(mean[largest])


def deepest_in_the_middle(case: Evolution) -> Finding:
    """Claim 5: wear is largest in the middle of the slip zone and at the beginning."""
    places = {c: largest_on_rings(case, "wear_depth", c)[0] for c in case.cycles[1:]}
    rates = {c: largest_on_rings(case, "wear_rate", c)[1] for c in case.cycles}
    most = max(rates, key=lambda cycle: rates[cycle])
    start, end = _MIDDLE_THIRD
    middle = [cycle_text(cycle) for cycle, place in places.items() if start <= place <= end]
    early = most <= _BEGINNING * case.last
    remark = f"in the middle from cycle {middle[0]} to {middle[-1]}" if middle else "never there"
    numbers = {
        "place after the first cycle": short(places[case.cycles[1]]),
        "place after the last cycle": short(places[case.last]),
        "snapshots in the middle third": percent(len(middle) / len(places)),
        "cycle that wears most": cycle_text(most),
    }
    return _finding(
        len(middle) == len(places) and early,
        bool(middle),
        remark if early else f"{remark}; the cycle that wears most is {cycle_text(most)}",
        numbers,
    )


def unevenness(case: Evolution, cycle: int, start: float = 0.0, end: float = 1.0) -> float:
    """Standard deviation of the wear of one cycle over the slip zone, of its mean.

    `start` and `end` choose a part of the zone, in fractions of its width.
    """
    part = case.zones(cycle).between(start, end)
    _, values, cells = case.rings(case.field("wear_rate", cycle), part)
    mean = float(np.average(values, weights=cells))
    variance = float(np.average((values - mean) ** 2, weights=cells))
    return math.sqrt(variance) / mean if mean > 0.0 else math.inf


def even_wear(case: Evolution) -> Finding:
    """Claim 6: the wear of one cycle becomes almost constant over the slip zone."""
    means = [case.field("wear_rate", n)[case.zones(n).slip].mean() for n in case.cycles]
    cycle = case.cycles[np.flatnonzero(np.array(means) >= _STILL_WEARING * means[0])[-1]]
    now, middle = unevenness(case, cycle), unevenness(case, cycle, *_MIDDLE_HALF)
    numbers = {
        "snapshot": cycle_text(cycle),
        "unevenness in cycle 0": percent(unevenness(case, 0)),
        "unevenness there": percent(now),
        "over the middle half": percent(middle),
    }
    remark = "over the middle half only" if middle <= _EVEN else "nor over the middle half"
    return _finding(now <= _EVEN, middle <= _EVEN, remark, numbers)


def amplitude_left(case: Evolution, cycle: int, zone: Mask) -> float:
    """Amplitude of the waves on the worn and yielded surface in a zone, of the first one's.

    Rings are averaged out, so that the wear scar itself does not count.
    """
    amplitude = case.parameter("roughness_amplitude")
    changed = case.field("wear_depth", cycle) + case.field("plastic_depth", cycle)
    shape, pattern = amplitude * case.waves + changed, case.waves[zone]
    radius, mean, _ = case.rings(shape, zone)
    local = shape[zone] - np.interp(case.radius[zone], radius, mean)
    return float((local * pattern).sum() / (pattern**2).sum()) / amplitude


def asperities(case: Evolution) -> Finding:
    """Claim 7: wear is first on asperities, and after 7000 cycles the slip zone has none left."""
    wear, pressure = case.field("wear_rate", 0), case.field("pressure", 0)
    on_tips = float(wear[case.waves < 0.0].sum() / wear.sum())
    there = float((pressure * wear).sum() / wear.sum() / pressure[case.zones(0).slip].mean())
    cycle = case.nearest(RUN_IN)
    zones = case.zones(cycle)
    slip = amplitude_left(case, cycle, zones.slip)
    middle = amplitude_left(case, cycle, zones.between(*_MIDDLE_HALF))
    first = on_tips >= _ON_TIPS and there > 1.0
    numbers = {
        "wear on tips in cycle 0": percent(on_tips),
        "pressure where it wears, to the slip zone's mean": short(there),
        "snapshot": cycle_text(cycle),
        "amplitude left in the slip zone": percent(slip),
        "in its middle half": percent(middle),
    }
    gone, gone_in_part = abs(slip) <= _WORN_OFF, abs(middle) <= _WORN_OFF
    remark = "gone in the middle half only" if gone_in_part else "asperities remain"
    if not first:
        remark = "wear is not first on asperities"
    return _finding(first and gone, first or gone_in_part, remark, numbers)


def growth(case: Evolution, cycle: float) -> float:
    """Growth of the contact half-width since cycle 0, m."""
    return case.at("contact_half_width_x", cycle) - case.at("contact_half_width_x", 0.0)


def late_growth(case: Evolution) -> float:
    """Share of the whole growth that falls into the second half of the cycles."""
    whole = growth(case, case.last)
    return 1.0 - growth(case, 0.5 * case.last) / whole if whole > 0.0 else 0.0


def width_grows_faster_when_rough(smooth: Evolution, rough: Evolution) -> Finding:
    """Claim 8: the rough contact widens much faster and ends almost as wide as the smooth one."""
    ratio = growth(rough, _EARLY) / growth(smooth, _EARLY)
    last = [case.at("contact_half_width_x", case.last) for case in (rough, smooth)]
    level = last[0] / last[1] - 1.0
    late = max(late_growth(smooth), late_growth(rough))
    reasons = {
        f"it grows {short(ratio)} times as much": ratio < _MUCH,
        f"the last widths are {percent(abs(level))} apart": abs(level) > _ALMOST,
        f"{percent(late)} of the growth is in the second half of the cycles": late > _ALMOST,
    }
    against = [reason for reason, applies in reasons.items() if applies]
    numbers = {
        f"growth by cycle {_EARLY:.0f}, rough to smooth": short(ratio),
        "growth by cycle 1000": short(growth(rough, 1000.0) / growth(smooth, 1000.0)),
        "rough beyond smooth at the end": percent(level),
        "growth in the second half": f"{percent(late)} of all",
    }
    stabilises = abs(level) <= _ALMOST and late <= _ALMOST
    return _finding(not against, ratio >= _MUCH or stabilises, " and ".join(against), numbers)


def shear_like_pressure(case: Evolution) -> Finding:
    """Claim 9: shear behaves like pressure."""
    shear, pressure = (zone_means(case, name) for name in ("shear_traction", "pressure"))
    opposite = [_steps(q) * _steps(p) < 0.0 for q, p in zip(shear, pressure, strict=True)]
    against, steps = int(np.sum(opposite)), np.size(opposite)
    numbers = {
        **_last_to_first(*shear),
        "changes against those of pressure": f"{against} of {steps}",
    }
    remark = f"{against} of {steps} changes go the other way"
    return _finding(not against, against < steps // 2, remark, numbers)


def more_wear_when_rough(smooth: Evolution, rough: Evolution) -> Finding:
    """Claim 10: at the beginning rough bodies wear more."""
    cycles = [cycle for cycle in smooth.cycles if 0 < cycle <= RUN_IN and cycle in rough.cycles]
    ratios = {
        "volume": [
            rough.scalar("wear_volume", n) / smooth.scalar("wear_volume", n) for n in cycles
        ],
        "largest depth": [
            rough.field("wear_depth", n).max() / smooth.field("wear_depth", n).max() for n in cycles
        ],
    }
    numbers = {
        f"{what}, rough to smooth, cycle {cycle_text(cycles[index])}": short(values[index])
        for what, values in ratios.items()
        for index in (0, -1)
    }
    less = [
        f"less {what} at cycle {', '.join(lower)}"
        for what, values in ratios.items()
        if (lower := [cycle_text(n) for n, v in zip(cycles, values, strict=True) if v <= 1.0])
    ]
    higher = max(map(max, ratios.values())) > 1.0
    return _finding(not less, bool(higher), " and ".join(less), numbers)
