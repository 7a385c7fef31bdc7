"""Contact by other ways than the library's: its own Love formula, dense matrices, a full FFT."""

import numpy as np
from scipy.optimize import brentq, lsq_linear

from fretwear.mechanics.geometry import Array
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.state import State, WearProblem

from .problems import unfolded


def love(x: Array, y: Array, spacing: tuple[float, float], modulus: float) -> Array:
    """Displacement, m/Pa, at a distance (x, y), m, from the center of a loaded rectangle.

    Love (1929), in its form with logarithms; it is even in x and y, and taken where both are
    positive no logarithm cancels.
    """
    x, y = np.abs(x), np.abs(y)
    k, l = x + spacing[0] / 2, x - spacing[0] / 2  # noqa: E741 - the letters of the formula
    m, n = y + spacing[1] / 2, y - spacing[1] / 2
    total = (
        k * np.log((m + np.hypot(k, m)) / (n + np.hypot(k, n)))
        + l * np.log((n + np.hypot(l, n)) / (m + np.hypot(l, m)))
        + m * np.log((k + np.hypot(k, m)) / (l + np.hypot(l, m)))
        + n * np.log((l + np.hypot(l, n)) / (k + np.hypot(k, n)))
    )
    return total / (np.pi * modulus)


def influence_matrix(window: Grid, modulus: float) -> Array:
    """Displacement of each cell of a whole window under unit pressure on each, m/Pa."""
    x, y = (c.ravel() for c in np.meshgrid(window.x, window.y, indexing="ij"))
    return love(x[:, None] - x, y[:, None] - y, window.spacing, modulus)


def displacement(pressure: Array, spacing: tuple[float, float], modulus: float) -> Array:
    """Displacement, m, under a pressure, Pa, on a whole window, by a zero-padded FFT."""
    nx, ny = pressure.shape
    x = np.fft.ifftshift(np.arange(-nx, nx)) * spacing[0]
    y = np.fft.ifftshift(np.arange(-ny, ny)) * spacing[1]
    kernel = love(x[:, None], y[None, :], spacing, modulus)
    spectrum = np.fft.rfft2(kernel) * np.fft.rfft2(pressure, s=kernel.shape)
    return np.fft.irfft2(spectrum, s=kernel.shape)[:nx, :ny]


def dense_contact(
    matrix: Array, shape: Array, total: float, limit: float = np.inf
) -> tuple[Array, float]:
    """Pressure, Pa, and approach, m, for 0 ≤ p ≤ p_lim and ∑p = total.

    At a given approach the contact is a bounded least-squares problem, which BVLS (Stark and
    Parker, 1995) solves by exchanging single cells; the load grows with the approach.
    """
    scale = matrix[0, 0]
    factor = np.linalg.cholesky(matrix / scale).T
    unit = total / shape.size
    bounds = (0.0, limit / unit if np.isfinite(limit) else np.inf)

    def pressure(approach: float) -> Array:
        right = np.linalg.solve(factor.T, (approach - shape.ravel()) / (scale * unit))
        found = lsq_linear(factor, right, bounds, method="bvls", tol=1e-14, max_iter=10_000)
        return found.x

    def excess(approach: float) -> float:
        return float(pressure(approach).sum()) / shape.size - 1.0

    low, high = float(shape.min()), float(shape.max())
    while excess(high) < 0:
        low, high = high, high + (high - low)
    approach = brentq(excess, low, high, xtol=1e-18, rtol=1e-14)
    return pressure(approach).reshape(shape.shape) * unit, float(approach)


def worst_violation(problem: WearProblem, state: State) -> float:
    """How far a state is from the conditions of contact, by its pressure and its shape alone.

    The largest error of the load, gap under pressure, overlap of the bodies and difference of the
    state's own gap from that of its shape; relative to the load and to the approach.
    """
    shape = problem.unworn(state.geometry) + state.wear + state.plastic
    fields = (state.pressure, shape, state.gap)
    pressure, shape, reported = (unfolded(field, state.geometry.even) for field in fields)
    spacing = state.geometry.spacing
    gap = displacement(pressure, spacing, problem.bodies.composite_modulus) + shape - state.approach
    load = float(pressure.sum()) * spacing[0] * spacing[1]
    lengths = np.abs(gap[pressure > 0]).max(), -gap.min(), np.abs(reported - gap).max()
    return max(abs(load / problem.hertz.load - 1.0), float(max(lengths)) / state.approach)
