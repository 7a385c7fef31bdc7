import numpy as np
import pytest

from fretwear_fit.estimate import root_of
from fretwear_fit.noise import Noise, NoiseEvidence

from ..studies import near

X = np.sort(np.random.default_rng(3).uniform(0.0, 300e-6, 80))


@pytest.mark.parametrize(("length", "white"), [(0.0, 0.0), (5e-6, 0.0), (40e-6, 0.0), (40e-6, 0.3)])
def test_whitening_is_the_inverse_root_of_the_covariance(length, white):
    noise = Noise(30e-9, length, white)
    apart = np.abs(X[:, None] - X)
    correlation = np.exp(-apart / length) if length else np.eye(X.size)
    correlation = white * np.eye(X.size) + (1.0 - white) * correlation
    columns = noise.whitened(X, np.eye(X.size))
    inverse = np.linalg.inv(30e-9**2 * correlation)
    assert np.allclose(columns.T @ columns, inverse, rtol=1e-6, atol=1e-9 * np.abs(inverse).max())
    sign, determinant = np.linalg.slogdet(correlation)
    assert sign == 1.0
    expected = determinant + 2 * X.size * np.log(30e-9)
    assert noise.log_determinant(X) == pytest.approx(expected, rel=1e-9)


def test_size_and_length_of_noise_are_recovered_beside_a_tilted_base_line():
    x = np.linspace(0.0, 1e-3, 2000)
    noise = Noise(30e-9, 10e-6)
    readings = noise.drawn(x, np.random.default_rng(5)) + 1e-7 + 3e-4 * x
    found = NoiseEvidence(x, readings, np.vander(x, 2)).best()
    # About 100 correlation lengths: sizes are known to 1/√100, lengths to twice that.
    assert found.size == near(noise.size, rel=0.2)
    assert found.length == near(noise.length, rel=0.4)


def test_white_noise_on_correlated_noise_is_told_apart():
    """As correlated noise alone it would be of short length, and its mean known too well."""
    x, ones = np.linspace(0.0, 1e-3, 800), np.ones((800, 1))
    noise = Noise(30e-9, 10e-6, 0.5)
    found = NoiseEvidence(x, noise.drawn(x, np.random.default_rng(7)), ones).best()
    assert found.white == pytest.approx(0.5, abs=0.15)
    assert found.length == near(noise.length, rel=0.5)
    told, true = (each.whitened(x, ones) for each in (found, noise))
    assert (told**2).sum() == near((true**2).sum(), rel=0.5)


def test_a_size_that_few_readings_tell_widens_intervals_as_student_derived():
    """White noise with a known length and ten degrees of freedom: quantiles of t, not normal."""
    readings = np.random.default_rng(1).normal(size=12)
    evidence = NoiseEvidence(np.arange(12.0), readings, np.vander(np.arange(12.0), 2), length=0.0)
    shares = np.column_stack([np.full(400, 0.5), (np.arange(400) + 0.5) / 400])
    sizes = np.array([noise.size for noise in evidence.drawn(shares)])
    spread = (sizes / evidence.best().size) ** 2
    for level, quantile in ((0.68, 1.046), (0.9, 1.812), (0.95, 2.228)):  # of t with ν = 10
        assert root_of(level, spread) == pytest.approx(quantile, rel=0.01)
    assert root_of(0.95, np.ones(1)) == pytest.approx(1.95996, rel=1e-5)


def test_noise_is_correlated_over_no_more_than_0_3_of_its_readings():
    """A straight line about its mean, as alike over long distances as readings can be."""
    x = np.linspace(0.0, 1e-3, 50)
    evidence = NoiseEvidence(x, 1e-4 * x, np.ones((50, 1)))
    assert evidence.best().length == near(0.3e-3, rel=1e-3)
    (longest,) = evidence.drawn(np.array([[1.0, 0.5]]))
    assert longest.length == near(0.3e-3, rel=1e-9)
