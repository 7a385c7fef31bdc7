"""Unlike bodies loaded with friction: CONTACT's example of Spence's problem, and cycles."""

import numpy as np
import pytest

from fretwear.mechanics.contact.cells import Region
from fretwear.mechanics.contact.grid import Grid
from fretwear.theory import HertzContact

from ..studies import near
from .unlike import UnlikeContact


@pytest.mark.slow
def test_contact_of_spence():
    """Example spence35 of CONTACT: 35 steps of a sphere on a rigid flat, ν = 0, β = 1/2."""
    friction, size = 0.2986, 0.2
    grid = Grid((48, 48), (size, size), (False, False))
    place = (np.arange(48) - 23) * size
    bodies = UnlikeContact(
        grid, 1.0, 1.0, 0.5, friction, 0.004116 * (place[:, None] ** 2 + place**2)
    )
    for step in range(1, 36):
        bodies.load((step / 45) ** 3)
    pressure, sheared = bodies.contact.pressure, bodies.sheared
    assert bodies.contact.approach == near(0.09874, rel=1e-3)
    assert pressure.max() == near(0.02392, rel=2e-3)
    assert (pressure > 0).sum() == pytest.approx(921, abs=4)
    assert sheared.stick.sum() == pytest.approx(225, abs=1)
    work = friction * float((pressure * sheared.amplitude).sum()) * grid.unit_area
    assert work == near(1.842e-5, rel=2e-3)
    # Nothing distinguishes a direction.
    traction = np.roll(sheared.traction, (1, 1), (1, 2))
    assert np.abs(traction[0] - traction[1].T).max() <= 1e-4 * np.abs(traction).max()


def steel_on_aluminium(cells, steps):
    """E* = R = a = 1; G 80 and 26.3 GPa, ν 0.3 and 0.33, µ 0.3, loaded in steps."""
    first, second = (80.0, 0.3), (26.3, 0.33)
    normal = sum((1 - nu) / (2 * g) for g, nu in (first, second))
    coupling = sum((2 - nu) / (4 * g) for g, nu in (first, second)) / normal
    beta = abs(
        sum(s * (1 - 2 * nu) / g for s, (g, nu) in zip((1, -1), (first, second), strict=True))
    )
    beta /= 4 * normal
    count = 2 * int(np.ceil(1.15 * cells / 2)) * 2
    while pow(30, 64, count):
        count += 2
    grid = Grid((count, count), (1 / cells, 1 / cells), (False, False))
    shape = (grid.x[:, None] ** 2 + grid.y**2) / 2
    bodies = UnlikeContact(grid, 1.0, coupling, beta, 0.3, shape)
    for step in range(1, steps + 1):
        bodies.load(4 / 3 * (step / steps) ** 3)
    return grid, coupling, bodies


def test_steel_on_aluminium_slips_at_its_edge_before_any_tangential_force():
    grid, coupling, bodies = steel_on_aluminium(20, 10)
    hertz = HertzContact(1.0, 4 / 3, 1.0)
    radius = np.sqrt(grid.zone(Region(bodies.sheared.stick, 1.0)).area / np.pi)
    # a cell is 0.05 wide
    assert radius == pytest.approx(0.9527, abs=0.02)
    assert bodies.contact.pressure.max() / hertz.peak_pressure == near(1.0121, rel=4e-3)
    assert bodies.contact.approach / hertz.approach == near(0.9980, rel=2e-3)
    bodies.load(4 / 3, 0.3 * 0.3 * 4 / 3)
    radius = np.sqrt(grid.zone(Region(bodies.sheared.stick, 1.0)).area / np.pi)
    assert radius == pytest.approx(0.8600, abs=0.005)
    displacement = 0.3 * coupling * hertz.approach * (1 - 0.7 ** (2 / 3))
    assert bodies.sheared.displacement / displacement == near(1.0142, rel=3e-3)
    assert bodies.sheared.force == near(0.3 * 0.3 * 4 / 3, rel=1e-9)


@pytest.mark.parametrize("ratio", [0.3, 0.75])
def test_cycles_of_steel_on_aluminium_are_symmetric_from_the_second_on(ratio):
    """Pressure has dragged the surfaces at β/µ = 0.39, which cycles forget.

    Work of both halves of a cycle agrees within 1 % from the second on, path in each cell within
    1.6 % of the longest in the second and 0.6 % in the third.
    """
    grid, coupling, bodies = steel_on_aluminium(10, 6)
    friction, load = 0.3, 4 / 3

    def half_cycle(bodies, *forces):
        path = np.zeros(grid.shape)
        for force in np.linspace(*forces, 5)[1:]:
            bodies.load(load, force * friction * load)
            path += np.where(bodies.contact.pressure > 0, bodies.sheared.amplitude, 0.0)
        work = friction * float((bodies.contact.pressure * path).sum()) * grid.unit_area
        return path, work

    half_cycle(bodies, 0.0, ratio)
    works = []
    for cycle in range(3):
        (back, first), (forth, second) = (
            half_cycle(bodies, *forces) for forces in ((ratio, -ratio), (-ratio, ratio))
        )
        works.append(first + second)
        apart = np.abs(back - forth[::-1]).max() / forth.max()
        assert apart > 0.1 if cycle == 0 else apart <= (0.02 if cycle == 1 else 0.01)
        assert cycle == 0 or first == near(second, rel=0.01)
    alike = UnlikeContact(
        grid, 1.0, coupling, 0.0, friction, (grid.x[:, None] ** 2 + grid.y**2) / 2
    )
    alike.load(load)
    half_cycle(alike, 0.0, ratio)
    same = half_cycle(alike, ratio, -ratio)[1] + half_cycle(alike, -ratio, ratio)[1]
    assert works[0] > works[1] > works[2] > same
    assert works[2] == near(same, rel=0.03)
