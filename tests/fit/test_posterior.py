"""When an ensemble sampler is needed, and whether its draws are those of the posterior."""

import numpy as np
import pytest

from fretwear.study.contact import case_keys
from fretwear_fit.comparison import Comparison
from fretwear_fit.estimate import Fitter
from fretwear_fit.posterior import sampled
from fretwear_fit.request import Measurement, Unknown


def banana(u):
    """Two numbers, known to 0.1 and 0.3, of which the second bends with the first."""
    return np.array([[u[0]], [u[1] + 1.5 * u[0] ** 2]])


@pytest.mark.slow
def test_draws_of_a_bent_posterior_have_the_quantiles_of_the_likelihood_itself():
    """On a fine grid; the emulator begins with eight runs about the best parameters."""
    about = case_keys()["friction"].about
    unknowns = [Unknown(name, -2.0, 2.0, about, False) for name in "ab"]
    data = [
        Comparison(Measurement.unchecked(quantity="wear_volume", value=0.5, error=error), 1, None)
        for error in (0.4, 0.1)
    ]

    def signals(points):
        values = [
            [unknown.value(x) for unknown, x in zip(unknowns, u, strict=True)] for u in points
        ]
        return [[*banana(each)] for each in values]

    fitter = Fitter(unknowns, data, signals)
    best = fitter.best(np.array([0.6, 0.5]))
    emulator, _ = fitter.emulator(best)
    found = sampled(fitter, emulator, np.ones((1, 2)), seed=1, reason="bent")
    assert found.is_checked
    a, b = np.meshgrid(*[np.linspace(-2.0, 2.0, 801)] * 2, indexing="ij")
    first, second = banana(np.array([a, b]))[:, 0]
    density = np.exp(-0.5 * ((first - 0.5) / 0.4) ** 2 - 0.5 * ((second - 0.5) / 0.1) ** 2)
    for place, axis in enumerate((a[:, 0], b[0])):
        below = np.cumsum(density.sum(axis=1 - place))
        for share in (0.05, 0.5, 0.95):
            expected = np.interp(share, below / below[-1], axis)
            drawn = unknowns[place].value(np.quantile(found.draws[..., place], share))
            assert drawn == pytest.approx(expected, abs=0.06)
