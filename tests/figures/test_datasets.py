"""What is no case is refused with words on what to give instead."""

from collections.abc import Callable

import pytest
import xarray as xr
from matplotlib.figure import Figure

from fretwear import figures
from fretwear.running.simulate import Result

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
def test_what_is_no_dataset_is_refused(
    draw: Callable[..., object], given: object, remedy: str
) -> None:
    with pytest.raises(TypeError, match=remedy):
        draw(given)


@pytest.mark.parametrize("draw", OF_A_CASE)
def test_the_history_of_a_case_has_no_fields(
    draw: Callable[..., object], smooth_run: Result
) -> None:
    with pytest.raises(ValueError, match=r"history of a case.*open_case opens the case"):
        draw(smooth_run.history)


@pytest.mark.parametrize("draw", [figures.wear_map, figures.animation])
def test_a_merged_study_has_no_fields(draw: Callable[..., object], small_study) -> None:
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
def test_cases_to_compare_have_titles(compare: Callable[..., Figure], smooth: xr.Dataset) -> None:
    for wrong in ([smooth, smooth], smooth):
        with pytest.raises(TypeError, match="given by their titles"):
            compare(wrong)
    with pytest.raises(ValueError, match="no case"):
        compare({})
    with pytest.raises(TypeError, match="open the file first"):
        compare({"a": "a.nc", "b": "b.nc"})


def test_an_unknown_quantity_is_refused_with_those_there_are(smooth: xr.Dataset) -> None:
    with pytest.raises(ValueError, match="'pressure', 'shear_traction'"):
        figures.compare_profiles({"a": smooth}, "pressure_profiles")
