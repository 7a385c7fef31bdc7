"""What the slip of the unworn sphere costs."""

import numpy as np
import pytest

from fretwear.source_study.models import QUANTITIES, Cost, costs, excess_shear
from fretwear.source_study.source import simpler_cases


@pytest.fixture(scope="module")
def simple(finished):
    return simpler_cases(finished.summary).load(finished.cases)


def test_models_agree_on_the_unworn_smooth_sphere(quartet, simple):
    found = {cost.label: cost for cost in costs(quartet, simple, 0)[: len(QUANTITIES)]}
    assert found["Energy dissipated in a cycle"].ratio == pytest.approx(1.0, abs=0.02)
    assert found["Contact half-width"].ratio == pytest.approx(1.0, abs=1e-6)
    assert found["Stick half-width"].ratio == pytest.approx(1.0, abs=0.02)


def test_slip_that_does_not_grow_wears_less(quartet, simple):
    volumes = [cost for cost in costs(quartet, simple, 3500) if cost.label == "Wear volume"]
    assert len(volumes) == 4
    assert all(0.3 < cost.ratio < 0.9 for cost in volumes)


def test_only_the_simple_model_loads_valleys_with_shear(quartet, simple):
    for _, case in quartet.each():
        # Single precision of the stored fields.
        assert excess_shear(case, case.last) < 1e-5
    assert excess_shear(simple.rough_elastic, 0) > 0.05
    assert excess_shear(simple.smooth_elastic, 0) < 1e-3


def test_nothing_is_compared_with_nothing():
    assert np.isnan(Cost("smooth elastic", 0, "Wear volume", 0.0, 1.0).ratio)
    assert np.isnan(Cost("smooth elastic", 0, "Wear volume", 1e-9, 1.0).ratio)
    assert Cost("smooth elastic", 0, "Wear volume", 2.0, 1.0).ratio == 0.5
