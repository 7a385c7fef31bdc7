"""The unworn gap: a paraboloid and the waves of the study."""

import numpy as np

from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.roughness import BothRough, SelfAffineRoughness, WavyRoughness
from fretwear.mechanics.surfaces import Sphere

from .problems import fretting, near

RADIUS, AMPLITUDE = 10e-3, 0.2e-6
SLOPE_X, SLOPE_Y = np.tan(np.deg2rad(5.7)), np.tan(np.deg2rad(1.0))
WAVES = WavyRoughness(AMPLITUDE, np.arctan(SLOPE_X), np.arctan(SLOPE_Y))


def test_smooth_sphere_is_the_paraboloid_of_hertz():
    window = Grid((5, 7), (1e-6, 2e-6))
    shape = Sphere(RADIUS).gap(window.x[:, None], window.y)
    assert shape.shape == (5, 7)
    assert shape[3, 4] == near(((3.5e-6) ** 2 + (9e-6) ** 2) / (2 * RADIUS), rel=1e-14)


def test_waves_are_those_of_the_study():
    x, y = np.linspace(-3e-5, 3e-5, 41), np.linspace(-8e-5, 8e-5, 37)
    expected = AMPLITUDE * np.outer(
        np.sin(np.pi / 2 + 0.5 * np.pi * SLOPE_X / AMPLITUDE * x),
        np.cos(0.5 * np.pi * SLOPE_Y / AMPLITUDE * y),
    )
    # One rounding of the sine's argument, which reaches a few tens.
    np.testing.assert_allclose(WAVES.height(x[:, None], y), expected, atol=1e-14 * AMPLITUDE)


def test_waves_rise_with_the_mean_slope_along_each_direction():
    length_x, length_y = 4 * AMPLITUDE / SLOPE_X, 4 * AMPLITUDE / SLOPE_Y
    crest = np.array([0.0])
    along_x = WAVES.height(np.linspace(0, length_x, 20001), crest)
    along_y = WAVES.height(crest, np.linspace(0, length_y, 20001))
    # The path up and down of a whole wave, 4 A, over its length; crests fall on sample points.
    assert np.abs(np.diff(along_x)).sum() / length_x == near(SLOPE_X, rel=1e-7)
    assert np.abs(np.diff(along_y)).sum() / length_y == near(SLOPE_Y, rel=1e-7)
    assert along_x[-1] == near(AMPLITUDE, rel=1e-12)


def test_rough_sphere_is_even_and_the_sum_of_both():
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


def test_a_slope_of_zero_makes_ridges():
    ridges = WavyRoughness(AMPLITUDE, 0.0, np.arctan(SLOPE_Y)).height(
        np.array([0.0, 1.0, 2.0])[:, None] * 1e-5, np.linspace(0.0, 5e-5, 9)
    )
    np.testing.assert_array_equal(ridges[1:], ridges[:-1])
    assert np.ptp(ridges[0]) > AMPLITUDE


def test_the_reach_of_the_surface_is_where_it_rises_above_an_approach():
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
