"""Draws from the posterior: resampled about the best parameters, or by an ensemble sampler."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from fretwear.arrays import Array
from fretwear_fit.estimate import Emulator, Fitter, Profile

CHAINS, DRAWS = 4, 1000
_TRIALS, _WIDER = 20000, 1.3
_TOGETHER = 0.95  # correlation beyond which the ensemble sampler is asked
_LOPSIDED = 2.0  # so is it where one half of an interval is this many times the other
_LEVEL = 0.9
_WALKERS, _BURN_IN, _THIN = 40, 500, 10
_CHECKS, _ROUNDS, _TOLERATED = 4, 4, 0.5  # runs at draws, and how far off χ² may be there
# In standard deviations: runs that are taken in, and how far what the quadratic misses reaches.
_NEAR, _REACH, _NUGGET = 8.0, 1.5, 1e-6


@dataclass(frozen=True)
class Posterior:
    """Draws of an ensemble sampler on an emulator that runs have checked."""

    draws: Array  # in the coordinates in which parameters are sought, shape (4, 1000, p)
    missed: float  # largest error of χ² at the last runs that checked the emulator

    @property
    def is_checked(self) -> bool:
        """Whether the emulator was right at the draws that were run."""
        return self.missed <= _TOLERATED

    def interval(self, place: int, level: float) -> tuple[float, float]:
        """The central interval of a parameter, in the coordinate in which it is sought."""
        ends = 0.5 - 0.5 * level, 0.5 + 0.5 * level
        low, high = np.quantile(self.draws[..., place], ends)
        return float(low), float(high)


def why_to_sample(profiles: Sequence[Profile], correlation: Array) -> str:
    """Why the profile likelihood does not do for intervals; empty where it does."""
    apart = np.abs(correlation[np.triu_indices(len(correlation), 1)])
    if apart.size and apart.max() > _TOGETHER:
        return f"two parameters have a correlation of {apart.max():.3f}"
    for profile in profiles:
        if profile.falls:
            return "χ² falls again beside its least value"
        best = float(np.interp(0.0, profile.roots, profile.points[:, profile.place]))
        low, high = profile.interval(_LEVEL)
        halves = best - low, high - best
        if not any(profile.is_open(_LEVEL)) and max(halves) > _LOPSIDED * min(halves):
            return "χ² rises much faster on one side than on the other"
    return ""


def log_mixture(rises: Array, scales: Array, count: int) -> Array:
    """Logarithm of Σ s_j^(−p/2) exp(−Δχ²/2s_j): the likelihood, with the noise integrated out."""
    parts = -0.5 * rises[:, None] / scales - 0.5 * count * np.log(scales)
    return np.asarray(np.logaddexp.reduce(parts, axis=1))


def importance_draws(
    emulator: Emulator, covariance: Array, spread: Array, ends: Array, seed: int
) -> Array:
    """Draws by importance resampling of the emulator about the best parameters, (4, 1000, p).

    The prior is uniform in the coordinates in which parameters are sought, within their `ends`,
    shape (2, p).
    """
    generator, scales = np.random.default_rng(seed), _scales(spread)
    root, size = np.linalg.cholesky(covariance), len(covariance)
    normal = generator.standard_normal((_TRIALS, size))
    normal *= _WIDER * np.sqrt(generator.choice(scales, _TRIALS))[:, None]
    u = emulator.best + normal @ root.T
    inside = ((u > ends[0]) & (u < ends[1])).all(axis=1)
    u, normal = u[inside], normal[inside]
    chunks = np.array_split(emulator.at(u), max(1, len(u) // 500))
    misfit = np.concatenate([emulator.misfit(chunk) for chunk in chunks])
    logarithm = log_mixture(misfit - emulator.least, scales, size) - log_mixture(
        (normal**2).sum(axis=1), _WIDER**2 * scales, size
    )
    weights = np.exp(logarithm - logarithm.max())
    chosen = generator.choice(len(u), CHAINS * DRAWS, p=weights / weights.sum())
    return np.asarray(u[chosen].reshape(CHAINS, DRAWS, -1))


def _scales(spread: Array) -> Array:
    """Variances with the noises that the readings allow, the same for all parameters."""
    return np.asarray(np.exp(np.log(spread).mean(axis=1)))


class ResidualEmulator:
    """χ² over the parameters, from the residuals of runs.

    A quadratic goes through the principal components of the residuals by least squares; a Gaussian
    process takes up what it misses. Parameters are measured in standard deviations.
    """

    def __init__(self, center: Array, root: Array) -> None:
        """Begin about a center u₀, (p,), with a root of the covariance, (p, p)."""
        self.center, self._inverse = center, np.linalg.inv(root)
        self.places, self.residuals = np.zeros((0, center.size)), list[Array]()

    def at(self, u: Array) -> Array:
        """Parameters in standard deviations from the center, shape (m, p)."""
        return np.asarray((u - self.center) @ self._inverse.T)

    def learn(self, points: Sequence[Array], residuals: Sequence[Array]) -> None:
        """Take in runs and their residuals, shape (n,) each."""
        self.places = np.concatenate([self.places, self.at(np.array(points))])
        self.residuals += residuals
        rows = np.array(self.residuals)
        mean = rows.mean(axis=0)
        components, sizes, axes = np.linalg.svd(rows - mean, full_matrices=False)
        kept = sizes > 1e-9 * max(sizes[0], 1e-300)
        components = (components * sizes)[:, kept]
        self._mean, self._along = float(mean @ mean), axes[kept] @ mean
        basis = self._basis(self.places)
        self._quadratic = np.linalg.lstsq(basis, components, rcond=1e-8)[0]
        gram = self._kernel(self.places) + _NUGGET * np.eye(len(rows))
        self._missed = np.linalg.solve(gram, components - basis @ self._quadratic)

    def misfit(self, u: Array) -> Array:
        """χ² at parameters, shape (m, p)."""
        c = self.at(u)
        rest = self._basis(c) @ self._quadratic + self._kernel(c) @ self._missed
        return np.asarray(self._mean + 2.0 * rest @ self._along + (rest**2).sum(axis=1))

    def _basis(self, c: Array) -> Array:
        first, second = np.triu_indices(c.shape[1])
        return np.column_stack([np.ones(len(c)), c, c[:, first] * c[:, second]])

    def _kernel(self, c: Array) -> Array:
        squares = ((c[:, None] - self.places) ** 2).sum(axis=2)
        return np.asarray(np.exp(-0.5 * squares / _REACH**2))


def has_sampler() -> bool:
    """Whether emcee is installed."""
    return find_spec("emcee") is not None


def sampled(fitter: Fitter, best: Array, covariance: Array, spread: Array, seed: int) -> Posterior:
    """Draws by the affine-invariant ensemble sampler of emcee, on an emulator of all runs.

    Runs at draws check the emulator, and are taken in until it is right there.

    References
    ----------
    J. Goodman, J. Weare (2010), Ensemble samplers with affine invariance, Commun. Appl. Math.
    Comput. Sci. 5, 65–80. D. Foreman-Mackey et al. (2013), emcee: the MCMC hammer, PASP 125, 306.
    """
    generator = np.random.default_rng(seed)
    root = np.asarray(np.linalg.cholesky(covariance), float)
    emulator, scales = ResidualEmulator(best, root), _scales(spread)
    least = fitter.misfit(fitter.signal(best))
    signals = [(np.frombuffer(key), s) for key, s in fitter.signals_of.items() if s is not None]
    near = [(u, s) for u, s in signals if np.abs(emulator.at(u)).max() < _NEAR]
    emulator.learn([u for u, _ in near], [fitter.residuals(s) for _, s in near])

    def likely(u: Array) -> Array:
        inside = ((u > fitter.lower) & (u < fitter.upper)).all(axis=1)
        density = log_mixture(emulator.misfit(u) - least, scales, best.size)
        return np.where(inside, density, -np.inf)

    start = best + generator.standard_normal((_WALKERS, best.size)) @ root.T
    room = 1e-3 * (fitter.upper - fitter.lower) * generator.uniform(size=start.shape)
    start = np.clip(start, fitter.lower + room, fitter.upper - room)
    for _ in range(_ROUNDS):
        draws = _ensemble(likely, start, seed)
        flat = draws.reshape(-1, best.size)
        points: list[Array] = []
        for _ in range(_CHECKS):  # each the farthest from all runs
            there = np.concatenate([emulator.places, *[emulator.at(u)[None] for u in points]])
            few = flat[generator.choice(len(flat), 200, replace=False)]
            apart = ((emulator.at(few)[:, None] - there) ** 2).sum(axis=2).min(axis=1)
            points.append(few[int(apart.argmax())])
        checked = [
            (u, fitter.residuals(signal))
            for u, signal in zip(points, fitter.signals_at(points), strict=True)
            if signal is not None
        ]
        emulated = emulator.misfit(np.array([u for u, _ in checked]))
        missed = max(abs(float(r @ r) - t) for (_, r), t in zip(checked, emulated, strict=True))
        if missed <= _TOLERATED:
            break
        emulator.learn([u for u, _ in checked], [rest for _, rest in checked])
    return Posterior(draws, missed)


def _ensemble(likely: Callable[[Array], Array], start: Array, seed: int) -> Array:
    """Draws of all walkers after they have forgotten their start, shape (4, 1000, p)."""
    import emcee

    sampler = emcee.EnsembleSampler(*start.shape, likely, vectorize=True)
    state = emcee.State(start, random_state=np.random.RandomState(seed).get_state())
    kept = CHAINS * DRAWS // _WALKERS
    sampler.run_mcmc(state, _BURN_IN + kept * _THIN)
    chain = sampler.get_chain(discard=_BURN_IN, thin=_THIN)  # (draws, walkers, p)
    groups = np.split(chain, CHAINS, axis=1)
    return np.array([group.reshape(DRAWS, -1) for group in groups])
