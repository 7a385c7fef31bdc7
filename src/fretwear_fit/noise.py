"""Correlated noise of profilometers: its likelihood, and its estimate beside a scar."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretwear.arrays import Array

_LEAST_RHO = 1e-12
_LENGTHS = 61


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


@dataclass(frozen=True)
class NoiseEvidence:
    """Readings of noise about a trend, which tell its size and its correlation length.

    x and readings have the shape (n,), m; trend, shape (n, k), has the columns of the base line,
    and of whatever else has been fitted to the readings. A size or a length that is known is kept.
    """

    x: Array
    readings: Array
    trend: Array
    size: float | None = None
    length: float | None = None
    is_beside: bool = True  # whether the readings lie beside the scar

    @property
    def degrees(self) -> int:
        """Degrees of freedom."""
        return int(self.x.size - self.trend.shape[1])

    def best(self) -> Noise:
        """Size and length of the largest restricted likelihood."""
        from scipy.optimize import minimize_scalar

        length = self.length
        if length is None:
            ends = np.log(0.1 * self._step), np.log(self._longest)
            optimum = minimize_scalar(lambda log: self._at(float(np.exp(log)))[0], bounds=ends)
            # Noise that is correlated over less than a step is not correlated.
            length = 0.0 if self._at(0.0)[0] <= optimum.fun else float(np.exp(optimum.x))
        return Noise(self.size or float(np.sqrt(self._at(length)[1])), length)

    def drawn(self, shares: Array) -> list[Noise]:
        """Noises that the readings allow, at shares of probability of length and size, (m, 2).

        The prior is uniform in ln σ and in artanh ρ, with ρ the correlation over a step; artanh ρ
        is ½ ln ℓ for long correlations, and an estimate of it has the variance 1/n for any ρ.
        """
        from scipy.special import gammaincinv

        lengths = np.full(len(shares), self.length or 0.0)
        if self.length is None:
            z = np.linspace(0.0, np.arctanh(np.exp(-self._step / self._longest)), _LENGTHS)
            rho = np.tanh(z[1:])
            likely = np.array([self._at(at)[0] for at in (0.0, *-self._step / np.log(rho))])
            weights = np.exp(-0.5 * (likely - likely.min()))
            below = np.append(0.0, np.cumsum(0.5 * (weights[1:] + weights[:-1])))
            drawn = np.interp(shares[:, 0] * below[-1], below, z)
            lengths = -self._step / np.log(np.maximum(np.tanh(drawn), 1e-300))
        if self.size is not None:
            return [Noise(self.size, length) for length in lengths]
        # The sum of squares over σ² is distributed as χ².
        half = 0.5 * self.degrees
        factors = half / gammaincinv(half, 1.0 - shares[:, 1])
        return [
            Noise(float(np.sqrt(self._at(length)[1] * factor)), length)
            for length, factor in zip(lengths.tolist(), factors, strict=True)
        ]

    @property
    def _step(self) -> float:
        return float(np.median(np.diff(self.x)))

    @property
    def _longest(self) -> float:
        return 0.3 * float(self.x[-1] - self.x[0])

    def _at(self, length: float) -> tuple[float, float]:
        """Minus twice the restricted log-likelihood at the best size, and its square."""
        unit = Noise(1.0, length)
        columns = unit.whitened(self.x, np.column_stack([self.trend, self.readings]))
        q, r = np.linalg.qr(columns[:, :-1])
        rest = columns[:, -1] - q @ (q.T @ columns[:, -1])
        variance = max(float(rest @ rest) / self.degrees, 1e-300)
        determinants = unit.log_determinant(self.x) + 2.0 * float(np.log(np.abs(np.diag(r))).sum())
        if self.size is not None:
            return float(rest @ rest) / self.size**2 + determinants, self.size**2
        return self.degrees * np.log(variance) + determinants, variance
