"""Find the cases of the source study among the points of a merged study."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fretwear.data.files import open_case, open_history
from fretwear.source_study.evolution import Evolution
from fretwear.source_study.quartet import Quartet
from fretwear.vocabulary import PointStatus

SOURCE_RADIUS = 0.01
"""Sphere radius, m, that stands for the study's own, which it does not give."""

_SHARED = {
    "load": 50.0,
    "tangential_load": 20.0,
    "friction": 0.5,
    "youngs_modulus": 208e9,
    "poisson_ratio": 0.3,
    "wear_coefficient": 7e-13,
}
_AMPLITUDE, _SLOPE_X, _SLOPE_Y = 0.2e-6, math.radians(5.7), math.radians(1.0)
_PLASTIC_LIMIT = 4500e6
_CONTRASTS = ("roughness_amplitude", "plastic_limit")
_GROUPING = ("radius", "slip_model")
_NEARLY = 1e-6
_FOLLOWING = "jaeger"


@dataclass(frozen=True)
class SourceCases:
    """Ids of the four cases of the source study for one sphere radius and one slip model.

    Parameters
    ----------
    radius : float
        Sphere radius, m.
    slip_model : str
        How slip was computed.
    smooth_elastic, rough_elastic, smooth_plastic, rough_plastic : str
        Case ids.
    """

    radius: float
    slip_model: str
    smooth_elastic: str
    rough_elastic: str
    smooth_plastic: str
    rough_plastic: str

    def load(self, cases: Path) -> Quartet:
        """Read the four cases into memory from a folder of case files ``<case id>.nc``.

        Raises
        ------
        CaseFileError
            When a file is missing or damaged.
        """
        ids = (self.smooth_elastic, self.rough_elastic, self.smooth_plastic, self.rough_plastic)
        return Quartet(*(_read(cases / f"{case_id}.nc") for case_id in ids))


def source_cases(summary: xr.Dataset) -> list[SourceCases]:
    """Find the finished cases that have the source study's parameters.

    Parameters
    ----------
    summary : xarray.Dataset
        A merged study.

    Returns
    -------
    list of SourceCases
        One for each sphere radius and slip model of which all four cases are done, in the order
        of the study; empty when the study is another one.
    """
    found: dict[tuple[float, str], dict[tuple[bool, bool], str]] = {}
    for values in _points(summary):
        if _is_source(values):
            group = (float(values["radius"]), str(values["slip_model"]))
            kind = (values["roughness_amplitude"] > 0.0, math.isfinite(values["plastic_limit"]))
            found.setdefault(group, {})[kind] = str(values["case_id"])
    return [
        SourceCases(
            radius,
            model,
            kinds[False, False],
            kinds[True, False],
            kinds[False, True],
            kinds[True, True],
        )
        for (radius, model), kinds in found.items()
        if len(kinds) == 4
    ]


def reference_cases(summary: xr.Dataset) -> SourceCases | None:
    """Choose the cases that figures and claims are about; None when the study has none.

    Of several groups it is the one whose radius is nearest `SOURCE_RADIUS`, with the slip that
    follows the worn shape.
    """
    groups = source_cases(summary)
    return min(
        groups,
        key=lambda group: (
            group.slip_model != _FOLLOWING,
            abs(math.log(group.radius / SOURCE_RADIUS)),
        ),
        default=None,
    )


def simpler_cases(summary: xr.Dataset) -> SourceCases | None:
    """Find the cases of `reference_cases` with the slip of the unworn sphere, if they are there."""
    reference = reference_cases(summary)
    for group in source_cases(summary):
        if (
            reference
            and group.radius == reference.radius
            and group.slip_model != reference.slip_model
        ):
            return group
    return None


def _points(summary: xr.Dataset) -> Iterator[dict[str, Any]]:
    """Iterate over the finished points; without a needed parameter there is none."""
    names = ("case_id", *_SHARED, *_CONTRASTS, *_GROUPING, "roughness_slope_x", "roughness_slope_y")
    if "status" not in summary or not set(names) <= set(summary.variables):
        return
    status = summary["status"]
    columns = {name: summary[name].broadcast_like(status).values.ravel() for name in names}
    for index in np.flatnonzero(status.values.ravel() == PointStatus.DONE):
        yield {name: column[index] for name, column in columns.items()}


def _is_source(values: dict[str, Any]) -> bool:
    if any(isinstance(values[name], str) for name in (*_SHARED, *_CONTRASTS)):
        return False
    shared = all(_near(float(values[name]), value) for name, value in _SHARED.items())
    limit = float(values["plastic_limit"])
    limited = math.isinf(limit) or _near(limit, _PLASTIC_LIMIT)
    waves = (
        (float(values["roughness_amplitude"]), _AMPLITUDE),
        (float(values["roughness_slope_x"]), _SLOPE_X),
        (float(values["roughness_slope_y"]), _SLOPE_Y),
    )
    rough = waves[0][0] == 0.0 or all(_near(value, wanted) for value, wanted in waves)
    return shared and limited and rough


def _near(value: float, wanted: float) -> bool:
    return math.isclose(value, wanted, rel_tol=_NEARLY)


def _read(path: Path) -> Evolution:
    with open_case(path) as dataset, open_history(path) as history:
        return Evolution(dataset.load(), history.load())
