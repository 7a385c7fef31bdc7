"""Partial slip against Cattaneo and Mindlin, and against a second contact on the whole window."""

import numpy as np
import pytest

from fretwear.mechanics.contact import solve_contact
from fretwear.mechanics.contact_problem import ContactProblem
from fretwear.mechanics.halfspace import half_space
from fretwear.mechanics.layers import WearLayer, WinklerLayer
from fretwear.mechanics.loading import first_loading
from fretwear.mechanics.measures import measure
from fretwear.mechanics.slip import CattaneoMindlinSlip, Friction, JaegerSlip
from fretwear.mechanics.state import State
from fretwear.theory import CattaneoMindlin

from .problems import (
    COUPLING,
    FRICTION,
    HERTZ,
    LOAD,
    MODULUS,
    P0,
    ROUGH,
    SMOOTH,
    A,
    fretting,
    near,
    window,
)

FINE = (0.2, 0.5, 0.8, 0.9)


@pytest.fixture(scope="module", params=FINE)
def unworn(request) -> tuple[State, CattaneoMindlin]:
    """The unworn smooth contact at 110 cells per radius, and its closed form."""
    state = first_loading(fretting(110, load_ratio=request.param))
    tangential = request.param * FRICTION * LOAD
    return state, CattaneoMindlin(HERTZ, FRICTION, tangential, COUPLING)


def distance(state: State) -> np.ndarray:
    return np.hypot(*np.meshgrid(state.window.x, state.window.y, indexing="ij"))


def test_slip_of_the_unworn_sphere_is_the_closed_form(unworn):
    state, theory = unworn
    slip = Friction(FRICTION, COUPLING).slip(state.reduced)
    r = distance(state)
    annulus = (r > theory.stick_radius) & (r < A)
    expected = theory.slip(r)
    assert np.abs(slip - expected)[annulus].max() <= 0.01 * expected[annulus].max()


def test_dissipated_energy_of_the_unworn_sphere_is_the_closed_form(unworn):
    state, theory = unworn
    found = Friction(FRICTION, COUPLING).dissipated_energy(
        state.window, state.pressure, state.reduced
    )
    assert found == near(theory.dissipated_energy, rel=5e-3)


def test_shear_traction_carries_the_tangential_load_and_obeys_coulomb(unworn):
    state, theory = unworn
    shear = Friction(FRICTION, COUPLING).shear_traction(state.pressure, state.reduced)
    assert state.window.integral(shear) == near(theory.tangential_load, rel=1e-12)
    slipping = (state.pressure > 0) & ~state.reduced.stick
    np.testing.assert_array_equal(shear[slipping], FRICTION * state.pressure[slipping])
    assert (np.abs(shear) <= FRICTION * state.pressure * (1 + 1e-12)).all()
    # Both edges are square roots: half a cell of the outer one is √(h/a) ≈ 3 % of µp0.
    error = np.abs(shear - theory.shear_traction(distance(state)))
    assert error.max() < 0.03 * FRICTION * P0
    assert state.window.integral(error) < 2e-3 * FRICTION * LOAD


def test_tangential_displacement_is_that_of_mindlin(unworn):
    state, theory = unworn
    found = Friction(FRICTION, COUPLING).tangential_displacement(state.approach, state.reduced)
    # The difference of two approaches, each good to 1e-5.
    assert found == near(theory.tangential_displacement, rel=2e-4)


def test_stick_radius_is_that_of_cattaneo(unworn):
    state, theory = unworn
    widths = measure(state, Friction(FRICTION, COUPLING))
    # A part of a cell: 0.3 cells of a/110 are 0.6 % of the smallest stick radius here.
    for found in (widths.stick_half_width_x, widths.stick_half_width_y):
        assert found == pytest.approx(theory.stick_radius, abs=0.3 * A / 110)


def test_gap_is_exactly_zero_in_the_stick_zone_and_nowhere_negative(unworn):
    state, _ = unworn
    assert not state.reduced.gap[state.reduced.stick].any()
    assert (state.reduced.gap >= 0).all()
    assert (state.reduced.gap[state.pressure == 0] > 0).all()


def on_the_whole_window(shape, cells, load):
    return solve_contact(ContactProblem(half_space(cells, MODULUS), shape, load), tolerance=1e-9)


@pytest.mark.parametrize("surface", [SMOOTH, ROUGH], ids=["smooth", "rough"])
@pytest.mark.parametrize("quarter", [True, False], ids=["quarter", "whole"])
@pytest.mark.parametrize("start", ["none", "one cell", "everywhere"])
def test_reduced_contact_does_not_depend_on_the_window_it_was_solved_on(surface, quarter, start):
    n = 36 if quarter else 72
    cells = window((n, n), quarter=quarter)
    shape = surface.shape(cells)
    center = tuple(0 if quarter else count // 2 for count in cells.shape)
    guess = {
        "none": None,
        "one cell": np.zeros(cells.shape),
        "everywhere": np.full(cells.shape, P0),
    }[start]
    if start == "one cell":
        # On a rough surface its neighborhood does not even hold the highest wave.
        guess[center] = 1.0
    load = 0.5 * LOAD
    found = JaegerSlip(load).reduced(half_space(cells, MODULUS), shape, guess)
    expected = on_the_whole_window(shape, cells, load)
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-5 * P0)
    np.testing.assert_array_equal(found.stick, expected.pressure > 0)
    gap = np.where(found.stick, 0.0, np.maximum(expected.gap, 0.0))
    np.testing.assert_allclose(found.gap, gap, atol=2e-8 * HERTZ.approach)
    assert found.approach == near(expected.approach, rel=2e-8)


@pytest.mark.parametrize("quarter", [True, False])
def test_a_passing_reduced_contact_is_good_to_its_own_tolerance(quarter):
    cells = window((48, 48) if quarter else (64, 64), quarter=quarter)
    bodies, shape = half_space(cells, MODULUS), ROUGH.shape(cells)
    model = JaegerSlip(0.3 * LOAD)
    exact = model.reduced(bodies, shape)
    passing = model.reduced(bodies, shape + 0.0, exact.pressure, 10.0)
    # 1e-6 of the largest displacement, which the approach is near to.
    assert passing.approach == near(exact.approach, rel=2e-6)
    np.testing.assert_allclose(passing.gap, exact.gap, atol=2e-6 * exact.approach)
    np.testing.assert_allclose(passing.pressure, exact.pressure, atol=1e-3 * P0)
    np.testing.assert_array_equal(passing.gap == 0, passing.pressure > 0)


def test_solving_the_reduced_contact_leaves_its_arguments_as_they_are():
    cells = window((24, 24))
    shape, start = ROUGH.shape(cells), np.ones(cells.shape)
    kept = shape.copy(), start.copy()
    found = JaegerSlip(0.3 * LOAD).reduced(half_space(cells, MODULUS), shape, start)
    np.testing.assert_array_equal(shape, kept[0])
    np.testing.assert_array_equal(start, kept[1])
    for result in (found.pressure, found.gap):
        assert not np.shares_memory(result, shape)
        assert not np.shares_memory(result, start)


@pytest.mark.parametrize("surface", [SMOOTH, ROUGH], ids=["smooth", "rough"])
def test_wear_beside_the_stick_zone_adds_to_the_gap_and_leaves_the_stick_zone(surface):
    cells = window((32, 32))
    shape = surface.shape(cells)
    bodies, model = half_space(cells, MODULUS), JaegerSlip(0.4 * LOAD)
    before = model.reduced(bodies, shape)
    wear = np.random.default_rng(5).uniform(0, 0.1, cells.shape) * HERTZ.approach
    wear[before.stick] = 0.0
    after = model.reduced(bodies, shape + wear)
    np.testing.assert_array_equal(after.stick, before.stick)
    expected = model.gap_after(before.gap, wear)
    np.testing.assert_allclose(after.gap, expected, atol=2e-8 * HERTZ.approach)
    np.testing.assert_allclose(expected, before.gap + wear, rtol=1e-15)


def test_wear_layer_of_the_current_shape_feeds_back_on_slip():
    field = np.full((3, 3), 2.0)
    layer = JaegerSlip(1.0).wear_layer(field, field, None, field, 0.5)
    assert isinstance(layer, WearLayer)
    # W₀ + (eˣ - 1) g* at x = 2 + 0.5·1.
    np.testing.assert_allclose(layer.displacement(np.ones((3, 3))), 2 + np.expm1(2.5) * 2)


def test_cattaneo_mindlin_model_keeps_disc_and_slip_of_the_unworn_sphere():
    model = CattaneoMindlinSlip(HERTZ.with_load(0.4 * LOAD))
    cells = window((40, 40))
    bodies = half_space(cells, MODULUS)
    r = np.hypot(*np.meshgrid(cells.x, cells.y, indexing="ij"))
    stick_radius = A * 0.4 ** (1 / 3)
    theory = CattaneoMindlin(HERTZ, FRICTION, 0.6 * FRICTION * LOAD, COUPLING)
    for shape in (SMOOTH.shape(cells), ROUGH.shape(cells)):
        reduced = model.reduced(bodies, shape)
        np.testing.assert_array_equal(reduced.stick, r < stick_radius)
        np.testing.assert_allclose(
            Friction(FRICTION, COUPLING).slip(reduced), theory.slip(r), atol=1e-12 * A
        )
    assert not model.follows_shape
    worn = np.ones(cells.shape)
    np.testing.assert_array_equal(model.gap_after(reduced.gap, worn), reduced.gap)
    layer = model.wear_layer(worn, reduced.gap, None, 0.2 * worn, 0.5)
    assert isinstance(layer, WinklerLayer)
    # Constant slip: wear is g* ∫βp dN, exactly linear.
    np.testing.assert_allclose(layer.displacement(3 * worn), 1 + 1.7 * reduced.gap, rtol=1e-14)
