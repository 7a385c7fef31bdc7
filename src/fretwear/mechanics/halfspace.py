"""The elastic half-space: surface displacement under a pressure given on a window of cells.

The pressure is piecewise constant on rectangular cells. Its displacement is a discrete
convolution with the influence coefficients of Love (1929).
"""

from __future__ import annotations

from functools import cached_property
from weakref import WeakValueDictionary

import numpy as np

from fretwear.mechanics import passes
from fretwear.mechanics.arrays import Array, Single
from fretwear.mechanics.convolution import Convolution, CosineConvolution, FourierConvolution
from fretwear.mechanics.window import Window

# How many parts are kept of one window, and of the one before it.
_PARTS = 4
_LATEST = 2


def influence_coefficients(
    shape: tuple[int, int], spacing: tuple[float, float], composite_modulus: float
) -> Array:
    """Normal displacement of cell (i, j) per unit pressure on cell (0, 0).

    Love, "The stress produced in a semi-infinite solid by pressure on part of the boundary",
    Phil. Trans. R. Soc. A 228 (1929), for a rectangle; the four corner terms of neighbouring
    cells coincide, so the logarithms are taken once per corner.

    Parameters
    ----------
    shape
        Number of offsets i = 0 … nx-1 and j = 0 … ny-1.
    spacing
        Cell size along x and y, m.
    composite_modulus
        E*, Pa.

    Returns
    -------
    Array, m/Pa, shape (nx, ny).
    """
    dx, dy = spacing
    x = ((np.arange(shape[0] + 1) - 0.5) * dx)[:, None]
    y = ((np.arange(shape[1] + 1) - 0.5) * dy)[None, :]
    # x arsinh(y/|x|) + y arsinh(x/|y|), in as little memory as can be.
    corner, other = y / np.abs(x), x / np.abs(y)
    for ratio, side in ((corner, x), (other, y)):
        np.arcsinh(ratio, out=ratio)
        ratio *= side
    corner += other
    coefficients: Array = np.diff(np.diff(corner, axis=0), axis=1)
    coefficients /= np.pi * composite_modulus
    return coefficients


class HalfSpace:
    """The elastic bodies on a window.

    Parameters
    ----------
    window
        The cells.
    composite_modulus
        E*, Pa.
    workers
        Threads of one transform.

    Attributes
    ----------
    self_influence
        Displacement of a cell per pressure on itself, m/Pa.
    """

    def __init__(self, window: Window, composite_modulus: float, workers: int = 1) -> None:
        self.window = window
        self._modulus = composite_modulus
        self._workers = workers
        self._parts: dict[tuple[int, int], HalfSpace] = {}
        kind = CosineConvolution if window.quarter else FourierConvolution
        kernel = influence_coefficients(
            kind.offsets(window.shape), window.spacing, composite_modulus
        )
        self.self_influence = float(kernel[0, 0])
        self._convolution: Convolution[Array] = kind.with_kernel(kernel, workers)

    def displacement(self, pressure: Array) -> Array:
        """Normal surface displacement w, m, of a pressure, Pa; both of the window's shape."""
        return self._convolution(pressure)

    @cached_property
    def single(self) -> Convolution[Single]:
        """`displacement` in units of `self_influence`, and its inverse, in single precision.

        Good to some parts in 10⁷: enough for a step to the solution, not for the solution itself.
        """
        return self._convolution.in_single(self.self_influence)

    def displacement_in_single(self, pressure: Array) -> Array:
        """`displacement` to some parts in 10⁷, in less time."""
        result, unit = self.relative_displacement(pressure)
        return np.multiply(result, unit, dtype=np.float64)

    def relative_displacement(self, pressure: Array) -> tuple[Single, float]:
        """`displacement_in_single` in some unit, m, and the unit."""
        field, unit = passes.scaled(pressure)
        return self.single(field), unit * self.self_influence

    def part(self, shape: tuple[int, int]) -> HalfSpace:
        """The same bodies on a smaller window around the same origin."""
        if shape == self.window.shape:
            return self
        part = self._parts.pop(shape, None)
        if part is None:
            window = Window(shape, self.window.spacing, self.window.quarter)
            part = half_space(window, self._modulus, self._workers)
            if len(self._parts) == _PARTS:
                # Zones that change their size seldom change it back: the one longest out of use.
                del self._parts[next(iter(self._parts))]
        self._parts[shape] = part
        return part

    def take_parts(self, other: HalfSpace) -> None:
        """Keep the latest parts of the same bodies on a smaller window: they will be asked for."""
        self._parts.update(list(other._parts.items())[-_LATEST:])


_in_use: WeakValueDictionary[tuple[Window, float, int], HalfSpace] = WeakValueDictionary()


def half_space(window: Window, composite_modulus: float, workers: int = 1) -> HalfSpace:
    """The half-space of a window.

    One that is still in use is not made again.
    """
    key = window, composite_modulus, workers
    bodies = _in_use.get(key)
    if bodies is None:
        bodies = _in_use[key] = HalfSpace(window, composite_modulus, workers)
    return bodies
