"""Profiles, maps, bearing areas and films of a case: the data, their units, no overlaps."""

import shutil
import subprocess

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver
from PIL import Image, ImageSequence
from scipy import ndimage

import fretwear
from fretwear import figures
from fretwear.data.dataset import mirrored
from fretwear.data.files import open_case, write_case
from fretwear.figures.cases import (
    FfmpegMissingError,
    compare_cases,
    durations,
    overview,
    well_spaced_cycles,
)
from fretwear.figures.datasets import profiles_of, representative_cycles
from fretwear.figures.maps import take_wear_map, wear_map
from fretwear.figures.profiles import compare_bearing_areas
from fretwear.units import number_text
from fretwear.vocabulary import ContactState

from ..studies import steel

KINDS = {
    "pressure_profiles": ("pressure", "Pressure (MPa)", 1e6),
    "shear_profiles": ("shear_traction", "Shear traction (MPa)", 1e6),
    "gap_profiles": ("gap", "Gap (µm)", 1e-6),
    "wear_profiles": ("wear_depth", "Wear depth (µm)", 1e-6),
    "wear_rate_profiles": ("wear_rate", "Wear depth per cycle (pm)", 1e-12),
}


def _curves(axes):
    """Return the thick curves: those labelled with a cycle."""
    return [
        (line.get_xdata(), line.get_ydata())
        for line in axes.get_lines()
        if not str(line.get_label()).startswith("_")
    ]


@pytest.mark.parametrize("name", KINDS)
def test_a_smooth_profile_is_the_line_of_cells_nearest_the_middle(name, smooth):
    variable, label, size = KINDS[name]
    axes = getattr(figures, name)(smooth).axes[0]
    assert axes.get_ylabel() == label
    assert axes.get_xlabel() == "x (µm)"
    curves = _curves(axes)
    assert len(curves) == smooth.sizes["cycle"]
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
    assert {"0", "1", "10", "100", "1000"} <= named or surface == "rough"


def test_a_figure_is_as_wide_as_journal_columns_and_wear_is_drawn_downwards(smooth):
    widths = [figures.pressure_profiles(smooth, columns=n).get_figwidth() for n in (1, 2)]
    assert widths == pytest.approx([90.0 / 25.4, 190.0 / 25.4])
    with pytest.raises(ValueError, match="columns = 3"):
        figures.pressure_profiles(smooth, columns=3)
    low, high = figures.wear_profiles(smooth).axes[0].get_ylim()
    assert low > high == 0.0


@pytest.mark.parametrize("name", KINDS)
def test_no_drawn_line_leaves_its_data(name, smooth, rough):
    variable, _, _ = KINDS[name]

    def shapes(rows):
        return [row / np.abs(row).max() for row in rows if row.any()]

    data = [case[variable].isel(y=0).values.astype(float) for case in (smooth, rough)]
    stored = [shape for rows in data for shape in shapes(rows)]
    for figure in (
        *(getattr(figures, name)(case) for case in (smooth, rough)),
        figures.compare_profiles({"smooth": smooth, "again": smooth}, variable),
        figures.compare_profiles({"smooth": smooth, "rough": rough}, variable),
    ):
        lines = [n for a in figure.axes for n in a.get_lines() if n.get_label()[0] != "_"]
        assert lines
        for drawn in shapes([line.get_ydata() for line in lines]):
            # The gap extends beyond the cells stored.
            parts = [(drawn[: shape.size], shape) for shape in stored if shape.size <= drawn.size]
            assert any(np.allclose(p / np.abs(p).max(), s, 0, 1e-5) for p, s in parts if p.any())


def test_rough_profiles_are_filled_first_beside_last_over_a_strip_of_their_zones(
    rough, check_texts
):
    figure = figures.pressure_profiles(rough)
    first, last = figure.axes
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["cycle 0", "cycle 1000"]
    for axes, place in ((first, 0), (last, -1)):
        line = next(n for n in axes.get_lines() if n.get_label() == "Pressure")
        expected = rough["pressure"].isel(y=0, cycle=place).values / 1e6
        np.testing.assert_allclose(line.get_ydata(), expected, rtol=1e-6)
        (fill,) = axes.collections
        assert fill.get_paths()[0].vertices[:, 1].max() == pytest.approx(expected.max(), rel=1e-6)
        (strip,) = axes.get_images()
        zones = rough["contact_state"].isel(y=0, cycle=place).values
        np.testing.assert_array_equal(strip.get_array()[0], zones)
    assert {"stick", "slip", "open"} <= set(check_texts(figure))
    # No wear can be seen after ten cycles beside that after a thousand.
    assert [a.get_title(loc="left") for a in figures.wear_profiles(rough).axes] == [
        "cycle 100",
        "cycle 1000",
    ]
    # In the axes of another figure, the last stands before the line of the first.
    (axes,) = Figure().subplots(1, 1, squeeze=False)[0]
    figures.pressure_profiles(rough, ax=axes)
    assert [line.get_label() for line in axes.get_lines()] == ["_first", "Pressure"]


def test_the_gap_beyond_the_cells_stored_is_that_of_a_wider_window(rough):
    cut, known, end = rough.isel(x=slice(0, -4)), rough["gap"].isel(y=0), float(rough["x"][-1])
    found = profiles_of(cut, "gap", rough["cycle"].values.tolist(), end).values
    # Cells far away act like forces at their centres.
    tolerance = 1e-4 * float(known.max())
    assert found[:, : known.sizes["x"]] == pytest.approx(known.values, abs=tolerance)
    # A last cell that is loaded, and worn, acts on itself and on its neighbours.
    for at, cycle in ((0, 0), (-1, 1000)):
        loaded = np.flatnonzero(rough["pressure"].isel(y=0, cycle=at) > 0.0)
        narrow = rough.isel(x=slice(0, int(loaded[-1]) + 1))
        found = profiles_of(narrow, "gap", cycle, end).values[0]
        tolerance = 0.02 * float(known.max())
        assert found[: known.sizes["x"]] == pytest.approx(known.values[at], abs=tolerance)
    # A contact that is not even has two sides.
    uneven = mirrored(cut).assign(gap=lambda case: case["gap"] + 1e-8 * (case["x"] > 0.0))
    both = profiles_of(uneven, "gap", 100, end)
    assert both.x == pytest.approx(-both.x[::-1])
    outside = both.x > cut["x"].values[-1]
    assert outside.any()
    right, left = both.values[:, outside], both.values[:, ::-1][:, outside]
    assert right == pytest.approx(left + 1e-8, abs=1e-12)


def test_only_the_cycles_and_the_case_asked_for_are_drawn(smooth, small_study):
    assert len(_curves(figures.gap_profiles(smooth, [0, 100]).axes[0])) == 2
    with pytest.raises(ValueError, match=r"no snapshot at \[50\].*\[0, 1, 10, 100, 1000\]"):
        figures.pressure_profiles(smooth, [0, 50])
    with pytest.raises(ValueError, match="select one point first"):
        figures.pressure_profiles(small_study.summary)
    point = small_study.summary.isel(
        normal_load=1, friction=1, roughness_amplitude=0, plastic_limit=0
    )
    (_, pressure), *_ = _curves(figures.pressure_profiles(point).axes[0])
    assert pressure.max() / 1e3 == pytest.approx(1.004, rel=0.01)


def test_panels_have_one_case_each_and_one_key_to_the_cycles(smooth, rough, check_texts):
    figure = figures.compare_profiles(
        dict.fromkeys(["one", "other", "again"], smooth), "wear_depth"
    )
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["one", "other", "again"]
    words = check_texts(figure)
    assert words.count("cycle") == 1
    assert words.count("x (µm)") == 2
    # Beside a rough case, a smooth one is drawn as it is.
    figure = figures.compare_profiles({"smooth": smooth, "rough": rough}, "pressure")
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        f"{title}, cycle {cycle}" for title in ("smooth", "rough") for cycle in (0, 1000)
    ]
    check_texts(figure)


@pytest.mark.parametrize("name", ["wear_depth", "wear_rate"])
def test_a_scar_too_small_for_the_scale_of_the_others_has_one_of_its_own_that_is_said(
    name, smooth, check_texts
):
    shallow = smooth.assign({name: 1e-2 * smooth[name]})
    figure = figures.compare_profiles({"deep": smooth, "shallow": shallow, "same": smooth}, name)
    texts = check_texts(figure)
    assert {"deep", "shallow, own scale", "same"} <= set(texts)
    deep, own, same = figure.axes
    assert deep.get_ylim() == same.get_ylim()
    for axes, case in ((deep, smooth), (own, shallow)):
        largest = max(float(np.nanmax(y)) for _, y in _curves(axes))
        assert 0.9 < largest / max(axes.get_ylim()) < 1.0
        assert axes.yaxis.label.get_visible()
        assert axes.yaxis.get_tick_params()["labelleft"]
        _, _, unit = axes.get_ylabel().partition("(")
        size = {"µm)": 1e-6, "nm)": 1e-9, "pm)": 1e-12, "fm)": 1e-15}[unit]
        assert size * largest == pytest.approx(float(case[name].isel(y=0).max()), rel=1e-6)
    assert "own scale" in figure.caption


def test_a_peak_is_cut_only_at_a_singular_edge_and_its_value_is_written(smooth, check_texts):
    steep = smooth.copy(deep=True)
    steep["pressure"][-1, 20] = 30.0 * float(smooth["pressure"][0].max())
    highest = float(steep["pressure"].max()) / 1e6
    singular = steep.assign(peak_pressure_error=("cycle", [0.0, 0.0, 0.0, 0.0, np.inf]))
    for case, cycles, is_cut in (
        (singular, None, True),
        (singular, [1000], False),
        (steep, None, False),
        (steep.assign(peak_pressure_error=("cycle", np.ones(5))), None, False),
    ):
        figure = figures.pressure_profiles(case, cycles)
        axes = figure.axes[0]
        assert ("_above" in [line.get_label() for line in axes.get_lines()]) is is_cut
        assert bool(axes.get_ylim()[1] < highest) is is_cut
        assert ("singular" in figure.caption) is is_cut
        assert any(number_text(highest, 3) in text for text in check_texts(figure)) is is_cut


def test_the_map_is_the_last_scar_mirrored_with_circles_for_edges(smooth):
    scar, last = take_wear_map(smooth, None), smooth.isel(cycle=-1)
    half = last.sizes["x"]
    np.testing.assert_array_equal(scar.depth[half:, half:], last["wear_depth"].values)
    for mirrored_depth in (scar.depth[::-1], scar.depth[:, ::-1]):
        np.testing.assert_array_equal(scar.depth, mirrored_depth)
    np.testing.assert_array_equal(scar.x, -scar.x[::-1])
    for edge, name in ((scar.contact_edge, "contact"), (scar.stick_edge, "stick")):
        away = np.hypot(*edge.T) - float(last[f"{name}_half_width_x"])
        # The half-widths along x and y are interpolated inside the cells, each on its own.
        assert np.abs(away).max() < 0.1 * float(smooth["cell_x"])


def test_every_spot_of_a_rough_contact_has_its_own_edge(rough):
    scar = take_wear_map(rough, 0)
    state = rough["contact_state"].isel(cycle=0).values
    _, spots = ndimage.label(mirrored(rough)["contact_state"].isel(cycle=0).values > 0)
    assert spots > 4
    rings = np.split(scar.contact_edge, np.flatnonzero(np.isnan(scar.contact_edge[:, 0])))
    closed = [ring[~np.isnan(ring[:, 0])] for ring in rings]
    assert sum(len(ring) > 0 for ring in closed) >= spots
    # What all contours enclose is the cells in contact, but for their corners.
    area = sum(0.5 * (r[:-1, 0] @ r[1:, 1] - r[1:, 0] @ r[:-1, 1]) for r in closed if len(r))
    cells = 4.0 * (state > 0).sum() * float(rough["cell_x"]) * float(rough["cell_y"])
    assert abs(area) == pytest.approx(cells, rel=0.2)


def test_scars_of_very_different_depths_and_widths_are_all_seen_on_one_scale(smooth):
    shallow = smooth.assign(wear_depth=0.1 * smooth["wear_depth"])
    deep, flat, _ = figures.compare_wear_maps({"deep": smooth, "shallow": shallow}).axes
    norm = deep.get_images()[0].norm
    assert flat.get_images()[0].get_clim() == (norm.vmin, norm.vmax)
    assert norm(flat.get_images()[0].get_array().max()) == pytest.approx(np.sqrt(0.1), rel=1e-3)
    alike = figures.compare_wear_maps({"one": smooth, "other": smooth})
    scale = alike.axes[0].get_images()[0].norm
    assert scale(0.5 * scale.vmax) == pytest.approx(0.5)
    wide = smooth.assign_coords(y=2.0 * smooth.y)
    wide["contact_half_width_y"] = 2.0 * wide.contact_half_width_y
    figure = figures.compare_wear_maps({"wide": wide, "round": smooth})
    for axes in figure.axes[:2]:
        assert axes.get_ylim()[1] > 1e6 * float(wide.contact_half_width_y[-1])


def test_the_outline_of_a_scar_at_an_angle_is_not_an_ellipse_along_the_axes(smooth):
    whole = mirrored(smooth)
    zone = whole.contact_state.values
    zone[:, whole.x.values > 0.0] *= whole.y.values > 0.0
    turned = whole.assign(contact_state=(whole.contact_state.dims, zone, whole.contact_state.attrs))
    edge = take_wear_map(turned, None).contact_edge
    assert edge[edge[:, 0] > 2e-5, 1].min() > -1e-5


def test_a_mirrored_case_gives_the_same_map_and_profiles(smooth_run, tmp_path):
    write_case(smooth_run.dataset, smooth_run.history, tmp_path / "case.nc")
    with open_case(tmp_path / "case.nc", full=True) as whole:
        maps = [take_wear_map(each, None) for each in (whole, smooth_run.dataset)]
        axes = [figures.gap_profiles(each).axes[0] for each in (whole, smooth_run.dataset)]
        for one, other in zip(*(each.get_lines() for each in axes), strict=True):
            np.testing.assert_allclose(one.get_xydata(), other.get_xydata())
    np.testing.assert_array_equal(maps[0].depth, maps[1].depth)
    np.testing.assert_allclose(maps[0].contact_edge, maps[1].contact_edge)


def test_the_image_is_to_scale_and_says_its_units(rough, check_texts):
    figure = figures.wear_map(rough)
    axes = figure.axes[0]
    figure.draw_without_rendering()
    (image,) = axes.get_images()
    left, right, bottom, top = image.get_extent()
    assert right == -left == pytest.approx(rough.sizes["x"] * 4.0)
    assert top == -bottom == pytest.approx(rough.sizes["y"] * 4.0)
    assert axes.get_aspect() == 1.0
    words = check_texts(figure)
    assert {"x (µm), direction of slip", "y (µm)", "edge of contact"} <= set(words)
    assert any(text.startswith("Wear depth (") for text in words)
    check_texts(figures.wear_map(rough, cycle=0))


def test_curves_are_the_heights_of_the_roughness_less_what_is_lost(rough, check_texts):
    figure = figures.bearing_area(rough)
    (axes,) = figure.axes
    (share, first), (_, last) = (line.get_xydata().T for line in axes.get_lines())
    assert (np.diff(share) > 0.0).all()
    assert (np.diff([first, last]) <= 0.0).all()
    assert first.mean() == pytest.approx(0.0, abs=1e-6 * first.max())
    size = {"nm": 1e9, "µm": 1e6}[axes.get_ylabel().split("(")[1].rstrip(")")]
    # The waves are symmetric about their mean: 0.3 µm up and down.
    assert first.max() == pytest.approx(0.3e-6 * size, rel=0.05)
    end = rough.isel(cycle=-1)
    inside = np.hypot(end.x / end.contact_half_width_x, end.y / end.contact_half_width_y) <= 1.0
    lost = float((end.wear_depth + end.plastic_depth).where(inside).mean())
    assert first.mean() - last.mean() == pytest.approx(size * lost, rel=1e-4)
    assert {"cycle 0", "cycle 1000"} <= set(check_texts(figure))


def test_cases_are_compared_on_one_scale_of_heights(rough, check_texts, smooth):
    figure = compare_bearing_areas({"one": rough, "other": rough})
    one, other = figure.axes
    for mine, theirs in zip(one.get_lines(), other.get_lines(), strict=True):
        np.testing.assert_array_equal(mine.get_xydata(), theirs.get_xydata())
    assert one.get_ylim() == other.get_ylim()
    assert {"one", "other", "cycle 0", "cycle 1000"} <= set(check_texts(figure))
    with pytest.raises(ValueError, match="this case is smooth"):
        figures.bearing_area(smooth)


CYCLES = (0, 1, 10, 100, 1000)


def test_every_picture_is_a_snapshot_on_the_whole_contact(rough, check_texts):
    animation = figures.animation(rough)
    assert animation.cycles == CYCLES
    limits = []
    for cycle in CYCLES:
        figure, case = animation.show(cycle), rough.sel(cycle=cycle)
        words = check_texts(figure)
        assert any(text.startswith(f"Cycle {cycle} ") for text in words)
        assert {"stick", "slip", "open", "Pressure (MPa)", "Wear depth (µm)"} <= set(words)
        lines = {line.get_label(): line for axes in figure.axes for line in axes.get_lines()}
        x, pressure = lines["Pressure"].get_data()
        half = case["pressure"].isel(y=0).values / 1e6
        np.testing.assert_allclose(pressure, np.concatenate([half[::-1], half]), rtol=1e-6)
        np.testing.assert_allclose(x, -x[::-1])
        zones = figure.axes[1].get_images()[0].get_array()
        quarter = zones[zones.shape[0] // 2 :, zones.shape[1] // 2 :]
        np.testing.assert_array_equal(quarter, case["contact_state"].values.T)
        limits.append([(axes.get_xlim(), axes.get_ylim()) for axes in figure.axes])
    assert all(other == limits[0] for other in limits)


def test_a_gif_has_one_picture_a_snapshot_and_rests_at_the_end(smooth_run, tmp_path):
    seen: list[tuple[int, int]] = []
    animation = figures.animation(smooth_run.dataset, smooth_run.history)
    path = animation.save(
        tmp_path / "wear.gif", dots_per_inch=60, progress=lambda *at: seen.append(at)
    )
    assert seen == [(number, 5) for number in range(1, 6)]
    with Image.open(path) as film:
        assert film.info["loop"] == 0
        assert film.width == pytest.approx(190 / 25.4 * 60, abs=1)
        durations = [picture.info["duration"] for picture in ImageSequence.Iterator(film)]
    assert durations == pytest.approx([1000 * n for n in animation.seconds], abs=10)
    assert durations[-1] == max(durations)


def test_snapshots_far_apart_are_shown_longer_and_cycles_for_a_smooth_film_are_whole():
    first, second, third, last = durations([0, 10, 20, 1000])
    assert second < min(first, third) <= max(first, third) < last
    for end in (1, 50, 7000, 30000):
        cycles = well_spaced_cycles(end)
        assert (cycles[0], cycles[-1]) == (0, end)
        assert all(isinstance(cycle, int) for cycle in cycles)
        assert cycles == sorted(set(cycles))
    assert 25 <= len(cycles) <= 32


def test_other_snapshots_and_films_are_refused_and_without_ffmpeg_a_gif_is_offered(
    smooth, tmp_path, monkeypatch
):
    animation = figures.animation(smooth, cycles=[0, 1000])
    assert animation.cycles == (0, 1000)
    with pytest.raises(ValueError, match=r"shows \[0, 1000\]"):
        animation.show(10)
    for name in ("wear.avi", "wear"):
        with pytest.raises(ValueError, match=r"\.gif or \.mp4"):
            animation.save(tmp_path / name)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FfmpegMissingError, match=r"wear\.gif instead"):
        animation.save(tmp_path / "wear.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(shutil.which("ffprobe") is None, reason="needs Debian's ffmpeg")
def test_an_mp4_lasts_as_long_as_its_pictures_and_plays_everywhere(smooth, tmp_path):
    animation = figures.animation(smooth, cycles=[0, 10, 1000])
    path = animation.save(tmp_path / "wear.mp4", dots_per_inch=51)
    entries = "stream=codec_name,pix_fmt,duration"
    command = ["ffprobe", "-v", "error", "-show_entries", entries, "-of", "csv=p=0", path]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    codec, pixels, seconds = told.strip().split(",")
    assert (codec, pixels) == ("h264", "yuv420p")
    assert float(seconds) == pytest.approx(sum(animation.seconds), abs=0.2)


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
        with pytest.raises(TypeError, match="by their titles"):
            compare(wrong)
    with pytest.raises(ValueError, match="no case"):
        compare({})
    with pytest.raises(TypeError, match="open the file first"):
        compare({"a": "a.nc", "b": "b.nc"})
    with pytest.raises(ValueError, match="'pressure', 'shear_traction'"):
        figures.compare_profiles({"a": smooth}, "pressure_profiles")


def test_few_snapshots_are_all_shown_and_many_thinned_evenly_in_the_fourth_root():
    assert representative_cycles([1000, 0, 1]) == (0, 1, 1000)
    chosen = representative_cycles(range(10001), most=5)
    assert (chosen[0], chosen[-1]) == (0, 10000)
    steps = np.diff(np.power(chosen, 0.25))
    assert steps.max() / steps.min() < 1.1


def test_figures_of_friction_in_two_directions_show_the_y_axis_and_the_direction_of_slip():
    case = steel(cycles=300, cell="6 um", error_estimate=False)
    both = fretwear.simulate(case.replace(slip_model="coupled"))
    single = fretwear.simulate(case)
    (arrows,), none = (wear_map(each).findobj(Quiver) for each in (both, single))
    assert not none
    last = both.isel(cycle=-1).transpose("x", "y")
    angle = np.arctan2(last.slip_y.values, last.slip_x.values)
    for x, y, along, across in zip(arrows.X, arrows.Y, arrows.U, arrows.V, strict=True):
        cell = last.sel(x=1e-6 * x, y=1e-6 * y, method="nearest")
        assert int(cell.contact_state) == ContactState.SLIP
        turned = float(np.arctan2(cell.slip_y, cell.slip_x))
        assert np.arctan2(across, along) == pytest.approx(turned, abs=1e-6)
    assert 20 < arrows.N < 400
    assert np.abs(arrows.V).max() > 0.3 * np.abs(np.sin(angle[last.contact_state == 1])).max()
    depth = 1e6 * float(last.wear_depth.isel(x=last.sizes["x"] // 2).max())
    for figure in (overview(both), compare_cases({"one": single, "two": both})):
        (axes,) = [axes for axes in figure.axes if axes.get_ylabel().startswith("Wear depth (")]
        unit = {"µm": 1.0, "nm": 1e3}[axes.get_ylabel().split("(")[1].rstrip(")")]
        deepest = max(float(np.max(line.get_ydata())) for line in axes.lines)
        assert deepest == pytest.approx(unit * depth, rel=1e-3)
        assert max(axes.get_ylim()) > unit * depth
        assert "dotted: y" in axes.get_xlabel()
