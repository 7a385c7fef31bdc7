"""Profiles, maps and other figures of cases: what they draw is the data, in units of the labels."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.image import imread

from fretwear import fatigue, figures, stress
from fretwear.data.atomic import DataFileError
from fretwear.data.dataset import line_near_the_middle
from fretwear.data.labels import mirrored
from fretwear.figures.style import JournalFigure
from fretwear.units import number_text

UNITS = {"pressure": 1e6, "shear_traction": 1e6, "wear_depth": 1e-6, "gap": 1e-6}


@pytest.mark.parametrize("name", ["pressure", "shear_traction", "wear_depth"])
def test_a_smooth_profile_is_the_line_of_cells_nearest_the_middle_from_its_axis_on(name, smooth):
    figure = figures.field_profiles(smooth, name)
    (axes,) = figure.axes
    unit = 1e-9 if "(nm)" in axes.get_ylabel() else UNITS[name]
    expected = line_near_the_middle(smooth[name]).transpose("cycle", "x").values
    lines = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
    assert [line.get_label() for line in lines] == ["0", "1", "10", "100", "1000"]
    for line, values in zip(lines, expected, strict=True):
        x, y = line.get_data()
        assert x[0] == -x[1]  # the cell on the other side, so that no gap lies beside the axis
        assert y[0] == y[1]
        np.testing.assert_allclose(1e-6 * x[1:], smooth["x"], rtol=1e-6)
        np.testing.assert_allclose(unit * y[1:], values, rtol=1e-6)
    assert figure.get_figwidth() == pytest.approx(90.0 / 25.4)
    assert axes.get_xlabel() == "x (µm)"
    assert axes.yaxis_inverted() == (name == "wear_depth")


def test_slip_is_drawn_only_where_surfaces_touch(smooth):
    lines = figures.field_profiles(smooth, "slip").axes[0].get_lines()
    for curve, edge in zip(lines, 1e6 * smooth["contact_half_width_x"].values, strict=True):
        x, slip = curve.get_data()
        assert np.nanmax(slip) > 0.0
        assert np.isnan(slip[x > edge + 4.0]).all()


def test_a_rough_profile_is_filled_before_the_line_of_the_first(rough):
    axes = figures.field_profiles(rough, "pressure").axes[0]
    first, last = axes.get_lines()
    pressure = 1e-6 * line_near_the_middle(rough["pressure"]).transpose("cycle", "x").values
    np.testing.assert_allclose(first.get_ydata()[1:], pressure[0], rtol=1e-6)
    np.testing.assert_allclose(last.get_ydata()[1:], pressure[-1], rtol=1e-6)
    (strip,) = axes.get_images()
    state = line_near_the_middle(rough["contact_state"]).isel(cycle=-1)
    np.testing.assert_array_equal(strip.get_array()[0], state)


@pytest.mark.slow
def test_cases_stand_side_by_side_with_letters(smooth, rough, check_texts):
    figure = figures.field_profiles({"smooth": smooth, "rough": rough}, "pressure")
    assert [axes.get_title(loc="left")[-6:].strip() for axes in figure.axes] == ["smooth", "rough"]
    check_texts(figure)


def test_a_singular_peak_is_cut_and_its_value_is_written(smooth):
    singular = smooth.copy(deep=True)
    singular["peak_pressure_error"] = singular["peak_pressure"] * np.inf
    singular["pressure"][-1, 10, 0] = 4.0 * float(singular["pressure"].max())
    (axes,) = figures.field_profiles(singular, "pressure").axes
    highest = 1e-6 * float(singular["pressure"].max())
    assert axes.get_ylim()[1] < highest
    assert axes.texts[0].get_text().strip() == f"↑ {number_text(highest, 3)} MPa"


@pytest.mark.parametrize("draw", [figures.overview, figures.wear_map, figures.fretting_loops])
def test_what_is_no_dataset_of_a_case_is_told_what_makes_one(draw, smooth):
    for computed in (draw, stress, fatigue):
        with pytest.raises(TypeError, match=r"not str: fretwear\.open_case"):
            computed("case.nc")
    with pytest.raises(ValueError, match=r"a line contact has no map; field_profiles"):
        figures.wear_map(smooth.isel(y=0))
    study = smooth.assign(status=("load", [0, 0]))
    with pytest.raises(ValueError, match=r"2 points of a study|no variable"):
        draw(study)


def test_a_figure_that_is_not_there_names_those_of_any_result():
    with pytest.raises(AttributeError, match="scalar_history draws any result"):
        figures.wear_volume  # noqa: B018


@pytest.mark.parametrize(
    "drawn", [("wear_map",), ("field_profiles", "pressure"), ("scalar_history", "wear_volume")]
)
def test_a_panel_is_drawn_into_axes_that_are_there(drawn, smooth):
    figure = Figure()
    left, right = figure.subplots(1, 2)
    name, *quantity = drawn
    assert getattr(figures, name)(smooth, *quantity, ax=right) is figure
    assert right.has_data()
    assert not left.has_data()


def test_the_map_is_the_whole_scar_to_scale_with_the_edges_of_the_zones(smooth):
    figure = figures.wear_map(smooth)
    axes, bar = figure.axes
    (image,) = axes.get_images()
    depth = mirrored(smooth[["wear_depth"]].isel(cycle=-1))["wear_depth"].transpose("y", "x")
    unit = 1e-9 if "(nm)" in bar.get_ylabel() else 1e-6
    np.testing.assert_allclose(unit * np.asarray(image.get_array()), depth, rtol=1e-6)
    assert axes.get_aspect() == 1.0
    edges = [collection.get_paths()[0].vertices for collection in axes.collections]
    for zone, edge in zip(("contact", "stick"), edges, strict=True):
        radius = 1e6 * float(smooth[f"{zone}_half_width_x"][-1])
        np.testing.assert_allclose(np.hypot(*edge.T), radius, atol=4.0)  # a cell


def test_scars_of_very_different_depths_are_seen_on_one_scale(smooth):
    shallow = smooth.assign(wear_depth=smooth["wear_depth"] / 100.0)
    figure = figures.wear_map({"deep": smooth, "shallow": shallow})
    deep, flat = (axes.get_images()[0] for axes in figure.axes[:2])
    assert deep.norm is flat.norm
    assert flat.norm(np.max(flat.get_array())) == pytest.approx(0.1)
    assert "square root" in figure.caption


@pytest.mark.slow
def test_all_of_a_case_on_one_page(smooth_run, check_texts):
    figure = figures.overview(smooth_run.dataset)
    zones = figure.axes[5]
    contact, stick = zones.get_lines()
    width = 1e6 * smooth_run.dataset["contact_radius"].values
    np.testing.assert_allclose(contact.get_ydata(), width)
    assert (stick.get_ydata() < contact.get_ydata()).all()
    check_texts(figure)


@pytest.mark.slow
def test_a_dataset_without_these_fields_and_cycles_is_refused(smooth_run, small_study):
    with pytest.raises(ValueError, match=r"cycles = \[5\]: this dataset has snapshots at \[0, 1"):
        figures.field_profiles(smooth_run.dataset, "pressure", cycles=5)
    for dataset in (smooth_run.history, small_study.summary):
        with pytest.raises(ValueError, match="has no variable 'wear_depth'"):
            figures.wear_map(dataset)


def test_a_misspelt_name_is_answered_with_the_nearest_one():
    with pytest.raises(ValueError, match="did you mean 'wear_volume'"):
        figures.scalar_history(xr.Dataset({"wear_volume": ("cycle", [0.0])}), "wear_volum")
    with pytest.raises(ValueError, match="did you mean 'pressure'"):
        figures.field_profiles(xr.Dataset(), "presure")


def test_a_map_in_axes_of_the_caller_has_its_key_below_them(smooth):
    canvas = JournalFigure(1, 80.0)
    axes = canvas.subplots()
    figures.wear_map(smooth, ax=axes)
    canvas.draw_without_rendering()
    label = axes.xaxis.label.get_window_extent()
    assert axes.get_legend().get_window_extent().y1 <= label.y0 + 1.0


def test_a_file_that_cannot_be_written_leaves_nothing(smooth, tmp_path):
    figure = figures.scalar_history(smooth, "wear_volume")
    with pytest.raises(ValueError, match="not supported"):
        figures.save_as(figure, tmp_path / "figure.jp")
    (tmp_path / "figure.png").mkdir()
    with pytest.raises(DataFileError):
        figures.save_as(figure, tmp_path / "figure.png")
    assert [path.name for path in tmp_path.iterdir()] == ["figure.png"]
    figures.save_as(figure, tmp_path / "a.svg", tmp_path / "a.png")
    assert imread(tmp_path / "a.png").shape[1] == int(90.0 / 25.4 * 300.0)
