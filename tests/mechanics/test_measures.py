"""Radii of contact and stick zone by their outlines, and half-widths of the scar."""

import numpy as np
import pytest

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.wear.integrator import evolve, first_loading
from fretwear.mechanics.wear.measures import half_extent, measure, open_within_outline, scatter
from fretwear.run.simulate import simulate

from ..studies import near, steel
from .problems import EVEN, A, Waves, fretting, uneven

CYLINDER = {"kind": "cylinder", "radius": "6 mm"}


@pytest.mark.parametrize(
    ("changes", "within"),
    [({"geometry": Rings}, 0.02), *[({"roughness": uneven(None, even)}, 0.1) for even in EVEN]],
)
def test_a_smooth_sphere_has_the_radii_of_hertz_and_cattaneo(changes, within):
    problem = fretting(16, **changes)
    state = first_loading(problem)
    found, doubt = measure(problem, state), scatter(state)
    for radius, zone in ((A, "contact"), (A * 0.2 ** (1 / 3), "stick")):
        assert getattr(found, f"{zone}_radius") == pytest.approx(radius, abs=within * A / 16), zone
        assert doubt[f"{zone}_radius"] < within * A / 16
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


def test_the_radius_stays_where_the_half_width_jumps_to_the_next_row_of_tips():
    """Tips 0.2 a apart; between the loads those 1.1 a from the centre begin to touch on y = 0."""
    waves = Waves(0.1e-6, 2 * np.pi / (0.2 * A), 2 * np.pi / (0.2 * A))
    found = []
    for load in (50.5, 51.9):
        problem = fretting(32, roughness=waves, normal=NormalLoad(load))
        found.append(measure(problem, first_loading(problem)))
    before, after = found
    assert after.contact_half_width_x > 1.1 * before.contact_half_width_x
    assert after.contact_radius == near(before.contact_radius, rel=0.01)


@pytest.mark.parametrize("edge", [17.1, 17.5, 17.9])
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


def evolve_to(problem, cycles=(10.0, 1000.0)):
    return [measure(problem, s) for s in evolve(problem, [*cycles]) if s.cycle in cycles]


def test_line_contacts_have_no_radii_and_no_scar_along_y():
    dataset = simulate(steel(radius=None, indenter=CYLINDER, load="50 N/mm", cycles=100))
    assert "scar_half_width_x_error" in dataset
    names = " ".join(map(str, dataset.variables))
    assert not [n for n in ("contact_radius", "stick_radius", "width_y") if n in names]
    scar, contact = (float(dataset[f"{of}_half_width_x"][-1]) for of in ("scar", "contact"))
    assert scar == near(contact, rel=0.02)
