"""Stresses below tractions on cells, against closed forms, published values and equilibrium."""

import math

import numpy as np
import pytest

from fretwear_cracks.cracks import von_mises
from fretwear_cracks.tractions import Tractions

from ..studies import near
from . import hertz

NU, CELLS = 0.3, 64
STEP, HERTZ = 1 / CELLS, hertz.sphere(CELLS)
XX, YY, ZZ, XY, XZ, YZ = range(6)


def sphere(shear, pressure=HERTZ):
    return Tractions(pressure[None], shear[None], (STEP, STEP), (True, True), NU)


def total(parts):
    return parts[0][0] + parts[1][0]


# Full tensors (x, y, z | xx, yy, zz, xy, xz, yz) under a sphere, in a and p0.
SLIDING = """
 0.0  0.0 0.25 | -0.398521   -0.398521   -0.9411765     0          -0.159669    0
 0.5  0.0 0.25 | -0.4596498  -0.3515736  -0.8287296     0          -0.2520782   0
-0.5  0.0 0.25 | -0.1812651  -0.3000513  -0.7571884     0          -0.01360746  0
 0.4  0.4 0.5  | -0.1985903  -0.1546523  -0.6439169    -0.03698608 -0.1851679  -0.1276011
-0.9  0.0 0.05 |  0.1450597  -0.2517291  -0.3928465     0          -0.0148553   0
-1.2  0.0 0.1  |  0.173922   -0.06641261  0.0009608379  0          -0.01077974  0
 0.0  0.9 0.1  | -0.2683838  -0.2138801  -0.3954216    -0.1216075  -0.0838598  -0.1517375
 0.3 -0.6 1.0  | -0.03618139 -0.05278077 -0.366497      0.02444081 -0.07556914  0.1221657
"""
PARTIAL_SLIP = """
 0.0  0.0 0.25 | -0.398521   -0.398521   -0.9411765     0          -0.1699011   0
 0.5  0.0 0.25 | -0.4428433  -0.3560234  -0.7909015     0          -0.2674029   0
-0.5  0.0 0.25 | -0.1980716  -0.2956014  -0.7950166     0          -0.02893213  0
 0.4  0.4 0.5  | -0.2097558  -0.15484    -0.6363662    -0.0377588  -0.2021984  -0.1183077
-0.9  0.0 0.05 |  0.2746266  -0.2071965  -0.3749875     0          -0.07725832  0
-1.2  0.0 0.1  |  0.2499192  -0.05390453  0.0050834     0          -0.02724334  0
 0.0  0.9 0.1  | -0.2683838  -0.2138801  -0.3954216    -0.1799009  -0.1378562  -0.1517375
 0.3 -0.6 1.0  | -0.03973285 -0.05263218 -0.3687464     0.02711445 -0.08262072  0.1215445
"""


@pytest.mark.parametrize(
    ("text", "friction", "stick_radius"),
    [(SLIDING, 0.3, 0.0), (PARTIAL_SLIP, 0.5, 0.2 ** (1 / 3))],
    ids=["sliding", "partial slip"],
)
def test_tensors_under_a_sphere_to_a_thousandth_of_the_peak_pressure(text, friction, stick_radius):
    rows = [line.replace("|", "").split() for line in text.strip().splitlines()]
    table = np.array(rows, dtype=float)
    shear = friction * (HERTZ - hertz.sphere(CELLS, stick_radius))
    found = total(sphere(shear).at(table[:, :3]))
    np.testing.assert_allclose(found.T, table[:, 3:], atol=1e-3)


@pytest.mark.parametrize(
    ("friction", "largest", "x", "z"),
    [(0.0, 0.62004, 0.0, 0.48087), (0.2, 0.63766, 0.21922, 0.45713), (0.35, 0.67418, 0.364, 0.41)],
)
def test_the_largest_von_mises_stress_below_a_sliding_sphere(friction, largest, x, z):
    slid = sphere(friction * HERTZ)
    depths = np.arange(0.3, 0.6, 0.005)
    plane = np.array([von_mises(total(slid.section(depth))) for depth in depths])
    row, column = np.unravel_index(plane.argmax(), plane.shape)
    assert plane.max() == near(largest, rel=1e-3)
    assert (slid.x[column], depths[row]) == pytest.approx((x, z), abs=0.02)


def test_the_surface_inside_a_sliding_contact():
    """The part of the shear traction is linear in x: σ_xx = −(4 + ν)πµp0 x/8a."""
    friction = 0.3
    slid = sphere(friction * HERTZ)
    of_pressure, of_shear = (part[0] for part in slid.section(0.0))
    inside = abs(slid.x) < 0.85
    r, pressure = abs(slid.x[inside]), np.sqrt(1 - slid.x[inside] ** 2)
    radial = (1 - 2 * NU) / (3 * r**2) * (1 - pressure**3) - pressure
    linear = -(4 + NU) * math.pi * friction / 8 * slid.x[inside]
    np.testing.assert_allclose(of_pressure[XX][inside], radial, atol=1e-3)
    np.testing.assert_allclose(of_shear[XX][inside], linear, atol=5e-3)
    np.testing.assert_allclose(of_shear[XZ][inside], -friction * pressure, atol=2e-3)


def test_a_cylinder_sliding_in_plane_strain():
    """McEwen (1949), in Johnson (1985), equations 4.49 and 4.50, and 7.29 for the shear."""
    pressure = hertz.cylinder(CELLS)[None]
    slid = Tractions(pressure, 0.4 * pressure, (STEP, 1.0), (True, False), NU, plane_strain=True)
    x, z = (each.ravel() for each in np.meshgrid([0.0, 0.4, -0.9, 1.3], [0.05, 0.3, 0.79, 2.0]))
    found = slid.at(np.stack([x, 5.0 + 0 * x, z], axis=1))
    both = 1 - x**2 + z**2
    root = np.sqrt(both**2 + 4 * x**2 * z**2)
    m, n = np.sqrt(0.5 * (root + both)), np.sign(x) * np.sqrt(0.5 * (root - both))
    squares = m**2 + n**2
    xx = -(m * (1 + (z**2 + n**2) / squares) - 2 * z)
    zz, xz = -m * (1 - (z**2 + n**2) / squares), -n * (m**2 - z**2) / squares
    np.testing.assert_allclose(found[0][0][[XX, ZZ]], [xx, zz], atol=1e-3)
    np.testing.assert_allclose(found[0][0][XZ], xz, atol=1e-3)
    np.testing.assert_allclose(found[0][0][YY], NU * (xx + zz), atol=1e-3)
    of_shear = found[1][0] / 0.4
    # The shear of q gives the σ_zz that a pressure of the same form gives as shear, and so on.
    np.testing.assert_allclose(of_shear[ZZ], found[0][0][XZ], atol=1e-12)
    np.testing.assert_allclose(of_shear[XZ], found[0][0][XX], atol=1e-12)


def test_a_unit_square_as_the_program_contact_gives_it():
    """Its command subsurf, at a point nominally on the axis: the digits place it at −9e-5."""
    square = Tractions(
        np.ones((1, 1, 1)), 0.999 * np.ones((1, 1, 1)), (0.5, 0.5), (True, True), 0.28
    )
    found = total(square.at(np.array([[-9e-5, 0.0, 0.5]])))[:, 0]
    expected = {XX: -0.076184, YY: -0.076223, ZZ: -0.700842, XZ: -0.149363}
    for component, value in expected.items():
        assert found[component] == pytest.approx(value, abs=1e-6)
    assert found[[XY, YZ]] == pytest.approx(0.0, abs=1e-12)


RANDOM = np.random.default_rng(7)


@pytest.mark.parametrize("even", [(True, True), (True, False), (False, True), (False, False)])
def test_sections_are_the_sums_over_cells(even):
    pressure, shear, across = (RANDOM.random((n, 6, 8)) for n in (2, 3, 3))
    fields = Tractions(pressure, shear, (0.1, 0.12), even, NU, across=across)
    for depth in (0.01, 0.2, 0.5):
        on_plane = np.stack([fields.x, 0 * fields.x, 0 * fields.x + depth], axis=1)
        for section, sums in zip(fields.section(depth), fields.at(on_plane), strict=True):
            np.testing.assert_allclose(section, sums, atol=1e-12)


@pytest.mark.parametrize("even", [(True, True), (False, False)])
def test_shear_along_y_is_shear_along_x_of_the_turned_contact(even):
    fields, turned = RANDOM.random((1, 6, 8)), [1, 0, 2, 3, 5, 4]
    # Along x shear is even, along y odd: the turned contact is given on both sides.
    along_y = Tractions(fields, 0 * fields, (0.1, 0.12), even, NU, across=fields)
    whole = along_y.on_both_sides(fields, odd=True).swapaxes(1, 2)
    along_x = Tractions(0 * whole, whole, (0.12, 0.1), (False, False), NU)
    points = RANDOM.random((20, 3)) * [1.6, 1.6, 0.5] - [0.8, 0.8, -0.01]
    expected = along_x.at(points[:, [1, 0, 2]])[1][:, turned]
    np.testing.assert_allclose(along_y.at(points)[1], expected, atol=1e-13)
    assert abs(expected).max() > 0.1


def test_stresses_are_in_equilibrium():
    rough = sphere(HERTZ * RANDOM.random((70, 70)), HERTZ * RANDOM.random((70, 70)))
    points = np.array([[0.3, 0.2, 0.4], [-0.7, 0.5, 0.2], [0.0, -0.9, 0.15], [1.1, 0.1, 0.3]])
    step = 1e-4
    slopes = [
        (total(rough.at(points + step * way)) - total(rough.at(points - step * way))) / (2 * step)
        for way in np.eye(3)
    ]
    rows = [(XX, XY, XZ), (XY, YY, YZ), (XZ, YZ, ZZ)]
    for row in rows:
        terms = np.array([slope[each] for slope, each in zip(slopes, row, strict=True)])
        assert (abs(terms.sum(axis=0)) < 1e-3 * abs(terms).sum(axis=0)).all()
