"""Correlated noise of profilometers: its likelihood, and its estimate beside a scar."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretwear.arrays import Array

_LEAST_RHO = 1e-12
# Correlation lengths and white shares that are compared.
_LENGTHS, _SHARES = 31, 8


@dataclass(frozen=True)
class Noise:
    """Gaussian noise: a part of it white, the rest with the covariance exp(−|Δx|/ℓ).

    The correlated part, an Ornstein–Uhlenbeck process, has the variance (1 − w) σ².
    """

    size: float  # standard deviation σ, m
    length: float  # correlation length ℓ, m; 0: uncorrelated
    white: float = 0.0  # share w of the variance, less than 1

    def whitened(self, x: Array, columns: Array) -> Array:
        """Turn columns of noise into independent unit ones: L⁻¹r with LLᵀ the covariance.

        x has the shape (n,), m, increasing, the columns (n, k). A correlated reading depends on
        those before only by the last one, so that B, with BBᵀ = (1 − w)⁻¹ times the inverse of its
        covariance, has two diagonals; L⁻¹ is then C⁻¹B with CCᵀ = 1 + w BBᵀ of two diagonals too.
        """
        from scipy.linalg import solve_banded

        rho, size = self._correlation(x), self.size * np.sqrt(1.0 - self.white)
        scale = size * np.sqrt(1.0 - rho**2)[:, None]
        rest = columns[1:] - rho[:, None] * columns[:-1]
        result = np.concatenate([columns[:1] / size, rest / scale])
        if not self.white:
            return result
        return np.asarray(solve_banded((1, 0), self._factor(rho), result, check_finite=False))

    def log_determinant(self, x: Array) -> float:
        """Logarithm of the determinant of the covariance."""
        rho, size = self._correlation(x), self.size * np.sqrt(1.0 - self.white)
        determinant = 2.0 * x.size * np.log(size) + np.log1p(-(rho**2)).sum()
        if self.white:
            determinant += 2.0 * np.log(self._factor(rho)[0]).sum()
        return float(determinant)

    def _factor(self, rho: Array) -> Array:
        """Both diagonals of C, shape (2, n)."""
        from scipy.linalg import cholesky_banded

        # Of B without its size: 1, then −ρ and 1 over √(1 − ρ²).
        upper = np.append(1.0, 1.0 / np.sqrt(1.0 - rho**2))
        lower = -rho * upper[1:]
        bands = np.zeros((2, upper.size))
        bands[0] = upper**2
        bands[0, 1:] += lower**2
        bands[1, :-1] = lower * upper[:-1]
        bands *= self.white / (1.0 - self.white)
        bands[0] += 1.0
        return np.asarray(cholesky_banded(bands, lower=True, check_finite=False))

    def drawn(self, x: Array, generator: np.random.Generator) -> Array:
        """One realisation of the noise at positions x, shape (n,)."""
        if self.white:
            parts = ((1.0 - self.white, self.length), (self.white, 0.0))
            noises = (Noise(self.size * float(np.sqrt(v)), length) for v, length in parts)
            return np.asarray(np.sum([noise.drawn(x, generator) for noise in noises], axis=0))
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


UNIT = Noise(1.0, 0.0)


@dataclass(frozen=True)
class NoiseEvidence:
    """Readings of noise about a trend, which tell its size, correlation length and white share.

    x and readings have the shape (n,), m; trend, shape (n, k), has the columns of the base line,
    and of whatever else has been fitted to the readings. A size or a length that is known is kept;
    with a known length, no share is white.
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
        """Size, length and white share of the largest restricted likelihood."""
        from scipy.optimize import minimize

        noises, misfits = self._compared
        start = noises[int(misfits.argmin())]
        if not start.length or self.length is not None:
            return start
        ends = np.log(0.1 * self._step), np.log(self._longest)

        def tried(place: Array) -> Noise:
            return Noise(1.0, float(np.exp(np.clip(place[0], *ends))), float(place[1]))

        begin = [float(np.clip(np.log(start.length), *ends)), start.white]
        bounds = [ends, (0.0, 0.98)]
        optimum = minimize(
            lambda place: self._of(tried(place))[0], begin, method="Nelder-Mead", bounds=bounds
        )
        shape = tried(optimum.x)
        return replace(shape, size=float(np.sqrt(self._of(shape)[1])))

    def drawn(self, shares: Array) -> list[Noise]:
        """Noises that the readings allow, at shares of probability of shape and size, (m, 2).

        The prior is uniform in ln σ. Noise is white with a probability of ½; otherwise the prior is
        uniform in the white share and in artanh ρ, with ρ the correlation over a step; artanh ρ is
        ½ ln ℓ for long correlations, and an estimate of it has the variance 1/n for any ρ.
        """
        from scipy.special import gammaincinv

        noises, misfits = self._compared
        likely = np.cumsum(np.exp(-0.5 * (misfits - misfits.min())))
        places = np.searchsorted(likely, shares[:, 0] * likely[-1])
        if self.size is not None:
            return [noises[place] for place in places]
        # The sum of squares over σ² is distributed as χ².
        half = 0.5 * self.degrees
        factors = np.sqrt(half / gammaincinv(half, 1.0 - shares[:, 1]))
        return [
            replace(noises[place], size=noises[place].size * float(factor))
            for place, factor in zip(places, factors, strict=True)
        ]

    @cached_property
    def _compared(self) -> tuple[list[Noise], Array]:
        """Noises of many lengths and white shares, each with its best size, and −2 ln of each."""
        if self.length is not None:
            shapes = [Noise(1.0, self.length)]
        else:
            z = np.linspace(0.0, np.arctanh(np.exp(-self._step / self._longest)), _LENGTHS)
            lengths = -self._step / np.log(np.tanh(z[1:]))
            shares = np.arange(_SHARES) / _SHARES
            # White noise is as likely beforehand as all correlated noises together.
            shapes = [Noise(1.0, 0.0)] * (_SHARES * lengths.size)
            shapes += [Noise(1.0, float(length), float(w)) for length in lengths for w in shares]
        found = {shape: self._of(shape) for shape in dict.fromkeys(shapes)}
        noises = [replace(shape, size=float(np.sqrt(found[shape][1]))) for shape in shapes]
        return noises, np.array([found[shape][0] for shape in shapes])

    @property
    def _step(self) -> float:
        return float(np.median(np.diff(self.x)))

    @property
    def _longest(self) -> float:
        return 0.3 * float(self.x[-1] - self.x[0])

    def _of(self, unit: Noise) -> tuple[float, float]:
        """Minus twice the restricted log-likelihood at the best size, and its square."""
        columns = unit.whitened(self.x, np.column_stack([self.trend, self.readings]))
        q, r = np.linalg.qr(columns[:, :-1])
        rest = columns[:, -1] - q @ (q.T @ columns[:, -1])
        variance = max(float(rest @ rest) / self.degrees, 1e-300)
        determinants = unit.log_determinant(self.x) + 2.0 * float(np.log(np.abs(np.diag(r))).sum())
        if self.size is not None:
            return float(rest @ rest) / self.size**2 + determinants, self.size**2
        return self.degrees * float(np.log(variance)) + determinants, variance
