"""The key results of every point of a study, as numbers and as people read them."""

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
from fretwear.figures.wording import value_text, words_text
from fretwear.study.plan import Plan, PlannedPoint
from fretwear.study.points import Axis
from fretwear.units import Unit, readable_unit
from fretwear.vocabulary import MAXIMUM_WEAR_DEPTH, RESULTS, PointStatus

Array = NDArray[np.float64]

FIRST, LAST = "first", "last"
KEY_RESULTS: Mapping[str, tuple[str, ...]] = {
    "contact_half_width_x": (FIRST, LAST),
    "stick_half_width_x": (FIRST, LAST),
    "central_pressure": (FIRST, LAST),
    "peak_pressure": (LAST,),
    MAXIMUM_WEAR_DEPTH.name: (LAST,),
    "wear_volume": (LAST,),
    "dissipated_energy": (FIRST, LAST),
}
"""Results of the table of cases, and whether those of the first or of the last cycle."""

_RUN_AGAIN = "Run and merge the study again"
_POINTS_AT_A_TIME = 256
_UNKNOWN_REASON = "The simulation failed; its log tells why."


@dataclass(frozen=True)
class PointResult:
    """What became of one point of a study.

    Attributes
    ----------
    number : int
        Place in the study, from 1.
    id : str
        Case id, empty when invalid.
    status : PointStatus
        Whether it is done.
    reason : str
        Why it is not.
    labels : mapping of str to str
        Varied values for people, by name.
    title : str
        The varied values in one line.
    values : mapping of (str, str) to float
        Key results in SI units by name and cycle, as in `KEY_RESULTS`; empty when not done.
    capped, smooth : bool
        Whether there is a plastic limit, and whether there is no roughness.
    sort_keys : mapping of str to float
        By the name of a varied parameter, a number that sorts its values: the SI value, or the
        place in the study file where the value is no number.
    """

    number: int
    id: str
    status: PointStatus
    reason: str
    labels: Mapping[str, str]
    title: str
    values: Mapping[tuple[str, str], float] = field(default_factory=dict)
    capped: bool = False
    smooth: bool = False
    sort_keys: Mapping[str, float] = field(default_factory=dict)

    @property
    def done(self) -> bool:
        """Whether there are results."""
        return self.status == PointStatus.DONE

    def first(self, name: str) -> float:
        """Return a key result at cycle 0."""
        return self.values[name, FIRST]

    def last(self, name: str) -> float:
        """Return a key result at the last cycle."""
        return self.values[name, LAST]

    def ratio(self, name: str) -> float:
        """Return a key result at the last cycle over that at cycle 0."""
        return self.last(name) / self.first(name)


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
    columns = {
        (name, when): _evaluated(summary, name, when)
        for name, cycles in KEY_RESULTS.items()
        for when in cycles
    }
    status = summary["status"].values
    results: list[PointResult] = []
    for planned, (place, _) in zip(plan.points, layout.points(), strict=True):
        result = _described(len(results) + 1, planned, PointStatus(int(status[place])))
        if planned.case is None or not result.done:
            reason = planned.point.problem or failures.get(planned.id, _UNKNOWN_REASON)
            results.append(replace(result, reason=reason))
            continue
        results.append(
            replace(
                result,
                values={key: float(column[place]) for key, column in columns.items()},
                capped=math.isfinite(planned.case.plastic_limit),
                smooth=planned.case.roughness is None,
            )
        )
    return results


def _described(number: int, planned: PlannedPoint, status: PointStatus) -> PointResult:
    names = [name.replace(".", "_") for name in planned.point.values]
    values = list(planned.point.values.values())
    labels = list(planned.point.labels.values())
    titles = [_text(*varied, words_text) for varied in zip(names, values, labels, strict=True)]
    return PointResult(
        number=number,
        id=planned.id,
        status=PointStatus.INVALID if planned.case is None else status,
        reason="",
        labels={
            name: _text(name, value, label, value_text)
            for name, value, label in zip(names, values, labels, strict=True)
        },
        title=", ".join(titles) or "the case",
        sort_keys={
            name: float(value) if isinstance(value, float | int) else float(place)
            for name, value, place in zip(names, values, planned.point.index, strict=True)
        },
    )


def labels_of(axis: Axis) -> tuple[str, ...]:
    """Return the values of a varied parameter for people."""
    return tuple(
        _text(axis.coordinate, value, written, value_text)
        for value, written in zip(axis.values, axis.labels, strict=True)
    )


def _text(name: str, value: object, written: str, words: Callable[[str, object], str]) -> str:
    """Return a value in words; one that is not a single number stays as the study file has it."""
    is_number = isinstance(value, float | int) and not isinstance(value, bool)
    return words(name, value if is_number else written)


def marked_label(name: str) -> str:
    """Return the label of a result, with a dagger where the value means little by itself."""
    return RESULTS[name].label + ("" if RESULTS[name].is_headline else " †")


def display_units(results: Sequence[PointResult]) -> dict[str, Unit]:
    """Return the unit in which each key result is shown, the same for all points and cycles."""
    return {
        name: RESULTS[name].unit
        or readable_unit(
            [result.values[name, when] for result in results if result.done for when in cycles],
            RESULTS[name].si_unit,
        )
        for name, cycles in KEY_RESULTS.items()
    }


def _evaluated(summary: xr.Dataset, name: str, when: str) -> Array:
    """Return a key result of every point of a merged study, NaN where it is not done."""
    if name == MAXIMUM_WEAR_DEPTH.name:
        return _deepest(summary)
    values = summary[name].transpose(..., "cycle").values.astype(np.float64)
    if when == FIRST:
        return values[..., 0]
    # Cases may end at different cycles: the last value that is known.
    backwards = np.isfinite(values)[..., ::-1]
    place = values.shape[-1] - 1 - backwards.argmax(axis=-1)
    return np.take_along_axis(values, place[..., None], axis=-1)[..., 0]


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
