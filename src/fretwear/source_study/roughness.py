"""Claims about roughness: when it stops to matter, and what becomes of its asperities."""

from __future__ import annotations

import numpy as np

from fretwear.data.merge import Resampling
from fretwear.source_study.evolution import Array, Evolution, Mask, rings
from fretwear.source_study.quartet import Pair, Quartet
from fretwear.source_study.verdict import Answer, Finding, Judgement, Measurement, percent

RUN_IN = 7000
"""The cycle after which, the study says, rough and smooth are alike."""

_ALIKE = 0.05
_ON_TIPS = 0.9
_GONE, _REMAIN, _REMAIN_IN_PART = 0.1, 0.9, 0.5
_MIDDLE_HALF = (0.25, 0.75)


def rough_becomes_smooth(quartet: Quartet) -> Judgement:
    """Claim 3: after about 7000 cycles rough and smooth agree in the slip zone."""
    return Judgement(
        3,
        "After about 7000 cycles pressure and slip of the rough contact equal the smooth one's in "
        "the slip zone.",
        f"At the snapshot nearest cycle {RUN_IN}, over the slip zone that both have in common, the "
        "mean difference of pressure and that of slip are at most 5 % of the smooth contact's "
        "mean. In part: at most 5 % of the Hertz pressure and of the smooth contact's largest "
        "slip, as good as equal in a figure.",
        tuple(_alike(pair) for pair in quartet.pairs()),
    )


def asperities(quartet: Quartet) -> Judgement:
    """Claim 7: wear starts on tips; asperities go in the slip zone, stay in the stick zone."""
    rough = (("rough elastic", quartet.rough_elastic), ("rough plastic", quartet.rough_plastic))
    return Judgement(
        7,
        "Rough: wear starts on asperity tips; later the asperities in the slip zone are gone, "
        "those in the stick zone remain.",
        "In cycle 0 at least 90 % of the wear is on the half of the surface that stands out; "
        "after the last cycle the waves have at most 10 % of their amplitude left in the slip "
        "zone and at least 90 % in the stick zone. In part: at most 10 % in the middle half of "
        "the slip zone, at least 50 % in the stick zone.",
        tuple(_asperities(name, case) for name, case in rough),
    )


def differences(pair: Pair, field: str, cycle: int) -> tuple[float, float, float]:
    """How far rough and smooth are apart in the slip zone that they have in common.

    Parameters
    ----------
    pair : Pair
        The cases.
    field : str
        Name of the field.
    cycle : int
        A snapshot of both.

    Returns
    -------
    apart, mean, largest : float
        Mean of |rough − smooth|, mean and largest value of the smooth one, unit of the field.
    """
    smooth, rough = pair.smooth, pair.rough
    both = [smooth.zones(cycle), rough.zones(cycle)]
    inner = max(zones.stick_radius for zones in both)
    outer = min(zones.contact_radius for zones in both)
    zone = (rough.radius > inner) & (rough.radius <= outer)
    if not zone.any():
        return np.nan, np.nan, np.nan
    reference = _brought_to(rough, smooth, field, cycle)[zone]
    apart = np.abs(rough.field(field, cycle)[zone] - reference)
    return float(apart.mean()), float(reference.mean()), float(reference.max())


def amplitude_left(case: Evolution, cycle: int, zone: Mask) -> float:
    """Amplitude of the waves on the worn and yielded surface in a zone, of the first one's.

    Rings are averaged out, so that the wear scar itself does not count.
    """
    waves = _waves(case)
    changed = case.field("wear_depth", cycle) + case.field("plastic_depth", cycle)
    shape = case.parameter("roughness_amplitude") * waves + changed
    profile = rings(case, shape, zone)
    local = shape[zone] - np.interp(case.radius[zone], profile.radius, profile.mean)
    pattern = waves[zone]
    projected = float((local * pattern).sum() / (pattern**2).sum())
    return projected / case.parameter("roughness_amplitude")


def share_on_tips(case: Evolution, cycle: int) -> float:
    """Share of the wear of one cycle on cells where the waves stand out of their mean."""
    wear = case.field("wear_rate", cycle)
    return float(wear[_waves(case) < 0.0].sum() / wear.sum())


def _alike(pair: Pair) -> Finding:
    cycle = pair.smooth.nearest(RUN_IN)
    pressure, mean_pressure, _ = differences(pair, "pressure", cycle)
    slip, mean_slip, largest_slip = differences(pair, "slip", cycle)
    hertz = pair.smooth.parameter("hertz_pressure")
    numbers = (
        Measurement(f"pressure, cycle {cycle}", 100.0 * pressure / mean_pressure, "% of mean"),
        Measurement(f"slip, cycle {cycle}", 100.0 * slip / mean_slip, "% of mean"),
        Measurement("pressure", 100.0 * pressure / hertz, "% of Hertz"),
        Measurement("slip", 100.0 * slip / largest_slip, "% of largest"),
    )
    if pressure <= _ALIKE * mean_pressure and slip <= _ALIKE * mean_slip:
        return Finding(pair.subject, Answer.YES, numbers)
    apart = (
        f"pressure {percent(pressure / mean_pressure)} and slip {percent(slip / mean_slip)} apart "
        f"at cycle {cycle}"
    )
    if pressure <= _ALIKE * hertz and slip <= _ALIKE * largest_slip:
        remark = f"{apart}, equal only on the scale of a figure"
        return Finding(pair.subject, Answer.PARTLY, numbers, remark)
    return Finding(pair.subject, Answer.NO, numbers, apart)


def _asperities(subject: str, case: Evolution) -> Finding:
    zones = case.zones(case.last)
    on_tips = share_on_tips(case, 0)
    slip = amplitude_left(case, case.last, zones.slip)
    middle = amplitude_left(case, case.last, zones.between(*_MIDDLE_HALF))
    stick = amplitude_left(case, case.last, zones.stick)
    numbers = (
        Measurement("wear on tips in cycle 0", 100.0 * on_tips, "%"),
        Measurement("amplitude left in the slip zone", 100.0 * slip, "%"),
        Measurement("in its middle half", 100.0 * middle, "%"),
        Measurement("amplitude left in the stick zone", 100.0 * stick, "%"),
    )
    starts = on_tips >= _ON_TIPS
    if starts and abs(slip) <= _GONE and stick >= _REMAIN:
        return Finding(subject, Answer.YES, numbers)
    remark = (
        f"{percent(slip)} of the amplitude is left in the slip zone "
        f"({percent(middle)} in its middle half) and {percent(stick)} in the stick zone"
    )
    partly = starts and abs(middle) <= _GONE and stick >= _REMAIN_IN_PART
    return Finding(subject, Answer.PARTLY if partly else Answer.NO, numbers, remark)


def _waves(case: Evolution) -> Array:
    along_x, along_y = case.wavenumbers
    pattern: Array = np.cos(along_x * case.x) * np.cos(along_y * case.y)
    return pattern


def _brought_to(target: Evolution, source: Evolution, field: str, cycle: int) -> Array:
    """A field of one case on the cells of another, linear between its own."""
    along_x, along_y = (
        Resampling(source.dataset[name].values, target.dataset[name].values) for name in ("x", "y")
    )
    return along_y.linear(along_x.linear(source.field(field, cycle), 0), 1)
