"""Draws from the posterior by an ensemble sampler on the emulator of the runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretwear.arrays import Array
from fretwear_fit.emulator import Emulator
from fretwear_fit.estimate import TOLERATED, Fitter, Profile

CHAINS, DRAWS = 4, 1000
TOGETHER = 0.95  # correlation above which intervals come from the draws
_LOPSIDED = 2.0  # ratio of the halves of an interval above which they do
_LEVEL = 0.9
_BESIDE = 0.1  # least part of an interval on either side of the best value
_WALKERS, _BURN_IN, _THIN = 200, 300, 40
_SCALES = 32  # values of the variance of the noise
_CHECKS, _AMONG = 4, 200  # runs at draws at once, and draws among which the farthest is taken


@dataclass(frozen=True)
class Posterior:
    """Draws from the posterior.

    The prior is uniform in the coordinates in which parameters are sought, within their ranges.
    """

    draws: Array  # in the coordinates in which parameters are sought, shape (4, 1000, p)
    reason: str = ""  # why intervals come from the draws; empty if from profiles
    error: float = 0.0  # of rises of χ², by which the draws are wider where it is not tolerated

    @property
    def is_checked(self) -> bool:
        """Whether the emulator was right at the last runs."""
        return self.error <= TOLERATED

    def interval(self, place: int, level: float, best: float) -> tuple[float, float]:
        """An interval of a parameter, in the coordinate in which it is sought, around its best.

        It is central, but at least a tenth of its draws lies on either side of the best value, or
        all draws that do.
        """
        draws = self.draws[..., place]
        share = float((draws < best).mean())
        least = _BESIDE * level
        below = np.clip(0.5 - 0.5 * level, share - level + least, share - least)
        below = float(np.clip(below, 0.0, 1.0 - level))
        low, high = np.quantile(draws, (below, below + level))
        return min(float(low), best), max(float(high), best)


def why_to_sample(profiles: Sequence[Profile], correlation: Array) -> str:
    """Why the profile likelihood does not do for intervals; empty where it does."""
    apart = np.abs(correlation[np.triu_indices(len(correlation), 1)])
    if apart.size and apart.max() > TOGETHER:
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


def sampled(
    fitter: Fitter,
    emulator: Emulator,
    spread: Array,
    seed: int,
    reason: str = "",
    error: float = 0.0,
) -> Posterior:
    """Draws by the affine-invariant ensemble sampler of emcee.

    With a reason, intervals rest on them: runs at draws far from all others check the emulator,
    which takes them in until it is right there. If it is not when no run is left, draws are wider
    by the error of rises of χ² at the last check, or by the error there was.

    References
    ----------
    J. Goodman, J. Weare (2010), Ensemble samplers with affine invariance, Commun. Appl. Math.
    Comput. Sci. 5, 65–80. D. Foreman-Mackey et al. (2013), emcee: the MCMC hammer, PASP 125, 306.
    """
    generator, draws = np.random.default_rng(seed), _ensemble(fitter, emulator, spread, seed)
    while reason and fitter.left:
        points: list[Array] = []
        for _ in range(min(_CHECKS, fitter.left)):
            few = generator.choice(draws.reshape(-1, emulator.center.size), _AMONG, replace=False)
            there = np.concatenate([emulator.places, *[emulator.at(u)[None] for u in points]])
            apart = ((emulator.at(few)[:, None] - there) ** 2).sum(axis=2).min(axis=1)
            points.append(few[int(apart.argmax())])
        error = fitter.check(emulator, points)
        if error <= TOLERATED:
            break
        draws = _ensemble(fitter, emulator, spread, seed)
    if error > TOLERATED:
        draws = _ensemble(fitter, emulator, spread * (1.0 + error), seed)
    return Posterior(draws, reason, error)


def _ensemble(fitter: Fitter, emulator: Emulator, spread: Array, seed: int) -> Array:
    """Draws of all walkers after they have forgotten their start, shape (4, 1000, p).

    With the variances s_j that the noise may have, over the one taken, the likelihood is
    Σ s_j^(−p/2) exp(−Δχ²/2s_j).
    """
    import emcee

    best, ends, count = emulator.best, np.array([fitter.lower, fitter.upper]), emulator.center.size
    scales = np.exp(np.log(spread).mean(axis=1))
    scales = np.quantile(scales, (np.arange(_SCALES) + 0.5) / _SCALES)

    def likely(u: Array) -> Array:
        inside = ((u > ends[0]) & (u < ends[1])).all(axis=1)
        rises = emulator.misfit(u) - emulator.least
        parts = -0.5 * rises[:, None] / scales - 0.5 * count * np.log(scales)
        return np.where(inside, np.logaddexp.reduce(parts, axis=1), -np.inf)

    generator = np.random.default_rng(seed)
    start = best + generator.standard_normal((_WALKERS, count)) @ emulator.root.T
    room = 1e-3 * (ends[1] - ends[0]) * generator.uniform(size=start.shape)
    sampler = emcee.EnsembleSampler(_WALKERS, count, likely, vectorize=True)
    state = emcee.State(
        np.clip(start, ends[0] + room, ends[1] - room),
        random_state=np.random.RandomState(seed).get_state(),
    )
    sampler.run_mcmc(state, _BURN_IN + CHAINS * DRAWS // _WALKERS * _THIN)
    chain = sampler.get_chain(discard=_BURN_IN, thin=_THIN)  # (draws, walkers, p)
    groups = np.split(chain, CHAINS, axis=1)
    return np.array([group.reshape(DRAWS, -1) for group in groups])
