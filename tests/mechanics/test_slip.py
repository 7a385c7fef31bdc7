"""Partial slip against Cattaneo and Mindlin, and against a second contact on the whole window."""

import numpy as np
import pytest

from fretwear.mechanics.contact import ContactProblem
from fretwear.mechanics.integrator import first_loading
from fretwear.mechanics.measures import measure
from fretwear.mechanics.slip import CattaneoMindlin, Jaeger, WinklerLayer
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.state import State
from fretwear.theory import CattaneoMindlin as UnwornSlip

from .problems import (
    COUPLING,
    EVEN,
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
    reduced,
    window,
)
from .problems import (
    unworn as shape_of,
)

FINE = (0.2, 0.5, 0.8, 0.9)


@pytest.fixture(scope="module", params=FINE)
def unworn(request) -> tuple[State, UnwornSlip]:
    """The unworn smooth contact at 110 cells per radius, and its closed form."""
    state = first_loading(fretting(110, load_ratio=request.param))
    tangential = request.param * FRICTION * LOAD
    return state, UnwornSlip(HERTZ, FRICTION, tangential, COUPLING)


def distance(state: State) -> np.ndarray:
    return np.hypot(*np.meshgrid(state.geometry.x, state.geometry.y, indexing="ij"))


def test_slip_of_the_unworn_sphere_is_the_closed_form(unworn):
    state, theory = unworn
    slip = fretting().slip(state.reduced)
    r = distance(state)
    annulus = (r > theory.stick_radius) & (r < A)
    expected = theory.slip(r)
    assert np.abs(slip - expected)[annulus].max() <= 0.01 * expected[annulus].max()


def test_shear_traction_carries_the_tangential_load_and_obeys_coulomb(unworn):
    state, theory = unworn
    shear = fretting().shear_traction(state.pressure, state.reduced)
    assert state.geometry.integral(shear) == near(theory.tangential_load, rel=1e-12)
    slipping = (state.pressure > 0) & ~state.reduced.stick
    np.testing.assert_array_equal(shear[slipping], FRICTION * state.pressure[slipping])
    assert (np.abs(shear) <= FRICTION * state.pressure * (1 + 1e-12)).all()
    # Both edges are square roots: half a cell of the outer one is √(h/a) ≈ 3 % of µp0.
    error = np.abs(shear - theory.shear_traction(distance(state)))
    assert error.max() < 0.03 * FRICTION * P0
    assert state.geometry.integral(error) < 2e-3 * FRICTION * LOAD


def test_energy_displacement_and_stick_radius_are_those_of_cattaneo_and_mindlin(unworn):
    state, theory = unworn
    found = measure(fretting(), state)
    assert found.dissipated_energy == near(theory.dissipated_energy, rel=5e-3)
    # The difference of two approaches, each good to 1e-5.
    displacement = fretting().tangential_displacement(state.approach, state.reduced)
    assert displacement == near(theory.tangential_displacement, rel=2e-4)
    # A part of a cell: 0.3 cells of a/110 are 0.6 % of the smallest stick radius here.
    for width in (found.stick_half_width_x, found.stick_half_width_y):
        assert width == pytest.approx(theory.stick_radius, abs=0.3 * A / 110)


def test_gap_is_exactly_zero_in_the_stick_zone_and_nowhere_negative(unworn):
    state, _ = unworn
    assert not state.reduced.gap[state.reduced.stick].any()
    assert (state.reduced.gap >= 0).all()
    assert (state.reduced.gap[state.pressure == 0] > 0).all()


def on_the_whole_window(shape, cells, load):
    return solve_contact(ContactProblem(cells.half_space(MODULUS), shape, load), tolerance=1e-9)


@pytest.mark.parametrize("surface", [SMOOTH, ROUGH], ids=["smooth", "rough"])
@pytest.mark.parametrize("even", EVEN)
@pytest.mark.parametrize("start", ["none", "one cell", "everywhere"])
def test_reduced_contact_does_not_depend_on_the_window_it_was_solved_on(surface, even, start):
    cells = window(tuple(36 if one else 72 for one in even), even=even)
    shape = shape_of(cells, surface)
    center = tuple(0 if one else n // 2 for n, one in zip(cells.shape, even, strict=True))
    guess = {
        "none": None,
        "one cell": np.zeros(cells.shape),
        "everywhere": np.full(cells.shape, P0),
    }[start]
    if start == "one cell":
        # On a rough surface its neighborhood does not even hold the highest wave.
        guess[center] = 1.0
    load = 0.5 * LOAD
    found = reduced(load, cells.half_space(MODULUS), shape, guess)
    expected = on_the_whole_window(shape, cells, load)
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-5 * P0)
    np.testing.assert_array_equal(found.stick, expected.pressure > 0)
    gap = np.where(found.stick, 0.0, np.maximum(expected.gap, 0.0))
    np.testing.assert_allclose(found.gap, gap, atol=2e-8 * HERTZ.approach)
    assert found.approach == near(expected.approach, rel=2e-8)


@pytest.mark.parametrize("even", [(True, True), (False, False)])
def test_a_passing_reduced_contact_is_good_to_its_own_tolerance(even):
    cells = window((48, 48) if even[0] else (64, 64), even=even)
    bodies, shape = cells.half_space(MODULUS), shape_of(cells, ROUGH)
    exact = reduced(0.3 * LOAD, bodies, shape)
    passing = reduced(0.3 * LOAD, bodies, shape + 0.0, exact.pressure, 1e-6)
    # 1e-6 of the largest displacement, which the approach is near to.
    assert passing.approach == near(exact.approach, rel=2e-6)
    np.testing.assert_allclose(passing.gap, exact.gap, atol=2e-6 * exact.approach)
    np.testing.assert_allclose(passing.pressure, exact.pressure, atol=1e-3 * P0)
    np.testing.assert_array_equal(passing.gap == 0, passing.pressure > 0)


@pytest.mark.parametrize("surface", [SMOOTH, ROUGH], ids=["smooth", "rough"])
def test_wear_beside_the_stick_zone_adds_to_the_gap_and_leaves_the_stick_zone(surface):
    cells = window((32, 32))
    shape = shape_of(cells, surface)
    bodies, model = cells.half_space(MODULUS), Jaeger()
    before = reduced(0.4 * LOAD, bodies, shape)
    wear = np.random.default_rng(5).uniform(0, 0.1, cells.shape) * HERTZ.approach
    wear[before.stick] = 0.0
    after = reduced(0.4 * LOAD, bodies, shape + wear)
    np.testing.assert_array_equal(after.stick, before.stick)
    expected = model.gap_after(before.gap, wear)
    np.testing.assert_allclose(after.gap, expected, atol=2e-8 * HERTZ.approach)
    np.testing.assert_allclose(expected, before.gap + wear, rtol=1e-15)


def test_cattaneo_mindlin_model_keeps_disc_and_slip_of_the_unworn_sphere():
    model, problem = CattaneoMindlin(), fretting(load_ratio=0.6)
    cells = window((40, 40))
    bodies = cells.half_space(MODULUS)
    r = np.hypot(*np.meshgrid(cells.x, cells.y, indexing="ij"))
    stick_radius = A * 0.4 ** (1 / 3)
    theory = UnwornSlip(HERTZ, FRICTION, 0.6 * FRICTION * LOAD, COUPLING)
    for shape in (shape_of(cells, SMOOTH), shape_of(cells, ROUGH)):
        found = model.reduced(problem, bodies, shape)
        np.testing.assert_array_equal(found.stick, r < stick_radius)
        np.testing.assert_allclose(fretting().slip(found), theory.slip(r), atol=1e-12 * A)
    assert not model.follows_shape
    worn = np.ones(cells.shape)
    np.testing.assert_array_equal(model.gap_after(found.gap, worn), found.gap)
    layer = model.wear_layer(worn, found.gap, None, 0.2 * worn, 0.5)
    assert isinstance(layer, WinklerLayer)
    # Constant slip: wear is g* ∫βp dN, exactly linear.
    np.testing.assert_allclose(layer.displacement(3 * worn), 1 + 1.7 * found.gap, rtol=1e-14)
