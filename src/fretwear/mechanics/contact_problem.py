"""What a normal contact is given: bodies, shape, load, limit, layer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretwear.mechanics.arrays import Array
from fretwear.mechanics.halfspace import HalfSpace
from fretwear.mechanics.layers import Layer


@dataclass(frozen=True)
class ContactProblem:
    """A normal contact.

    Parameters
    ----------
    half_space
        The elastic bodies on a window.
    shape
        Gap at zero load and zero approach, m, shape of the window.
    load
        Normal load P of the whole contact, N.
    limit
        Largest pressure, Pa; infinite when elastic.
    layer
        Local compliance, or None.
    """

    half_space: HalfSpace
    shape: Array
    load: float
    limit: float = np.inf
    layer: Layer | None = None

    @property
    def total(self) -> float:
        """Sum of the pressure over the window's cells that carries the load, Pa."""
        window = self.half_space.window
        return self.load / (window.cell_area * window.copies)

    def separation(self, pressure: Array, displacement: Array) -> Array:
        """K p + W(p) + h, m: the gap plus the approach."""
        result = displacement + self.shape
        if self.layer is not None:
            self.layer.add_displacement(pressure, result)
        return result
