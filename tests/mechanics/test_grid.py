"""Grids: half-space against Love's formula, dense matrices and symmetries; growth of windows."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import dblquad

from fretwear import Case
from fretwear.mechanics import convolution
from fretwear.mechanics.geometry import Array, Even, Mask, Workspace
from fretwear.mechanics.geometry.grid import Grid, fast_shape, influence_coefficients
from fretwear.mechanics.integrator import evolve, first_loading
from fretwear.mechanics.loading import NormalLoad
from fretwear.mechanics.team import Team
from fretwear.running.simulate import wear_problem

from . import oracles
from .problems import EVEN, covered, folded, matrix_of, near, unfolded

MODULUS = 114e9
SPACING = (1.3e-6, 2.9e-6)

# Rounding of a transform of some thousand terms, relative to the largest value.
ROUNDING = 1e-13
SINGLE_ROUNDING = 1e-6


def noise(shape: tuple[int, int], seed: int = 0) -> Array:
    return np.random.default_rng(seed).standard_normal(shape)


def assert_equal_to_rounding(result: Array, expected: Array, rounding: float = ROUNDING) -> None:
    np.testing.assert_allclose(result, expected, rtol=0, atol=rounding * np.abs(expected).max())


def test_influence_coefficients_are_those_of_love():
    nx, ny = 60, 40
    x, y = np.arange(nx)[:, None] * SPACING[0], np.arange(ny)[None, :] * SPACING[1]
    # Second differences of corner terms that grow with the distance lose (r/h)² ≈ 10⁴ of 2e-16.
    np.testing.assert_allclose(
        influence_coefficients((nx, ny), SPACING, MODULUS),
        oracles.love(x, y, SPACING, MODULUS),
        rtol=1e-11,
    )


@pytest.mark.parametrize("offset", [(1, 0), (0, 1), (2, 3)])
def test_influence_coefficient_is_the_integral_of_the_point_force(offset: tuple[int, int]):
    x, y = offset[0] * SPACING[0], offset[1] * SPACING[1]
    half_x, half_y = SPACING[0] / 2, SPACING[1] / 2
    integral, _ = dblquad(
        lambda eta, xi: 1 / np.hypot(x - xi, y - eta), -half_x, half_x, -half_y, half_y, epsabs=0
    )
    coefficients = influence_coefficients((4, 4), SPACING, MODULUS)
    # The quadrature is asked for 1.5e-8.
    assert coefficients[offset] == near(integral / (np.pi * MODULUS), rel=1e-8)


@pytest.fixture(params=["as installed", "scipy"])
def _library(request, monkeypatch):
    if request.param == "scipy":
        monkeypatch.setattr(convolution, "ducc0", None)


@pytest.mark.usefixtures("_library")
@pytest.mark.parametrize("even", EVEN)
@pytest.mark.parametrize("shape", [(18, 12), (16, 10)])
def test_part_and_whole_half_space_agree(shape: tuple[int, int], even: Even):
    pressure = noise(folded(np.empty(shape), even).shape)
    whole = Grid(shape, SPACING, (False, False)).half_space(MODULUS)
    part = Grid(pressure.shape, SPACING, even).half_space(MODULUS)
    expected = folded(whole.displacement(unfolded(pressure, even)), even)
    assert_equal_to_rounding(part.displacement(pressure), expected)
    assert part.self_influence == near(whole.self_influence, rel=1e-14)


@pytest.mark.usefixtures("_library")
@pytest.mark.parametrize("shape", [(8, 10), (6, 14)])
def test_whole_half_space_is_the_dense_product(shape: tuple[int, int]):
    window = Grid(shape, SPACING, (False, False))
    pressure = noise(shape)
    expected = oracles.influence_matrix(window, MODULUS) @ pressure.ravel()
    result = window.half_space(MODULUS).displacement(pressure)
    assert_equal_to_rounding(result, expected.reshape(shape))


@pytest.mark.parametrize("even", EVEN)
def test_displacement_is_symmetric_and_positive(even: Even):
    window = Grid((14, 14), (1e-6, 1e-6), even)
    matrix = matrix_of(window.half_space(MODULUS).displacement, np.ones(window.shape, np.bool_))
    assert_equal_to_rounding(matrix, matrix.T)
    least = np.linalg.eigvalsh(matrix).min() * MODULUS / 1e-6
    # 0.58 is the infimum over all wavelengths, that of a checkerboard; a finite grid stays above.
    assert 0.58 < least < 0.60


@pytest.mark.usefixtures("_library")
@pytest.mark.parametrize("even", EVEN)
@pytest.mark.parametrize("shape", [(14, 10), (150, 96)])
def test_single_precision_is_good_to_some_parts_in_ten_million(even, shape):
    bodies = Grid(shape, SPACING, even).half_space(MODULUS)
    pressure = noise(shape)
    result = bodies.single(pressure.astype(np.float32))
    assert result.dtype == np.float32
    expected = bodies.displacement(pressure) / bodies.self_influence
    assert_equal_to_rounding(result, expected, SINGLE_ROUNDING)
    for scale in (1e-30, 0.0, 3.0, 1e40):
        result, unit = bodies.relative_displacement(scale * pressure)
        expected = bodies.displacement(scale * pressure)
        assert result.dtype == np.float32
        assert_equal_to_rounding(result * np.float64(unit), expected, SINGLE_ROUNDING)


def sized(half: tuple[int, int], even: Even) -> tuple[int, int]:
    """Cells along x and y of a window with so many on the positive side."""
    x, y = (n if one_side else 2 * n for n, one_side in zip(half, even, strict=True))
    return x, y


def corner(grid: Grid, reach: tuple[int, int]) -> Mask:
    """Cells within so many of the origin."""
    x, y = (n * d for n, d in zip(reach, SPACING, strict=True))
    return np.logical_and.outer(np.abs(grid.x) < x, np.abs(grid.y) < y)


@pytest.mark.parametrize("even", EVEN)
def test_part_is_the_half_space_of_a_smaller_window(even: Even):
    grid = Grid(sized((24, 20), even), SPACING, even)
    bodies = grid.half_space(MODULUS)
    part = bodies.around(corner(grid, (5, 2)))
    assert part.geometry.shape == sized((9, 6), even)
    fresh = part.geometry.half_space(MODULUS)
    pressure = noise(part.geometry.shape)
    np.testing.assert_array_equal(part.displacement(pressure), fresh.displacement(pressure))
    assert bodies.around(np.ones(grid.shape, np.bool_)) is bodies


@pytest.mark.parametrize("even", EVEN)
def test_threads_do_not_change_the_result(even: Even):
    # Large enough for each thread to have several blocks of rows.
    window = Grid((360, 250), SPACING, even)
    pressure = noise(window.shape)
    alone, *others = (window.half_space(MODULUS, Team(n)) for n in (1, 2, 3))
    for together in others:
        np.testing.assert_array_equal(alone.displacement(pressure), together.displacement(pressure))
        single = pressure.astype(np.float32)
        np.testing.assert_array_equal(alone.single(single), together.single(single))
        inverses = [each.single.inverse()(single.copy()) for each in (alone, together)]
        np.testing.assert_array_equal(*inverses)


@pytest.mark.parametrize("even", EVEN)
def test_window_is_centered_and_measures_its_area(even: Even):
    window = Grid((6, 8), SPACING, even)
    area = 4 * window.extent[0] * window.extent[1]
    assert window.integral(np.ones(window.shape)) == near(area, rel=1e-14)
    if even[0]:
        assert window.x[0] == SPACING[0] / 2
    else:
        np.testing.assert_allclose(window.x, -window.x[::-1], rtol=1e-14)
    assert window.x[-1] + SPACING[0] / 2 == near(window.extent[0], rel=1e-14)
    assert window.y[-1] + SPACING[1] / 2 == near(window.extent[1], rel=1e-14)


half_shapes = st.tuples(st.integers(1, 9), st.integers(1, 9))


@given(half_shapes, half_shapes, st.sampled_from(EVEN))
def test_resizing_keeps_every_common_cell_where_it_is(old, new, even):
    first = Grid(sized(old, even), SPACING, even)
    second = Grid(sized(new, even), SPACING, even)
    position = np.add.outer(first.x, 10 * first.y)
    moved = first.resized(position, second)
    common = covered(second, first)
    there = np.add.outer(second.x, 10 * second.y)
    np.testing.assert_allclose(moved[common], there[common], atol=1e-18)
    assert not moved[~common].any()
    inside = np.logical_and.outer(
        np.abs(second.x) < first.extent[0], np.abs(second.y) < first.extent[1]
    )
    np.testing.assert_array_equal(common, inside)


@given(st.floats(1e-6, 3e-4), st.floats(1e-6, 3e-4), st.sampled_from(EVEN))
def test_fast_shapes_cover_the_extent_asked_for(along_x, along_y, even):
    shape = fast_shape((along_x, along_y), SPACING, even)
    extent = Grid(shape, SPACING, even).extent
    assert extent[0] >= along_x * (1 - 1e-8)
    assert extent[1] >= along_y * (1 - 1e-8)
    for n, one_side in zip(shape, even, strict=True):
        half = n if one_side else n // 2
        for factor in (2, 3, 5, 7, 11):
            while half % factor == 0:
                half //= factor
        assert half == 1, f"{n} cells are slow to transform"


@given(half_shapes, st.sampled_from(EVEN))
def test_smallest_window_holds_its_cells_and_a_margin(reach, even):
    grid = Grid(sized((20, 24), even), SPACING, even)
    held = grid.around(corner(grid, reach))
    for axis in (0, 1):
        assert held.extent[axis] >= (min(reach[axis] + 4, 20) - 1e-6) * SPACING[axis]
        assert held.shape[axis] <= grid.shape[axis]


@pytest.fixture
def problem():
    case = Case(
        radius="10 mm",
        youngs_modulus="208 GPa",
        poisson_ratio=0.3,
        load="20 N",
        tangential_ratio=0.8,
        friction=0.6,
        wear_coefficient="7e-13 / Pa",
        roughness={"amplitude": "0.2 um", "slope_x": "3 deg", "slope_y": "1 deg"},
        cell=("1.5 um", "3 um"),
        cycles=1000,
    )
    return wear_problem(case, Grid)


def wider(window: Grid, factor: float) -> Grid:
    nx, ny = (int(factor * n) for n in window.shape)
    return Grid((nx, ny), window.spacing, window.even)


def test_nothing_penetrates_beyond_the_window_at_any_step(problem):
    for state in evolve(problem, [10, 100, 1000]):
        wide = state.on(Workspace(problem), wider(state.geometry, 1.6))
        assert wide.gap.min() >= -1e-5 * state.approach


def test_a_tip_beyond_the_window_is_noticed(problem):
    state = list(evolve(problem, [100]))[-1]
    window = state.geometry
    columns = np.flatnonzero(state.pressure.any(axis=1))
    # Cut the window in the valley before the outermost row of tips that touch.
    gaps = np.flatnonzero(np.diff(columns) > 1)
    cut = int(columns[gaps[-1]]) + 3
    small = Grid((cut, window.shape[1]), window.spacing, window.even)
    inner = window.resized(state.pressure, small)
    assert not inner[-2:].any()
    grown = small.holding(Workspace(problem), inner, state.approach)
    assert grown.shape[0] > columns[-1]


def test_tips_that_the_displacement_keeps_open_are_not_touched(problem):
    state = first_loading(problem)
    wide = wider(state.geometry, 1.6)
    outside = ~covered(wide, state.geometry)
    # Rigid bodies would touch there.
    assert (problem.unworn(wide)[outside] < state.approach).any()
    held = state.geometry.holding(Workspace(problem), state.pressure, state.approach)
    assert held is state.geometry


def test_a_small_load_on_the_tips_beside_a_valley_needs_no_wide_window(problem):
    # Of 0.2 um waves the first window would lie in the valley, and its approach reach far beyond.
    a = problem.spacing[0]
    small = replace(problem, normal=NormalLoad(1e-3), spacing=(a / 24, a / 24), extent=(4e-6, 4e-6))
    state = first_loading(small)
    assert not state.pressure[state.geometry.x < 2e-6].any()
    assert state.geometry.extent[0] < problem.wavelengths[0]
    assert state.geometry.integral(state.pressure) == near(1e-3)


def test_a_window_grows_before_the_contact_is_at_its_border(problem):
    state = first_loading(replace(problem, roughness=None))
    grid = state.geometry
    reach = np.flatnonzero(state.pressure.any(axis=1))[-1] + 1
    close, far = (np.zeros(grid.shape) for _ in range(2))
    close[: grid.shape[0] - 1, 0] = 1.0
    far[:reach, 0] = 1.0
    grown = grid.ahead_of(problem, replace(state, pressure=close))
    assert grown.shape[0] > grid.shape[0]
    assert grown.shape[1] == grid.shape[1]
    assert grid.ahead_of(problem, replace(state, pressure=far)) is grid


@pytest.mark.parametrize("even", EVEN)
def test_pressure_near_a_border_asks_for_growth_on_that_side_only(even: Even):
    window = Grid((10, 12), (1e-6, 1e-6), even)
    sides = {(9, 4): (True, False), (4, 11): (False, True), (9, 11): (True, True)}
    sides |= {} if even[0] else {(0, 5): (True, False)}
    sides |= {} if even[1] else {(5, 0): (False, True)}
    for cell, expected in sides.items():
        pressure = np.zeros(window.shape)
        pressure[5, 5] = pressure[cell] = 1.0
        assert window.touched(pressure) == expected
        grown = window.grown(expected)
        for axis in (0, 1):
            assert (grown.shape[axis] > window.shape[axis]) == expected[axis]
    assert window.touched(np.zeros(window.shape)) == (False, False)
