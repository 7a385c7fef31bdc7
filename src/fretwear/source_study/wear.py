"""Claims about wear over the slip zone: where it is deepest, how even one cycle's is."""

from __future__ import annotations

import math

import numpy as np

from fretwear.source_study.evolution import Evolution, rings
from fretwear.source_study.quartet import Quartet
from fretwear.source_study.verdict import (
    Answer,
    Finding,
    Judgement,
    Measurement,
    joined,
    percent,
    short,
)

_MIDDLE = (1.0 / 3.0, 2.0 / 3.0)
_MIDDLE_HALF = (0.25, 0.75)
_EVEN = 0.1
_STILL_WEARING = 0.01


def deepest_in_the_middle(quartet: Quartet) -> Judgement:
    """Claim 5: the deepest wear is in the middle of the slip zone."""
    return Judgement(
        5,
        "The deepest wear is in the middle of the slip zone.",
        "Averaged over rings, wear is deepest in the middle third of the slip zone at every "
        "snapshot after cycle 0. In part: at some snapshots.",
        tuple(_deepest(name, case) for name, case in quartet.each()),
    )


def even_wear(quartet: Quartet) -> Judgement:
    """Claim 6: the wear of one cycle tends to a constant over the slip zone."""
    return Judgement(
        6,
        "The wear of one cycle tends to a constant over the slip zone.",
        "Averaged over rings, its standard deviation over the slip zone has become smaller since "
        "cycle 0 and is at most 10 % of the mean, at the last snapshot at which the mean is still "
        "at least 1 % of the first. In part: at most 10 % over the middle half of the slip zone.",
        tuple(_even(name, case) for name, case in quartet.each()),
    )


def place_of_deepest(case: Evolution, cycle: int) -> float:
    """Where wear is deepest in the slip zone: 0 at the edge of stick, 1 at its outer rim."""
    zones = case.zones(cycle)
    profile = rings(case, case.field("wear_depth", cycle), case.radius <= zones.contact_radius)
    return float(zones.place(profile.radius[int(profile.mean.argmax())]))


def unevenness(case: Evolution, cycle: int, start: float = 0.0, end: float = 1.0) -> float:
    """Standard deviation of the wear of one cycle over (part of) the slip zone, of its mean.

    Parameters
    ----------
    case, cycle
        The case and a snapshot of it.
    start, end : float
        The part, in fractions of the width of the slip zone.
    """
    part = case.zones(cycle).between(start, end)
    profile = rings(case, case.field("wear_rate", cycle), part)
    mean = float(np.average(profile.mean, weights=profile.cells))
    variance = float(np.average((profile.mean - mean) ** 2, weights=profile.cells))
    return math.sqrt(variance) / mean if mean > 0.0 else math.inf


def _deepest(subject: str, case: Evolution) -> Finding:
    places = {cycle: place_of_deepest(case, cycle) for cycle in case.worn_cycles}
    right = [cycle for cycle, place in places.items() if _MIDDLE[0] <= place <= _MIDDLE[1]]
    numbers = (
        Measurement("place after the first cycle", places[case.worn_cycles[0]]),
        Measurement("place after the last cycle", places[case.last]),
        Measurement("snapshots in the middle third", 100.0 * len(right) / len(places), "%"),
    )
    if len(right) == len(places):
        return Finding(subject, Answer.YES, numbers)
    when = f"at cycle {joined([str(cycle) for cycle in right])} only" if right else "never"
    remark = f"{when}; after the last one at {short(places[case.last])} of its width"
    return Finding(subject, Answer.PARTLY if right else Answer.NO, numbers, remark)


def _even(subject: str, case: Evolution) -> Finding:
    cycle = _last_wearing(case)
    first, now = unevenness(case, 0), unevenness(case, cycle)
    middle = unevenness(case, cycle, *_MIDDLE_HALF)
    numbers = (
        Measurement("unevenness in cycle 0", 100.0 * first, "%"),
        Measurement(f"unevenness in cycle {cycle}", 100.0 * now, "%"),
        Measurement(f"middle half, cycle {cycle}", 100.0 * middle, "%"),
    )
    if now <= _EVEN and now < first:
        return Finding(subject, Answer.YES, numbers)
    if middle <= _EVEN and now < first:
        return Finding(subject, Answer.PARTLY, numbers, "only over the middle half of the zone")
    change = "more even than at first" if now < first else "no more even than at first"
    remark = f"{percent(now)} over the slip zone in cycle {cycle}, {change}"
    return Finding(subject, Answer.NO, numbers, remark)


def _last_wearing(case: Evolution) -> int:
    """The last snapshot with at least 1 % of the first mean wear of one cycle."""
    means = []
    for cycle in case.cycles:
        means.append(float(case.field("wear_rate", cycle)[case.zones(cycle).slip].mean()))
    wearing = np.flatnonzero(np.array(means) >= _STILL_WEARING * means[0])
    return case.cycles[int(wearing[-1])]
