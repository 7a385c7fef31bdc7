"""Partial slip, the wear of a stage, and the numbers that describe a contact."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fretwear.mechanics.contact.cells import Beside, ContactProblem, Region
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import solve_contact
from fretwear.mechanics.slip.models import CattaneoMindlin, Pressed, WearLayer
from fretwear.mechanics.surfaces.roughness import WavyRoughness
from fretwear.mechanics.wear.integrator import first_loading
from fretwear.mechanics.wear.measures import half_width, measure, next_tip, stick_half_width
from fretwear.mechanics.wear.state import CONTACT_GAP
from fretwear.theory import PartialSlip

from ..studies import near
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
    reduced,
    window,
)
from .problems import unworn as shape_of

PROBLEM = fretting()


@pytest.fixture(scope="module", params=[0.2, 0.9])
def unworn(request):
    """The unworn smooth contact at 110 cells per radius, and its closed form."""
    state = first_loading(fretting(110, load_ratio=request.param))
    tangential = request.param * FRICTION * LOAD
    return state, PartialSlip(HERTZ, FRICTION, tangential, COUPLING)


def test_slip_and_traction_of_the_unworn_sphere_are_those_of_cattaneo_and_mindlin(unworn):
    state, theory = unworn
    slip = PROBLEM.slip(state.reduced)
    r = np.hypot(*np.meshgrid(state.geometry.x, state.geometry.y, indexing="ij"))
    annulus = (r > theory.stick_radius) & (r < A)
    expected = theory.slip(r)
    assert np.abs(slip - expected)[annulus].max() <= 0.01 * expected[annulus].max()
    shear = PROBLEM.shear_traction(state.pressure, state.reduced)
    assert state.geometry.integral(shear) == near(theory.tangential_load, rel=1e-12)
    slipping = (state.pressure > 0) & ~state.reduced.stick
    np.testing.assert_array_equal(shear[slipping], FRICTION * state.pressure[slipping])
    assert (np.abs(shear) <= FRICTION * state.pressure * (1 + 1e-12)).all()
    # Both edges are square roots: half a cell of the outer one is √(h/a) ≈ 3 % of µp0.
    error = np.abs(shear - theory.shear_traction(r))
    assert error.max() < 0.03 * FRICTION * P0
    assert state.geometry.integral(error) < 2e-3 * FRICTION * LOAD


def test_measures_of_the_unworn_sphere_are_those_of_hertz_and_cattaneo(unworn):
    state, theory = unworn
    found, stick, share = measure(PROBLEM, state), theory.stick_radius, theory.stick_load_share
    moved, force = theory.tangential_displacement, theory.tangential_load
    # Half-widths are known to a part of a cell: 0.3 cells of a/110 are 0.6 % of the smallest stick
    # radius here. Areas count cells: 1 % of the smallest.
    expected = {
        "approach": (HERTZ.approach, 1e-4),
        # The difference of two approaches, each good to 1e-5.
        "tangential_displacement": (moved, 2e-4),
        "normal_force": (LOAD, 1e-9),
        "tangential_force": (force, 1e-9),
        "regime": (0.0, 0.0),
        "sliding_ratio": (theory.dissipated_energy / (4.0 * force * moved), 5e-3),
        "contact_half_width_x": (A, 3e-3),
        "contact_half_width_y": (A, 3e-3),
        "stick_half_width_x": (stick, 0.3 / 110 * A / stick),
        "stick_half_width_y": (stick, 0.3 / 110 * A / stick),
        "contact_radius": (A, 5e-3),
        "stick_radius": (stick, 5e-3),
        "scar_half_width_x": (0.0, 0.0),
        "scar_half_width_y": (0.0, 0.0),
        "contact_area": (np.pi * A**2, 1e-2),
        "stick_area": (np.pi * stick**2, 1e-2),
        "mean_stick_pressure": (share * LOAD / (np.pi * stick**2), 1e-2),
        "stick_load_share": (share, 1e-2),
        "peak_pressure": (P0, 4e-3),
        "central_pressure": (P0, 4e-3),
        "wear_volume": (0.0, 0.0),
        "maximum_wear_depth": (0.0, 0.0),
        "plastic_volume": (0.0, 0.0),
        "dissipated_energy": (theory.dissipated_energy, 5e-3),
    }
    assert expected.keys() == vars(found).keys()
    for name, (value, rel) in expected.items():
        assert getattr(found, name) == near(value, rel=rel), name


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
    whole = ContactProblem(cells.half_space(MODULUS), shape, load)
    expected = solve_contact(whole, tolerance=1e-9)
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-5 * P0)
    np.testing.assert_array_equal(found.stick, expected.pressure > 0)
    gap = np.where(found.stick, 0.0, np.maximum(expected.gap, 0.0))
    np.testing.assert_allclose(found.gap, gap, atol=2e-8 * HERTZ.approach)
    assert found.approach == near(expected.approach, rel=2e-8)


def test_wear_under_a_slip_that_stays_is_linear_in_the_pressure():
    problem, cells = fretting(load_ratio=0.6), window((40, 40))
    model = CattaneoMindlin()
    shape = shape_of(cells, ROUGH)
    gap = model.reduced(problem, Pressed(cells.half_space(MODULUS), shape, shape, shape, 0.0)).gap
    worn = np.ones(cells.shape)
    np.testing.assert_array_equal(model.gap_after(gap, worn), gap)
    layer = model.wear_layer(worn, gap, None, 0.2 * worn, 0.5)
    np.testing.assert_allclose(layer.tangent_in(0.5, worn), 2.0 * layer.compliance, rtol=1e-6)
    # W + g* ∫βp dN
    np.testing.assert_allclose(layer.displacement(3 * worn), 1 + 1.7 * gap, rtol=1e-14)


def integrated(wear, gap, shift, known, rate, pressure):
    """Wear and g* at the end of a stage in which x grows to known + τp and G by ``shift``."""
    end = known + rate * pressure

    def slope(_, state):
        # dW/dx = g*, dg*/dx = g* + dG/dx
        return [state[1], state[1] + shift / end]

    # Errors of a small gap grow by e^x as it does: they have to be small beside the gap itself.
    close = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-22}
    return solve_ivp(slope, (0, end), [wear, gap], **close).y[:, -1]


@given(
    wear=st.floats(0, 3),
    gap=st.floats(0, 2),
    known=st.floats(0, 2),
    rate=st.floats(0.01, 3),
    pressure=st.floats(1e-3, 3),
    shift=st.floats(-3, 3) | st.none(),
)
@example(wear=1.0, gap=0.0, shift=-1.0, known=0.0, rate=1.0, pressure=1.0)
@example(wear=0.0, gap=2.0**-24, shift=None, known=0.0, rate=3.0, pressure=3.0)
def test_wear_of_a_stage_solves_its_equation_and_its_tangent_is_the_derivative(
    wear, gap, known, rate, pressure, shift
):
    def at(*values):
        return [np.array([[each]]) for each in values]

    changed = None if shift is None else np.array([[shift]])
    stage = WearLayer(*at(wear, gap), changed, *at(known), rate)
    # Below x = 0.01 the difference of two close numbers says nothing about (eˣ - 1)/x.
    middle = max(pressure, 0.01 / rate)
    places = pressure, 1.1 * pressure, (1 - 1e-5) * middle, (1 + 1e-5) * middle
    low, high, down, up = (stage.displacement(place)[0, 0] for place in at(*places))
    tangent = stage.tangent_in(1.0, *at(pressure))[0, 0]
    # Wear never decreases with pressure nor below its start.
    assert wear <= low <= high * (1 + 1e-15)
    assert tangent >= 0
    if shift is not None and shift < 0:
        return
    expected, reduced = integrated(wear, gap, shift or 0.0, known, rate, pressure)
    assert low == pytest.approx(expected, rel=1e-8, abs=1e-12)
    # What wears off adds to g*.
    assert shift is not None or low - wear == pytest.approx(reduced - gap, rel=1e-7, abs=1e-9)
    # Truncation is (step·τ)²; rounding 1e-16 of the displacement over a step of 1e-5.
    slope = stage.tangent_in(1.0, *at(middle))[0, 0]
    assert slope == pytest.approx((up - down) / (places[3] - places[2]), rel=1e-6, abs=3e-8)
    if shift is not None:
        # Slip that falls with the approach: the wear depth is linear in it.
        follows = replace(stage, shift=stage.shift + 1.0, response=np.array([[-0.4]]), level=2.0)
        apart = follows.at(3.0).displacement(*at(pressure)) - follows.displacement(*at(pressure))
        assert follows.per_approach(*at(pressure)) == pytest.approx(apart, rel=1e-9, abs=1e-12)


def test_short_stages_keep_their_accuracy():
    exponents = np.array([[1e-15, 1e-9, 9e-8, 1.1e-7, 9e-4, 1.1e-3, 0.1]])
    one, nothing = np.ones_like(exponents), np.zeros_like(exponents)
    stage = WearLayer(nothing, nothing, one, nothing, 1.0)
    # φ(x) - 1 = x/2 + x²/6 + x³/24 + …; below 1e-7 the layer stops at x/2 ± x²/6, and close above
    # a few roundings of φ ≈ 1 remain.
    series = sum(exponents**n / np.prod(np.arange(2, n + 2)) for n in range(1, 9))
    error = np.abs(stage.displacement(exponents) - series)
    assert (error <= 1e-13 * series + 2e-15).all()
    derivative = sum(n * exponents ** (n - 1) / np.prod(np.arange(2, n + 2)) for n in range(1, 9))
    # As the solver is told it, in single precision and in its own units.
    np.testing.assert_allclose(stage.tangent_in(3e-4, exponents), derivative / 3e-4, rtol=1e-6)
    endless = np.full_like(exponents, 1e9)
    for value in (stage.displacement(endless), stage.tangent_in(1.0, endless)):
        assert np.isfinite(value).all()


@given(
    edge=st.floats(2.0, 15.0),
    axis=st.sampled_from([0, 1]),
    even=st.sampled_from(EVEN),
    power=st.sampled_from([1.5, 1.0]),
)
def test_half_width_finds_the_edge_inside_a_cell_unworn_and_worn_in(edge, axis, even, power):
    spacing = (1e-6, 1.7e-6)
    cells = Grid(tuple(20 if one else 40 for one in even), spacing, even)
    position = np.abs(cells.x[:, None] if axis == 0 else cells.y[None, :])
    distance = np.broadcast_to(position, cells.shape) / spacing[axis]
    gap = 1e-9 * np.maximum(distance - edge, 0.0) ** power
    # Both power laws are met exactly, so only rounding is left.
    found = half_width(cells.along(axis), gap == 0, gap)
    assert found == near(edge * spacing[axis], rel=1e-9)


def test_half_widths_of_odd_contacts():
    """Cells outside with equal gaps put the edge in the middle between cell centers."""
    uneven = Grid((20, 8), (1e-6, 1e-6), (False, True))
    inside = np.zeros(uneven.shape, dtype=bool)
    inside[4:13, 0] = True
    # From -6 µm to 3 µm: the mean of both sides.
    assert half_width(uneven.along(0), inside, np.where(inside, 0.0, 1e-9)) == near(4.5e-6)
    assert stick_half_width(uneven.along(0), inside * 1e9) == near(4.5e-6)
    cells = Grid((8, 6), (1e-6, 2e-6))
    nothing, off_axis, spots = (np.zeros(cells.shape, dtype=bool) for _ in range(3))
    off_axis[3, 4] = spots[[0, 1, 5, 6], 0] = True
    # Zero where the axis is open, up to the outermost spot, and the window at most.
    for inside, expected in ((nothing, 0.0), (off_axis, 0.0), (spots, 7e-6)):
        assert half_width(cells.along(0), inside, np.where(inside, 0.0, 1e-9)) == near(expected)
    assert half_width(cells.along(1), ~nothing, np.zeros(cells.shape)) == near(cells.extent[1])


@given(
    place=st.floats(9.6, 10.4),
    lowest=st.floats(0.01, 0.9).flatmap(lambda size: st.sampled_from([-size, size])),
    axis=st.sampled_from([0, 1]),
    even=st.sampled_from(EVEN),
)
def test_a_tip_that_touches_between_centers_is_the_edge_and_next_to_touching_if_it_does_not(
    place, lowest, axis, even
):
    """A paraboloid of radius 1 in units of cells, beyond a zone that ends with the fourth cell."""
    spacing = (1e-6, 1.7e-6)
    cells = Grid(tuple(24 if one else 48 for one in even), spacing, even)
    x, y = np.meshgrid(np.abs(cells.x) / spacing[0], np.abs(cells.y) / spacing[1], indexing="ij")
    along, across = (x, y) if axis == 0 else (y, x)
    inside = (along < 4.0) & (across < 2.0)
    tip = 0.5 * ((along - place) ** 2 + across**2) + lowest / 8.0
    assert (tip > 0.0).all()
    gap = 1e-9 * np.where(inside, 0.0, np.where(along < 7.0, 1e3 * (along - 3.9), tip))
    lines = cells.along(axis)
    edge = place + np.sqrt(max(-lowest / 8.0, 0.0))
    found = half_width(lines, inside, gap, tips=True) / spacing[axis]
    assert found == near(edge, rel=1e-9) if lowest < 0.0 else found < 5.0
    jump, at_top = next_tip(lines, inside, gap)
    assert jump / spacing[axis] == near((edge - 3.5) / len(lines), rel=1e-9)
    assert at_top == near(1e-9 * lowest / 8.0, rel=1e-6)


@pytest.mark.slow
def test_areas_and_mean_pressures_of_rough_contacts_converge_with_few_cells_on_a_tip():
    """Counts of cells fall linearly with the spacing, to where corrected areas are at once."""
    rough = WavyRoughness(amplitude=0.2e-6, slope_x=np.radians(2), slope_y=np.radians(1))

    def areas(cells):
        problem = fretting(2 * cells, roughness=rough, spacing=(A / cells, 2 * A / cells))
        state = first_loading(problem)
        found = measure(problem, state)
        zones = state.in_contact, state.reduced.stick
        counted = [state.geometry.unit_area * zone.sum() for zone in zones]
        means.append((state.pressure[zones[1]].mean(), found.mean_stick_pressure))
        return np.array([counted, [found.contact_area, found.stick_area]])

    means: list[tuple[float, float]] = []

    coarse, fine = areas(128), areas(256)
    converged = 2 * fine[0] - coarse[0]
    assert (coarse[0] > 1.03 * converged).all()
    np.testing.assert_allclose(coarse[1], converged, rtol=0.025)
    np.testing.assert_allclose(fine[1], converged, rtol=0.01)
    # What cells cover beyond the edge carries less than they do in the mean.
    mean = 2 * means[1][0] - means[0][0]
    assert means[0][1] == near(mean, rel=0.025)
    assert means[1][1] == near(mean, rel=0.01)
    # Where a few cells on each tip are all at the limit, their corrected area is smaller.
    rough = WavyRoughness(amplitude=0.2e-6, slope_x=np.radians(5.7), slope_y=np.radians(1))
    problem = fretting(100, roughness=rough, limit=4.5e9 / P0)
    state = first_loading(problem)
    assert 0.9 * 4.5e9 < measure(problem, state).mean_stick_pressure <= 4.5e9
    # Nor do they bear more than the limit where the surface beside them bears nothing.
    full = replace(state, pressure=np.where(state.reduced.stick, 4.5e9, 0.0))
    assert measure(problem, full).mean_stick_pressure == near(4.5e9, rel=1e-12)


@pytest.mark.parametrize(("across", "within"), [(6, 0.03), (12, 0.012), (24, 0.004)])
def test_areas_of_round_contacts_follow_their_edges_within_cells(across, within):
    """Errors fall faster than cells get narrower, wherever the edge cuts these.

    No cell is covered by more than a fifth too much or too little.
    """
    modulus, radius, contact_radius = 1e11, 1e-3, 0.5e-6 * across
    load = 4.0 * modulus * contact_radius**3 / (3.0 * radius)
    grid = Grid((4 * across, 4 * across), (1e-6, 1e-6), even=(False, False))
    for x, y in ((0.0, 0.0), (0.3, 0.1), (0.5, 0.25), (0.1, 0.45), (0.5, 0.5)):
        squares = (grid.x[:, None] - 1e-6 * x) ** 2 + (grid.y - 1e-6 * y) ** 2
        problem = ContactProblem(grid.half_space(modulus), 0.5 * squares / radius, load)
        found = solve_contact(problem, tolerance=1e-7)
        beside = Beside(found.pressure, np.where(found.pressure > 0.0, 0.0, found.gap))
        region = Region(found.pressure > 0.0, 0.0, beside)
        area = grid.zone(region).area
        assert area == near(np.pi * contact_radius**2, rel=within), (x, y)
        covered = grid.covered(region, grid)
        assert grid.integral(covered) == near(area, rel=1e-12)
        # Points within the cells, by which the circle covers them.
        within_cell = (np.arange(20) + 0.5) / 20 - 0.5
        along, rows = (
            np.add.outer(places, 1e-6 * (within_cell - middle)).ravel()
            for places, middle in ((grid.x, x), (grid.y, y))
        )
        inside = np.hypot(along[:, None], rows) < contact_radius
        exact = inside.reshape(grid.shape[0], 20, grid.shape[1], 20).mean(axis=(1, 3))
        assert np.abs(covered - exact).max() < 0.2


def test_contact_is_read_off_the_gap_wherever_the_approach_counts_from():
    state = first_loading(fretting(64, load_ratio=0.5))
    contact, area = state.in_contact, measure(PROBLEM, state).contact_area
    # Worn surfaces conform: no pressure, and no gap either.
    conforming = replace(
        state,
        pressure=np.where(state.reduced.stick, state.pressure, 0.0),
        gap=np.where(contact, 0.9 * CONTACT_GAP * state.approach, state.gap),
    )
    np.testing.assert_array_equal(conforming.in_contact, contact)
    # Without pressure, both directions tell alike where the edge cuts its cells.
    assert measure(PROBLEM, conforming).contact_area == near(area, rel=1e-3)
    raised = state.gap + 1.1 * CONTACT_GAP * state.approach
    opened = replace(state, pressure=np.zeros_like(raised), gap=raised)
    assert measure(PROBLEM, opened).contact_area == 0
    # Waves that only touch in their valleys bring the approach down to zero and below.
    for approach in (0.0, -state.approach):
        lowered = replace(state, approach=approach)
        assert measure(PROBLEM, lowered).contact_area == near(area, rel=1e-12)
