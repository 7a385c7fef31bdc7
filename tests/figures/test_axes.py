"""Axes, keys and labels can be read, any number of names becomes panels, one style for all."""

import hashlib
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from itertools import pairwise

import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear import figures
from fretwear.data.atomic import DataFileError
from fretwear.figures.axes import label_curves, outside_key, set_cycle_axis
from fretwear.figures.cases import ZONE_COLORS
from fretwear.figures.history import CyclePlot, representative_cases, study_curves
from fretwear.figures.index import HISTORIES, PROFILES
from fretwear.figures.style import (
    CATEGORICAL,
    JournalFigure,
    sequential_colours,
    style_context,
    text_colour,
)

PANELS = [f"{field}_profiles" for field in ("pressure", "shear", "gap", "wear", "wear_rate")]
PANELS += ["wear_map", "contact_half_width", "stick_half_width", "wear_volume", "dissipated_energy"]


@pytest.mark.parametrize("name", PANELS)
def test_a_panel_is_drawn_into_axes_that_are_there(name, smooth):
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert getattr(figures, name)(smooth, ax=right) is figure
    assert right.has_data()
    assert not left.has_data()
    assert "(" in right.get_ylabel()


def test_every_field_and_scalar_has_a_figure_under_its_name(smooth):
    assert {*PROFILES, *HISTORIES} <= set(dir(figures))
    for name, label in (("slip_profiles", "Slip amplitude ("), ("approach", "Approach (µm)")):
        drawn = getattr(figures, name)(smooth)
        assert drawn.axes[0].get_ylabel().startswith(label)
        assert drawn.caption.startswith(label.partition(" (")[0])
    # What does not touch may move, but does not slip.
    curves = [
        line
        for line in figures.slip_profiles(smooth).axes[0].get_lines()
        if line.get_xdata().size > 9
    ]
    edges = 1e6 * smooth["contact_half_width_x"].values
    assert len(curves) == len(edges)
    for curve, edge in zip(curves, edges, strict=True):
        x, slip = curve.get_data()
        assert np.nanmax(slip) > 0.0
        assert np.isnan(slip[x > edge + 4.0]).all()
    with pytest.raises(AttributeError, match="no attribute 'pressures'"):
        figures.pressures  # noqa: B018
    assert "after cycle 10." in figures.wear_map(smooth, cycle=10).caption


def test_one_case_goes_into_one_axes_a_study_of_many_panels_does_not(small_study, smooth):
    figure = Figure()
    with pytest.raises(ValueError, match=r"takes 4 panels.*dataset\.isel"):
        figures.wear_volume(small_study.summary, ax=figure.subplots())
    part = small_study.summary.isel(normal_load=0, friction=0)
    assert figures.wear_volume(part, ax=figure.subplots()).axes
    for select in ({"cycle": 1000}, {"cycle": [0, 1000]}):
        lines = figures.pressure_profiles(smooth.sel(select)).axes[0].get_lines()
        drawn = [line for line in lines if not str(line.get_label()).startswith("_")]
        assert drawn[-1].get_label() == "1000"
    alone = figures.pressure_profiles(smooth, cycles=1000)
    assert alone.axes[0].get_ylabel() == "Pressure (MPa)"


def _cycle_axes(cycles):
    axes = JournalFigure(1, 60.0).subplots()
    axes.plot(cycles, cycles)
    set_cycle_axis(axes, cycles)
    return axes


def _at(axes, cycle):
    """Return where a cycle lies along the axis, from 0 to 1."""
    return float(axes.transAxes.inverted().transform(axes.transData.transform((cycle, 0.0)))[0])


def test_decades_are_equally_long_and_zero_lies_before_them():
    axes = _cycle_axes([0, 10, 100, 1000, 30000])
    zero, *positions = (_at(axes, cycle) for cycle in (0, 10, 100, 1000, 10000))
    steps = np.diff(positions)
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)
    assert 0.0 <= zero < 0.05
    assert 0.3 * steps[0] < positions[0] - zero < steps[0]
    assert _at(axes, 30000) <= 1.0
    axes = _cycle_axes([10, 100, 1000])
    assert "_break" not in [line.get_label() for line in axes.get_lines()]
    assert 0.0 < _at(axes, 10) < 0.1


@pytest.mark.parametrize(
    ("cycles", "words"),
    [
        ([0, 10, 100, 1000, 7000], ["0", "10", "100", "1000", "7000"]),
        ([0, 10, 1000], ["0", "10", "100", "1000"]),
        ([0, 10, 100, 1000, 12000], ["0", "10", "100", "1000", "12\u2009000"]),
        ([300, 5000], ["500", "1000", "2000", "5000"]),
        ([0, 60, 800], ["0", "100", "200", "500", "800"]),
        ([0, 30, 2900], ["0", "50", "100", "200", "500", "1000", "2900"]),
    ],
)
def test_ticks_name_zero_every_decade_and_the_last_cycle_unless_they_would_touch(cycles, words):
    axes = _cycle_axes(cycles)
    axes.figure.draw_without_rendering()
    assert [each.get_text() for each in axes.get_xticklabels() if each.get_text()] == words


@pytest.mark.parametrize("cycles", [[0, 30000], [0, 2000, 7000], [0], [5, 7]])
def test_cycles_within_a_decade_have_a_linear_axis(cycles):
    axes = _cycle_axes(cycles)
    assert (axes.get_xscale(), axes.get_xlabel()) == ("linear", "Cycle")


@pytest.mark.parametrize("columns", [1, 2])
@pytest.mark.parametrize("words", ["short", "some more words than that"])
def test_a_key_is_no_wider_than_its_figure(columns, words):
    with style_context():
        figure = JournalFigure(columns, 60.0)
        labels = [f"{words} {number}" for number in range(9)]
        key = outside_key(figure, [Line2D([], []) for _ in labels], labels)
        figure.draw_without_rendering()
        assert key.get_window_extent().width <= figure.bbox.width
        assert figure.legends == [key]
        assert [text.get_text() for text in key.get_texts()] == labels


X = np.linspace(0.0, 1.0, 200)


def _axes(height=60.0):
    with style_context():
        axes = JournalFigure(1, height).subplots()
        axes.set_xlim(0.0, 1.0)
        axes.set_ylim(0.0, 1.0)
        return axes


def test_labels_are_clear_of_every_curve_and_nearest_to_their_own():
    axes = _axes()
    curves = {f"n{n}": axes.plot(X, 0.9 * (1.0 - X**n), "k")[0] for n in (1, 2, 4)}
    assert label_curves(axes, list(curves.values()), list(curves))
    boxes = {text.get_text(): text.get_window_extent() for text in axes.texts}
    assert set(boxes) == set(curves)
    x = np.linspace(0.0, 1.0, 5000)
    for name, box in boxes.items():
        assert axes.bbox.containsx(box.x0)
        assert axes.bbox.containsx(box.x1)
        away = {}
        for other, curve in curves.items():
            points = axes.transData.transform(np.transpose([x, np.interp(x, *curve.get_data())]))
            assert not any(box.contains(*point) for point in points)
            away[other] = np.hypot(*(points - box.get_points().mean(axis=0)).T).min()
        assert min(away, key=away.get) == name


def test_labels_on_a_logarithmic_axis_stand_beside_their_curves_although_these_begin_at_zero():
    axes = Figure(figsize=(7, 2)).subplots()
    cycles = np.array([0.0, 1.0, 10.0, 100.0, 1000.0])
    curves = [axes.plot(cycles, factor * cycles)[0] for factor in (1.0, 2.0)]
    axes.set(xscale="log", yscale="log", xlim=(0.5, 2000.0), ylim=(0.5, 4000.0))
    assert label_curves(axes, curves, ["single", "double"])
    to_pixels = axes.transData.transform
    for text, factor in zip(axes.texts, (1.0, 2.0), strict=True):
        own, other = (
            to_pixels(np.column_stack([cycles[1:], of * cycles[1:]]))
            for of in (factor, 3.0 - factor)
        )
        centre = text.get_window_extent().get_points().mean(axis=0)
        x = np.linspace(own[0, 0], own[-1, 0], 2000)
        apart = [
            np.hypot(*(np.column_stack([x, np.interp(x, *of.T)]) - centre).T).min()
            for of in (own, other)
        ]
        assert apart[0] < apart[1]
        assert apart[0] < 25.0


def test_curves_that_cannot_be_told_apart_share_a_label_and_those_without_room_have_none():
    axes = _axes()
    with style_context():
        curves = [axes.plot(X, y)[0] for y in (X, X + 1e-4, 0.3 * X)]
        assert label_curves(axes, curves, ["7000", "30 000", "0"])
    assert {text.get_text() for text in axes.texts} == {"7000, 30 000", "0"}
    axes.texts[0].remove()
    with style_context():
        assert label_curves(axes, curves, ["slip", "slip, in both directions", "0"])
    assert "slip; slip, in both directions" in {text.get_text() for text in axes.texts}
    curves = [
        axes.plot(X[::20], X[::20] + shift, marker=marker)[0]
        for shift, marker in ((0.0, "s"), (0.02, "^"), (0.04, "s"))
    ]
    assert not label_curves(axes, curves, ["first", "second", "third"])
    axes = _axes(height=16.0)
    levels = np.linspace(0.05, 0.95, 12)
    curves = [axes.plot(X, np.full_like(X, level))[0] for level in levels]
    assert not label_curves(axes, curves, [f"curve {level:.2f}" for level in levels])
    assert not axes.texts


def _grid(levels):
    shape = tuple(len(values) for values in levels.values())
    cycles = [0.0, 10.0, 100.0]
    table = np.arange(np.prod(shape, dtype=int) * 3, dtype=float).reshape(*shape, 3)
    coords = {name: list(values) for name, values in levels.items()}
    return xr.Dataset({"wear_volume": ((*levels, "cycle"), table)}, {**coords, "cycle": cycles})


def _list(volumes, **values):
    coords = {name: ("point", list(column)) for name, column in values.items()}
    coords["case_id"] = ("point", [f"case-{number}" for number in range(len(volumes))])
    table = np.stack([0 * volumes, volumes], axis=1)
    return xr.Dataset(
        {"wear_volume": (("point", "cycle"), table)},
        {**coords, "point": np.arange(len(volumes)), "cycle": [0.0, 10.0]},
    )


DEMO = {
    "load": [20.0, 40.0],
    "friction": [0.3, 0.6],
    "roughness_amplitude": [0.0, 1e-7, 2e-7],
    "plastic_limit": [np.inf, 4.5e9],
}


@pytest.mark.parametrize(
    ("levels", "rows", "across", "color", "style"),
    [
        (DEMO, ("load",), ("friction",), "roughness_amplitude", "plastic_limit"),
        ({}, (), (), None, None),
        ({"load": [1.0, 2.0]}, (), (), "load", None),
        ({"load": [1.0, 2.0, 3.0], "friction": [0.3, 0.5]}, (), (), "load", "friction"),
        ({"radius": range(1, 9), "load": range(1, 10)}, (), ("radius",), "load", None),
        ({"load": [1.0, 2.0], "slip_model": ["a", "b"]}, (), (), "load", "slip_model"),
        (
            {"load": [1.0, 2.0], "friction": [0.1, 0.2, 0.3], "radius": [1.0, 2.0, 3.0, 4.0]},
            (),
            ("friction",),
            "radius",
            "load",
        ),
    ],
)
def test_names_find_their_places(levels, rows, across, color, style):
    plot = CyclePlot(_grid(levels), "wear_volume")
    assert (tuple(plot.rows), tuple(plot.across)) == (rows, across)
    assert (plot.color, plot.style) == (color, style)
    assert not plot.thinned


def test_many_values_are_thinned_evenly_and_a_fifth_name_is_held_at_its_last():
    study = _grid({"load": np.arange(20.0), "friction": np.arange(30.0), "radius": np.arange(70.0)})
    plot = CyclePlot(study, "wear_volume")
    assert (plot.levels["load"][0], plot.levels["load"][-1]) == (0.0, 19.0)
    assert plot.thinned == {"load": 20, "friction": 30, "radius": 70}
    assert 0 < len(plot.lines) <= 5 * 4 * 60
    plot = CyclePlot(_grid({**DEMO, "radius": [1.0, 2.0, 3.0]}), "wear_volume")
    assert plot.thinned == {"radius": 3}
    assert [line.values["radius"] for line in plot.lines] == [3.0] * 24
    with pytest.raises(ValueError, match="'stick_area'"):
        study_curves(_grid(DEMO), "stick_area")


def test_points_drawn_at_random_are_told_by_panels_and_one_colour_bar():
    loads, ratios = np.linspace(20.0, 60.0, 30), np.linspace(0.9, 0.5, 30)
    limits = [np.inf, 4.5e9] * 15
    sampled = _list(np.ones(30), load=loads, tangential_ratio=ratios, plastic_limit=limits)
    plot = CyclePlot(sampled, "wear_volume")
    assert (plot.across, plot.color, plot.style) == (["plastic_limit"], "load", None)
    assert plot.paired == ["tangential_ratio"]
    assert len(plot.lines) == 30
    study = _list(np.ones(5), load=[1.0, 2.0, 3.0, 4.0, 5.0], friction=[0.1, 0.2, 0.3, 0.4, 0.5])
    plot = CyclePlot(study, "wear_volume")
    assert (plot.rows, plot.across) == ([], [])
    assert plot.color in ("load", "friction")


def test_the_demo_gives_the_four_corners_of_roughness_and_plastic_limit(small_study):
    summary = small_study.summary.copy(deep=True)
    chosen = representative_cases(summary)
    assert chosen == representative_cases(summary)
    assert chosen.contrasts == ("roughness_amplitude", "plastic_limit")
    assert list(chosen.ids) == [
        "smooth, elastic",
        r"smooth, $p_\mathrm{lim}$ = 4500 MPa",
        r"$h_\mathrm{a}$ = 0.3 µm, elastic",
        r"$h_\mathrm{a}$ = 0.3 µm, $p_\mathrm{lim}$ = 4500 MPa",
    ]
    assert chosen.common == "normal load 40 N, coefficient of friction 0.6"
    for title, case_id in chosen.ids.items():
        assert case_id.startswith("P40N-Q19.2N-mu0.6-")
        assert ("elastic" in case_id) is ("elastic" in title)
    summary["wear_volume"].loc[{"load": 40.0, "friction": 0.6, "plastic_limit": 4.5e9}] = np.nan
    chosen = representative_cases(summary)
    assert len(chosen.ids) == 4
    assert chosen.common == "normal load 40 N, coefficient of friction 0.3"


def test_a_study_of_other_names_takes_the_extremes_of_its_first_two(small_study):
    summary = small_study.summary.isel(roughness_amplitude=0, plastic_limit=0)
    chosen = representative_cases(summary)
    assert chosen.contrasts == ("load", "friction")
    assert next(iter(chosen.ids)) == "$P$ = 30 N, $µ$ = 0.3"
    assert len(chosen.ids) == 4
    alone = summary.isel(normal_load=0, friction=0)
    chosen = representative_cases(alone)
    assert (chosen.contrasts, chosen.ids) == ((), {"": str(alone["case_id"].item())})
    sampled = _list(np.array([3.0, 9.0, 1.0, 2.0]), load=[20, 40, 30, 25], friction=[3, 4, 5, 6])
    assert list(representative_cases(sampled).ids.values()) == ["case-2", "case-1"]


@pytest.mark.parametrize("models", [["jaeger", "cattaneo_mindlin"], ["cattaneo_mindlin", "jaeger"]])
def test_slip_that_follows_the_worn_shape_is_shown_whatever_the_order(small_study, models):
    one = small_study.summary.isel(normal_load=1, friction=1).drop_vars(
        "slip_model", errors="ignore"
    )
    summary = xr.concat([one] * 2, xr.Variable("slip_model", models), coords=["case_id"])
    chosen = representative_cases(summary)
    assert (len(chosen.ids), chosen.common) == (4, "slip of the worn shape")


def _luminance(color):
    """Relative luminance of WCAG 2."""
    channels = [n / 12.92 if n <= 0.04045 else ((n + 0.055) / 1.055) ** 2.4 for n in to_rgb(color)]
    return np.dot([0.2126, 0.7152, 0.0722], channels)


@pytest.mark.parametrize("color", [*CATEGORICAL, *sequential_colours(6), "white"])
def test_text_in_any_colour_stands_out_from_white(color):
    assert 1.05 / (_luminance(text_colour(color)) + 0.05) >= 4.5
    # Colours that are dark enough stay as they are.
    assert text_colour("#000000") == "#000000"
    assert text_colour(CATEGORICAL[0].lower()) == CATEGORICAL[0].lower()


def test_later_cycles_and_zones_differ_in_grey():
    shades = [_luminance(color) for color in sequential_colours(6)]
    assert np.diff(np.cbrt(shades)).max() < -0.02
    shades = [_luminance(color) for color in ZONE_COLORS.values()]
    assert all(first > 1.5 * second for first, second in pairwise(shades))


SCRIPT = """
import sys, xarray as xr
from pathlib import Path
from fretwear import figures
case = xr.load_dataset(sys.argv[1])
figures.save_figure(figures.wear_map(case), Path(sys.argv[2]))
"""


def _digests(folder):
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in folder.iterdir()}


def test_another_process_and_other_settings_of_the_user_give_the_same_bytes(rough, tmp_path):
    rough.to_netcdf(tmp_path / "case.nc")
    subprocess.run(
        [sys.executable, "-c", SCRIPT, tmp_path / "case.nc", tmp_path / "there" / "map"],
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "1"},
    )
    with matplotlib.rc_context({"svg.fonttype": "none", "savefig.dpi": 50, "font.size": 5}):
        figures.save_figure(figures.wear_map(rough), tmp_path / "here" / "map")
    found = _digests(tmp_path / "here")
    assert set(found) == {"map.svg", "map.png"}
    assert found == _digests(tmp_path / "there")
    # The vector file is well-formed and undated, and loads nothing.
    root = ET.fromstring((tmp_path / "here" / "map.svg").read_text(encoding="utf-8"))
    assert root.tag.endswith("svg")
    links = [v for each in root.iter() for name, v in each.attrib.items() if name.endswith("href")]
    assert links
    assert all(link.startswith(("#", "data:")) for link in links)
    assert not [element for element in root.iter() if element.tag.endswith("date")]


def test_a_file_that_cannot_be_written_leaves_nothing(smooth, tmp_path):
    figure = figures.pressure_profiles(smooth)
    for name in ("figure.docx", "figure"):
        with pytest.raises(ValueError, match=r"\.png, \.svg or \.pdf"):
            figures.save_as(figure, tmp_path / name)
    (tmp_path / "folder").write_text("a file where a folder should be", encoding="utf-8")
    with pytest.raises(DataFileError):
        figures.save_as(figure, tmp_path / "folder" / "figure.svg")
    assert [file.name for file in tmp_path.iterdir()] == ["folder"]


def test_matplotlibs_own_way_to_save_and_to_show_gives_journal_quality(smooth, tmp_path):
    wide, narrow = (figures.pressure_profiles(smooth, columns=columns) for columns in (2, 1))
    with matplotlib.rc_context({"savefig.dpi": 50, "savefig.bbox": "tight", "pdf.fonttype": 3}):
        wide.savefig(tmp_path / "p.png")
        wide.savefig(tmp_path / "p.pdf")
    (path,) = figures.save_figure(narrow, tmp_path / "q", ("png",))
    for file, millimetres in ((tmp_path / "p.png", 190.0), (path, 90.0)):
        width = int.from_bytes(file.read_bytes()[16:20], "big")
        assert width == pytest.approx(millimetres / 25.4 * 300.0, abs=1.0)
    assert narrow._repr_png_().startswith(b"\x89PNG")
    content = (tmp_path / "p.pdf").read_bytes()
    assert b"/FontFile2" in content
    assert b"/Type3" not in content
