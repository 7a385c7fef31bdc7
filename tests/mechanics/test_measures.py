"""The numbers that describe a contact: half-widths, areas, radii by outlines, the scar."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretwear.mechanics.contact.cells import Evidence, Region
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactProblem, solve_contact
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.surfaces.roughness import WavyRoughness
from fretwear.mechanics.wear.integrator import evolve, first_loading
from fretwear.mechanics.wear.measures import (
    Measures,
    half_extent,
    half_width,
    open_within_outline,
    outline_spots,
    stick_half_width,
)
from fretwear.mechanics.wear.state import CONTACT_GAP
from fretwear.theory import PartialSlip

from ..studies import near
from .problems import (
    COUPLING,
    EVEN,
    FRICTION,
    HERTZ,
    LOAD,
    P0,
    A,
    Waves,
    fretting,
    uneven,
)


@pytest.mark.parametrize(
    ("changes", "within"),
    [({"geometry": Rings}, 0.02), *[({"roughness": uneven(None, even)}, 0.1) for even in EVEN[:2]]],
)
def test_a_smooth_sphere_has_the_radii_of_hertz_and_cattaneo(changes, within):
    problem = fretting(16, **changes)
    state = first_loading(problem)
    found = Measures(problem, state)
    for radius, zone in ((A, "contact"), (A * 0.2 ** (1 / 3), "stick")):
        assert getattr(found, f"{zone}_radius") == pytest.approx(radius, abs=within * A / 16), zone
    assert found.scar_half_width_x == found.scar_half_width_y == 0.0


def test_an_outline_holds_valleys_and_the_inside_of_a_ring_and_tips_outside_move_it_little():
    grid = Grid((80, 80), (1.0, 1.0), (False, False))
    r, rows = np.hypot(grid.x[:, None], grid.y), np.arange(80) % 4 < 2
    disc = r < 30.0
    for holes in (disc & (r > 20.0), disc & rows, disc & rows[:, None]):
        hull = holes.sum() + open_within_outline(holes, grid.x, grid.y, grid.even)
        assert hull == near(disc.sum(), rel=0.02)
    assert open_within_outline(disc, grid.x, grid.y, grid.even) == 0
    assert open_within_outline(~(r < 99.0), grid.x, grid.y, grid.even) == 0
    disc[72, 40] = True  # at 32.5, 1.08 of the radius
    jump = open_within_outline(disc, grid.x, grid.y, grid.even) / disc.sum()
    angle = np.arccos(30.0 / 32.5)
    assert jump == near((np.tan(angle) - angle) / np.pi, rel=0.3)
    for even, kept in zip(EVEN, (np.s_[40:, 40:], np.s_[40:], np.s_[:, 40:]), strict=False):
        part = Grid(disc[kept].shape, (1.0, 1.0), even)
        whole = np.where(r < 30.0, r > 20.0, np.isclose(r, np.hypot(33.5, 0.5)))
        of_part = open_within_outline(whole[kept], part.x, part.y, even) << sum(even)
        assert of_part == open_within_outline(whole, grid.x, grid.y, grid.even)


def test_spots_that_join_or_leave_a_zone_are_counted_unless_they_lie_in_its_outline():
    whole = Grid((40, 40), (1.0, 1.0), (False, False))
    r = np.hypot(whole.x[:, None], whole.y)
    ring, spot = (r < 9.0) & (r > 5.0), np.hypot(whole.x[:, None] - 12.5, whole.y) < 1.0

    def state(cells, grid=whole):
        kept = whole.resized(cells, grid)
        stick = SimpleNamespace(stick=kept & (grid.x > 0)[:, None])
        return SimpleNamespace(geometry=grid, in_contact=kept, reduced=stick)

    near = spot & ~np.roll(spot, 1, axis=0)
    for old, new, expected in (
        (ring, r < 10.0, (0, 0)),  # grows, and fills from outside
        (ring, ring | spot, (1, 1)),
        (ring | spot | spot[::-1], ring, (2, 1)),
        (ring | spot[::-1], ring | spot, (2, 1)),  # as many leave as join
        (ring, ring | (r < 2.0), (0, 0)),  # within the outline
        (ring | near, ring | spot, (0, 0)),  # is already there
        (ring & False, ring, (0, 0)),  # contact begins
    ):
        assert outline_spots(state(old), state(new)) == expected
    small = Grid((24, 24), (1.0, 1.0), (False, False))
    assert outline_spots(state(ring, small), state(ring | spot)) == (1, 1)


def test_the_radius_stays_where_the_half_width_jumps_to_the_next_row_of_tips():
    """Tips 0.2 a apart; between the loads those 1.1 a from the centre begin to touch on y = 0."""
    waves = Waves(0.1e-6, 2 * np.pi / (0.2 * A), 2 * np.pi / (0.2 * A))
    found = []
    for load in (50.5, 51.9):
        problem = fretting(32, roughness=waves, normal=NormalLoad(load))
        found.append(Measures(problem, first_loading(problem)))
    narrow, wide = found
    assert wide.contact_half_width_x > 1.1 * narrow.contact_half_width_x
    assert wide.contact_radius == near(narrow.contact_radius, rel=0.01)


@pytest.mark.parametrize("edge", [17.1, 17.9])
@pytest.mark.parametrize("shape", [lambda t: t, lambda t: 1.0 - (1.0 - t) ** 2, np.sqrt])
def test_half_the_extent_of_a_scar_ends_within_a_cell(edge, shape):
    x = np.arange(60) - 29.5
    depth = shape(np.maximum(1.0 - np.abs(x - 4.0) / edge, 0.0))
    ends = [edge * (1.0 - t) for t in (0.01, 1.0 - np.sqrt(0.99), 1e-4)]
    nearest = min(ends, key=lambda end: abs(half_extent(x, depth, is_even=False) - end))
    assert half_extent(x, depth, is_even=False) == pytest.approx(nearest, abs=0.5)
    assert half_extent(x[30:], depth[30:], is_even=True) == pytest.approx(4.0 + nearest, abs=0.6)
    # A part no deeper than 1 % of the maximum lies outside, and bare ends say nothing.
    shallow = np.where(np.abs(x) > 25.0, 0.009, depth)
    assert half_extent(x, shallow, is_even=False) == pytest.approx(nearest, abs=0.6)
    assert half_extent(x, 0.0 * depth, is_even=False) == 0.0


def test_the_scar_of_a_grid_is_that_of_rings():
    coarse, fine = (fretting(16, geometry=kind) for kind in (Grid, Rings))
    pairs = zip(evolve_to(coarse), evolve_to(fine), strict=True)
    for grid, rings in pairs:
        assert grid.scar_half_width_x == pytest.approx(rings.scar_half_width_x, abs=0.25 * A / 16)
        assert grid.scar_half_width_y == near(grid.scar_half_width_x, rel=1e-6)


def evolve_to(problem):
    cycles = [10.0, 1000.0]
    return [Measures(problem, s) for s in evolve(problem, cycles) if s.cycle in cycles]


PROBLEM = fretting()


@pytest.fixture(scope="module")
def unworn():
    """The unworn smooth contact at 110 cells per radius, and its closed form."""
    state = first_loading(fretting(110, load_ratio=0.9))
    return state, PartialSlip(HERTZ, FRICTION, 0.9 * FRICTION * LOAD, COUPLING)


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
    found, stick, share = Measures(PROBLEM, state), theory.stick_radius, theory.stick_load_share
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
    assert expected.keys() == found.scalars({}, of_steps=True).keys()
    for name, (value, rel) in expected.items():
        assert getattr(found, name) == near(value, rel=rel), name


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
    found = half_width(cells.axis_cells(axis), gap == 0, gap)
    assert found == near(edge * spacing[axis], rel=1e-9)


def test_half_widths_of_odd_contacts():
    """Cells outside with equal gaps put the edge in the middle between cell centers."""
    uneven = Grid((20, 8), (1e-6, 1e-6), (False, True))
    inside = np.zeros(uneven.shape, dtype=bool)
    inside[4:13, 0] = True
    # From -6 µm to 3 µm: the mean of both sides.
    assert half_width(uneven.axis_cells(0), inside, np.where(inside, 0.0, 1e-9)) == near(4.5e-6)
    assert stick_half_width(uneven.axis_cells(0), inside * 1e9) == near(4.5e-6)
    cells = Grid((8, 6), (1e-6, 2e-6))
    nothing, off_axis, spots = (np.zeros(cells.shape, dtype=bool) for _ in range(3))
    off_axis[3, 4] = spots[[0, 1, 5, 6], 0] = True
    # Zero where the axis is open, up to the outermost spot, and the window at most.
    for inside, expected in ((nothing, 0.0), (off_axis, 0.0), (spots, 7e-6)):
        assert half_width(cells.axis_cells(0), inside, np.where(inside, 0.0, 1e-9)) == near(
            expected
        )
    assert half_width(cells.axis_cells(1), ~nothing, np.zeros(cells.shape)) == near(cells.extent[1])


@given(
    place=st.floats(9.6, 10.4),
    lowest=st.floats(0.01, 0.9).flatmap(lambda size: st.sampled_from([-size, size])),
    axis=st.sampled_from([0, 1]),
    even=st.sampled_from(EVEN),
)
def test_a_tip_that_touches_between_centers_is_the_edge(place, lowest, axis, even):
    """A paraboloid of radius 1 in units of cells, beyond a zone that ends with the fourth cell."""
    spacing = (1e-6, 1.7e-6)
    cells = Grid(tuple(24 if one else 48 for one in even), spacing, even)
    x, y = np.meshgrid(np.abs(cells.x) / spacing[0], np.abs(cells.y) / spacing[1], indexing="ij")
    along, across = (x, y) if axis == 0 else (y, x)
    inside = (along < 4.0) & (across < 2.0)
    tip = 0.5 * ((along - place) ** 2 + across**2) + lowest / 8.0
    assert (tip > 0.0).all()
    gap = 1e-9 * np.where(inside, 0.0, np.where(along < 7.0, 1e3 * (along - 3.9), tip))
    lines = cells.axis_cells(axis)
    edge = place + np.sqrt(max(-lowest / 8.0, 0.0))
    found = half_width(lines, inside, gap, tips=True) / spacing[axis]
    assert found == near(edge, rel=1e-9) if lowest < 0.0 else found < 5.0


@dataclass(frozen=True)
class Skewed(Waves):
    """Waves without symmetry, mirrored by the signs of x and y, and then turned."""

    signs: tuple[int, int] = (1, 1)
    is_turned: bool = False

    def height(self, x, y):
        x, y = (sign * coordinate for sign, coordinate in zip(self.signs, (x, y), strict=True))
        x, y = (y, x) if self.is_turned else (x, y)
        oblique = 0.5 * np.sin(11.0 * x / A + 8.0 * y / A)
        return oblique * self.amplitude + super().height(x + 0.04 * A, y + 0.09 * A)


@pytest.mark.parametrize(
    ("signs", "is_turned"), [((-1, 1), False), ((1, -1), False), ((-1, -1), False), ((1, 1), True)]
)
def test_a_map_that_is_mirrored_or_turned_has_the_same_measures(signs, is_turned):
    def numbers(**changes):
        waves = Skewed(0.15e-6, 12.0 / A, 12.0 / A, (False, False), **changes)
        problem = fretting(12, roughness=waves, load_ratio=0.6)
        state = first_loading(problem)
        return Measures(problem, state).scalars({}, of_steps=True)

    axes = {"_x": "_y", "_y": "_x"} if is_turned else {}
    changed = numbers(signs=signs, is_turned=is_turned)
    for name, value in numbers().items():
        same = name[:-2] + axes.get(name[-2:], name[-2:])
        assert changed[same] == near(value, rel=1e-6), name


@pytest.mark.slow
def test_areas_and_mean_pressures_of_rough_contacts_converge_with_few_cells_on_a_tip():
    """Counts of cells fall linearly with the spacing, to where corrected areas are at once."""
    rough = WavyRoughness(amplitude=0.2e-6, slope_x=np.radians(2), slope_y=np.radians(1))

    def areas(cells):
        problem = fretting(2 * cells, roughness=rough, spacing=(A / cells, 2 * A / cells))
        state = first_loading(problem)
        found = Measures(problem, state)
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
    assert 0.9 * 4.5e9 < Measures(problem, state).mean_stick_pressure <= 4.5e9
    # Nor do they bear more than the limit where the surface beside them bears nothing.
    full = replace(state, pressure=np.where(state.reduced.stick, 4.5e9, 0.0))
    assert Measures(problem, full).mean_stick_pressure == near(4.5e9, rel=1e-12)


@pytest.mark.parametrize(("across", "within"), [(6, 0.03), (12, 0.012)])
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
        beside = Evidence(found.pressure, np.where(found.pressure > 0.0, 0.0, found.gap))
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
    contact, area = state.in_contact, Measures(PROBLEM, state).contact_area
    # Worn surfaces conform: no pressure, and no gap either.
    conforming = replace(
        state,
        pressure=np.where(state.reduced.stick, state.pressure, 0.0),
        gap=np.where(contact, 0.9 * CONTACT_GAP * state.approach, state.gap),
    )
    np.testing.assert_array_equal(conforming.in_contact, contact)
    # Without pressure, both directions tell alike where the edge cuts its cells.
    assert Measures(PROBLEM, conforming).contact_area == near(area, rel=1e-3)
    raised = state.gap + 1.1 * CONTACT_GAP * state.approach
    opened = replace(state, pressure=np.zeros_like(raised), gap=raised)
    assert Measures(PROBLEM, opened).contact_area == 0
    # Waves that only touch in their valleys bring the approach down to zero and below.
    for approach in (0.0, -state.approach):
        lowered = replace(state, approach=approach)
        assert Measures(PROBLEM, lowered).contact_area == near(area, rel=1e-12)
