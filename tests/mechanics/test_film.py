"""A film on a half-space: responses, influence of cells, and the contact of a sphere with it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm, schur
from scipy.special import j0, jv

from fretwear.mechanics.contact.film import Film
from fretwear.mechanics.contact.grid import Grid, influence_coefficients
from fretwear.mechanics.contact.problem import ContactProblem, solve_contact
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Row, Strips, influence_of_cell
from fretwear.mechanics.slip.models import Cerruti
from fretwear.mechanics.surfaces.coating import Coating
from fretwear.mechanics.surfaces.materials import ElasticBodies
from fretwear.mechanics.wear.integrator import first_loading

from ..studies import near
from .oracles import normal_contact, with_images
from .problems import STEEL, A, fretting

RADIUS, LOAD, (YOUNG, NU) = 10e-3, 50.0, STEEL
PAIRS = [(4.0, 0.2, 0.3), (0.25, 0.35, 0.3), (1.0, 0.5, 0.1), (30.0, 0.1, 0.45), (0.05, 0.49, 0.25)]


def film(ratio, nu, thickness, substrate=NU, modulus=YOUNG):
    """A film of a Young's modulus over that of the substrate."""
    moduli = ratio * modulus / (2.0 * (1.0 + nu)), modulus / (2.0 * (1.0 + substrate))
    return Film(thickness, moduli, (nu, substrate))


def state_matrix(shear, nu):
    """Derivatives by kz of (U, W, τ, σ), displacements in units of traction over k."""
    lame = 2.0 * shear * nu / (1.0 - 2.0 * nu) if nu < 0.5 else 1e15 * shear
    stiff = lame + 2.0 * shear
    return np.array(
        [
            [0.0, -1.0, 1.0 / shear, 0.0],
            [lame / stiff, 0.0, 0.0, 1.0 / stiff],
            [4.0 * shear * (lame + shear) / stiff, 0.0, 0.0, -lame / stiff],
            [0.0, 0.0, 1.0, 0.0],
        ]
    )


@pytest.mark.parametrize(("ratio", "nu", "substrate"), PAIRS)
def test_responses_solve_the_layered_problem(ratio, nu, substrate):
    body = film(ratio, nu, 1.0, substrate, modulus=2.0)
    (first, second), (nu1, nu2) = body.shear_moduli, body.poisson_ratios
    _, decaying, _ = schur(state_matrix(second, nu2), sort="lhp")
    for wave in (0.01, 0.1, 0.3, 1.0, 3.0):
        surface = expm(-wave * state_matrix(first, nu1)) @ decaying[:, :2]
        moved = surface[:2] @ np.linalg.inv(surface[2:])
        waves = np.array([wave])
        assert body.normal(waves)[0] == pytest.approx(-moved[1, 1], rel=1e-10)
        assert body.along(waves)[0] == pytest.approx(-moved[0, 0], rel=1e-10)
        # Across k, the displacement V and its traction G V' alone.
        through = math.cosh(wave), math.sinh(wave)
        up = through[0] + second / first * through[1], first * through[1] + second * through[0]
        assert body.across(waves)[0] == pytest.approx(up[0] / up[1], rel=1e-10)


def moved_by_gaussian(body, sigma, x, y):
    """What a film adds under exp(−r²/2σ²) at a place, by quadrature."""
    r = math.hypot(x, y)

    def response(wave):
        waves = np.array([0.0, wave * body.thickness])
        if body.way == "normal":
            even, twist = body.normal(waves), np.zeros(2)
        else:
            even, twist = (0.5 * (body.along(waves) + s * body.across(waves)) for s in (1.0, -1.0))
        turned = (twist[1] - twist[0]) * jv(2, wave * r) * (y**2 - x**2) / max(r, 1e-9) ** 2
        result = (even[1] - even[0]) * j0(wave * r) + (turned if body.way == "along" else 0.0)
        return result * sigma**2 * math.exp(-0.5 * (wave * sigma) ** 2) / body.per

    return quad(response, 0.0, 9.0 / sigma, limit=200, epsabs=1e-12)[0]


@pytest.mark.parametrize("way", ["normal", "along", "alike"])
@pytest.mark.parametrize(("ratio", "thickness"), [(4.0, 0.1), (0.2, 0.02), (30.0, 0.5), (3.0, 4.0)])
def test_a_film_on_cells_adds_its_transform(ratio, thickness, way):
    """Constant pressures on cells of a twentieth of σ err by the cube of that."""
    body = replace(film(ratio, 0.2, thickness, modulus=2.0), way=way, per=1.5)
    sigma, spacing = 0.5, (0.025, 0.02)
    grid = Grid((90, 110), spacing)
    x, y = (np.arange(-n + 0.5, n) * d for n, d in zip(grid.shape, spacing, strict=True))
    wide = [sigma**2 - d**2 / 12.0 for d in spacing]
    pressure = np.exp(-(x[:, None] ** 2) / 2 / wide[0] - y**2 / 2 / wide[1])
    pressure *= sigma**2 / math.sqrt(wide[0] * wide[1])
    kernel = body.on_cells((180, 220), spacing)
    largest = abs(moved_by_gaussian(body, sigma, 0.0, 0.0))
    for i, j in ((90, 110), (110, 118), (102, 170), (170, 112)):
        along, across = np.abs(i - np.arange(180)), np.abs(j - np.arange(220))
        found = float((kernel[np.ix_(along, across)] * pressure).sum())
        assert found == pytest.approx(
            moved_by_gaussian(body, sigma, x[i], y[j]), abs=3e-4 * largest
        )


@pytest.mark.parametrize("way", ["normal", "along"])
def test_a_film_on_strips_adds_its_transform(way):
    body = replace(film(4.0, 0.2, 0.3, modulus=2.0), way=way, per=1.5)
    reference, width = 7.0, 0.1
    column, bare = (influence_of_cell(90, width, reference, 1.0, one) for one in (body, None))
    added = column - bare
    response = body.normal if way == "normal" else body.along

    def integrand(wave, distance):
        rest, moved = response(np.array([0.0, wave * body.thickness])) / body.per
        apart = math.cos(wave * distance) - math.cos(wave)
        return (moved - rest) / wave * apart * np.sinc(0.5 * wave * width / np.pi) ** 2

    for place in (0, 30):
        expected = quad(integrand, 1e-9, 400.0, (place * width,), limit=900)[0] * width / np.pi
        assert added[place] - added[10] == pytest.approx(expected, rel=5e-4)
    assert column[70] == pytest.approx(0.0, abs=1e-4 * column[0])
    strips = Strips(tuple(width * np.arange(21.0)), reference)
    assert strips.influence(1.0, body)[3, 5] == pytest.approx(column[2] + column[9], rel=1e-9)


def sphere(cells, body, *, rigid):
    """Peak pressure, approach and radius over those of Hertz without the film."""
    modulus = YOUNG / (1.0 - NU**2) / (1 if rigid else 2)
    radius = math.cbrt(0.75 * LOAD * RADIUS / modulus)
    half_space = cells(radius).half_space(modulus, replace(body, thickness=body.thickness * radius))
    x, y = np.meshgrid(half_space.geometry.x, half_space.geometry.y, indexing="ij")
    shape = 0.5 * (x**2 + y**2) / RADIUS
    contact = solve_contact(ContactProblem(half_space, shape, LOAD), tolerance=1e-7)
    area = half_space.geometry.integral((contact.pressure > 0.0).astype(float))
    peak = 1.5 * LOAD / math.pi / radius**2
    hertz = peak, radius**2 / RADIUS, radius
    found = contact.pressure.max(), contact.approach, math.sqrt(area / math.pi)
    return np.array(found) / hertz


def squares(radius):
    return Grid((100, 100), (radius / 60.0, radius / 60.0))


def rings(radius):
    return Rings(tuple(np.linspace(0.0, 1.7 * radius, 256).tolist()))


# Rigid sphere and a ball of the substrate, by an independent solution on rings.
REFERENCE = [
    (True, 4.0, 0.2, 0.1, 1.0451, 0.9717),
    (True, 4.0, 0.2, 0.5, 1.5195, 0.8510),
    (True, 4.0, 0.2, 2.0, 2.3963, 0.5678),
    (True, 0.25, 0.35, 0.1, 0.9042, 1.0604),
    (True, 0.25, 0.35, 0.5, 0.6653, 1.2689),
    (True, 0.25, 0.35, 2.0, 0.4394, 1.7784),
    (False, 2.0, 0.25, 0.2, 1.0225, 0.9858),
    (False, 2.0, 0.25, 1.0, 1.1641, 0.9262),
    (False, 0.5, 0.3, 0.2, 0.9532, 1.0284),
    (False, 0.5, 0.3, 1.0, 0.8137, 1.1221),
]


@pytest.mark.parametrize("cells", [squares, rings])
@pytest.mark.parametrize(("rigid", "ratio", "nu", "thickness", "peak", "approach"), REFERENCE)
def test_a_sphere_on_a_film(cells, rigid, ratio, nu, thickness, peak, approach):
    found = sphere(cells, film(ratio, nu, thickness), rigid=rigid)
    assert found[:2] == pytest.approx([peak, approach], rel=3e-4)


@pytest.mark.parametrize("cells", [squares, rings])
@pytest.mark.parametrize(("ratio", "nu", "radius"), [(4.0, 0.2, 0.760), (0.25, 0.35, 1.303)])
def test_the_radius_of_a_contact_with_a_film(cells, ratio, nu, radius):
    """Cells tell it to a fraction of their width."""
    assert sphere(cells, film(ratio, nu, 0.5), rigid=True)[2] == pytest.approx(radius, rel=4e-3)


def geometries():
    edges = tuple((np.linspace(0.0, 1.0, 31) ** 1.3).tolist())
    yield Grid((12, 9), (0.05, 0.08))
    yield Rings(edges)
    yield Strips(edges, 10.0)
    yield Row((14, 1), (0.05, 1.0), (False, True), 10.0)


@pytest.mark.parametrize("cells", [*geometries()])
@pytest.mark.parametrize("way", ["normal", "along"])
def test_limits_of_a_film(cells, way):
    """Without thickness it is the substrate, of infinite thickness a half-space by itself."""

    def coupling(nu):
        return 1.0 if cells.plane_strain else (1.0 - 0.5 * nu) / (1.0 - nu)

    def moved(modulus, nu, body=None):
        half_space = cells.half_space(modulus / (1.0 - nu**2), body)
        if way == "along":
            half_space = half_space.along_x(coupling(nu), coupling(NU))
        pressure = np.zeros(cells.shape)
        pressure[1, 0] = 1.0
        displacement = half_space.displacement(pressure)
        same = way == "normal" or type(cells) is Grid
        return displacement * (1.0 if same else coupling(nu) / coupling(NU))

    bare, stiff = moved(YOUNG, NU), moved(3.0 * YOUNG, 0.2)
    for body, expected in (
        (film(3.0, 0.2, 1e-12), bare),
        (film(1.0, NU, 0.1), bare),
        (film(3.0, 0.2, 1e12), stiff),
    ):
        assert moved(YOUNG, NU, body) == pytest.approx(expected, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("thickness", [0.1, 0.5])
def test_partial_slip_on_a_film_is_that_of_a_dense_solution(ratio, thickness):
    """The default of a sphere; a bound on |q| alone, without slip across the force."""
    count = 24
    problem = fretting(
        count,
        load_ratio=0.7,
        bodies=ElasticBodies(*STEEL),
        coating=Coating(thickness * A, ratio * STEEL[0], 0.25),
        slip_model=Cerruti(),
        extent=(1.4 * A, 1.4 * A),
    )
    state = first_loading(problem)
    grid = state.geometry
    nx, ny = grid.shape
    weights = 1.0, 2.0 * problem.bodies.coupling - 1.0
    shape = 2 * nx + 1, 2 * ny + 1
    moved = replace(problem.film, way="along")
    kernel = influence_coefficients(shape, grid.spacing, problem.composite_modulus, weights, moved)
    touched = np.flatnonzero(state.pressure)
    matrix = with_images(kernel, *np.divmod(touched, ny))
    bound = problem.friction_law.coefficient * state.pressure.ravel()[touched]
    # What q leaves of its bound is the pressure of a contact, and the slip its gap.
    spare, slip, _ = normal_contact(matrix, -matrix @ bound, 1.0, 0.3 * bound.sum())
    traction = bound - spare
    assert traction.min() >= -bound.max()
    area = grid.unit_area
    found = problem.slip(state.reduced).ravel()[touched]
    assert found.max() == near(slip.max(), rel=1e-3)
    assert state.reduced.stick.sum() == (traction < bound).sum()
    energy = 4.0 * area * (bound * slip).sum()
    assert problem.dissipated_energy(state, grid) == near(energy, rel=1e-3)
