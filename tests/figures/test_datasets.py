"""Datasets are taken as they are meant, what is none is refused with what to give instead."""

import numpy as np
import pytest
import xarray as xr

from fretwear import figures
from fretwear.figures.datasets import half_profiles, peak_envelope, representative_cycles, wave_mean

PROFILES = [figures.pressure_profiles, figures.wear_profiles]
OF_A_CASE = [*PROFILES, figures.wear_map, figures.overview, figures.animation]


@pytest.mark.parametrize("draw", [*OF_A_CASE, figures.wear_volume])
@pytest.mark.parametrize(
    ("given", "remedy"),
    [
        ("case.nc", r"fretwear\.open_case\('case\.nc'\)"),
        (xr.DataArray([1.0]), "whole dataset"),
        ({"a": xr.Dataset()}, "compare_"),
        (None, "simulate"),
    ],
)
def test_what_is_no_dataset_is_refused(draw, given, remedy):
    with pytest.raises(TypeError, match=remedy):
        draw(given)


@pytest.mark.parametrize("draw", OF_A_CASE)
def test_histories_and_merged_studies_have_no_fields(draw, smooth_run, small_study):
    with pytest.raises(ValueError, match=r"history of a case.*open_case opens the case"):
        draw(smooth_run.history)
    if draw in (figures.wear_map, figures.animation):
        with pytest.raises(ValueError, match=r"merged study.*open the case with open_case"):
            draw(small_study.summary)


@pytest.mark.parametrize(
    "compare",
    [
        lambda cases: figures.compare_profiles(cases, "pressure"),
        figures.compare_wear_maps,
        figures.compare_cases,
    ],
)
def test_cases_to_compare_have_titles(compare, smooth):
    for wrong in ([smooth, smooth], smooth):
        with pytest.raises(TypeError, match="given by their titles"):
            compare(wrong)
    with pytest.raises(ValueError, match="no case"):
        compare({})
    with pytest.raises(TypeError, match="open the file first"):
        compare({"a": "a.nc", "b": "b.nc"})
    with pytest.raises(ValueError, match="'pressure', 'shear_traction'"):
        figures.compare_profiles({"a": smooth}, "pressure_profiles")


WAVELENGTH = 8.37
X = (np.arange(400) + 0.5) * 0.25
SLOW = np.sqrt(np.maximum(0.0, 1.0 - (X / 80.0) ** 2))


@pytest.mark.parametrize("phase", [0.0, np.pi])
def test_the_envelope_goes_through_the_peaks_whatever_their_phase(phase):
    values = SLOW * (1.0 + np.cos(2.0 * np.pi * X / WAVELENGTH + phase))
    inside = (X > WAVELENGTH) & (X < 70.0)
    envelope = peak_envelope(X, values, WAVELENGTH)
    # Between crests the cubics leave the slow factor by about its curvature over a wave.
    np.testing.assert_allclose(envelope[inside], 2.0 * SLOW[inside], rtol=0.02)


def test_envelope_and_mean_are_those_of_a_profile_without_waves():
    # At most the slope of the profile times a wavelength lies between two of its knots.
    inside = X < 60.0
    envelope = peak_envelope(X, SLOW, WAVELENGTH)
    np.testing.assert_allclose(envelope[inside], SLOW[inside], atol=0.02)
    values = np.where(X > 50.0, 1.0 + np.cos(2.0 * np.pi * X / WAVELENGTH), 0.0)
    envelope = peak_envelope(X, values, WAVELENGTH)
    assert (envelope[X < 50.0 - 1.5 * WAVELENGTH] == 0.0).all()
    values = 3.0 + np.cos(2.0 * np.pi * X / WAVELENGTH)
    mean = wave_mean(X, values, WAVELENGTH)
    assert mean.shape == X.shape
    # A window of whole cells misses the wavelength by up to half a cell in 33: twice averaged,
    # less than 0.1 % of the wave is left.
    known = np.isfinite(mean)
    assert known[: -round(1.1 * WAVELENGTH / 0.25)].all()
    np.testing.assert_allclose(mean[known], 3.0, atol=1e-3)
    narrow = np.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(wave_mean(X[:3], narrow, WAVELENGTH), narrow)


def test_few_snapshots_are_all_shown_and_many_thinned_evenly_in_the_fourth_root():
    assert representative_cycles([1000, 0, 1]) == (0, 1, 1000)
    chosen = representative_cycles(range(10001), most=5)
    assert chosen[0] == 0
    assert chosen[-1] == 10000
    steps = np.diff(np.power(chosen, 0.25))
    assert steps.max() / steps.min() < 1.1


def test_profiles_lie_at_positive_x_and_know_their_waves(smooth, rough):
    plain, wavy = half_profiles(smooth, "pressure"), half_profiles(rough, "pressure")
    assert (plain.x > 0.0).all()
    assert not plain.is_wavy
    assert wavy.is_wavy
    assert wavy.wavelength == pytest.approx(4.0 * 0.3e-6 / np.tan(np.deg2rad(1.8)))
    coarse = rough.isel(x=slice(None, None, 4))
    assert not half_profiles(coarse, "pressure").is_wavy, "the cells do not resolve the waves"
