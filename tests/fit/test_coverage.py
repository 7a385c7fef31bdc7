"""Intervals of a scar whose depth is a multiple of a known profile, where they are exact."""

import numpy as np
import pytest
from scipy.stats import binom, norm

from fretwear.study.case import case_keys
from fretwear_fit.comparison import Comparison
from fretwear_fit.estimate import LEVELS, Fitter
from fretwear_fit.noise import Noise
from fretwear_fit.request import Unknown

from .conftest import measured

X, GRID = np.linspace(-1e-3, 1e-3, 161), np.linspace(-2e-3, 2e-3, 1601)
DEPTH = 1e-6


def profile(x):
    """A scar over half of the line, m."""
    return DEPTH * np.maximum(1.0 - (x / 5e-4) ** 2, 0.0)


def fitter_of(readings, noise=None, multiple=lambda u: 4.0 * u):
    """The fitter of a multiple of the profile, a function of the place in its range."""
    known = {} if noise is None else {"noise": noise.size, "correlation_length": noise.length}
    scar = measured(X, readings, baseline=("offset", "tilt"), **known)
    comparison = Comparison(scar, 1, noise or Noise(0.05 * DEPTH, 0.0), grid=GRID)
    unknown = Unknown("multiple", 0.0, 4.0, case_keys()["friction"].parameter, logarithmic=False)
    return Fitter(
        [unknown], [comparison], lambda points: [[multiple(u[0]) * profile(GRID)] for u in points]
    )


def fitted(readings, noise=None):
    """The fitter of a multiple of the profile, its emulator, and the interval of each level.

    The noise is estimated beside the scar unless it is known.
    """
    fitter = fitter_of(readings, noise)
    (unknown,) = fitter.unknowns
    best = fitter.best(np.array([0.4]))
    parts = fitter.parts(fitter.signal(best))
    fitter.compare([c.with_noise_beside(s, n) for c, s, n in parts])
    emulator, slopes = fitter.emulator(best)
    spread = fitter.spread(fitter.signal(emulator.best), slopes)
    (found,), _ = fitter.intervals(emulator, spread)
    values = [[float(unknown.value(u)) for u in found.interval(level)] for level in LEVELS]
    return fitter, float(unknown.value(emulator.best[0])), values


def test_runs_at_some_distances_find_another_minimum():
    """The multiple has a ripple, so that its sums of squares have a minimum each 0.06."""

    def rippled(u):
        return 4.0 * (u + 0.02 * np.sin(2.0 * np.pi * u / 0.06))

    fitter = fitter_of(rippled(0.33) * profile(X), Noise(0.01 * DEPTH, 0.0), rippled)
    ends = [np.array([0.25975]), fitter.elsewhere(np.array([0.25975]))]
    trapped, found = (fitter.misfit(fitter.signal(u)) for u in ends)
    assert found < 0.05 * trapped
    assert rippled(ends[1][0]) == pytest.approx(rippled(0.33), rel=0.02)


@pytest.mark.parametrize("length", [0.0, 6e-5])
def test_intervals_with_a_known_noise_are_those_of_generalised_least_squares(length):
    """By dense matrices: multiple, offset and tilt with the covariance of the noise."""
    noise = Noise(0.1 * DEPTH, length)
    readings = 1.3 * profile(X) + noise.drawn(X, np.random.default_rng(4)) + 0.2 * DEPTH
    apart = np.abs(X[:, None] - X)
    covariance = noise.size**2 * (np.exp(-apart / length) if length else np.eye(X.size))
    columns = np.column_stack([profile(X), X**0, X / X[-1]])
    weighted = np.linalg.solve(covariance, columns).T
    inverse = np.linalg.inv(weighted @ columns)
    best, deviation = (inverse @ weighted @ readings)[0], np.sqrt(inverse[0, 0])
    fitter, found, intervals = fitted(readings, noise)
    assert found == pytest.approx(best, abs=0.05 * deviation)
    for level, ends in zip(LEVELS, intervals, strict=True):
        half = norm.ppf(0.5 + 0.5 * level) * deviation
        assert ends == pytest.approx([best - half, best + half], abs=0.03 * half)
    assert len(fitter.signals_of) <= 20


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_intervals_with_an_estimated_noise_hold_the_truth_as_often_as_they_say(share):
    """Of 100 scars; a count of 90 % so far from 90 has a probability of 0.1 %."""
    count, held = 100, np.zeros(len(LEVELS), int)
    for number in range(count):
        generator = np.random.default_rng([number, int(10 * share)])
        length = 2e-5 * 5.0 ** generator.uniform()
        readings = profile(X) + DEPTH * (generator.normal() + generator.normal() * X / X[-1])
        for part, reach in ((share, length), (1.0 - share, 0.0)):
            readings += Noise(0.1 * DEPTH * np.sqrt(part), reach).drawn(X, generator)
        _, best, intervals = fitted(readings)
        assert all(low <= best <= high for low, high in intervals)
        held += [low <= 1.0 <= high for low, high in intervals]
    for number, level in zip(held, LEVELS, strict=True):
        low, high = binom.interval(0.999, count, level)
        assert low <= number <= high, (held, level)
