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
from fretwear.mechanics.geometry.rings import elliptic_integrals, mean_influence

# Points of Gauss across a ring, and across one whose width is more than a part of its radius: with
# fewer, waves of pressure on the innermost rings would have negative energies.
_POINTS, _INNER, _OF_RADIUS = 2, 8, 0.15
# arcosh χ up to which Q follows from those of lower degree, and number of degrees above the
# largest one from which ratios of successive ones, beyond, converge downward.
_FORWARD, _ABOVE = 0.3, 60


def toroidal_differences(apart: Array, degrees: int) -> tuple[Array, Array]:
    """Q_{−½}, and Q_{n−½} − Q_{−½} for n = 0 … ``degrees`` on a new first axis.

    ``apart`` is χ − 1, not negative. Where that is zero, Q_{−½} is infinite, and zero here; the
    differences are those of the digamma function.
    """
    chi = 1.0 + apart
    touching = apart == 0.0
    complement = np.sqrt(np.where(touching, 1.0, apart) / (2.0 + apart))
    second, first = elliptic_integrals(complement)
    modulus = np.sqrt(2.0 / (2.0 + apart))
    lowest = np.where(touching, 0.0, modulus * first)
    result = np.zeros((degrees + 1, *apart.shape))
    half = chi * modulus * first - np.sqrt(2.0 * (2.0 + apart)) * second - lowest
    result[1] = np.where(touching, -2.0, half)
    for n in range(1, degrees):
        # (n + ½) Q_{n+½} = 2 n χ Q_{n−½} − (n − ½) Q_{n−3/2}
        rise = 2.0 * n * (chi * result[n] + apart * lowest) - (n - 0.5) * result[n - 1]
        result[n + 1] = rise / (n + 0.5)
    far = np.arccosh(chi) > _FORWARD
    chi, lowest_far = chi[far], lowest[far]
    ratios = np.empty((degrees, chi.size))
    ratio = np.zeros(chi.size)
    for n in range(degrees + _ABOVE, 0, -1):
        ratio = (n - 0.5) / (2.0 * n * chi - (n + 0.5) * ratio)
        if n <= degrees:
            ratios[n - 1] = ratio
    result[1:, far] = lowest_far * (np.cumprod(ratios, axis=0) - 1.0)
    return lowest, result


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
        self._starts, self._areas = np.cumsum(counts) - counts, np.pi * np.diff(edges**2)
        points, rules = [], {count: leggauss(count) for count in (_POINTS, _INNER)}
        for middle, width, number in zip(*rings, counts, strict=True):
            nodes, weights = rules[int(number)]
            at = middle + 0.5 * width * nodes
            points.append([at, at * weights / (at @ weights)])
        r, self._shares = np.concatenate(points, axis=1)
        self._of_radii = 2.0 / np.sqrt(np.multiply.outer(r, r))
        apart = np.subtract.outer(r, r) ** 2 / (2.0 * np.multiply.outer(r, r))
        self._apart, self._slope = apart, r[:, None] / r - r / r[:, None]
        self._lowest, self._beyond = toroidal_differences(apart, 2 * count)
        self._uniform = mean_influence(edges) / self._areas[:, None]

    def _mean(self, field: Array) -> Array:
        """Means over displaced rings, integrals over loaded ones, of a field at their points."""
        mean = self._shares[:, None] * (self._of_radii * field) * self._shares
        for axis in (0, 1):
            mean = np.add.reduceat(mean, self._starts, axis=axis)
        return np.asarray(mean * self._areas / (2.0 * np.pi**2))

    def along(self, wave: int) -> Array:
        """Of the wave k by itself: under a pressure, or under shear on average over directions."""
        return self._uniform + self._mean(self._beyond[2 * wave]) if wave else self._uniform

    def across(self, wave: int) -> Array:
        """Displacement u_x + i u_y = e^{2ijθ} by a traction q_x + i q_y = e^{2i(1−j)θ}, j the wave.

        It adds to the mean over directions by how much kernels depend on the direction.
        """
        p, apart, lowest = 2 * wave - 1, self._apart, self._lowest
        odd = abs(p)
        there, before = self._beyond[odd], self._beyond[odd - 1]
        rest = (2 * odd - 1) * before - 2 * odd * (1.0 + apart) * there - 2 * odd * apart * lowest
        return self._mean(rest + p * self._slope * (there + lowest)) - self._uniform
