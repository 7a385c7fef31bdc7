"""The key results of every point of a study, as numbers with the texts that people read."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fretwear.data.merge import StudyLayout
from fretwear.data.safe import DataFileError
from fretwear.figures.wording import (
    MEGAPASCAL,
    MICROMETRE,
    Unit,
    readable_unit,
    value_text,
    words_text,
)
from fretwear.study.plan import Plan, PlannedPoint
from fretwear.study.points import Axis

Array = NDArray[np.float64]
Evaluation = Callable[[xr.Dataset], Array]

DONE, FAILED, INVALID = "done", "failed", "invalid"
_STATUS = (DONE, FAILED, INVALID)
_RUN_AGAIN = "Run and merge the study again"
_POINTS_AT_A_TIME = 256
UNKNOWN_REASON = "The simulation failed; its log tells why."


@dataclass(frozen=True)
class Quantity:
    """One key result.

    Parameters
    ----------
    name : str
        Short name, unique.
    heading : str
        Heading of its column, without the unit.
    when : {"first", "last"}
        Cycle at which it is taken.
    base : str
        SI unit, when the display unit follows from the values.
    unit : Unit or None
        Display unit; None chooses one by the largest value.
    of : callable
        Evaluates it for every point of the merged study, in SI units.
    """

    name: str
    heading: str
    when: str
    base: str
    unit: Unit | None
    of: Evaluation


@dataclass(frozen=True)
class PointResult:
    """What became of one point.

    Parameters
    ----------
    number : int
        Place in the study, from 1.
    id : str
        Case id, empty when invalid.
    status : str
        ``done``, ``failed`` or ``invalid``.
    reason : str
        Why it is not done.
    labels : mapping of str to str
        Varied values in the words of people, by name.
    values : mapping of str to float
        Key results in SI units by name; empty when not done.
    title : str
        The varied values in one line.
    capped, smooth : bool
        Whether a plastic limit applies, and whether there is no roughness.
    sort_keys : mapping of str to float
        Numbers that put the points in the order of a varied value, by its name.
    """

    number: int
    id: str
    status: str
    reason: str
    labels: Mapping[str, str]
    title: str
    values: Mapping[str, float] = field(default_factory=dict)
    capped: bool = False
    smooth: bool = False
    sort_keys: Mapping[str, float] = field(default_factory=dict)

    @property
    def done(self) -> bool:
        """Whether there are results."""
        return self.status == DONE


def _first(name: str) -> Evaluation:
    def first(summary: xr.Dataset) -> Array:
        return _over_cycles(summary, name)[..., 0]

    return first


def _last(name: str) -> Evaluation:
    def last(summary: xr.Dataset) -> Array:
        values = _over_cycles(summary, name)
        backwards = np.isfinite(values)[..., ::-1]
        place = values.shape[-1] - 1 - backwards.argmax(axis=-1)
        return np.take_along_axis(values, place[..., None], axis=-1)[..., 0]

    return last


def _over_cycles(summary: xr.Dataset, name: str) -> Array:
    return summary[name].transpose(..., "cycle").values.astype(np.float64)


def _deepest(summary: xr.Dataset) -> Array:
    """Return the deepest wear of every point, reading the profiles of a few points at a time."""
    profiles = summary["wear_profile"].transpose(..., "cycle", "x")
    if profiles.ndim == 2:
        return np.asarray(_largest(profiles.values))
    deepest = np.empty(profiles.shape[:-2])
    for index in np.ndindex(*profiles.shape[:-3]):
        for start in range(0, profiles.shape[-3], _POINTS_AT_A_TIME):
            here = (*index, slice(start, start + _POINTS_AT_A_TIME))
            deepest[here] = _largest(profiles[here].values)
    return deepest


def _largest(profiles: NDArray[np.floating]) -> Array:
    known = np.where(np.isfinite(profiles), profiles, -np.inf)
    return np.asarray(known.max(axis=(-2, -1)), dtype=np.float64)


QUANTITIES = (
    Quantity("half_width_first", "Contact half-width", "first", "m", MICROMETRE,
             _first("contact_half_width_x")),
    Quantity("half_width", "Contact half-width", "last", "m", MICROMETRE,
             _last("contact_half_width_x")),
    Quantity("stick_first", "Stick half-width", "first", "m", MICROMETRE,
             _first("stick_half_width_x")),
    Quantity("stick", "Stick half-width", "last", "m", MICROMETRE, _last("stick_half_width_x")),
    Quantity("central_first", "Central pressure", "first", "Pa", MEGAPASCAL,
             _first("central_pressure")),
    Quantity("central", "Central pressure", "last", "Pa", MEGAPASCAL, _last("central_pressure")),
    Quantity("peak", "Highest pressure", "last", "Pa", MEGAPASCAL, _last("peak_pressure")),
    Quantity("depth", "Deepest wear", "last", "m", None, _deepest),
    Quantity("volume", "Wear volume", "last", "m3", None, _last("wear_volume")),
    Quantity("energy_first", "Energy per cycle", "first", "J", None, _first("dissipated_energy")),
    Quantity("energy", "Energy per cycle", "last", "J", None, _last("dissipated_energy")),
)  # fmt: skip
QUANTITY = {quantity.name: quantity for quantity in QUANTITIES}


def point_results(
    plan: Plan, summary: xr.Dataset, failures: Mapping[str, str]
) -> list[PointResult]:
    """Return the key results of every point, in the order of the study.

    Parameters
    ----------
    plan : Plan
        The study's plan.
    summary : xarray.Dataset
        The merged study.
    failures : mapping of str to str
        Reasons by case id, for points that failed.

    Raises
    ------
    DataFileError
        When `summary` is not that of the plan's study as it is now.
    """
    layout = StudyLayout(plan.study)
    _check_points(plan, layout, summary)
    table = {quantity.name: quantity.of(summary) for quantity in QUANTITIES}
    status = summary["status"].values
    return [
        _result(
            number,
            planned,
            _STATUS[int(status[place])],
            {name: float(column[place]) for name, column in table.items()},
            failures,
        )
        for number, (planned, (place, _)) in enumerate(
            zip(plan.points, layout.points(), strict=True), 1
        )
    ]


def _check_points(plan: Plan, layout: StudyLayout, summary: xr.Dataset) -> None:
    file = Path(str(summary.encoding.get("source", "summary.nc")))
    sizes = {dim: summary.sizes.get(dim, 0) for dim in layout.dims}
    if tuple(sizes.values()) != layout.shape:
        problem = f"its points are {sizes}, those of the study {plan.study.name!r} {layout.shape}"
        raise DataFileError(file, problem, _RUN_AGAIN)
    ids = summary["case_id"].values
    for planned, (place, _) in zip(plan.points, layout.points(), strict=True):
        if str(ids[place]) != planned.id:
            now = planned.id or "an invalid point"
            problem = f"it has case {ids[place]} where the study {plan.study.name!r} has {now}"
            raise DataFileError(file, problem, _RUN_AGAIN)


def display_unit(quantity: Quantity, results: Sequence[PointResult]) -> Unit:
    """Return the unit in which a quantity is shown for all points."""
    if quantity.unit is not None:
        return quantity.unit
    return readable_unit([r.values[quantity.name] for r in results if r.done], quantity.base)


def labels_of(axis: Axis) -> tuple[str, ...]:
    """Return the values of a varied parameter in the words of people."""
    return tuple(
        _text(axis.coordinate, value, written, value_text)
        for value, written in zip(axis.values, axis.labels, strict=True)
    )


def _text(name: str, value: object, written: str, words: Callable[[str, object], str]) -> str:
    """Return a value in words; what is no single number stays as the study file has it."""
    is_number = isinstance(value, float | int) and not isinstance(value, bool)
    return words(name, value if is_number else written)


def _result(
    number: int,
    planned: PlannedPoint,
    status: str,
    values: Mapping[str, float],
    failures: Mapping[str, str],
) -> PointResult:
    varied = [
        (name.replace(".", "_"), value, planned.point.labels[name])
        for name, value in planned.point.values.items()
    ]
    result = PointResult(
        number=number,
        id=planned.id,
        status=INVALID if planned.case is None else status,
        reason="",
        labels={name: _text(name, value, label, value_text) for name, value, label in varied},
        title=", ".join(_text(name, value, label, words_text) for name, value, label in varied)
        or "the case",
        sort_keys=_sort_keys(planned),
    )
    if planned.case is None or not result.done:
        reason = planned.point.problem or failures.get(planned.id, UNKNOWN_REASON)
        return replace(result, reason=reason)
    return replace(
        result,
        values=values,
        capped=math.isfinite(planned.case.plastic_limit),
        smooth=planned.case.roughness is None,
    )


def _sort_keys(planned: PlannedPoint) -> dict[str, float]:
    """Return SI values where they are numbers, and places in the study file where not."""
    keys = {}
    for (name, value), place in zip(planned.point.values.items(), planned.point.index, strict=True):
        is_number = isinstance(value, float | int)
        keys[name.replace(".", "_")] = float(value) if is_number else float(place)
    return keys
