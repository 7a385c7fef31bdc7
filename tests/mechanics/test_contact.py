"""Normal contact against Hertz, Winkler, dense matrices and its own conditions."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fretwear.mechanics.contact import problem as contact
from fretwear.mechanics.contact import solver
from fretwear.mechanics.contact.cells import ContactError, ContactProblem
from fretwear.mechanics.contact.problem import projected_gradient, solve_contact
from fretwear.mechanics.slip.models import WearLayer, WinklerLayer

from ..studies import near
from . import oracles
from .problems import (
    HERTZ,
    LOAD,
    MODULUS,
    P0,
    RADIUS,
    ROUGH,
    SMOOTH,
    A,
    pressed,
    window,
)

SURFACES = {"smooth": SMOOTH, "rough": ROUGH}
# Elastic; the top of the pressure cut off; nearly all of the contact at its limit.
LIMITS = (np.inf, 0.9, 0.55)


def test_hertz_pressure_converges_with_the_grid():
    errors = []
    for n in (16, 32, 64):
        cells = window((n, n))
        r = np.hypot(*np.meshgrid(cells.x, cells.y, indexing="ij"))
        error = solve_contact(pressed(cells)).pressure - HERTZ.pressure(r)
        errors.append(cells.integral(np.abs(error)) / LOAD)
    # The square-root edge limits the order to 3/2: a factor of 2.8 each time the cells halve.
    assert errors[1] < errors[0] / 2
    assert errors[2] < errors[1] / 2
    assert errors[2] < 2e-3


@pytest.mark.parametrize("limit", [np.inf, 0.8])
@pytest.mark.parametrize("rough", [False, True], ids=["smooth", "rough"])
def test_a_given_approach_carries_the_load_that_leads_to_it(limit, rough):
    problem = pressed(window((48, 48)), roughness=ROUGH if rough else SMOOTH, limit=limit)
    loaded = solve_contact(problem, tolerance=1e-10)
    at_approach = replace(problem, load=None, approach=loaded.approach)
    held = solve_contact(at_approach, tolerance=1e-10)
    assert held.approach == loaded.approach
    np.testing.assert_allclose(held.pressure, loaded.pressure, atol=1e-7 * P0)
    np.testing.assert_array_equal(held.saturated, loaded.saturated)
    if not rough and np.isinf(limit):
        smooth = solve_contact(replace(at_approach, approach=HERTZ.approach))
        assert problem.half_space.geometry.integral(smooth.pressure) == near(LOAD, rel=2e-3)
    for wrong in ({"load": None}, {"approach": HERTZ.approach}):
        with pytest.raises(ValueError, match="either a load or an approach"):
            replace(problem, **wrong)


def test_soft_layer_alone_is_a_winkler_foundation():
    cells = window((64, 64), 1.2 * A)
    # So soft a layer that the half-space adds 1e-6 of its displacement.
    compliance = 1e6 * A / MODULUS
    layer = WinklerLayer(np.full(cells.shape, compliance), np.zeros(cells.shape))
    load = np.pi * RADIUS * HERTZ.approach**2 / 4 / compliance
    found = solve_contact(replace(pressed(cells, layer=layer), load=load))
    r2 = np.add.outer(cells.x**2, cells.y**2)
    # p = (δ - r²/2R)/c, so P = πRδ²/c; cells cut the rim, which carries nothing.
    expected = HERTZ.approach / 2
    assert found.approach == near(expected, rel=1e-3)
    pressure = np.maximum(found.approach - r2 / (2 * RADIUS), 0.0) / compliance
    np.testing.assert_allclose(found.pressure, pressure, atol=1e-4 * pressure.max())


@pytest.mark.parametrize("layered", [False, True], ids=["bare", "layered"])
@pytest.mark.parametrize("limit", LIMITS)
def test_small_contacts_equal_a_dense_bounded_least_squares_solution(limit, layered):
    cells = window((10, 8), even=(False, False))
    matrix = oracles.influence_matrix(cells, MODULUS)
    random = np.random.default_rng(7)
    compliance = random.uniform(0.0, 3.0, cells.shape) * matrix[0, 0] * layered
    offset = random.uniform(0.0, 0.05, cells.shape) * HERTZ.approach * layered
    layer = WinklerLayer(compliance, offset) if layered else None
    problem = pressed(cells, roughness=ROUGH, limit=limit, layer=layer)
    found = solve_contact(problem, tolerance=1e-11)
    pressure, approach = oracles.dense_contact(
        matrix + np.diag(compliance.ravel()), problem.shape + offset, problem.total, limit * P0
    )
    # Both ways stop at a residual near 1e-11; the condition number of some tens adds to it.
    np.testing.assert_allclose(found.pressure, pressure, atol=1e-8 * P0)
    assert found.approach == near(approach, rel=1e-9)


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize(("limit", "tolerance"), [(0.55, 1e-7), (0.9, 1e-4), (np.inf, 1e-12)])
def test_solution_meets_the_conditions_of_contact_by_an_independent_convolution(
    name, limit, tolerance
):
    cells = window((48, 40), even=(False, False))
    problem = pressed(cells, roughness=SURFACES[name], limit=limit)
    found = solve_contact(problem, tolerance=tolerance)
    displaced = oracles.displacement(found.pressure, cells.spacing, MODULUS)
    gap = displaced + problem.shape - found.approach
    # The transforms of both round at some 1e-15.
    rounding = 4e-15 * displaced.max()
    slack = 1.01 * tolerance * displaced.max() + rounding
    assert found.pressure.min() >= 0
    assert found.pressure.max() <= limit * P0
    assert found.pressure.sum() * cells.unit_area == near(LOAD, rel=1e-12)
    at_limit = found.pressure == limit * P0
    loaded = (found.pressure > 0) & ~at_limit
    assert np.abs(gap[loaded]).max() < slack
    assert gap[found.pressure == 0].min() > -slack
    assert gap[at_limit].max(initial=-1.0) < slack
    np.testing.assert_array_equal(found.saturated, at_limit)
    np.testing.assert_allclose(found.penetration, np.maximum(-gap, 0) * at_limit, atol=slack)
    np.testing.assert_allclose(found.gap, gap, atol=1e-3 * slack + rounding)
    assert at_limit.any() == np.isfinite(limit)


def test_more_load_closes_more_and_never_relieves_a_cell():
    cells = window((32, 32))
    loads = [solve_contact(pressed(cells, load=part * LOAD), tolerance=1e-10) for part in (0.5, 1)]
    # The maximum principle of the half-space; the slack is the accuracy of both solutions.
    assert (loads[1].pressure - loads[0].pressure).min() > -1e-8 * P0
    assert loads[1].approach > loads[0].approach


NOTHING = np.zeros((12, 11))


def scattered(seed, loaded, power):
    """Pressure of any size on some of 12 × 11 cells."""
    random = np.random.default_rng(seed)
    start = 10**power * P0 * random.random((12, 11)) * (random.random((12, 11)) < loaded)
    start[random.integers(12), random.integers(11)] += P0
    return start


@given(
    start=st.builds(
        scattered, st.integers(0, 2**32 - 1), st.floats(0.01, 1.0), st.floats(-3.0, 3.0)
    ),
    limit=st.sampled_from(LIMITS) | st.floats(0.45, 3.0),
    rough=st.booleans(),
)
@example(start=scattered(0, 0.01, 3.0), limit=0.45, rough=True)
@example(start=np.outer(np.eye(12)[-1], np.eye(11)[-1]), limit=0.55, rough=True)
@example(start=np.outer(np.eye(12)[0], np.eye(11)[0]), limit=np.inf, rough=True)
@example(start=NOTHING, limit=np.inf, rough=False)
@example(start=NOTHING - P0, limit=0.9, rough=True)
@example(start=NOTHING + 1e3 * P0, limit=0.55, rough=True)
def test_any_start_leads_to_the_same_solution_and_is_left_as_it_is(start, limit, rough):
    problem = pressed(window((12, 11)), roughness=ROUGH if rough else SMOOTH, limit=limit)
    expected = solve_contact(problem, tolerance=1e-10)
    given_shape, given_start = problem.shape.copy(), start.copy()
    for guess, tolerance in ((start, 1e-10), (expected.pressure, 1e-3)):
        found = solve_contact(problem, guess, tolerance=tolerance)
        np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-7 * P0)
        for result in (found.pressure, found.gap, found.saturated):
            assert not np.shares_memory(result, guess)
            assert not np.shares_memory(result, problem.shape)
    np.testing.assert_array_equal(problem.shape, given_shape)
    np.testing.assert_array_equal(start, given_start)


def test_a_flat_punch_as_wide_as_the_window_loads_every_cell():
    cells = window((16, 16))
    flat = ContactProblem(cells.half_space(MODULUS), np.zeros(cells.shape), LOAD)
    found = solve_contact(flat)
    assert found.pressure.min() > 0
    assert cells.integral(found.pressure) == near(LOAD, rel=1e-12)
    cells = window((20, 20))
    mean = LOAD / cells.integral(np.ones(cells.shape)) / P0
    with pytest.raises(ContactError, match=r"cannot carry 50 N on a window"):
        solve_contact(pressed(cells, limit=0.999 * mean))
    found = solve_contact(pressed(cells, limit=1.01 * mean))
    assert found.pressure.max() <= 1.01 * mean * P0
    assert cells.integral(found.pressure) == near(LOAD, rel=1e-12)


def test_a_contact_that_does_not_converge_is_brought_by_the_projected_gradient_or_an_error(
    monkeypatch,
):
    problem = pressed(window((16, 16)), roughness=ROUGH, limit=1.2)
    expected = solve_contact(problem, tolerance=1e-9)
    calls = []

    def counted(*args):
        calls.append(args)
        return projected_gradient(*args)

    monkeypatch.setattr(solver, "projected_gradient", counted)
    monkeypatch.setattr(solver, "_ACTIVE_SET_STEPS", 2)
    found = solve_contact(problem, np.ones(problem.shape.shape), tolerance=1e-5)
    assert len(calls) == 1
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-3 * P0)
    monkeypatch.setattr(contact, "_LARGEST_STEPS", 1)
    with pytest.raises(ContactError, match=r"did not converge: residual .* instead of 1e-06"):
        solve_contact(problem)


def layers(cells):
    random = np.random.default_rng(3)
    compliance = random.uniform(0, 2, cells.shape) * A / 16 / MODULUS
    gap = random.uniform(0, 0.1, cells.shape) * HERTZ.approach
    zero = np.zeros(cells.shape)
    return {
        "bare": None,
        "Winkler": WinklerLayer(compliance, zero),
        "wear": WearLayer(zero, gap, None, zero, 0.5 / P0),
        "wear and flow": WearLayer(zero, gap, 0.3 * gap[::-1], zero, 0.5 / P0),
    }


@pytest.mark.parametrize(
    ("surface", "limit", "kind"),
    [("smooth", np.inf, "bare"), ("rough", 0.55, "bare")]
    + [("rough", 1.1, kind) for kind in ("Winkler", "wear", "wear and flow")],
)
def test_projected_gradient_and_active_set_agree(surface, limit, kind):
    cells = window((18, 16))
    problem = pressed(cells, roughness=SURFACES[surface], limit=limit, layer=layers(cells)[kind])
    found = projected_gradient(problem, np.ones(cells.shape), 1e-8)
    expected = solve_contact(problem, tolerance=1e-10)
    # The condition number, near 40 here, stands between the change of a step and the error.
    np.testing.assert_allclose(found, expected.pressure, atol=1e-6 * P0)
    bare = solve_contact(replace(problem, layer=None))
    assert (np.abs(found - bare.pressure).max() > 0.02 * P0) == (kind != "bare")
