"""Waves and random surfaces: the spectrum asked for, the same surface on every grid."""

from dataclasses import replace

import numpy as np
import pytest

from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.roughness import BothRough, SelfAffineRoughness, WavyRoughness

from .problems import fretting, near

RADIUS, AMPLITUDE = 10e-3, 0.2e-6
SLOPE_X, SLOPE_Y = np.tan(np.deg2rad(5.7)), np.tan(np.deg2rad(1.0))
WAVES = WavyRoughness(AMPLITUDE, np.arctan(SLOPE_X), np.arctan(SLOPE_Y))


def test_waves_are_those_of_the_study_and_rise_with_the_mean_slope():
    x, y = np.linspace(-3e-5, 3e-5, 41), np.linspace(-8e-5, 8e-5, 37)
    expected = AMPLITUDE * np.outer(
        np.sin(np.pi / 2 + 0.5 * np.pi * SLOPE_X / AMPLITUDE * x),
        np.cos(0.5 * np.pi * SLOPE_Y / AMPLITUDE * y),
    )
    # One rounding of the sine's argument, which reaches a few tens.
    np.testing.assert_allclose(WAVES.height(x[:, None], y), expected, atol=1e-14 * AMPLITUDE)
    length_x, length_y = 4 * AMPLITUDE / SLOPE_X, 4 * AMPLITUDE / SLOPE_Y
    crest = np.array([0.0])
    along_x = WAVES.height(np.linspace(0, length_x, 20001), crest)
    along_y = WAVES.height(crest, np.linspace(0, length_y, 20001))
    # The path up and down of a whole wave, 4 A, over its length; crests fall on sample points.
    assert np.abs(np.diff(along_x)).sum() / length_x == near(SLOPE_X, rel=1e-7)
    assert np.abs(np.diff(along_y)).sum() / length_y == near(SLOPE_Y, rel=1e-7)
    assert along_x[-1] == near(AMPLITUDE, rel=1e-12)
    ridges = WavyRoughness(AMPLITUDE, 0.0, np.arctan(SLOPE_Y)).height(
        np.array([0.0, 1.0, 2.0])[:, None] * 1e-5, np.linspace(0.0, 5e-5, 9)
    )
    np.testing.assert_array_equal(ridges[1:], ridges[:-1])
    assert np.ptp(ridges[0]) > AMPLITUDE


def test_a_rough_sphere_is_even_the_sum_of_both_and_reaches_as_far_as_it_rises():
    """Of the waves it has the means over cells, which are less by sin(kΔ/2)/(kΔ/2) each way."""
    window = Grid((12, 10), (2e-6, 5e-6), even=(False, False))
    rough, smooth = (fretting(roughness=each).unworn(window) for each in (WAVES, None))
    cell_x, cell_y = window.spacing
    less = np.sinc(WAVES.wavenumber_x * cell_x / (2 * np.pi))
    less *= np.sinc(WAVES.wavenumber_y * cell_y / (2 * np.pi))
    mean = less * WAVES.height(window.x[:, None], window.y)
    # Simpson's rule errs by (kΔ)⁴/2880.
    np.testing.assert_allclose(rough - smooth, mean, rtol=3e-3)
    np.testing.assert_allclose(rough, rough[::-1], rtol=1e-12)
    np.testing.assert_allclose(rough, rough[:, ::-1], rtol=1e-12)
    approach = 1.7e-6
    for roughness, height in ((None, approach), (WAVES, approach + AMPLITUDE)):
        for reach in fretting(roughness=roughness).reach(approach):
            assert reach == near(np.sqrt(2 * RADIUS * height), rel=1e-11)


def test_of_two_rough_surfaces_the_gap_has_both():
    random = SelfAffineRoughness(0.1e-6, 0.8, 60e-6, 30e-6, 3)
    half = WavyRoughness(0.5 * AMPLITUDE, *(np.arctan(0.5 * s) for s in (SLOPE_X, SLOPE_Y)))
    x, y = np.linspace(-3e-5, 3e-5, 11)[:, None], np.linspace(-8e-5, 8e-5, 7)
    twice, mixed = BothRough(half, half), BothRough(WAVES, random)
    np.testing.assert_allclose(twice.height(x, y), WAVES.height(x, y), atol=1e-14 * AMPLITUDE)
    np.testing.assert_array_equal(mixed.height(x, y), WAVES.height(x, y) + random.height(x, y))
    assert (twice.even, mixed.even) == ((True, True), (False, False))
    assert twice.highest == near(AMPLITUDE, rel=1e-14)
    # Whatever asks for cells asks for those of the finer one, along each axis.
    assert mixed.finest == (min(WAVES.finest[0], 30e-6), min(WAVES.finest[1], 30e-6))
    assert mixed.wavelengths == (min(WAVES.finest[0], 60e-6), min(WAVES.finest[1], 60e-6))


ROLLOFF, SHORTEST, HEIGHT = 80e-6, 20e-6, 0.2e-6
SURFACE = SelfAffineRoughness(HEIGHT, 0.8, ROLLOFF, SHORTEST, seed=7)
PERIOD = 16 * ROLLOFF


def moment(power, hurst):
    """∫ qᵏ C(q) dq of the continuous spectrum, up to the factor that all moments share."""
    rolloff, shortest = 2 * np.pi / ROLLOFF, 2 * np.pi / SHORTEST
    falling = power - 2 - 2 * hurst + 1
    return (
        rolloff ** (power + 1) / (power + 1)
        + rolloff ** (2 + 2 * hurst) * (shortest**falling - rolloff**falling) / falling
    )


@pytest.fixture(scope="module")
def spectra():
    """Power of the heights of 32 seeds over a period, by wave numbers of the period."""
    count = 3 * round(PERIOD / SHORTEST)
    x = (np.arange(count) + 0.5) * PERIOD / count
    heights = (replace(SURFACE, seed=seed).height(x[:, None], x) for seed in range(32))
    return [np.abs(np.fft.fft2(height) / height.size) ** 2 for height in heights]


def wave_numbers(count):
    numbers = np.fft.fftfreq(count, 1 / count)
    return np.hypot(numbers[:, None], numbers)


def test_the_spectrum_is_flat_falls_with_the_hurst_exponent_and_ends(spectra):
    number = wave_numbers(len(spectra[0]))
    wanted = HEIGHT * np.sqrt(moment(3, 0.8) / moment(1, 0.8))
    assert SURFACE.rms_slope == near(wanted, rel=2e-3)
    for power in spectra:
        assert np.sqrt(power.sum()) == near(HEIGHT, rel=1e-9)
        slope = np.sqrt((power * (2 * np.pi * number / PERIOD) ** 2).sum())
        assert slope == near(SURFACE.rms_slope, rel=1e-9)
    mean, number = np.mean(spectra, axis=0), wave_numbers(len(spectra[0]))
    falling = (number > 16) & (number < 63.5)
    slope = np.polyfit(np.log(number[falling]), np.log(mean[falling]), 1)[0]
    assert slope == pytest.approx(-2 - 2 * 0.8, abs=0.005)
    flat = (number > 0) & (number < 16)
    np.testing.assert_allclose(mean[flat], mean[flat].mean(), rtol=1e-9)
    assert mean[number > 64.5].max() < 1e-20 * mean.max()


def test_heights_of_a_point_are_normally_distributed_over_the_seeds():
    heights = [replace(SURFACE, seed=seed).height(0.0, 0.0) for seed in range(400)]
    assert np.mean(heights) == pytest.approx(0.0, abs=4 * HEIGHT / 20)
    # Of a normal distribution 68 % lie within the root mean square; four deviations of the share.
    inside = np.mean(np.abs(heights) < HEIGHT)
    assert inside == pytest.approx(0.683, abs=4 * np.sqrt(0.683 * 0.317 / 400))
    with pytest.raises(ValueError, match="at most the roll-off wavelength"):
        replace(SURFACE, shortest_wavelength=2 * ROLLOFF)
    with pytest.raises(ValueError, match="200 times as long as the shortest"):
        replace(SURFACE, shortest_wavelength=ROLLOFF / 200)


def test_the_surface_is_the_same_at_every_cell_size_and_with_shorter_waves():
    coarse = Grid((40, 30), (3e-6, 3e-6), (False, False))
    # Cells a third as large have every third centre in common, larger windows the inner cells.
    fine = Grid((180, 150), (1e-6, 1e-6), (False, False))
    height = SURFACE.height(coarse.x[:, None], coarse.y[None, :])
    there = SURFACE.height(fine.x[:, None], fine.y[None, :])[31:-29:3, 31:-29:3]
    np.testing.assert_allclose(height, there, atol=1e-12 * HEIGHT)
    x, y = np.meshgrid(coarse.x[:3], coarse.y[:2], indexing="ij")
    np.testing.assert_allclose(SURFACE.height(x, y), height[:3, :2], atol=1e-12 * HEIGHT)
    x = np.linspace(-PERIOD / 2, PERIOD / 2, 320, endpoint=False)
    more = replace(SURFACE, shortest_wavelength=SHORTEST / 2)
    height, other = (surface.height(x[:, None], x) for surface in (SURFACE, more))
    kept = np.fft.fft2(other)
    kept[wave_numbers(320) > 64.001] = 0.0
    same = np.fft.ifft2(kept).real
    np.testing.assert_allclose(same / same.std(), height / height.std(), atol=1e-9)


def test_heights_of_cells_are_means_over_them():
    cell, points = (4e-6, 3e-6), np.polynomial.legendre.leggauss(8)
    window = Grid((20, 16), cell, (False, False))
    laid = replace(SURFACE, anisotropy=2.0)
    mean = np.zeros(window.shape)
    for at_x, weight_x in zip(*points, strict=True):
        for at_y, weight_y in zip(*points, strict=True):
            x, y = window.x + 0.5 * at_x * cell[0], window.y + 0.5 * at_y * cell[1]
            mean += 0.25 * weight_x * weight_y * laid.height(x[:, None], y[None, :])
    found = laid.mean_height(window.x, window.y, cell)
    np.testing.assert_allclose(found, mean, atol=1e-12 * HEIGHT)
    both = BothRough(laid, SURFACE).mean_height(window.x, window.y, cell)
    np.testing.assert_array_equal(both, found + SURFACE.mean_height(window.x, window.y, cell))


@pytest.mark.parametrize(("anisotropy", "along_x", "along_y"), [(4.0, 4.0, 1.0), (0.25, 1.0, 4.0)])
def test_along_the_lay_all_wavelengths_are_longer(anisotropy, along_x, along_y):
    laid = replace(SURFACE, anisotropy=anisotropy)
    x, y = np.linspace(0, 1e-3, 50)[:, None], np.linspace(0, 3e-4, 40)
    expected = SURFACE.height(x / along_x, y / along_y)
    np.testing.assert_allclose(laid.height(x, y), expected, atol=1e-12 * HEIGHT)
    assert laid.finest == near((SHORTEST * along_x, SHORTEST * along_y), rel=1e-12)
    squares = SURFACE.rms_slope**2 / 2 * (1 / along_x**2 + 1 / along_y**2)
    assert laid.rms_slope == near(np.sqrt(squares), rel=1e-6)
