"""When an ensemble sampler is needed, and whether its draws are those of the posterior."""

import numpy as np
import pytest

from fretwear.study.case import case_keys
from fretwear_fit.comparison import Comparison
from fretwear_fit.estimate import AROUND, ENDS, SEARCH, Fitter
from fretwear_fit.posterior import sampled
from fretwear_fit.request import Measurement, Unknown


def banana(u):
    """Two numbers, known to 0.1 and 0.3, of which the second bends with the first."""
    return np.array([[u[0]], [u[1] + 1.5 * u[0] ** 2]])


def wave(u):
    """Two numbers, the second of which waves with the first: no quadratic."""
    return np.array([[u[0]], [u[1] + 0.5 * np.sin(4.0 * u[0])]])


def fitted(law, runs):
    """A fitter that made at most so many runs, and draws from its posterior."""
    quantity = case_keys()["friction"].parameter
    unknowns = [Unknown(name, -2.0, 2.0, quantity, False) for name in "ab"]
    data = [
        Comparison(Measurement.unchecked(quantity="wear_volume", value=0.5, error=error), 1)
        for error in (0.4, 0.1)
    ]

    def signals(points):
        values = [
            [unknown.value(x) for unknown, x in zip(unknowns, u, strict=True)] for u in points
        ]
        return [[*law(each)] for each in values]

    fitter = Fitter(unknowns, data, signals, runs=runs)
    fitter.keep(SEARCH)
    best = fitter.best(np.array([0.6, 0.5]))
    fitter.keep(AROUND)
    emulator, _ = fitter.emulator(best)
    fitter.keep(ENDS)
    _, error = fitter.intervals(emulator, spread := np.ones((1, 2)))
    fitter.keep(1.0)
    return fitter, sampled(fitter, emulator, spread, seed=1, reason="bent", error=error)


@pytest.mark.slow
def test_draws_of_a_bent_posterior_have_the_quantiles_of_the_likelihood_itself():
    """On a fine grid; the emulator begins with eight runs about the best parameters."""
    fitter, found = fitted(banana, runs=40)
    assert found.is_checked
    assert len(fitter.signals_of) <= 40
    unknowns = fitter.unknowns
    a, b = np.meshgrid(*[np.linspace(-2.0, 2.0, 801)] * 2, indexing="ij")
    first, second = banana(np.array([a, b]))[:, 0]
    density = np.exp(-0.5 * ((first - 0.5) / 0.4) ** 2 - 0.5 * ((second - 0.5) / 0.1) ** 2)
    for place, axis in enumerate((a[:, 0], b[0])):
        below = np.cumsum(density.sum(axis=1 - place))
        for share in (0.05, 0.5, 0.95):
            expected = np.interp(share, below / below[-1], axis)
            drawn = unknowns[place].value(np.quantile(found.draws[..., place], share))
            assert drawn == pytest.approx(expected, abs=0.06)


@pytest.mark.slow
def test_a_fit_that_runs_out_of_runs_says_so():
    """Its interpolation has not followed the wave yet."""
    few, short = fitted(wave, runs=16)
    assert len(few.signals_of) <= 16
    assert not short.is_checked
