"""Shear tractions and stresses over a cycle, and parameters for cracks."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fretwear.mechanics.contact.grid import Grid
from fretwear.run.simulate import simulate
from fretwear.theory import HertzContact, LineContact
from fretwear_cracks.cracks import PointLoops, von_mises
from fretwear_cracks.inputs import surface_of
from fretwear_cracks.states import LoadedSurface, StressHistory, over_the_loop

from ..studies import WAVES, near, steel
from . import hertz

E, NU, LOAD, FRICTION, RATIO = 208e9, 0.3, 50.0, 0.5, 0.8
MODULUS = E / (2 * (1 - NU**2))
HERTZ = HertzContact(radius=10e-3, load=LOAD, composite_modulus=MODULUS)
A = HERTZ.contact_radius


def sphere(ratio=RATIO, cells=40):
    """A sphere at +Q, a closed form."""
    count = int(1.2 * cells)
    grid = Grid((count, count), (A / cells, A / cells))
    pressure, stuck = (
        HERTZ.peak_pressure * hertz.sphere(cells, radius, count)
        for radius in (1.0, math.cbrt(1 - ratio))
    )
    shear = FRICTION * (pressure - stuck)
    gap = HERTZ.gap(np.hypot(grid.x[:, None], grid.y))
    return LoadedSurface(pressure, shear, gap, grid.spacing, grid.even, FRICTION, MODULUS, NU)


def at_phase(surface, step, count, ratio):
    """The shear traction of the unworn sphere after part of the way to −Q, without its edges."""
    x, y = surface.half_space.geometry.x, surface.half_space.geometry.y
    r = np.hypot(x[:, None], y)
    reached = HERTZ.with_load(LOAD * (1 - ratio * step / count))
    smooth = abs(r - reached.contact_radius) > 0.1 * A
    smooth &= abs(r - A) > 0.1 * A
    expected = surface.shear - 2 * FRICTION * (surface.pressure - reached.pressure(r))
    return expected, smooth


@pytest.mark.parametrize("ratio", [RATIO, 1.0], ids=["partial slip", "gross slip"])
def test_the_traction_falls_from_plus_to_minus_q_by_contacts_of_the_same_shape(ratio):
    surface, count = sphere(ratio), 8
    shears = surface.over_half_a_loop(count)
    integral = surface.half_space.geometry.integral
    forces = np.array([integral(shear) for shear in shears])
    whole = integral(surface.shear)
    expected = whole * (1 - 2 * np.arange(count) / count)
    np.testing.assert_allclose(forces, expected, atol=1e-4 * whole)
    for step in (1, 4, 7):
        expected, smooth = at_phase(surface, step, count, ratio)
        np.testing.assert_allclose(
            shears[step][smooth], expected[smooth], atol=4e-3 * FRICTION * HERTZ.peak_pressure
        )
    assert (abs(shears) <= FRICTION * surface.pressure * (1 + 1e-12)).all()


def test_the_traction_of_a_line_contact_over_half_a_loop():
    line = LineContact(radius=10e-3, load=18e3, composite_modulus=MODULUS)
    half, cells = line.contact_radius, 100
    x = (np.arange(130) + 0.5)[:, None] * half / cells
    pressure = line.pressure(x)
    shear = FRICTION * (pressure - line.with_load(0.4 * 18e3).pressure(x))
    spacing = (half / cells, 1.0)
    surface = LoadedSurface(
        pressure, shear, line.gap(x), spacing, (True, False), FRICTION, MODULUS, NU, line.reference
    )
    found = surface.over_half_a_loop(2)[1]
    middle = line.with_load(0.7 * 18e3)
    expected = shear - 2 * FRICTION * (pressure - middle.pressure(x))
    smooth = abs(x - middle.contact_radius) > 0.05 * half
    smooth &= abs(x - half) > 0.05 * half
    peak = FRICTION * line.peak_pressure
    np.testing.assert_allclose(found[smooth], expected[smooth], atol=4e-3 * peak)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::fretwear.ResultWarning")
def test_the_loop_of_a_rough_contact_has_the_influence_of_tractions_along_x():
    """Masing's loop ends in −q(+Q), and its work is the dissipated energy of the run.

    W = 8 (∫ f dd − Q d/2), where f(d) is the curve from 0 to +Q, and d the displacement of a cell
    that sticks. A smooth sphere does not tell the influences apart: its pressures stay Hertzian.
    """
    waves = {**WAVES, "slope_x": "1.5 deg", "slope_y": "1.5 deg"}
    case = steel(cycles=1, cell="3.6 um", roughness=waves, error_estimate=False)
    first = simulate(case, quarter=True).isel(cycle=0)
    surface, _ = surface_of(first, case, 0)

    def missed(of):
        ended = FRICTION * (of.pressure - of.reduced(1.0, of.pressure).pressure)
        return abs(ended - of.shear).sum() / of.shear.sum()

    assert missed(surface) < 5e-5
    assert missed(replace(surface, is_directed=False)) > 5e-3
    count, stuck = 32, (FRICTION * surface.pressure - surface.shear).argmax()
    u = [surface.sheared.displacement(q).flat[stuck] for q in surface.over_half_a_loop(count)]
    fallen = surface.coupling * (u[0] - np.array([*u, -u[0]]))
    force = surface.half_space.geometry.integral(surface.shear)
    half = np.trapezoid(force * np.linspace(0.0, 1.0, count + 1), 0.5 * fallen)
    work = 8 * (half - 0.25 * force * fallen[-1])
    assert work == near(float(first.dissipated_energy), rel=2e-3)


def test_a_bulk_stress_adds_to_the_stress_along_x_in_phase_with_the_force():
    surface, point = sphere(cells=10), np.array([[0.3 * A, 0.0, 0.4 * A]])
    plain, pulled = (StressHistory(surface, 8, bulk) for bulk in (0.0, 80e6))
    added = over_the_loop(*pulled.at(point)) - over_the_loop(*plain.at(point))
    ratio = [1, 0.5, 0, -0.5, -1, -0.5, 0, 0.5]
    np.testing.assert_allclose(added[:, 0, 0], 80e6 * np.array(ratio), atol=1.0)
    assert not added[:, 1:].any()


# x, y, z in a | σ_xx at +Q and −Q, SWT, √J2,a, P_H,max, Crossland with α 0.2, MPa | Fatemi–Socie
CRACKS = """
-0.95 0 0.05 |  380.68 -715.52 0.95367 300.92   -7.047 299.51  | 0.0043777
-0.8  0 0.1  |   53.983 -701.72 0.12038 268.16 -265.43  215.08  | 0.0032359
 0.3  0 0.45 | -276.1  -158.99 0       119.19 -397.98   39.596 | 0.0014826
"""


def test_crack_parameters_at_points_below_a_sphere():
    """To 1 %, with planes every 3° in the values compared with, and 0.1 % of the peak pressure."""
    rows = [line.replace("|", "").split() for line in CRACKS.strip().splitlines()]
    table = np.array(rows, dtype=float).T
    steady, alternating = StressHistory(sphere(cells=64), 32).at(A * table[:3].T)
    loops, megapascal = PointLoops(steady, alternating, E, NU), 1e6
    peak = HERTZ.peak_pressure * 1e-3
    np.testing.assert_allclose((steady + alternating[0])[0], megapascal * table[3], atol=peak)
    np.testing.assert_allclose((steady - alternating[0])[0], megapascal * table[4], atol=peak)
    expected = {
        "smith_watson_topper": table[5] * megapascal,
        "deviatoric": table[6] * megapascal,
        "fatemi_socie": table[9],
    }
    found = {
        "smith_watson_topper": loops.smith_watson_topper().value,
        "deviatoric": loops.crossland(0.0),
        "fatemi_socie": loops.fatemi_socie(1.0, 1000e6).value,
    }
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values, rtol=5e-3, err_msg=name)
    mean = loops.crossland(1.0) - loops.crossland(0.0)
    np.testing.assert_allclose(mean, megapascal * table[7], atol=peak)
    np.testing.assert_allclose(loops.crossland(0.2), megapascal * table[8], atol=peak)


@pytest.mark.parametrize("amplitude", [300e6, -300e6])
def test_parameters_of_a_loop_of_tension(amplitude):
    along_x = np.eye(6)[:, :1]
    alternating = amplitude * np.array([1.0, 0.4])[:, None, None] * along_x
    loops = PointLoops(50e6 * along_x, alternating, E, NU)
    swt = loops.smith_watson_topper()
    assert swt.value == near([350e6 * 300e6 / E], rel=1e-5)
    assert abs(swt.normal[0, 0]) == pytest.approx(1.0, abs=1e-4)
    assert loops.crossland(0.0) == near([300e6 / math.sqrt(3)])
    assert loops.crossland(0.3) == near([300e6 / math.sqrt(3) + 0.3 * 350e6 / 3])
    # γ_a = (1 + ν) σ_a sin 2θ/E, σ_n,max = 350 MPa cos²θ
    angle = np.linspace(0, math.pi / 2, 100_001)
    strain = (1 + NU) * 300e6 / E * np.sin(2 * angle)
    expected = (strain * (1 + 0.8 * 350e6 * np.cos(angle) ** 2 / 600e6)).max()
    assert loops.fatemi_socie(0.8, 600e6).value == near([expected], rel=1e-5)


def test_the_worst_plane_turns_with_the_stresses():
    """No direction of the first planes that are tried is preferred."""
    random = np.random.default_rng(3)
    values = []
    tensors = random.normal(size=(4, 3, 3)) * 1e8
    tensors += tensors.swapaxes(1, 2)
    for _ in range(6):
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        turned = turn @ tensors @ turn.T
        six = turned[:, [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]][..., None]
        loops = PointLoops(six[0], six[1:], E, NU)
        found = loops.smith_watson_topper(), loops.fatemi_socie(1.0, 1e9)
        values.append([each.value[0] for each in found])
    np.testing.assert_allclose(values, np.broadcast_to(values[0], (6, 2)), rtol=2e-4)


def test_the_von_mises_stress_is_that_of_the_principal_stresses():
    six = np.random.default_rng(5).normal(size=(6, 50))
    six[:, 0], six[:, 1] = 0.0, [1, 1, 1, 0, 0, 0]
    tensors = six[[0, 3, 4, 3, 1, 5, 4, 5, 2]].T.reshape(50, 3, 3)
    low, middle, high = np.linalg.eigvalsh(tensors).T
    squares = (high - middle) ** 2 + (middle - low) ** 2 + (high - low) ** 2
    np.testing.assert_allclose(von_mises(six), np.sqrt(squares / 2), atol=1e-12)
