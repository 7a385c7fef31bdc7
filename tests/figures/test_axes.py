"""Figures of one panel draw into axes of the user's own."""

from collections.abc import Callable

import matplotlib.pyplot as plt
import pytest
import xarray as xr
from matplotlib.figure import Figure

from fretwear import figures


@pytest.mark.parametrize(
    "draw",
    [
        figures.pressure_profiles,
        figures.shear_profiles,
        figures.gap_profiles,
        figures.wear_profiles,
        figures.wear_rate_profiles,
        figures.wear_map,
        figures.contact_half_width,
        figures.stick_half_width,
        figures.wear_volume,
        figures.dissipated_energy,
    ],
)
def test_a_panel_is_drawn_into_axes_that_are_there(
    draw: Callable[..., Figure], smooth: xr.Dataset
) -> None:
    figure, (left, right) = plt.subplots(1, 2)
    try:
        assert draw(smooth, axes=right) is figure
        assert right.has_data()
        assert not left.has_data()
        assert "(" in right.get_ylabel()
    finally:
        plt.close(figure)


def test_a_study_of_many_panels_does_not_go_into_one_axes(small_study) -> None:
    figure = Figure()
    with pytest.raises(ValueError, match=r"takes 4 panels.*dataset\.isel"):
        figures.wear_volume(small_study.summary, axes=figure.subplots())
    part = small_study.summary.isel(load=0, friction=0)
    assert figures.wear_volume(part, axes=figure.subplots()).axes


@pytest.mark.parametrize("select", [{"cycle": 1000}, {"cycle": [0, 1000]}])
def test_one_selected_snapshot_has_its_profile(
    select: dict[str, object], smooth: xr.Dataset
) -> None:
    figure = figures.pressure_profiles(smooth.sel(select))
    drawn = [
        line for line in figure.axes[0].get_lines() if not str(line.get_label()).startswith("_")
    ]
    assert drawn[-1].get_label() == "1000"
    alone = figures.pressure_profiles(smooth, cycles=1000)
    assert alone.axes[0].get_ylabel() == "Pressure (MPa)"
