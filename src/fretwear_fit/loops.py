"""A recording of many loops: friction, displacement and energy of each of its cycles."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from fretwear.arrays import Array
from fretwear.units import BY_SI_UNIT, QuantityError
from fretwear_measured.tables import read_text_table

_MOST_POINTS = 12  # of a table over cycles
_DISPLACEMENTS = ("displacement", "position", "stroke", "x")
_FORCES = ("force", "friction", "q", "fx", "load")


def loop_history(path: str | Path, load: float) -> pd.DataFrame:
    """The cycles of a recording under a normal load, N, or N/m of a line contact.

    Its columns are ``cycle`` from 0, ``displacement_amplitude`` (m), ``force_amplitude`` (N or
    N/m), ``dissipated_energy`` E = ∮ Q dδ (J or J/m), and ``friction`` E/(4 P δ₀), with half the
    width δ₀ of the loop at Q = 0: the coefficient of a contact that slides as a whole, whatever the
    compliance of the rig. A recording that begins or ends within a cycle loses that part.
    """
    table, example = read_text_table(Path(path)), "such as displacement (um),force (N)"
    x, _ = table.column(0, _DISPLACEMENTS, BY_SI_UNIT["m"], example)
    force, _ = table.column(1, _FORCES, BY_SI_UNIT["N"], example)
    there = np.isfinite(x) & np.isfinite(force)
    x, force = x[there], force[there]
    if not (cycles := _cycles_of(x)):
        raise QuantityError("has no complete cycle of its displacement")
    rows = [_loop(x[part], force[part]) for part in cycles]
    names = ["displacement_amplitude", "force_amplitude", "dissipated_energy", "width"]
    history = pd.DataFrame(rows, columns=names)
    history.insert(0, "cycle", np.arange(len(rows)))
    history["friction"] = history["dissipated_energy"] / (2.0 * load * history.pop("width"))
    return history


def _cycles_of(x: Array) -> list[slice]:
    """The complete cycles of a recorded displacement, from one rise through its mean to the next.

    A hysteresis of a quarter of the amplitude ignores noise at the mean.
    """
    middle, reach = 0.5 * (x.max() + x.min()), 0.125 * np.ptp(x)
    side = np.where(x > middle + reach, 1, np.where(x < middle - reach, -1, 0))
    places = np.flatnonzero(side)
    rises = places[1:][(side[places[1:]] > 0) & (side[places[:-1]] < 0)]
    return [slice(start, end) for start, end in pairwise(rises)]


def _loop(x: Array, force: Array) -> tuple[float, float, float, float]:
    """Amplitudes of displacement and force, energy, and width at the middle force of a loop."""
    force = force - 0.5 * (force.max() + force.min())
    energy = 0.5 * abs(float(force @ (np.roll(x, -1) - np.roll(x, 1))))
    after, x_after = np.roll(force, -1), np.roll(x, -1)
    crossing = np.sign(force) != np.sign(after)
    share = force[crossing] / (force[crossing] - after[crossing])
    places = x[crossing] + share * (x_after - x)[crossing]
    return 0.5 * float(np.ptp(x)), 0.5 * float(np.ptp(force)), energy, float(np.ptp(places))


def friction_text(table: pd.DataFrame) -> str:
    """The friction of `loop_history` as study files have it, at a few cycles."""
    last = len(table) - 1
    rows = {0, *np.geomspace(1, max(last, 1), _MOST_POINTS - 1).round().astype(int).tolist()}
    few = table.iloc[sorted(row for row in rows if row <= last)]
    values = ", ".join(f"{value:.3g}" for value in few["friction"])
    return f"friction: {{cycles: [{', '.join(map(str, few['cycle']))}], values: [{values}]}}"
