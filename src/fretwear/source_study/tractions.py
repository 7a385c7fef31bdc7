"""Claims about pressure and shear: where they rise and fall, where they peak."""

from __future__ import annotations

import numpy as np

from fretwear.source_study.evolution import Array, Evolution
from fretwear.source_study.quartet import Quartet
from fretwear.source_study.verdict import (
    Answer,
    Finding,
    Judgement,
    Measurement,
    joined,
    percent,
    snapshot,
)

_NOISE = 0.01
_NOTHING = 1e-3
_PEAK_CELLS = 2.0
_ALIKE = 0.05


def pressure_moves_inward(quartet: Quartet) -> Judgement:
    """Claim 1: pressure rises in the stick zone and falls in the slip zone."""
    return Judgement(
        1,
        "Pressure rises in the stick zone and falls in the slip zone.",
        "The mean pressure over the stick zone rises, that over the slip zone falls, from every "
        "snapshot to the next (steps back by up to 1 %, or 0.1 % of the first mean, count as none) "
        "and by more than 1 % in all.",
        tuple(_moves_inward(name, case, "pressure") for name, case in quartet.each()),
    )


def peak_at_stick_edge(quartet: Quartet) -> Judgement:
    """Claim 2: the smooth elastic peak sits at the edge of the stick zone."""
    case = quartet.smooth_elastic
    offsets = {cycle: _peak_offset(case, cycle) for cycle in case.worn_cycles}
    at_edge = [cycle for cycle, offset in offsets.items() if abs(offset) <= _PEAK_CELLS]
    since = _since(case.worn_cycles, at_edge)
    if since == case.worn_cycles[0]:
        answer, remark = Answer.YES, ""
    elif since is not None:
        before = max(cycle for cycle in case.worn_cycles if cycle < since)
        answer = Answer.PARTLY
        remark = f"at the edge from cycle {since} on, not yet at cycle {before}"
    else:
        answer = Answer.NO
        remark = "the peak is somewhere else after the last cycle"
    numbers = (
        Measurement("peak beyond the edge after the last cycle", offsets[case.last], "cells"),
        Measurement("first snapshot with the peak at the edge", snapshot(since)),
    )
    return Judgement(
        2,
        "The smooth elastic peak sits at the edge of the stick zone.",
        "At every snapshot after cycle 0 the cell of highest pressure is within two cells of the "
        "edge of the stick zone.",
        (Finding("smooth elastic", answer, numbers, remark),),
    )


def shear_behaves_like_pressure(quartet: Quartet) -> Judgement:
    """Claim 9: shear behaves like pressure."""
    return Judgement(
        9,
        "Shear behaves like pressure.",
        "Since cycle 0, shear q has changed as µ times the pressure p has: ∬|Δq − µΔp| is at most "
        "5 % of ∬|µΔp| at every snapshot. In part: only its means over stick and slip zone move "
        "as claim 1 says.",
        tuple(_shear_follows(name, case) for name, case in quartet.each()),
    )


def zone_means(case: Evolution, name: str) -> tuple[Array, Array]:
    """Means of a field over the stick zone and over the slip zone at every snapshot.

    Parameters
    ----------
    case : Evolution
        The case.
    name : str
        Name of the field.

    Returns
    -------
    stick, slip : array of shape (ncycles,)
        In the unit of the field; both zones are those of the snapshot.
    """
    means = []
    for cycle in case.cycles:
        field, zones = case.field(name, cycle), case.zones(cycle)
        means.append([float(field[zone].mean()) for zone in (zones.stick, zones.slip)])
    stick, slip = np.array(means).T
    return stick, slip


def _moves_inward(subject: str, case: Evolution, field: str) -> Finding:
    stick, slip = zone_means(case, field)
    numbers = (
        Measurement("stick zone, last to first", float(stick[-1] / stick[0])),
        Measurement("slip zone, last to first", float(slip[-1] / slip[0])),
    )
    steps_back = (
        *(f"falls in the stick zone {step}" for step in _steps_back(case, stick)),
        *(f"rises in the slip zone {step}" for step in _steps_back(case, -slip)),
    )
    in_all = stick[-1] > (1 + _NOISE) * stick[0] and slip[-1] < (1 - _NOISE) * slip[0]
    if in_all and not steps_back:
        return Finding(subject, Answer.YES, numbers)
    steps = f"it {joined(steps_back)}" if steps_back else "it hardly changes"
    return Finding(subject, Answer.PARTLY if in_all else Answer.NO, numbers, steps)


def _steps_back(case: Evolution, values: Array) -> list[str]:
    """Between which snapshots values that should rise fall instead by more than noise."""
    noise = np.maximum(_NOISE * np.abs(values[:-1]), _NOTHING * abs(values[0]))
    back = np.flatnonzero(np.diff(values) < -noise)
    runs = np.split(back, np.flatnonzero(np.diff(back) > 1) + 1) if back.size else []
    return [f"from cycle {case.cycles[run[0]]} to {case.cycles[run[-1] + 1]}" for run in runs]


def _peak_offset(case: Evolution, cycle: int) -> float:
    """How far outside the edge of stick the pressure peaks, in cells."""
    pressure = case.field("pressure", cycle)
    peak = case.radius[np.unravel_index(int(pressure.argmax()), pressure.shape)]
    return float((peak - case.zones(cycle).stick_radius) / case.spacing)


def _since(cycles: tuple[int, ...], right: list[int]) -> int | None:
    """The first snapshot from which on all are right; None when the last one is not."""
    since = None
    for cycle in reversed(cycles):
        if cycle not in right:
            break
        since = cycle
    return since


def _shear_follows(subject: str, case: Evolution) -> Finding:
    friction = case.parameter("friction")
    first_q, first_p = (case.field(name, 0) for name in ("shear_traction", "pressure"))
    apart = []
    for cycle in case.worn_cycles:
        shear = case.field("shear_traction", cycle) - first_q
        pressure = friction * (case.field("pressure", cycle) - first_p)
        apart.append(float(np.abs(shear - pressure).sum() / np.abs(pressure).sum()))
    worst = max(apart)
    numbers = (
        Measurement("largest difference of the changes", 100.0 * worst, "%"),
        Measurement("difference after the last cycle", 100.0 * apart[-1], "%"),
    )
    if worst <= _ALIKE:
        return Finding(subject, Answer.YES, numbers)
    means = _moves_inward(subject, case, "shear_traction")
    differs = f"the changes of q and µp differ by up to {percent(worst)}"
    if means.answer is Answer.YES:
        remark = f"{differs}, yet q rises in the stick zone and falls in the slip zone as p does"
        return Finding(subject, Answer.PARTLY, numbers, remark)
    return Finding(subject, Answer.NO, numbers, f"{differs}, and {means.remark}")
