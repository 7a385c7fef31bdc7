"""Profiles show the data, name their units and cycles, and can be read."""

import numpy as np
import pytest

from fretwear import figures
from fretwear.data.dataset import mirrored
from fretwear.figures.datasets import half_profiles

KINDS = {
    "pressure_profiles": ("pressure", "Pressure (MPa)"),
    "shear_profiles": ("shear_traction", "Shear traction (MPa)"),
    "gap_profiles": ("gap", "Gap (µm)"),
    "wear_profiles": ("wear_depth", "Wear depth (µm)"),
    "wear_rate_profiles": ("wear_rate", "Wear depth per cycle (pm)"),
}
SIZE = {"MPa": 1e6, "µm": 1e-6, "pm": 1e-12}


def _curves(axes):
    """Return the thick curves: those labelled with a cycle."""
    return [
        (line.get_xdata(), line.get_ydata())
        for line in axes.get_lines()
        if not str(line.get_label()).startswith("_")
    ]


@pytest.mark.parametrize("name", KINDS)
def test_a_smooth_profile_is_the_line_of_cells_nearest_the_middle(name, smooth):
    variable, label = KINDS[name]
    axes = getattr(figures, name)(smooth).axes[0]
    assert axes.get_ylabel() == label
    assert axes.get_xlabel() == "x (µm)"
    curves = _curves(axes)
    assert len(curves) == smooth.sizes["cycle"]
    size = SIZE[label.split("(")[1].rstrip(")")]
    for (x, y), expected in zip(curves, smooth[variable].isel(y=0).values, strict=True):
        stored = slice(0, smooth.sizes["x"])
        np.testing.assert_allclose(x[stored], smooth["x"].values * 1e6)
        np.testing.assert_allclose(y[stored], expected / size, rtol=1e-6)


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize(("surface", "columns"), [("smooth", 1), ("rough", 1), ("rough", 2)])
def test_every_text_stands_free_and_every_cycle_is_named(
    name, surface, columns, request, check_texts
):
    case = request.getfixturevalue(surface)
    words = check_texts(getattr(figures, name)(case, columns=columns))
    named = {part for text in words for part in text.replace("cycle ", "").split(", ")}
    assert {"0", "1", "10", "100", "1000"} <= named


def test_a_figure_is_as_wide_as_journal_columns_and_wear_is_drawn_downwards(smooth):
    for columns, millimetres in ((1, 90.0), (2, 190.0)):
        figure = figures.pressure_profiles(smooth, columns=columns)
        assert figure.get_figwidth() * 25.4 == pytest.approx(millimetres)
    with pytest.raises(ValueError, match="columns = 3"):
        figures.pressure_profiles(smooth, columns=3)
    low, high = figures.wear_profiles(smooth).axes[0].get_ylim()
    assert low > high == 0.0


def test_a_rough_profile_has_its_raw_line_and_an_envelope_above(rough):
    axes = figures.pressure_profiles(rough).axes[0]
    raw = [line.get_ydata() for line in axes.get_lines() if line.get_label() == "_raw"]
    thick = [y for _, y in _curves(axes)]
    assert len(raw) == len(thick) == rough.sizes["cycle"]
    for line, envelope, measured in zip(
        raw, thick, rough["pressure"].isel(y=0).values, strict=True
    ):
        np.testing.assert_allclose(line, measured / 1e6, rtol=1e-6)
        assert np.nanmax(envelope) == pytest.approx(line.max(), rel=1e-6)
        assert (line > 0.0).sum() < (envelope > 0.0).sum()


def test_the_gap_beyond_the_cells_stored_is_that_of_a_wider_window(rough):
    cut = rough.isel(x=slice(0, -4))
    known = rough["gap"].isel(y=0)
    found = half_profiles(cut, "gap", rough["cycle"].values.tolist(), reach=float(rough["x"][-1]))
    # Cells far away act like forces at their centres.
    tolerance = 1e-4 * float(known.max())
    assert found.values[:, : known.sizes["x"]] == pytest.approx(known.values, abs=tolerance)
    # A contact that is not even has two sides.
    uneven = mirrored(cut).assign(gap=lambda case: case["gap"] + 1e-8 * (case["x"] > 0.0))
    both = half_profiles(uneven, "gap", 100, reach=float(rough["x"][-1]))
    assert both.x == pytest.approx(-both.x[::-1])
    outside = np.abs(both.x) > cut["x"].values[-1]
    assert outside.any()
    assert both.values[:, outside] == pytest.approx(
        both.values[:, ::-1][:, outside] + 1e-8 * np.sign(both.x[outside]), abs=1e-12
    )


def test_only_the_cycles_and_the_case_asked_for_are_drawn(smooth, small_study):
    assert len(_curves(figures.gap_profiles(smooth, [0, 100]).axes[0])) == 2
    with pytest.raises(ValueError, match=r"no snapshot at \[50\].*\[0, 1, 10, 100, 1000\]"):
        figures.pressure_profiles(smooth, [0, 50])
    with pytest.raises(ValueError, match="select one point first"):
        figures.pressure_profiles(small_study.summary)
    point = small_study.summary.isel(load=1, friction=1, roughness_amplitude=0, plastic_limit=0)
    curves = _curves(figures.pressure_profiles(point).axes[0])
    np.testing.assert_allclose(curves[0][1].max() / 1e3, 1.004, rtol=0.01)


def test_panels_have_one_case_each_and_one_key_to_the_cycles(smooth, rough, check_texts):
    figure = figures.compare_profiles(
        {"smooth": smooth, "rough": rough, "again": smooth}, "wear_depth"
    )
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["smooth", "rough", "again"]
    words = check_texts(figure)
    assert words.count("cycle") == 1
    assert words.count("x (µm)") == 2


def _marks_above(axes):
    return sum(line.get_label() == "_above" for line in axes.get_lines())


def test_the_endless_peak_of_elastic_bodies_is_cut_and_marked(smooth):
    steep = smooth.copy(deep=True)
    steep["pressure"][-1, 20] = 30.0 * float(smooth["pressure"][0].max())
    for case, marked in ((steep, 1), (steep.assign_coords(plastic_limit=1e12), 0)):
        axes = figures.pressure_profiles(case).axes[0]
        highest = float(case["pressure"].isel(y=0).max()) / 1e6
        assert _marks_above(axes) == marked
        assert (axes.get_ylim()[1] < highest) == bool(marked)
    alone = figures.pressure_profiles(steep, cycles=[1000]).axes[0]
    assert _marks_above(alone) == 0
