"""Two cases side by side: which parameters differ, and by which factor results do."""

from __future__ import annotations

import math
from dataclasses import dataclass

import xarray as xr

KEY_RESULTS = (
    "contact_half_width_x",
    "stick_half_width_x",
    "central_pressure",
    "peak_pressure",
    "dissipated_energy",
    "wear_volume",
    "plastic_volume",
)
"""Quantities over the cycles that tell two cases apart; the deepest wear is added to them."""

_SAME = 1e-12


@dataclass(frozen=True)
class Compared:
    """One result of two cases.

    Attributes
    ----------
    name : str
        Name of the quantity; ``wear_depth`` is the deepest wear.
    long_name : str
        The quantity in words.
    units : str
        Its SI unit.
    first, second : float
        Its values.
    """

    name: str
    long_name: str
    units: str
    first: float
    second: float

    @property
    def ratio(self) -> float:
        """Second to first; NaN where the first is zero."""
        return self.second / self.first if self.first else math.nan


def compared_cycles(first: xr.Dataset, second: xr.Dataset) -> tuple[int, int]:
    """Return the cycles at which two cases are compared.

    That is the last snapshot that both have; where they share none but cycle 0, the last one of
    each.
    """
    mine, other = ({int(cycle) for cycle in case["cycle"].values} for case in (first, second))
    common = max(mine & other, default=0)
    return (common, common) if common else (max(mine), max(other))


def different_parameters(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """Return the parameters of two cases that differ, in the order of the first."""
    names = [
        str(name) for name, value in first.coords.items() if not value.dims and name != "cycle"
    ]
    names += [str(n) for n, v in second.coords.items() if not v.dims and n not in {*names, "cycle"}]
    return [name for name in names if not _agree(first.coords.get(name), second.coords.get(name))]


def compared_results(first: xr.Dataset, second: xr.Dataset) -> list[Compared]:
    """Return the key results of two cases at `compared_cycles`."""
    cycles = compared_cycles(first, second)
    states = [case.sel(cycle=cycle) for case, cycle in zip((first, second), cycles, strict=True)]
    results = []
    for name in KEY_RESULTS:
        values = (float(state[name]) for state in states)
        attributes = first[name].attrs
        results.append(Compared(name, attributes["long_name"], attributes["units"], *values))
    depths = (float(state["wear_depth"].max()) for state in states)
    results.append(Compared("wear_depth", "deepest wear", "m", *depths))
    return results


def _agree(first: xr.DataArray | None, second: xr.DataArray | None) -> bool:
    if first is None or second is None:
        return False
    mine, other = first.item(), second.item()
    if isinstance(mine, str) or isinstance(other, str):
        return bool(mine == other)
    return mine == other or math.isclose(mine, other, rel_tol=_SAME)
