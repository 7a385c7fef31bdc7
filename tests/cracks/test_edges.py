"""Stresses of the surface at the ends of contact, where the tension of sliding is largest."""

import math

import numpy as np
import pytest

import fretwear
from fretwear_cracks.edges import stresses_at_edge
from fretwear_cracks.influence import of_rectangles

from ..mechanics.problems import unfolded
from ..studies import near, steel
from . import hertz

NU = 0.3
XX, YY, ZZ, XY, XZ, YZ = range(6)
TRAILING = (4 + NU) * math.pi / 8


def sphere(cells, radius=1.0):
    """The pressure of a sphere on both sides along x and y."""
    return unfolded(hertz.sphere(cells, radius, int(1.2 * cells), divided=16))


def cylinder(cells, radius=1.0):
    """The pressure of a cylinder on both sides."""
    return unfolded(hertz.cylinder(cells, radius, int(1.3 * cells)), (True, False))


def edge_of(pressure, shears, friction, cells, across=None):
    spacing = (1 / cells, across or 1 / cells)
    return stresses_at_edge(
        pressure, np.stack(shears), friction, spacing, NU, plane_strain=across is not None
    )


@pytest.mark.parametrize("cells", [16, 32.3, 64])
def test_the_trailing_edge_of_a_sliding_sphere(cells):
    """(1 − 2ν)/3 + (4 + ν)πµ/8 in p0: Hamilton and Goodman, J. Appl. Mech. 33 (1966)."""
    pressure, friction = sphere(cells), 0.4
    edge = edge_of(pressure, [friction * pressure], friction, cells)
    assert edge.x == pytest.approx(-1, abs=1e-3 / cells * 5)
    assert edge.of_pressure[[XX, YY]] == pytest.approx([0.4 / 3, -0.4 / 3], abs=1.5e-3)
    assert edge.of_shears[0, XX] == near(friction * TRAILING, rel=3e-3)
    assert abs(edge.of_shears[0, [ZZ, XY, XZ, YZ]]).max() < 2e-3


def test_the_trailing_edge_of_a_sphere_in_partial_slip():
    """Nothing in p* is singular at the edge: its part is a smooth integral over the stick disc."""
    cells, friction, stick = 48, 0.5, 0.6
    shear = friction * (sphere(cells) - sphere(cells, stick))
    edge = edge_of(sphere(cells), [shear, -shear], friction, cells)
    angles = 2 * math.pi * (np.arange(400) + 0.5) / 400
    nodes, weights = np.polynomial.legendre.leggauss(100)
    # The root in p* vanishes in the angle whose sine is r/c.
    arcs = math.pi / 4 * (1 + nodes)
    r, pressure = stick * np.sin(arcs), stick * np.cos(arcs)
    corners = np.array([-0.5, 0.5]) * 1e-3
    x, y = (
        each[..., None, None]
        for each in (-1 - r[:, None] * np.cos(angles), -r[:, None] * np.sin(angles))
    )
    kernel = of_rectangles(x + corners[:, None], y + corners, 0.0, NU)[..., 0, 0] / 1e-6
    areas = math.pi / 4 * weights * stick * np.cos(arcs) * r * (2 * math.pi / 400)
    expected = friction * (TRAILING - (kernel[1, XX].sum(axis=1) * pressure * areas).sum())
    assert edge.of_shears[:, XX] == near([expected, -expected], rel=2e-3)


@pytest.mark.parametrize("stick", [0.0, 0.4, 0.8])
def test_the_trailing_edge_of_a_cylinder_in_partial_slip(stick):
    """σ_xx = 2 p0 √(µQ/P), from the two elliptic tractions, with Q/µP = 1 − (c/a)²."""
    cells, friction = 64, 0.5
    pressure = cylinder(cells)
    stuck = cylinder(cells, stick) if stick else 0 * pressure
    shear = friction * (pressure - stuck)
    edge = edge_of(pressure, [shear, -shear, 0 * shear], friction, cells, across=1.0)
    tension = 2 * friction * math.sqrt(1 - stick**2)
    assert edge.of_pressure[:3] == pytest.approx(np.zeros(3), abs=1e-3)
    assert edge.of_shears[:2, XX] == near([tension, -tension], rel=1e-3)
    assert edge.of_shears[:2, YY] == near([NU * tension, -NU * tension], rel=1e-3)
    # No shear: two equal contacts, of the way to −Q.
    assert edge.of_shears[2, XX] == pytest.approx(0.0, abs=1e-3)


def test_the_edge_of_a_simulated_contact_is_that_of_the_closed_form():
    """It slides as a whole; below the surface the largest tension is less."""
    sliding = {"tangential_ratio": None, "displacement_amplitude": "2.5 um"}
    case = steel(cycles=1, cell="2.3 um", error_estimate=False, **sliding)
    found = fretwear.stress(fretwear.simulate(case, quarter=True), phases=4)
    peak, radius = case.hertz_pressure, case.hertz_radius
    assert found.edge_x.values == near([-radius, radius], rel=1e-3)
    expected = peak * (0.4 / 3 + 0.5 * TRAILING)
    behind, ahead = found.edge_stress_xx.values.T
    assert behind[0] == near(expected, rel=5e-3)
    np.testing.assert_allclose(behind, np.roll(ahead, 2), rtol=1e-6)
    assert float(found.stress_xx.max()) < 0.9 * behind[0]
    largest = (behind[0] - NU * found.edge_stress_yy[0, 0]) * behind[0]
    assert float(found.smith_watson_topper_edge[0]) < float(largest) / case.bodies.youngs_modulus


@pytest.mark.slow
def test_a_surface_that_wear_has_made_singular_is_told_so():
    """All load has gone to the stick zone, and no cell is fine enough at its edge."""
    case = steel(cycles=100_000, cell="5 um", output_cycles=(), error_estimate=False)
    found = fretwear.stress(fretwear.simulate(case, quarter=True), 100_000, phases=2)
    assert "edge_x" not in found.coords
    assert "edge_stress_xx" not in found
    assert "have no limit at the surface" in found.warnings
