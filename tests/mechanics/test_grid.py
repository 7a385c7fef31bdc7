"""Grids: convolutions, Love's formula, dense matrices and symmetries; growth of windows."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.fft
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import dblquad

from fretwear.mechanics.contact import convolution, kernels
from fretwear.mechanics.contact.grid import Grid, fast_shape, influence_coefficients
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.wear.integrator import evolve, first_loading
from fretwear.mechanics.wear.state import Workspace
from fretwear.mechanics.wear.window import holding_cells, next_cells
from fretwear.run.states import wear_problem

from ..studies import WAVES, near, steel
from . import oracles
from .problems import EVEN, covered, folded, unfolded

MODULUS = 114e9
SPACING = (1.3e-6, 2.9e-6)

# Rounding of a transform of some thousand terms, relative to the largest value.
ROUNDING = 1e-13
SINGLE_ROUNDING = 1e-6


def assert_equal_to_rounding(result, expected, rounding=ROUNDING):
    np.testing.assert_allclose(result, expected, rtol=0, atol=rounding * np.abs(expected).max())


def test_influence_coefficients_are_those_of_love_and_integrals_of_the_point_force():
    found = influence_coefficients((60, 40), SPACING, MODULUS)
    x, y = np.arange(60)[:, None] * SPACING[0], np.arange(40) * SPACING[1]
    # Second differences of corner terms that grow with the distance lose (r/h)² ≈ 10⁴ of 2e-16.
    np.testing.assert_allclose(found, oracles.love(x, y, SPACING, MODULUS), rtol=1e-11)
    half_x, half_y = SPACING[0] / 2, SPACING[1] / 2
    for i, j in ((1, 0), (0, 1), (2, 3)):

        def force(eta, xi, i=i, j=j):
            return 1 / np.hypot(x[i, 0] - xi, y[j] - eta) / (np.pi * MODULUS)

        # The quadrature is asked for 1.5e-8.
        integral, _ = dblquad(force, -half_x, half_x, -half_y, half_y, epsabs=0)
        assert found[i, j] == near(integral, rel=1e-8)


@pytest.mark.parametrize("even", EVEN[:2])
def test_displacement_is_symmetric_and_positive(even):
    window = Grid((16, 16), (1e-6, 1e-6), even)
    displacement, units = window.half_space(MODULUS).displacement, np.eye(256).reshape(256, 16, 16)
    matrix = np.stack([displacement(unit).ravel() for unit in units], axis=1)
    assert_equal_to_rounding(matrix, matrix.T)
    least = np.linalg.eigvalsh(matrix).min() * MODULUS / 1e-6
    # 0.58 is the infimum over all wavelengths, of a checkerboard; a finite grid stays above.
    assert 0.58 < least < 0.60


@pytest.mark.parametrize("even", EVEN)
def test_displacement_is_the_dense_product_and_nearly_so_in_single_precision_and_any_unit(even):
    whole = Grid((16, 10), SPACING, (False, False))
    pressure = np.random.default_rng(0).standard_normal(folded(np.empty(whole.shape), even).shape)
    bodies = Grid(pressure.shape, SPACING, even).half_space(MODULUS)
    dense = oracles.influence_matrix(whole, MODULUS) @ unfolded(pressure, even).ravel()
    expected = folded(dense.reshape(whole.shape), even)
    assert_equal_to_rounding(bodies.displacement(pressure), expected)
    for scale in (1e-30, 0.0, 3.0, 1e40):
        result, unit = bodies.relative_displacement(scale * pressure)
        assert result.dtype == np.float32
        assert_equal_to_rounding(result * np.float64(unit), scale * expected, SINGLE_ROUNDING)


@pytest.fixture
def problem():
    waves = {**WAVES, "slope_x": "3 deg"}
    return wear_problem(
        steel(load="20 N", friction=0.6, roughness=waves, cell=("1.5 um", "3 um")), Grid
    )


def wider(window, factor):
    nx, ny = (int(factor * n) for n in window.shape)
    return Grid((nx, ny), window.spacing, window.even)


@pytest.mark.slow
def test_a_window_holds_tips_beyond_it_and_none_that_stay_open(problem):
    state = list(evolve(problem, [100]))[-1]
    window = state.geometry
    columns = np.flatnonzero(state.pressure.any(axis=1))
    # Cut the window in the valley before the outermost row of tips that touch.
    gaps = np.flatnonzero(np.diff(columns) > 1)
    cut = int(columns[gaps[-1]]) + 3
    small = Grid((cut, window.shape[1]), window.spacing, window.even)
    inner = window.resized(state.pressure, small)
    assert not inner[-2:].any()
    grown = holding_cells(small, Workspace(problem), inner, state.approach)
    assert grown.shape[0] > columns[-1]
    state = first_loading(problem)
    wide = wider(state.geometry, 1.6)
    outside = ~covered(wide, state.geometry)
    # Rigid bodies would touch there.
    assert (problem.unworn(wide)[outside] < state.approach).any()
    held = holding_cells(state.geometry, Workspace(problem), state.pressure, state.approach)
    assert held is state.geometry
    for state in evolve(problem, [10, 100, 1000]):
        wide = state.on(Workspace(problem), wider(state.geometry, 1.6))
        assert wide.gap.min() >= -1e-5 * state.approach


def test_the_window_of_a_few_tips_is_small_and_grows_before_the_contact_is_at_its_border(problem):
    # The first window would lie in the valley of 0.2 um waves, its approach reach far beyond.
    a = problem.spacing[0]
    small = replace(problem, normal=NormalLoad(1e-3), spacing=(a / 24, a / 24), extent=(4e-6, 4e-6))
    state = first_loading(small)
    assert not state.pressure[state.geometry.x < 2e-6].any()
    assert state.geometry.extent[0] < problem.wavelengths[0]
    assert state.geometry.integral(state.pressure) == near(1e-3)
    state = first_loading(replace(problem, roughness=None))
    grid = state.geometry
    reach = np.flatnonzero(state.pressure.any(axis=1))[-1] + 1
    close, far = (np.zeros(grid.shape) for _ in range(2))
    close[: grid.shape[0] - 1, 0] = 1.0
    far[:reach, 0] = 1.0
    grown = next_cells(grid, problem, replace(state, pressure=close))
    assert grown.shape[0] > grid.shape[0]
    assert grown.shape[1] == grid.shape[1]
    assert next_cells(grid, problem, replace(state, pressure=far)) is grid


@given(st.floats(1e-6, 3e-4), st.floats(1e-6, 3e-4), st.sampled_from(EVEN))
def test_fast_shapes_cover_the_extent_and_have_no_factor_beyond_five(along_x, along_y, even):
    shape = fast_shape((along_x, along_y), SPACING, even)
    extent = Grid(shape, SPACING, even).extent
    assert min(extent[0] / along_x, extent[1] / along_y) >= 1 - 1e-8
    for n, one_side in zip(shape, even, strict=True):
        assert 30**64 % (n if one_side else n // 2) == 0, f"{n} cells are slow to transform"


@pytest.mark.parametrize("even", EVEN)
def test_pressure_near_a_border_asks_for_growth_on_that_side_only(even):
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


@pytest.mark.parametrize("library", ["ducc0", "scipy"])
@pytest.mark.parametrize("even", EVEN)
@pytest.mark.parametrize("shape", [(4, 6), (54, 40), (120, 40)], ids=str)
def test_a_convolution_is_that_of_fourier_transforms(shape, even, library, monkeypatch):
    if library == "scipy":
        monkeypatch.setattr(kernels, "ducc0", None)
        monkeypatch.setattr(kernels, "scipy", scipy, raising=False)
    elif kernels.ducc0 is None:
        pytest.skip("ducc0 is not installed")
    # Several blocks of rows and of columns.
    monkeypatch.setattr(convolution, "_BLOCK_BYTES", 4000)
    random = np.random.default_rng(3)
    kernel = random.random((shape[0] + 1, shape[1] + 1))
    kernel[0, 0] = 0.3 * kernel.size
    field = random.standard_normal(folded(np.empty(shape), even).shape)
    whole = unfolded(field, even)
    ours = convolution.convolution(kernel.copy(), even)
    periodic = np.pad(kernel, [(0, n - 1) for n in shape], "reflect")
    spectrum = np.fft.fft2(periodic).real
    far = np.fft.ifft2(spectrum * np.fft.fft2(whole, spectrum.shape)).real[: shape[0], : shape[1]]
    near = np.fft.ifft2(np.fft.fft2(whole) / (0.5 * spectrum[::2, ::2] + 7.0)).real
    single, rounded = ours.in_single(2.0), field.astype(np.float32)
    found = ours(field), single(rounded), single.inverse(7.0)(+rounded)
    for one, exact, rtol in zip(found, (far, far / 2, near), (1e-14, 2e-6, 2e-6), strict=True):
        assert one.dtype == (field if rtol < 1e-7 else rounded).dtype
        np.testing.assert_allclose(one, folded(exact, even), atol=rtol * np.abs(exact).max())
