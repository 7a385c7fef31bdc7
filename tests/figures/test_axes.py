"""Axes of cycles, keys and labels beside curves can be read, also in the user's own axes."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretwear import figures
from fretwear.figures.axes import label_curves, outside_key, set_cycle_axis
from fretwear.figures.style import JournalFigure, style_context


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
def test_a_panel_is_drawn_into_axes_that_are_there(draw, smooth):
    figure, (left, right) = plt.subplots(1, 2)
    try:
        assert draw(smooth, ax=right) is figure
        assert right.has_data()
        assert not left.has_data()
        assert "(" in right.get_ylabel()
    finally:
        plt.close(figure)


def test_one_case_goes_into_one_axes_a_study_of_many_panels_does_not(small_study, smooth):
    figure = Figure()
    with pytest.raises(ValueError, match=r"takes 4 panels.*dataset\.isel"):
        figures.wear_volume(small_study.summary, ax=figure.subplots())
    part = small_study.summary.isel(load=0, friction=0)
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
    positions = [_at(axes, cycle) for cycle in (0, 10, 100, 1000, 10000)]
    steps = np.diff(positions)
    np.testing.assert_allclose(steps[1:], steps[1], rtol=1e-9)
    assert 0.0 <= positions[0] < 0.05
    assert 0.3 * steps[1] < steps[0] < steps[1]
    assert _at(axes, 30000) <= 1.0
    axes = _cycle_axes([10, 100, 1000])
    assert [line.get_label() for line in axes.get_lines()].count("_break") == 0
    assert 0.0 < _at(axes, 10) < 0.1


def _words(axes):
    axes.figure.draw_without_rendering()
    return [label.get_text() for label in axes.get_xticklabels() if label.get_text()]


def test_ticks_name_zero_every_decade_and_the_last_cycle_unless_they_would_touch():
    assert _words(_cycle_axes([0, 10, 100, 1000, 7000])) == ["0", "10", "100", "1000", "7000"]
    assert _words(_cycle_axes([0, 10, 1000])) == ["0", "10", "100", "1000"]
    words = _words(_cycle_axes([0, 10, 100, 1000, 12000]))
    assert words == ["0", "10", "100", "1000", "12\u2009000"]
    for cycles in ([0, 30000], [0, 2000, 7000], [0], [5, 7]):
        axes = _cycle_axes(cycles)
        assert (axes.get_xscale(), axes.get_xlabel()) == ("linear", "Cycle"), "within a decade"


@pytest.mark.parametrize("columns", [1, 2])
@pytest.mark.parametrize("words", ["short", "some more words than that"])
def test_a_key_is_no_wider_than_its_figure(columns, words):
    with style_context():
        figure = JournalFigure(columns, 60.0)
        figure.subplots()
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


def _crosses(box, axes, curve):
    x, y = curve.get_data()
    dense = np.linspace(0.0, 1.0, 5000)
    points = axes.transData.transform(np.column_stack([dense, np.interp(dense, x, y)]))
    return any(box.contains(*point) for point in points)


def test_labels_are_clear_of_every_curve_and_nearest_to_their_own():
    axes = _axes()
    curves = {f"n{n}": axes.plot(X, 0.9 * (1.0 - X**n), "k")[0] for n in (1, 2, 4)}
    assert label_curves(axes, list(curves.values()), list(curves))
    boxes = {text.get_text(): text.get_window_extent() for text in axes.texts}
    assert set(boxes) == {"n1", "n2", "n4"}
    for name, box in boxes.items():
        assert not any(_crosses(box, axes, curve) for curve in curves.values())
        assert axes.bbox.containsx(box.x0)
        assert axes.bbox.containsx(box.x1)
        centre = axes.transData.inverted().transform(box.get_points().mean(axis=0))
        away = {
            label: np.hypot(*(np.transpose(curve.get_xydata()) - centre[:, None])).min()
            for label, curve in curves.items()
        }
        assert min(away, key=away.get) == name


def test_curves_that_cannot_be_told_apart_share_a_label_and_those_without_room_have_none():
    axes = _axes()
    with style_context():
        curves = [axes.plot(X, y)[0] for y in (X, X + 1e-4, 0.3 * X)]
        assert label_curves(axes, curves, ["7000", "30 000", "0"])
    assert {text.get_text() for text in axes.texts} == {"7000, 30 000", "0"}
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
