"""The dataset of one case: mirrored, resampled, compared with another one."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.vocabulary import CYCLE, HEADLINES, RESULTS, SYMMETRIES, Variable, X, Y

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
    """What datasets of fretwear can do, as ``dataset.fretwear``."""

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset

    def full(self) -> xr.Dataset:
        """Return the whole contact, see `mirrored`."""
        return mirrored(self._dataset)


def resampled(
    values: NDArray[Any], cells: NDArray[np.float64], positions: NDArray[np.float64], axis: int
) -> NDArray[Any]:
    """Bring n values at cell centres to m other positions, both in m, along one axis.

    Physical quantities are interpolated linearly; states, which are whole numbers, are those of
    the nearest cell. At a cell centre the value is that of the cell to the last bit. Beyond the
    outermost cells, and nearer the middle than the first cell of one side, it stays that of the
    cell; cells that are all positive are one side of a contact that is even.
    """
    if np.array_equal(cells, positions):
        return values
    where = np.abs(positions) if cells[0] > 0.0 else positions
    lower = np.clip(np.searchsorted(cells, where, side="right") - 1, 0, cells.size - 2)
    weight = (where - cells[lower]) / (cells[lower + 1] - cells[lower])
    weight = np.clip(weight, 0.0, 1.0)
    along = np.moveaxis(values, axis, -1)
    if values.dtype.kind == "f":
        between = (1.0 - weight) * along[..., lower] + weight * along[..., lower + 1]
    else:
        between = along[..., lower + (weight >= 0.5)]
    return np.moveaxis(between.astype(values.dtype), -1, axis)


def positions_inside(
    cells: NDArray[np.float64], positions: NDArray[np.float64]
) -> NDArray[np.intp]:
    """Return which positions are not beyond the outermost cell centres, both in m."""
    return np.flatnonzero(np.abs(positions) <= np.abs(cells).max() * (1.0 + 1e-12))


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

    That is the last snapshot that both have; where they share none but cycle 0, the last one of
    each.
    """
    mine, other = ({int(cycle) for cycle in case["cycle"].values} for case in (first, second))
    common = max(mine & other, default=0)
    return (common, common) if common else (max(mine), max(other))


def compared_results(first: xr.Dataset, second: xr.Dataset) -> list[Compared]:
    """Return the `KEY_RESULTS` of two cases at `compared_cycles`."""
    cycles = compared_cycles(first, second)
    states = [case.sel(cycle=cycle) for case, cycle in zip((first, second), cycles, strict=True)]
    results = []
    for variable in KEY_RESULTS:
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


def representative_cycles(available: Collection[int], most: int = 6) -> tuple[int, ...]:
    """Return at most `most` cycles, first and last included, whose profiles differ.

    They are evenly spread in the fourth root of the cycle: in the logarithm too many early ones
    would be among them.
    """
    ordered = sorted(available)
    if len(ordered) <= most:
        return tuple(ordered)
    position = np.asarray(ordered, dtype=np.float64) ** 0.25
    wanted = np.linspace(position[0], position[-1], most)
    nearest = {int(np.abs(position - level).argmin()) for level in wanted}
    return tuple(ordered[index] for index in sorted(nearest | {0, len(ordered) - 1}))
