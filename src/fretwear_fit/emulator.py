"""What runs would give: residuals and signals over the parameters, from the runs there are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fretwear.arrays import Array

NEAR = 6.0
"""Runs this far from the best parameters are taken in, in standard deviations."""
_REACHES = (1.5, 3.0, 6.0, 12.0)  # of the Gaussian process, in standard deviations
_SAME, _NUGGET = 1e-6, 1e-6
_FREE_RANGE = 3.0  # of one minimisation, in standard deviations


class Emulator:
    """Residuals and signals as functions of the parameters, interpolated between runs.

    A quadratic goes through the runs by least squares, and a Gaussian process takes up what it
    misses; the reach of its covariance is the one with which each run is best foreseen by all
    others. An emulated row is then Σ w_i(u) r_i with weights w of the runs, so that χ² is wᵀGw with
    their products G. Parameters are measured in standard deviations.
    """

    def __init__(self, center: Array, covariance: Array) -> None:
        """Begin about parameters u₀, shape (p,), with their covariance, shape (p, p)."""
        self.center, self.root = center, np.linalg.cholesky(covariance)
        self._inverse = np.linalg.inv(self.root)
        self.deviations = np.sqrt(np.diag(covariance))
        self.places = np.zeros((0, center.size))
        self._points, self._residuals, self._signals = list[Array](), list[Array](), list[Array]()

    def at(self, u: Array) -> Array:
        """Parameters in standard deviations from the center, shape (p,) or (m, p)."""
        return np.asarray((u - self.center) @ self._inverse.T)

    def distance(self, u: Array) -> float:
        """Distance of parameters from the nearest run, in standard deviations."""
        return float(np.sqrt(((self.at(u) - self.places) ** 2).sum(axis=1)).min(initial=np.inf))

    def learn(
        self, points: Sequence[Array], residuals: Sequence[Array], signals: Sequence[Array]
    ) -> None:
        """Take in runs at parameters, shape (p,), their residuals and their signals."""
        for u, rest, signal in zip(points, residuals, signals, strict=True):
            if self.distance(u) > _SAME:
                self.places = np.concatenate([self.places, self.at(u)[None]])
                self._points.append(u)
                self._residuals.append(rest)
                self._signals.append(signal)
        rows = np.array(self._residuals)
        self._products = rows @ rows.T
        trend = np.linalg.pinv(self._basis(self.places), rcond=1e-8)
        missed = np.eye(len(rows)) - self._basis(self.places) @ trend
        errors = []
        for reach in _REACHES:
            inverse = np.linalg.inv(self._kernel(self.places, reach) + _NUGGET * np.eye(len(rows)))
            # What each run would be missed by without it, near the best more than far away.
            left_out = inverse @ missed / np.diag(inverse)[:, None]
            squares = np.einsum("ij,jk,ik->i", left_out, self._products, left_out)
            rises = np.diag(self._products) - self.least
            errors.append((float((squares / (1.0 + rises)).sum()), reach, inverse))
        _, self._reach, inverse = min(errors, key=lambda error: error[0])
        self._weights = np.concatenate([trend, inverse @ missed])

    @property
    def best(self) -> Array:
        """The parameters of the run with the least χ²."""
        return np.asarray(self._points[int(np.diag(self._products).argmin())])

    @property
    def least(self) -> float:
        """The least χ² of a run."""
        return float(np.diag(self._products).min())

    def misfit(self, u: Array) -> Array:
        """χ² at parameters, shape (p,) or (m, p)."""
        weights = self._weights_at(u)
        return np.asarray(((weights @ self._products) * weights).sum(axis=-1))

    def signal(self, u: Array) -> Array:
        """The signals of all measurements at parameters, shape (g,) or (m, g)."""
        return np.asarray(self._weights_at(u) @ np.array(self._signals))

    def minimum(self, start: Array, ends: Array, fixed: int | None = None) -> Array:
        """The parameters with the least χ² within their ranges, shape (2, p), one of them fixed."""
        from scipy.optimize import minimize

        free = [place for place in range(start.size) if place != fixed]
        if not free:
            return start
        scales, u = self.deviations[free], start.copy()

        def at(step: Array) -> float:
            u[free] = start[free] + step * scales
            return float(self.misfit(u))

        low, high = (
            np.clip((e[free] - start[free]) / scales, -_FREE_RANGE, _FREE_RANGE) for e in ends
        )
        at(minimize(at, np.zeros(len(free)), bounds=[*zip(low, high, strict=True)]).x)
        return u

    def _weights_at(self, u: Array) -> Array:
        c = self.at(u)
        terms = np.concatenate([self._basis(c), self._kernel(c, self._reach)], axis=-1)
        return np.asarray(terms @ self._weights)

    def _basis(self, c: Array) -> Array:
        """1, c_i and c_i c_j, shape (…, 1 + p + p (p + 1)/2)."""
        first, second = np.triu_indices(c.shape[-1])
        return np.concatenate([np.ones_like(c[..., :1]), c, c[..., first] * c[..., second]], -1)

    def _kernel(self, c: Array, reach: float) -> Array:
        squares = ((c[..., None, :] - self.places) ** 2).sum(axis=-1)
        return np.asarray(np.exp(-0.5 * squares / reach**2))
