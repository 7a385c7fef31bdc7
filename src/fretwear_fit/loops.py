"""A recording of many loops: friction, displacement and energy of each of its cycles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from fretwear.arrays import Array
from fretwear.units import QuantityError
from fretwear_fit.readings import cycles_of, recording_of
from fretwear_measured.tables import Layout

_MOST_POINTS = 12  # of a table over cycles


def loop_history(path: str | Path, load: float) -> pd.DataFrame:
    """The cycles of a recording under a normal load, N, or N/m of a line contact.

    Its columns are ``cycle`` from 0, ``displacement_amplitude`` (m), ``force_amplitude`` (N or
    N/m), ``dissipated_energy`` E = ∮ Q dδ (J or J/m), and ``friction`` E/(4 P δ₀), with half the
    width δ₀ of the loop at Q = 0: the coefficient of a contact that slides as a whole, whatever the
    compliance of the rig. A recording that begins or ends within a cycle loses that part.
    """
    x, force = recording_of(Path(path), Layout(), "N")
    if not (cycles := cycles_of(x)):
        raise QuantityError("has no complete cycle of its displacement")
    rows = [_loop(x[part], force[part]) for part in cycles]
    names = ["displacement_amplitude", "force_amplitude", "dissipated_energy", "width"]
    table = pd.DataFrame(rows, columns=names)
    table.insert(0, "cycle", np.arange(len(rows)))
    table["friction"] = table["dissipated_energy"] / (2.0 * load * table.pop("width"))
    return table


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
