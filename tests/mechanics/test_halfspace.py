"""Elastic half-space against Love's formula, quadrature, dense matrices and its own symmetries."""

from weakref import ref

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import dblquad

from fretwear.mechanics.arrays import Array
from fretwear.mechanics.convolution import CosineConvolution, FourierConvolution
from fretwear.mechanics.halfspace import HalfSpace, half_space, influence_coefficients
from fretwear.mechanics.window import Window, fast_shape

from . import oracles
from .problems import folded, matrix_of, near, unfolded

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


def test_influence_of_a_square_cell_on_itself():
    coefficients = influence_coefficients((1, 1), (1e-6, 1e-6), MODULUS)
    assert coefficients[0, 0] == near(4 * np.arcsinh(1) / np.pi * 1e-6 / MODULUS, rel=1e-14)
    # The number of the literature, to its digits.
    assert coefficients[0, 0] == near(1.1222 * 1e-6 / MODULUS, rel=1e-4)


def test_far_cells_act_like_point_forces():
    coefficients = influence_coefficients((101, 101), SPACING, MODULUS)
    for i, j in ((100, 0), (0, 100), (70, 70)):
        distance = np.hypot(i * SPACING[0], j * SPACING[1])
        point = SPACING[0] * SPACING[1] / (np.pi * MODULUS * distance)
        # The next term of the multipole series is at most (h/r)²/12.
        bound = max(SPACING) ** 2 / (12 * distance**2)
        assert coefficients[i, j] == near(point, rel=bound)


@pytest.mark.parametrize("shape", [(9, 12), (16, 5)])
def test_quarter_and_whole_half_space_agree(shape: tuple[int, int]):
    pressure = noise(shape)
    whole = half_space(Window((2 * shape[0], 2 * shape[1]), SPACING, False), MODULUS)
    quarter = half_space(Window(shape, SPACING), MODULUS)
    expected = folded(whole.displacement(unfolded(pressure)))
    assert_equal_to_rounding(quarter.displacement(pressure), expected)
    assert quarter.self_influence == near(whole.self_influence, rel=1e-14)


@pytest.mark.parametrize("shape", [(8, 11), (7, 6)])
def test_whole_half_space_is_the_dense_product(shape: tuple[int, int]):
    window = Window(shape, SPACING, quarter=False)
    pressure = noise(shape)
    expected = oracles.influence_matrix(window, MODULUS) @ pressure.ravel()
    result = half_space(window, MODULUS).displacement(pressure)
    assert_equal_to_rounding(result, expected.reshape(shape))


def test_uniform_pressure_on_many_cells_is_love_of_the_large_rectangle():
    shape = (30, 20)
    window = Window(shape, SPACING)
    bodies = half_space(window, MODULUS)
    size = (2 * shape[0] * SPACING[0], 2 * shape[1] * SPACING[1])
    x, y = np.meshgrid(window.x, window.y, indexing="ij")
    result = bodies.displacement(np.ones(shape))
    # Inside the rectangle too: its formula holds at every point of the surface.
    k, l = size[0] / 2 + x, x - size[0] / 2  # noqa: E741
    m, n = size[1] / 2 + y, y - size[1] / 2

    def corner(u: Array, v: Array) -> Array:
        return u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v))

    expected = corner(k, m) - corner(l, m) - corner(k, n) + corner(l, n)
    np.testing.assert_allclose(result, expected / (np.pi * MODULUS), rtol=1e-12)


@pytest.mark.parametrize("quarter", [True, False])
def test_displacement_is_symmetric_and_positive(quarter: bool):
    window = Window((14, 14), (1e-6, 1e-6), quarter)
    matrix = matrix_of(half_space(window, MODULUS).displacement, np.ones(window.shape, np.bool_))
    assert_equal_to_rounding(matrix, matrix.T)
    least = np.linalg.eigvalsh(matrix).min() * MODULUS / 1e-6
    # 0.58 is the infimum over all wavelengths, that of a checkerboard; a finite grid stays above.
    assert 0.58 < least < 0.60


@pytest.mark.parametrize("quarter", [True, False])
@pytest.mark.parametrize("shape", [(14, 10), (150, 96)])
def test_single_precision_is_good_to_some_parts_in_ten_million(quarter, shape):
    bodies = half_space(Window(shape, SPACING, quarter), MODULUS)
    pressure = noise(shape)
    result = bodies.single(pressure.astype(np.float32))
    assert result.dtype == np.float32
    expected = bodies.displacement(pressure) / bodies.self_influence
    assert_equal_to_rounding(result, expected, SINGLE_ROUNDING)
    for scale in (1e-30, 0.0, 3.0, 1e40):
        result = bodies.displacement_in_single(scale * pressure)
        expected = bodies.displacement(scale * pressure)
        assert result.dtype == np.float64
        assert_equal_to_rounding(result, expected, SINGLE_ROUNDING)


@pytest.mark.parametrize("quarter", [True, False])
@pytest.mark.parametrize("added", [0.0, 3.0])
@pytest.mark.parametrize(("precision", "rounding"), [(np.float64, 1e-12), (np.float32, 1e-6)])
def test_approximate_inverse_is_symmetric_positive_and_close(quarter, added, precision, rounding):
    shape = (14, 10)
    kind = CosineConvolution if quarter else FourierConvolution
    kernel = influence_coefficients(kind.offsets(shape), SPACING, MODULUS)
    convolve = kind.with_kernel(kernel / kernel[0, 0], 1)
    everywhere = np.ones(shape, np.bool_)
    invert = convolve.inverse if precision is np.float64 else convolve.in_single(1.0).inverse
    inverse = matrix_of(invert(added), everywhere, precision)
    assert_equal_to_rounding(inverse, inverse.T, rounding)
    assert np.linalg.eigvalsh(inverse).min() > 0
    direct = matrix_of(convolve, everywhere) + added * np.eye(inverse.shape[0])
    plain, preconditioned = (np.linalg.eigvals(m).real for m in (direct, inverse @ direct))
    spread = preconditioned.max() / preconditioned.min()
    # Conjugate gradients need √spread steps: without a bound here they would still converge.
    assert spread < 8
    assert spread < plain.max() / plain.min()


@pytest.mark.parametrize("quarter", [True, False])
def test_part_is_the_half_space_of_a_smaller_window(quarter: bool):
    bodies = half_space(Window((24, 20), SPACING, quarter), MODULUS)
    part = bodies.part((12, 10))
    fresh = HalfSpace(Window((12, 10), SPACING, quarter), MODULUS)
    assert part.window == fresh.window
    pressure = noise((12, 10))
    np.testing.assert_array_equal(part.displacement(pressure), fresh.displacement(pressure))
    assert bodies.part((24, 20)) is bodies


def test_a_few_parts_are_kept():
    bodies = half_space(Window((24, 20), SPACING), MODULUS)
    parts = [ref(bodies.part((size, 8))) for size in (8, 9, 10, 12)]
    assert bodies.part((8, 8)) is parts[0]()
    # Of a fifth, the one longest out of use makes room.
    bodies.part((15, 8))
    assert [part() is None for part in parts] == [False, True, False, False]


def test_the_latest_parts_outlive_their_window():
    small, large = (half_space(Window(shape, SPACING), MODULUS) for shape in ((24, 20), (30, 24)))
    parts = [ref(small.part((size, 8))) for size in (8, 9, 10, 12)]
    large.take_parts(small)
    del small
    assert [part() is None for part in parts] == [True, True, False, False]
    assert large.part((12, 8)) is parts[-1]()


def test_a_half_space_in_use_is_not_made_again():
    cells = Window((12, 10), SPACING, True)
    bodies = half_space(cells, MODULUS)
    assert half_space(Window((12, 10), SPACING, True), MODULUS) is bodies
    assert half_space(cells, 2 * MODULUS) is not bodies
    assert half_space(cells, MODULUS, workers=2) is not bodies


@pytest.mark.parametrize("quarter", [True, False])
@pytest.mark.parametrize("precision", [np.float64, np.float32])
def test_fields_given_are_left_as_they_are(quarter: bool, precision):
    bodies = half_space(Window((12, 10), SPACING, quarter), MODULUS)
    convolve = bodies.displacement if precision is np.float64 else bodies.single
    field = noise((12, 10)).astype(precision)
    kept = field.copy()
    result = convolve(field)
    np.testing.assert_array_equal(field, kept)
    assert not np.shares_memory(result, field)
    first = result.copy()
    convolve(field + precision(1.0))
    np.testing.assert_array_equal(result, first)


def test_threads_do_not_change_the_result():
    window = Window((48, 36), SPACING)
    pressure = noise(window.shape)
    alone, together = (half_space(window, MODULUS, workers=n) for n in (1, 2))
    np.testing.assert_array_equal(alone.displacement(pressure), together.displacement(pressure))


@pytest.mark.parametrize("quarter", [True, False])
def test_window_is_centered_and_measures_its_area(quarter: bool):
    window = Window((6, 8), SPACING, quarter)
    area = 4 * window.extent[0] * window.extent[1]
    assert window.integral(np.ones(window.shape)) == near(area, rel=1e-14)
    if quarter:
        assert window.x[0] == SPACING[0] / 2
    else:
        np.testing.assert_allclose(window.x, -window.x[::-1], rtol=1e-14)
    assert window.x[-1] + SPACING[0] / 2 == near(window.extent[0], rel=1e-14)
    assert window.y[-1] + SPACING[1] / 2 == near(window.extent[1], rel=1e-14)


half_shapes = st.tuples(st.integers(1, 9), st.integers(1, 9))


@given(half_shapes, half_shapes, st.booleans())
def test_resizing_keeps_every_common_cell_where_it_is(old, new, quarter):
    factor = 1 if quarter else 2
    first = Window((factor * old[0], factor * old[1]), SPACING, quarter)
    second = Window((factor * new[0], factor * new[1]), SPACING, quarter)
    position = np.add.outer(first.x, 10 * first.y)
    moved = first.resized(position, second.shape)
    covered = first.covered(second.shape)
    there = np.add.outer(second.x, 10 * second.y)
    np.testing.assert_allclose(moved[covered], there[covered], atol=1e-18)
    assert not moved[~covered].any()
    inside = np.logical_and.outer(
        np.abs(second.x) < first.extent[0], np.abs(second.y) < first.extent[1]
    )
    np.testing.assert_array_equal(covered, inside)


@given(st.floats(1e-6, 3e-4), st.floats(1e-6, 3e-4), st.booleans())
def test_fast_shapes_cover_the_extent_asked_for(along_x, along_y, quarter):
    shape = fast_shape((along_x, along_y), SPACING, quarter=quarter)
    extent = Window(shape, SPACING, quarter).extent
    assert extent[0] >= along_x * (1 - 1e-8)
    assert extent[1] >= along_y * (1 - 1e-8)
    for n in shape:
        half = n if quarter else n // 2
        for factor in (2, 3, 5, 7, 11):
            while half % factor == 0:
                half //= factor
        assert half == 1, f"{n} cells are slow to transform"


@given(half_shapes, st.integers(0, 3), st.booleans())
def test_smallest_window_holds_its_cells_and_the_margin(reach, margin, quarter):
    window = Window((20, 24) if quarter else (40, 48), SPACING, quarter)
    inside = np.logical_and.outer(
        np.abs(window.x) < reach[0] * SPACING[0], np.abs(window.y) < reach[1] * SPACING[1]
    )
    held = Window(window.holding(inside, margin), SPACING, quarter)
    assert held.extent[0] >= (min(reach[0] + margin, 20) - 1e-6) * SPACING[0]
    assert held.extent[1] >= (min(reach[1] + margin, 24) - 1e-6) * SPACING[1]
    assert held.shape[0] <= window.shape[0]
    assert held.shape[1] <= window.shape[1]
