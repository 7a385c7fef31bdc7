"""Friction in two directions, against CONTACT, dense projected gradients, and closed forms."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import dblquad

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactError, ContactProblem, solve_contact
from fretwear.mechanics.slip.coupled import shear
from fretwear.mechanics.slip.shear import shear_influence, shear_space
from fretwear.theory import HertzContact

from ..studies import near
from .oracles import vector_friction

MODULUS, COUPLING, FRICTION = 2.0, 1.3, 0.3


def whole_matrix(grid, modulus=MODULUS, coupling=COUPLING):
    """Influence of all cells of a window that is not even, shape (2n, 2n)."""
    x, y = (each.ravel() for each in np.meshgrid(grid.x, grid.y, indexing="ij"))
    i, j = (
        np.round((each[:, None] - each) / size).astype(int)
        for each, size in zip((x, y), grid.spacing, strict=True)
    )
    fields = shear_influence(grid.shape, grid.spacing, modulus, coupling)
    along, across, cross = (field[abs(i), abs(j)] for field in fields)
    cross = cross * np.sign(i) * np.sign(j)
    return np.block([[along, cross], [cross, across]])


def unfolded(traction, even):
    first, second = traction
    for axis in np.flatnonzero(even):
        first = np.concatenate([np.flip(first, axis), first], axis)
        second = np.concatenate([-np.flip(second, axis), second], axis)
    return np.stack([first, second])


def test_influence_is_the_integral_of_the_kernels_of_cerruti():
    spacing, cell = (0.1, 0.15), (3, 2)
    place = cell[0] * spacing[0], cell[1] * spacing[1]
    mixing = 2 * (COUPLING - 1)
    kernels = (
        lambda x, _, r: 1 / r + mixing * x**2 / r**3,
        lambda _, y, r: 1 / r + mixing * y**2 / r**3,
        lambda x, y, r: mixing * x * y / r**3,
    )
    fields = shear_influence((4, 4), spacing, MODULUS, COUPLING)
    for kernel, field in zip(kernels, fields, strict=True):
        integral, _ = dblquad(
            lambda y, x, kernel=kernel: kernel(x, y, np.hypot(x, y)),
            *(place[0] - spacing[0] / 2, place[0] + spacing[0] / 2),
            *(place[1] - spacing[1] / 2, place[1] + spacing[1] / 2),
        )
        assert field[cell] == near(integral / (np.pi * MODULUS), rel=1e-9)


@pytest.mark.parametrize("even", [(True, True), (True, False), (False, False)])
def test_transforms_give_the_sum_over_all_cells(even):
    whole = Grid((12, 8), (0.1, 0.15), (False, False))
    shape = tuple(n // 2 if each else n for n, each in zip(whole.shape, even, strict=True))
    bodies = shear_space(Grid(shape, whole.spacing, even), MODULUS, COUPLING)
    traction = np.random.default_rng(1).standard_normal((2, *shape))
    expected = (whole_matrix(whole) @ unfolded(traction, even).ravel()).reshape(2, *whole.shape)
    part = tuple(slice(-n, None) for n in shape)
    error = bodies.displacement(traction) - expected[:, *part]
    assert np.abs(error).max() <= 1e-14 * np.abs(expected).max()
    relative = bodies.single.displacement(traction.astype(np.float32)) * bodies.self_influence
    assert np.abs(relative - expected[:, *part]).max() <= 1e-6 * np.abs(expected).max()
    # The approximate inverse must be symmetric and positive definite.
    units = np.eye(traction.size).reshape(-1, *traction.shape)
    matrix = [bodies.inverse(unit).ravel() for unit in units]
    assert np.abs(np.array(matrix) - np.array(matrix).T).max() <= 1e-14 * np.abs(matrix).max()
    assert np.linalg.eigvalsh(matrix).min() > 0


def test_contact_of_kalker_and_vollebregt():
    """Example cattaneo of CONTACT: sets of cells, shift, work, and every cell."""
    table = np.genfromtxt(
        Path(__file__).with_name("contact_cattaneo.csv"), delimiter=",", names=True, skip_header=2
    )
    modulus, poisson, friction, load, size = 200.0, 0.42, 0.4, 9.1954, 0.13333
    composite, coupling = modulus / (1 - poisson), (2 - poisson) / (2 * (1 - poisson))
    grid = Grid((20, 20), (size, size), (False, False))
    place = (np.arange(20) - 9) * size
    shape = (place[:, None] ** 2 + place**2) / 100.0
    contact = solve_contact(ContactProblem(grid.half_space(composite), shape, load), tolerance=1e-9)
    bound = friction * contact.pressure
    result = shear(
        shear_space(grid, composite, coupling), bound, 0.875 * friction * load, tolerance=1e-8
    )
    assert (bound > 0).sum() == 177
    assert result.stick.sum() == 45
    assert contact.approach == near(1.99809e-2, rel=1e-4)
    assert result.displacement == pytest.approx(8.15489e-3, abs=1e-6)
    work = float((bound * result.amplitude).sum()) * grid.unit_area
    assert work == near(2.7496e-3, rel=1e-4)
    cells = (*(table[name].astype(int) + 9 for name in ("cell_x", "cell_y")),)
    traction = result.traction[:, *cells]
    assert np.abs(np.hypot(*traction) - table["traction_MPa"]).max() <= 0.005
    # Its traction acts on the other body; angles are printed to 0.1°, cells to five digits.
    angles = np.degrees(np.arctan2(*-traction[::-1])) % 360 - table["angle_deg"] % 360
    assert np.abs((angles + 180) % 360 - 180).max() <= 0.051
    assert np.abs(result.amplitude[cells] - table["slip_mm"]).max() <= 1e-5


def test_projected_gradients_lead_to_the_same_tractions():
    coupling, grid = (2 - 0.45) / (2 * (1 - 0.45)), Grid((22, 22), (0.1, 0.1), (False, False))
    pressure = HertzContact(1.0, 4 / 3, 1.0).pressure(np.hypot(grid.x[:, None], grid.y))
    bound = FRICTION * pressure
    matrix = whole_matrix(grid, 1.0, coupling)
    slip, traction = vector_friction(matrix, bound.ravel(), 0.8 * bound.sum())
    result = shear(
        shear_space(grid, 1.0, coupling), bound, 0.8 * grid.integral(bound), tolerance=1e-8
    )
    assert np.abs(result.traction.ravel() - traction).max() <= 1e-6 * bound.max()
    touches = pressure > 0
    assert np.abs(result.amplitude.ravel() - slip)[touches.ravel()].max() <= 1e-5 * slip.max()


def rough_contact(even, coupling):
    grid = Grid(tuple(20 if each else 40 for each in even), (0.06, 0.06), even)
    x, y = grid.x[:, None], grid.y
    shape = (x**2 + y**2) / 2 + 0.05 * np.cos(8 * x) * np.cos(6 * y)
    if not all(even):
        shape = shape + 0.05 * np.sin(7 * x * (not even[0])) + 0.05 * np.sin(5 * y * (not even[1]))
    half_space = grid.half_space(1.0)

    def under(load):
        return solve_contact(ContactProblem(half_space, shape, load), tolerance=1e-9)

    return grid, under, shear_space(grid, 1.0, coupling)


@pytest.mark.parametrize(("even", "ratio"), [((True, True), 0.2), ((False, True), 0.9)])
def test_coulombs_law_holds_in_every_cell_and_the_loop_has_its_work(even, ratio):
    grid, under, bodies = rough_contact(even, 1.4)
    bound = FRICTION * under(1.0).pressure
    result = shear(bodies, bound, ratio * FRICTION, tolerance=1e-8)
    size, largest = np.hypot(*result.traction), bound.max()
    assert result.force == near(ratio * FRICTION, rel=1e-12)
    assert np.all(size <= bound + 1e-12 * largest)
    slips = (bound > 0) & ~result.stick
    assert np.allclose(size[slips], bound[slips], rtol=1e-9)
    assert result.stick.any()
    assert slips.any()
    clear = slips & (result.amplitude > 0.01 * result.amplitude[slips].max())
    (q_x, q_y), (s_x, s_y) = result.traction[:, clear], result.slip[:, clear]
    turned = (q_x * s_y - q_y * s_x) / (size * result.amplitude)[clear]
    assert np.abs(turned).max() <= 1e-5
    assert np.all((result.traction * result.slip).sum(axis=0)[clear] > 0)
    # Masing's loop of a traction that is a minimum: 4 (Q δ − 2 E)
    work = 4 * grid.integral(bound * result.amplitude)
    loop = 4 * (result.force * result.displacement - 2 * result.energy)
    assert loop == near(work, rel=1e-6)


def test_without_poissons_ratio_it_is_the_contact_at_the_reduced_load():
    ratio = 0.9
    _, under, bodies = rough_contact((False, True), 1.0)
    full, reduced = under(1.0), under(1.0 - ratio)
    result = shear(bodies, FRICTION * full.pressure, ratio * FRICTION, tolerance=1e-8)
    expected = FRICTION * (full.pressure - reduced.pressure)
    assert np.abs(result.traction - [expected, 0 * expected]).max() <= 1e-6 * expected.max()
    slip = FRICTION * (reduced.gap - full.gap)
    assert np.abs(result.amplitude - slip).max() <= 1e-6 * slip.max()
    displacement = FRICTION * (full.approach - reduced.approach)
    assert result.displacement == near(displacement, rel=1e-6)


def test_a_displacement_through_a_rig_leads_to_the_force_that_it_has():
    _, under, bodies = rough_contact((True, True), 1.4)
    bound = FRICTION * under(1.0).pressure
    forced = shear(bodies, bound, 0.7 * FRICTION, tolerance=1e-8)
    for flexibility in (0.0, 0.5):
        moved = forced.displacement + flexibility * forced.force
        result = shear(bodies, bound, displacement=moved, flexibility=flexibility, tolerance=1e-8)
        assert result.force == near(forced.force, rel=1e-7)
        assert np.abs(result.traction - forced.traction).max() <= 1e-6 * bound.max()


def test_a_displacement_may_slide_the_contact_as_a_whole_but_a_force_may_not():
    _, under, bodies = rough_contact((False, False), 1.4)
    bound = FRICTION * under(1.0).pressure
    result = shear(bodies, bound, displacement=10.0)
    assert not result.stick.any()
    assert 0.999 * FRICTION < result.force <= FRICTION * (1 + 1e-12)
    with pytest.raises(ContactError, match="slides the contact as a whole"):
        shear(bodies, bound, 1.01 * FRICTION)
