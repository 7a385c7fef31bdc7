"""Two cases side by side: at which cycle, in which parameters, by which factors."""

import math

import numpy as np
import pytest
import xarray as xr

from fretwear.data.dataset import (
    KEY_RESULTS,
    compared_cycles,
    compared_results,
    different_parameters,
)


def _case(cycles: list[int], **parameters: float | str) -> xr.Dataset:
    growth = np.arange(1.0, len(cycles) + 1.0)
    names = {"long_name": "a quantity", "units": "m"}
    return xr.Dataset(
        {
            **dict.fromkeys(KEY_RESULTS, ("cycle", growth, names)),
            "wear_depth": (("cycle", "x"), np.outer(growth, [1.0, 3.0])),
        },
        {"cycle": [float(cycle) for cycle in cycles], **parameters},
    )


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ([0, 10, 100], [0, 10, 50], (10, 10)),
        ([0, 100], [0, 50], (100, 50)),
        ([0, 7], [0, 7], (7, 7)),
    ],
)
def test_cases_are_compared_where_both_have_a_snapshot(
    first: list[int], second: list[int], expected: tuple[int, int]
) -> None:
    assert compared_cycles(_case(first), _case(second)) == expected


def test_parameters_differ_beyond_rounding_or_where_one_is_missing() -> None:
    first = _case([0, 1], load=40.0, friction=0.3, slip_model="jaeger", plastic_limit=math.inf)
    second = _case([0, 1], load=40.0 * (1.0 + 1e-15), friction=0.6, slip_model="jaeger", radius=1.0)
    assert different_parameters(first, second) == ["friction", "plastic_limit", "radius"]
    assert different_parameters(first, first) == []


def test_results_have_their_ratio_and_the_deepest_wear_is_one_of_them() -> None:
    first, second = _case([0, 10]), _case([0, 5, 10])
    results = {result.variable.name: result for result in compared_results(first, second)}
    assert results["wear_volume"].ratio == pytest.approx(1.5)
    assert (results["maximum_wear_depth"].first, results["maximum_wear_depth"].second) == (6.0, 9.0)


def test_nothing_has_no_ratio() -> None:
    first = _case([0, 10])
    first["plastic_volume"] = 0.0 * first["plastic_volume"].assign_attrs(units="m3")
    first["plastic_volume"].attrs.update(long_name="plastic volume", units="m3")
    results = {result.variable.name: result for result in compared_results(first, _case([0, 10]))}
    assert math.isnan(results["plastic_volume"].ratio)
