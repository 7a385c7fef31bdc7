"""What all geometries share, and the unworn bodies on them.

A geometry is a set of cells: rectangles (`fretwear.mechanics.geometry.grid`), concentric rings
(`fretwear.mechanics.geometry.rings`) or the strips of a line contact
(`fretwear.mechanics.geometry.dense`). It defines the positions of the cells, the area of each, and
how the geometry is enlarged. Its half-space is the elastic bodies on these cells, and gives the
displacement under a pressure.

Every field has two axes; on rings and strips the second one has a single cell. In a line contact
loads are per length: areas are widths, m, and forces N/m.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array, Single

# A field in double or single precision; the result has the precision of the argument.
Real = TypeVar("Real", Array, Single)
Index = tuple[slice, slice]
# Whether something is even along x and along y.
Even = tuple[bool, bool]


@dataclass(frozen=True)
class Zone:
    """A part of the whole contact, and the cells at its edge.

    These are places in the flattened field, once for each side that two cells share.
    """

    area: float  #: m²
    inside: NDArray[np.intp]  #: cells of the zone, shape (sides,)
    outside: NDArray[np.intp]  #: those beside it


class Ground:
    """The unworn bodies of a problem on one geometry, computed when needed."""

    def __init__(self, problem: Any, geometry: Any, parts: dict[Any, Any]) -> None:
        self._problem, self.geometry, self._parts = problem, geometry, parts

    @cached_property
    def half_space(self) -> Any:
        """The elastic bodies."""
        return self._problem.half_space(self.geometry, self._parts)

    @cached_property
    def unworn(self) -> Array:
        """Gap at zero load and zero approach, m."""
        gap: Array = self._problem.unworn(self.geometry)
        return gap


class Workspace:
    """The workspace of a run: the unworn bodies on the two geometries used last."""

    def __init__(self, problem: Any) -> None:
        self.problem = problem
        self._grounds: dict[Any, Ground] = {}
        # Those of all windows: each of its own would be an array or two more.
        self._parts: dict[Any, Any] = {}

    def on(self, geometry: Any) -> Ground:
        """The unworn bodies on a geometry."""
        ground = self._grounds.pop(geometry, None) or Ground(self.problem, geometry, self._parts)
        self._grounds[geometry] = ground
        if len(self._grounds) > 2:
            del self._grounds[next(iter(self._grounds))]
        return ground

    def keep_only(self, geometry: Any) -> None:
        """Drop the bodies on all geometries but one."""
        self._grounds = {geometry: self.on(geometry)}
