"""Concentric rings: a contact with rotational symmetry, some hundreds of cells, dense matrices.

The pressure is uniform on each ring, and displacements are their means over a ring. So the
influence of rings on each other is symmetric, and a mean of the paraboloid is its value at the
root mean square of the ring's radii, where fields are given.

References
----------
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, section 3.4 (the displacement
of a uniform pressure on a disc).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ellipe, ellipkm1

from fretwear.mechanics.geometry import Array, Problem
from fretwear.mechanics.geometry.dense import DenseCells, edges_about_stick
from fretwear.mechanics.geometry.grid import Grid


@dataclass(frozen=True)
class Rings(DenseCells):
    """Concentric rings around the origin; the edges are their radii."""

    @classmethod
    def first(cls, problem: Problem) -> Rings:
        """Rings for the first loading of a problem, graded to the edge of its stick zone.

        Raises
        ------
        ValueError
            If the problem has no rotational symmetry.
        """
        if not problem.is_axisymmetric:
            raise ValueError("rings need a smooth indenter with rotational symmetry")
        return cls(edges_about_stick(problem, math.sqrt(2.0) * max(problem.extent)))

    @cached_property
    def areas(self) -> Array:
        """Areas of the rings, m², shape (n, 1)."""
        return math.pi * np.diff(np.square(self.edges))[:, None]

    @cached_property
    def x(self) -> Array:
        """Root mean square of the radii of each ring, m, shape (n,)."""
        square = np.square(self.edges)
        result: Array = np.sqrt(0.5 * (square[1:] + square[:-1]))
        return result

    @property
    def extent(self) -> tuple[float, float]:
        """Half-widths of the square within the outermost ring, m."""
        return self.edges[-1] / math.sqrt(2.0), self.edges[-1] / math.sqrt(2.0)

    def influence(self, modulus: float) -> Array:
        """Mean displacement of each ring under a unit pressure on each, m/Pa, shape (n, n)."""
        return mean_influence(np.asarray(self.edges)) / modulus / self.areas

    def plane(self, spacing: tuple[float, float]) -> Grid:
        """The grid on which fields are written: the quarter of the square within the rings."""
        x, y = (
            max(1, math.floor(each / size)) for each, size in zip(self.extent, spacing, strict=True)
        )
        return Grid((x, y), spacing)


def mean_influence(edges: Array) -> Array:
    """Displacement integrated over each ring under a unit pressure on each, times E*, m³.

    Over a disc of radius s beside or within one of radius t under a unit pressure, the larger of
    both being b and k the ratio of the smaller to it, the displacement integrates to
    (8/3) b³ [(1 + k²) E(k) − (1 − k²) K(k)] / E*; rings are differences of discs.

    Parameters
    ----------
    edges
        Radii of the edges of n rings from 0 outward, m.

    Returns
    -------
    Array, shape (n, n), symmetric.
    """
    larger = np.maximum(edges[:, None], edges[None, :])
    ratio = np.minimum(edges[:, None], edges[None, :]) / np.where(larger > 0.0, larger, 1.0)
    complement = np.maximum((1.0 - ratio) * (1.0 + ratio), np.finfo(np.float64).tiny)
    bracket = (1.0 + ratio**2) * ellipe(ratio**2) - complement * ellipkm1(complement)
    discs = (8.0 / 3.0) * larger**3 * bracket
    result: Array = np.diff(np.diff(discs, axis=0), axis=1)
    return result
