"""What the explorer shows of one case: profiles, zones and histories, read from its file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.data.files import open_case, open_history
from fretwear.figures.half_profile import representative_cycles
from fretwear.report.explorer.chosen import evenly

Array = NDArray[np.float64]

PROFILES = {
    "pressure": "pressure",
    "shear": "shear_traction",
    "gap": "gap",
    "wear": "wear_depth",
}
"""Fields along x, by the names that the page's script gives them."""

SCALARS = {
    "contact": "contact_half_width_x",
    "stick": "stick_half_width_x",
    "peak": "peak_pressure",
    "central": "central_pressure",
    "volume": "wear_volume",
    "energy": "dissipated_energy",
}
"""Numbers at every snapshot."""

HISTORY = {name: SCALARS[name] for name in ("contact", "stick", "volume")}
"""Numbers at every step."""

_BEYOND_CONTACT = 1.3
_MOST_SNAPSHOTS = 60
_MOST_STEPS = 400


@dataclass(frozen=True)
class CaseSeries:
    """One case along x > 0 on the line nearest y = 0, and over the cycles; SI units.

    Attributes
    ----------
    id : str
        Case id.
    x : array of shape (n,)
        Cell centres, to a little beyond the largest contact.
    cycles : array of shape (k,)
        Snapshots.
    profiles : dict of str to array of shape (k, n)
        By the names of `PROFILES`.
    states : array of int8 and shape (k, n)
        State of the contact in every cell.
    scalars : dict of str to array of shape (k,)
        By the names of `SCALARS`, and ``deepest``: the deepest wear of the profile.
    steps : array of shape (m,)
        Cycles reached by the steps.
    history : dict of str to array of shape (m,)
        By the names of `HISTORY`.
    friction : float
        Coefficient of friction.
    """

    id: str
    x: Array
    cycles: Array
    profiles: dict[str, Array]
    states: NDArray[np.int8]
    scalars: dict[str, Array]
    steps: Array
    history: dict[str, Array]
    friction: float


def read_series(path: Path) -> CaseSeries:
    """Read what the explorer shows of one case.

    Of more than 60 snapshots or 400 steps, evenly chosen ones are taken.

    Parameters
    ----------
    path : pathlib.Path
        A case file.

    Raises
    ------
    CaseFileError
        When the file is missing or damaged.
    """
    with open_case(path) as case, open_history(path) as history:
        kept = representative_cycles([int(n) for n in case["cycle"].values], _MOST_SNAPSHOTS)
        case = case.sel(cycle=list(kept))
        scalars = {name: _floats(case[variable]) for name, variable in SCALARS.items()}
        reach = _BEYOND_CONTACT * float(scalars["contact"].max())
        x = case["x"].values
        inside = np.flatnonzero((x > 0.0) & (x <= max(reach, float(np.abs(x).min()) * 2.0)))
        row = int(np.abs(case["y"].values).argmin())
        line = case.isel(y=row, x=inside)
        profiles = {name: _floats(line[variable]) for name, variable in PROFILES.items()}
        scalars["deepest"] = profiles["wear"].max(axis=1)
        steps = history.isel(step=evenly(history.sizes["step"], _MOST_STEPS))
        return CaseSeries(
            id=str(case.attrs["case_id"]),
            x=x[inside],
            cycles=_floats(case["cycle"]),
            profiles=profiles,
            states=line["contact_state"].values.astype(np.int8),
            scalars=scalars,
            steps=_floats(steps["cycle"]),
            history={name: _floats(steps[variable]) for name, variable in HISTORY.items()},
            friction=float(case["friction"]),
        )


def runs(states: NDArray[np.int8]) -> list[int]:
    """Return a row of states as pairs: a state, and in how many cells it goes on."""
    edges = np.flatnonzero(np.diff(states)) + 1
    starts, ends = np.r_[0, edges], np.r_[edges, states.size]
    pairs = zip(states[starts], ends - starts, strict=True)
    return [int(number) for pair in pairs for number in pair]


def _floats(values: xr.DataArray) -> Array:
    return values.values.astype(np.float64)
