"""The projected gradient, slow and safe: the same solutions by another road."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretwear.mechanics.contact import solve_contact
from fretwear.mechanics.gradient import project, projected_gradient
from fretwear.mechanics.layers import WearLayer, WinklerLayer

from .problems import HERTZ, MODULUS, P0, ROUGH, SMOOTH, A, near, pressed, window


@pytest.mark.parametrize("surface", [SMOOTH, ROUGH], ids=["smooth", "rough"])
@pytest.mark.parametrize("limit", [np.inf, 0.9, 0.55])
def test_projected_gradient_and_active_set_agree(surface, limit: float):
    problem = pressed(window((20, 18)), surface=surface, limit=limit)
    found = projected_gradient(problem, np.ones(problem.shape.shape), 1e-8)
    expected = solve_contact(problem, tolerance=1e-10)
    # The condition number, near 40 here, stands between the change of a step and the error.
    np.testing.assert_allclose(found, expected.pressure, atol=1e-6 * P0)


def layers():
    cells = window((16, 16))
    random = np.random.default_rng(3)
    compliance = random.uniform(0, 2, cells.shape) * A / 16 / MODULUS
    gap = random.uniform(0, 0.1, cells.shape) * HERTZ.approach
    nothing = np.zeros(cells.shape)
    return {
        "Winkler": WinklerLayer(compliance, nothing),
        "wear": WearLayer(nothing, gap, None, nothing, 0.5 / P0),
        "wear and flow": WearLayer(nothing, gap, 0.3 * gap[::-1], nothing, 0.5 / P0),
    }


@pytest.mark.parametrize("kind", layers())
def test_projected_gradient_and_active_set_agree_with_a_layer(kind: str):
    problem = pressed(window((16, 16)), surface=ROUGH, limit=1.1, layer=layers()[kind])
    found = projected_gradient(problem, np.ones((16, 16)), 1e-8)
    expected = solve_contact(problem, tolerance=1e-10)
    np.testing.assert_allclose(found, expected.pressure, atol=1e-6 * P0)
    bare = solve_contact(replace(problem, layer=None))
    assert np.abs(found - bare.pressure).max() > 0.02 * P0


def test_projected_gradient_obeys_bounds_and_load_even_when_cut_short():
    problem = pressed(window((20, 20)), surface=ROUGH, limit=0.9)
    found = projected_gradient(problem, np.ones((20, 20)), 1e-8, largest_steps=3)
    assert found.min() >= 0
    assert found.max() <= 0.9 * P0
    assert found.sum() == near(problem.total, rel=1e-12)


def test_projected_gradient_leaves_its_start_as_it_is():
    problem = pressed(window((12, 12)))
    start = np.random.default_rng(0).random((12, 12)) * P0
    kept = start.copy()
    result = projected_gradient(problem, start, 1e-6)
    np.testing.assert_array_equal(start, kept)
    assert not np.shares_memory(result, start)


@given(
    seed=st.integers(0, 2**32 - 1),
    limit=st.floats(0.1, 5.0) | st.just(np.inf),
    share=st.floats(0.02, 0.98),
    spread=st.floats(-3, 3).map(lambda power: 10**power),
)
def test_projection_is_the_nearest_feasible_pressure(seed, limit, share, spread):
    random = np.random.default_rng(seed)
    given_pressure = spread * random.normal(0.0, 1.0, (6, 5))
    total = share * given_pressure.size * min(limit, 5.0)
    found = project(given_pressure, limit, total)
    assert found.sum() == near(total, rel=1e-10)
    assert found.min() >= 0
    assert found.max() <= limit
    # Kuhn and Tucker: the nearest point is the given one shifted, and cut where it must be.
    shift = found - given_pressure
    slack = 1e-9 * (spread + total)
    free = (found > 0) & (found < limit)
    level = shift[free].mean() if free.any() else None
    if level is not None:
        np.testing.assert_allclose(shift[free], level, atol=slack)
        assert (shift[found == 0] >= level - slack).all()
        assert (shift[found == limit] <= level + slack).all()
