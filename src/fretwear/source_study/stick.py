"""Claim about the stick zone: constant when elastic, shrinking when the bodies yield."""

from __future__ import annotations

import numpy as np

from fretwear.source_study.evolution import Evolution
from fretwear.source_study.quartet import Quartet
from fretwear.source_study.verdict import Answer, Finding, Judgement, Measurement, percent
from fretwear.vocabulary import ContactState

_GROWTH = 0.01
_SHRUNK = 0.9
_AT_LIMIT = 0.999
_EDGE = 0.75


def stick_zone(quartet: Quartet) -> Judgement:
    """Claim 4: the elastic stick zone never changes; the plastic one yields and shrinks."""
    elastic = (("smooth elastic", quartet.smooth_elastic), ("rough elastic", quartet.rough_elastic))
    plastic = (("smooth plastic", quartet.smooth_plastic), ("rough plastic", quartet.rough_plastic))
    return Judgement(
        4,
        "Elastic: the stick zone never changes. Plastic: its edge yields and it shrinks "
        "continuously.",
        "Elastic: the same cells stick at every snapshot. Plastic: pressure reaches the limit in "
        "the outer quarter of the stick zone; the stick area never exceeds its smallest value so "
        "far by more than 1 % of the first, shrinks from every snapshot to the next once bodies "
        "yield, and by more than 10 % in all. In part: it does so from a later cycle on.",
        tuple(_constant(name, case) for name, case in elastic)
        + tuple(_shrinking(name, case) for name, case in plastic),
    )


def _constant(subject: str, case: Evolution) -> Finding:
    first = case.state(0) == ContactState.STICK
    changed = max(
        int(((case.state(cycle) == ContactState.STICK) != first).sum()) for cycle in case.cycles
    )
    numbers = (Measurement("stick cells that ever changed", float(changed)),)
    if changed == 0:
        return Finding(subject, Answer.YES, numbers)
    return Finding(subject, Answer.NO, numbers, f"{changed} cells of {int(first.sum())} changed")


def _shrinking(subject: str, case: Evolution) -> Finding:
    area = np.array([case.scalar("stick_area", cycle) for cycle in case.cycles])
    left = float(area[-1] / area[0])
    extent = case.zones(case.last).stick_radius / case.zones(0).stick_radius
    yields = _edge_yields(case)
    since = _shrinks_since(case)
    growth = _largest_growth(case)
    numbers = (
        Measurement("stick area left", 100.0 * left, "%"),
        Measurement("largest growth on the way", 100.0 * growth, "%"),
        Measurement("radius of the zone left", 100.0 * extent, "%"),
        Measurement(
            "first snapshot with an edge at the limit", np.nan if yields is None else float(yields)
        ),
    )
    if yields is None:
        return Finding(subject, Answer.NO, numbers, "the edge of the stick zone does not yield")
    if since is None or left > _SHRUNK:
        return Finding(subject, Answer.NO, numbers, "the stick zone does not shrink")
    began = _first_yield(case)
    if since <= began and growth <= _GROWTH:
        return Finding(subject, Answer.YES, numbers)
    remark = (
        f"the area of the cells that stick shrinks from cycle {since} on, having grown by up to "
        f"{percent(growth)}, while the zone around them shrinks to {percent(extent)} of its radius"
    )
    return Finding(subject, Answer.PARTLY, numbers, remark)


def _edge_yields(case: Evolution) -> int | None:
    """The first snapshot at which pressure is at the limit in the outer part of stick."""
    for cycle in case.cycles:
        zones = case.zones(cycle)
        edge = zones.stick & (case.radius >= _EDGE * zones.stick_radius)
        limit = case.parameter("plastic_limit")
        if case.field("pressure", cycle)[edge].max(initial=0.0) >= _AT_LIMIT * limit:
            return cycle
    return None


def _first_yield(case: Evolution) -> int:
    """The last snapshot before the bodies yield, cycle 0 if they do so at once."""
    before = [cycle for cycle in case.cycles if case.scalar("plastic_volume", cycle) == 0.0]
    return before[-1] if before else 0


def _shrinks_since(case: Evolution) -> int | None:
    """The first snapshot from which the stick area shrinks to every following one."""
    area = [case.scalar("stick_area", cycle) for cycle in case.cycles]
    since = None
    for index in range(len(area) - 2, -1, -1):
        if area[index + 1] >= area[index]:
            break
        since = case.cycles[index]
    return since


def _largest_growth(case: Evolution) -> float:
    """By how much the stick area exceeded its smallest value so far, of its first value."""
    _, area = case.track("stick_area")
    return float((area - np.minimum.accumulate(area)).max() / area[0])
