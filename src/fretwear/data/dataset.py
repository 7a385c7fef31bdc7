"""The dataset of one case: mirroring, and comparison with another."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fretwear.vocabulary import CYCLE, FORCES, HEADLINES, RESULTS, SYMMETRIES, Variable, X, Y

KEY_RESULTS: tuple[Variable, ...] = tuple(
    RESULTS[name] for name in (*HEADLINES, "plastic_volume", "central_pressure", "peak_pressure")
)
"""What tells two cases apart."""

_SAME = 1e-12


def mirrored(dataset: xr.Dataset) -> xr.Dataset:
    """Mirror a contact to the whole along the axes in which it is even, by its ``symmetry``.

    Lazily opened data stay lazy; a dataset of the whole contact is returned unchanged.
    """
    even = SYMMETRIES[dataset.attrs["symmetry"]]
    if not any(even):
        return dataset
    order, positions = {}, {}
    for name in (each.name for each, is_even in zip((X, Y), even, strict=True) if is_even):
        cells = np.arange(dataset.sizes[name])
        order[name] = np.r_[cells[::-1], cells]
        values = np.r_[-dataset[name].values[::-1], dataset[name].values]
        positions[name] = xr.Variable((name,), values, dataset[name].attrs)
    whole = dataset.isel(order).assign_coords(positions).assign_attrs(symmetry="none")
    # A derived dataset does not close the file that it reads from.
    whole.set_close(dataset.close)
    return whole


@xr.register_dataset_accessor("fretwear")  # type: ignore[no-untyped-call]
class Accessor:
    """Methods for datasets of fretwear, as ``dataset.fretwear``."""

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset

    def full(self) -> xr.Dataset:
        """Return the whole contact, see `mirrored`."""
        return mirrored(self._dataset)


@dataclass(frozen=True)
class Compared:
    """One result of two cases."""

    variable: Variable
    first: float  # in its SI unit
    second: float
    errors: tuple[float, float] = (0.0, 0.0)  # of both, as far as they are known

    @property
    def ratio(self) -> float:
        """Second to first; NaN where the first is zero."""
        return self.second / self.first if self.first else math.nan


def compared_cycles(first: xr.Dataset, second: xr.Dataset) -> tuple[int, int]:
    """Return the cycles at which two cases are compared.

    The last snapshot that both have or, if they share only cycle 0, the last one of each.
    """
    mine, other = ({int(cycle) for cycle in case["cycle"].values} for case in (first, second))
    common = max(mine & other, default=0)
    return (common, common) if common else (max(mine), max(other))


def compared_results(first: xr.Dataset, second: xr.Dataset) -> list[Compared]:
    """Return the `KEY_RESULTS` of two cases at `compared_cycles`, and forces that are results."""
    cycles = compared_cycles(first, second)
    states = [case.sel(cycle=cycle) for case, cycle in zip((first, second), cycles, strict=True)]
    results = []
    given = first.coords.keys() & second.coords.keys()
    forces = [RESULTS[name] for key, names in FORCES.items() if key not in given for name in names]
    for variable in (*KEY_RESULTS, *forces):
        if all(variable.name in state for state in states):
            known = variable.in_units(states[0][variable.name].attrs.get("units", variable.si_unit))
            a, b = (float(state[known.name]) for state in states)
            error = known.error.name
            apart = [float(state[error]) if error in state else 0.0 for state in states]
            results.append(Compared(known, a, b, (apart[0], apart[1])))
    return results


def different_parameters(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """Return the parameters of two cases that differ, in the order of the first."""
    mine, other = (
        {
            str(name): value.item()
            for name, value in case.coords.items()
            if not value.dims and name != CYCLE.name
        }
        for case in (first, second)
    )
    return [name for name in {**mine, **other} if not _agree(mine.get(name), other.get(name))]


def _agree(first: float | str | None, second: float | str | None) -> bool:
    if isinstance(first, int | float) and isinstance(second, int | float):
        return math.isclose(first, second, rel_tol=_SAME)
    return first == second
