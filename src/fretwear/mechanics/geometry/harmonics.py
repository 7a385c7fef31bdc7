"""Influence of rings on each other under tractions that vary along the angle like a wave.

With the distance d of two points at radii r and s and an angle α apart,

    ∫ cos nα / d dα = 2/√(rs) Q_{n−½}(χ),    χ = (r² + s²)/(2rs),

the toroidal functions Q (Heine's formula; Abramowitz and Stegun 1972, section 8.11, here over a
whole turn). For shear, Cerruti's kernels add the square of the direction from one point to the
other over d: for e^{2iψ} = (r − s e^{iα})²/d² and odd p, integration by parts and the derivative of
Q by χ lead to

    ∫ e^{2iψ} e^{ipα}/d dα = 2/√(rs) {(2|p| − 1) Q_{|p|−3/2} + [p (r/s − s/r) − 2|p| χ] Q_{|p|−½}}.

All of them have the singularity of Q_{−½}, of which the means over rings are known in closed form
(`fretwear.mechanics.geometry.rings.mean_influence`). The rest is bounded, and its mean is taken
from points of Gauss within each ring.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial.legendre import leggauss

from fretwear.arrays import Array
from fretwear.mechanics.geometry.rings import mean_influence
from fretwear.mechanics.team import kernels

# Points of Gauss across a ring, and across one whose width is more than a part of its radius: with
# fewer, waves of pressure on the innermost rings would have negative energies.
_POINTS, _INNER, _OF_RADIUS = 2, 8, 0.15


class RingHarmonics:
    """Means over rings of the displacement of equal bodies by waves of traction, times E*, m.

    ``edges`` are the radii of the edges of n rings from 0 outward, m, and ``count`` is the number
    of waves round a quarter: tractions vary as cos 2kθ and sin 2kθ, k = 0 … ``count``. All fields
    are per unit traction on a ring, shape (n, n): displaced rings, then loaded ones.
    """

    def __init__(self, edges: Array, count: int) -> None:
        rings = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
        inner = rings[1] > _OF_RADIUS * rings[0]
        counts = np.where(inner, _INNER, _POINTS)
        areas = np.pi * np.diff(edges**2)
        points, rules = [], {count: leggauss(count) for count in (_POINTS, _INNER)}
        for middle, width, number in zip(*rings, counts, strict=True):
            nodes, weights = rules[int(number)]
            at = middle + 0.5 * width * nodes
            points.append([at, at * weights / (at @ weights)])
        starts = (np.cumsum(counts) - counts)[None].astype(np.int64)
        means = kernels.ring_means(np.concatenate(points, axis=1), starts, count)
        means *= areas / (2.0 * np.pi**2)
        self._along, self._even, self._odd = np.split(means, [count + 1, 2 * count + 1])
        self._uniform = mean_influence(edges) / areas[:, None]

    def along(self, wave: int) -> Array:
        """Influence of the wave k on itself: by pressure, or by shear in the mean of directions."""
        return np.asarray(self._uniform + self._along[wave])

    def across(self, wave: int) -> Array:
        """Displacement u_x + i u_y = e^{2ijθ} by a traction q_x + i q_y = e^{2i(1−j)θ}, j the wave.

        It adds to the mean over directions by how much kernels depend on the direction.
        """
        number = wave - 1 if wave > 0 else -wave
        odd = self._odd[number] if wave > 0 else -self._odd[number]
        return np.asarray(self._even[number] + odd - self._uniform)
