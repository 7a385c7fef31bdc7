"""The unworn gap between the bodies before any load."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretwear.mechanics.arrays import Array
from fretwear.mechanics.window import Window


@dataclass(frozen=True)
class Waves:
    """Wavy roughness R(x, y) = A cos(k_y y) sin(π/2 + k_x x) = A cos(k_y y) cos(k_x x).

    Parameters
    ----------
    amplitude
        A, m.
    wavenumber_x, wavenumber_y
        k = (π/2)·tan θ/A for a mean slope tan θ along that direction, 1/m.
    """

    amplitude: float
    wavenumber_x: float
    wavenumber_y: float

    def height(self, x: Array, y: Array) -> Array:
        """Height, m, shape (nx, ny), at the coordinates x (nx,) and y (ny,), m."""
        along_x = self.amplitude * np.cos(self.wavenumber_x * x)
        return np.multiply.outer(along_x, np.cos(self.wavenumber_y * y))


@dataclass(frozen=True)
class Surface:
    """A sphere on a flat, smooth or with wavy roughness.

    Parameters
    ----------
    radius
        Radius of the sphere, m.
    waves
        Roughness, or None when smooth.
    """

    radius: float
    waves: Waves | None = None

    def shape(self, window: Window) -> Array:
        """Gap at zero load and zero approach, m, on the window's cells.

        The sphere is the paraboloid (x² + y²)/2R of Hertz's theory.
        """
        x, y = window.x, window.y
        paraboloid: Array = np.add.outer(x**2, y**2) / (2.0 * self.radius)
        return paraboloid if self.waves is None else paraboloid + self.waves.height(x, y)
