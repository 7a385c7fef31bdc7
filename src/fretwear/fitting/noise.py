"""Correlated noise of profilometers: its likelihood, and its estimate beside a scar."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretwear.arrays import Array

_LEAST_RHO = 1e-12


@dataclass(frozen=True)
class Noise:
    """Gaussian noise with the covariance σ² exp(−|Δx|/ℓ): an Ornstein–Uhlenbeck process."""

    size: float  # standard deviation σ, m
    length: float  # correlation length ℓ, m; 0: uncorrelated

    def whitened(self, x: Array, columns: Array) -> Array:
        """Turn columns of noise into independent unit ones: L⁻¹r with LLᵀ the covariance.

        x has the shape (n,), m, increasing, the columns (n, k). A reading depends on those before
        only by the last one, so that L⁻¹ has two diagonals.
        """
        rho = self._correlation(x)
        scale = self.size * np.sqrt(1.0 - rho**2)[:, None]
        result: Array = columns[1:] - rho[:, None] * columns[:-1]
        return np.concatenate([columns[:1] / self.size, result / scale])

    def log_determinant(self, x: Array) -> float:
        """Logarithm of the determinant of the covariance."""
        rho = self._correlation(x)
        return float(2.0 * x.size * np.log(self.size) + np.log1p(-(rho**2)).sum())

    def drawn(self, x: Array, generator: np.random.Generator) -> Array:
        """One realisation of the noise at positions x, shape (n,)."""
        unit = generator.standard_normal(x.size)
        noise = np.empty(x.size)
        noise[0] = unit[0]
        for place, rho in enumerate(self._correlation(x), start=1):
            noise[place] = rho * noise[place - 1] + np.sqrt(1.0 - rho**2) * unit[place]
        return self.size * noise

    def _correlation(self, x: Array) -> Array:
        if self.length == 0.0:
            return np.zeros(x.size - 1)
        rho: Array = np.minimum(np.exp(-np.diff(x) / self.length), 1.0 - _LEAST_RHO)
        return rho


def estimated_noise(x: Array, readings: Array, trend: Array, length: float | None = None) -> Noise:
    """Estimate size and length of noise by restricted maximum likelihood.

    x and readings have the shape (n,), m; trend, shape (n, k), has the columns of the base line,
    and of whatever else has been fitted to the readings. A length that is known is kept.
    """
    from scipy.optimize import minimize_scalar

    degrees = x.size - trend.shape[1]

    def at(length: float) -> tuple[float, float]:
        """Minus twice the restricted log-likelihood, and the best variance."""
        unit = Noise(1.0, length)
        columns = unit.whitened(x, np.column_stack([trend, readings]))
        q, r = np.linalg.qr(columns[:, :-1])
        rest = columns[:, -1] - q @ (q.T @ columns[:, -1])
        variance = max(float(rest @ rest) / degrees, 1e-300)
        of_trend = 2.0 * float(np.log(np.abs(np.diag(r)) + 1e-300).sum())
        return degrees * np.log(variance) + unit.log_determinant(x) + of_trend, variance

    if length is None:
        steps, span = float(np.median(np.diff(x))), float(x[-1] - x[0])
        ends = (np.log(0.1 * steps), np.log(0.3 * span))
        best = minimize_scalar(lambda each: at(float(np.exp(each)))[0], bounds=ends)
        length = float(np.exp(best.x))
        # Noise that is correlated over less than a step is not correlated.
        length = 0.0 if at(0.0)[0] <= best.fun else length
    return Noise(float(np.sqrt(at(length)[1])), length)
