"""Labels beside curves touch neither curves nor each other, or are left to a legend."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.transforms import Bbox

from fretwear.figures.axes import label_curves
from fretwear.figures.style import JournalFigure, style_context

X = np.linspace(0.0, 1.0, 200)


def _axes(height: float = 60.0) -> Axes:
    with style_context():
        axes = JournalFigure(1, height).subplots()
        axes.set_xlim(0.0, 1.0)
        axes.set_ylim(0.0, 1.0)
        return axes


def _crosses(box: Bbox, axes: Axes, curve: Line2D) -> bool:
    x, y = curve.get_data()
    dense = np.linspace(0.0, 1.0, 5000)
    points = axes.transData.transform(np.column_stack([dense, np.interp(dense, x, y)]))
    return any(box.contains(*point) for point in points)


def test_labels_are_clear_of_every_curve_and_nearest_to_their_own() -> None:
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


def test_curves_that_cannot_be_told_apart_share_a_label() -> None:
    axes = _axes()
    with style_context():
        curves = [axes.plot(X, y)[0] for y in (X, X + 1e-4, 0.3 * X)]
        assert label_curves(axes, curves, ["7000", "30 000", "0"])
    assert {text.get_text() for text in axes.texts} == {"7000, 30 000", "0"}


def test_marks_that_cover_each_other_give_no_place_for_a_label() -> None:
    axes = _axes()
    curves = [
        axes.plot(X[::20], X[::20] + shift, marker=marker)[0]
        for shift, marker in ((0.0, "s"), (0.02, "^"), (0.04, "s"))
    ]
    assert not label_curves(axes, curves, ["first", "second", "third"])


def test_without_room_nothing_is_added() -> None:
    axes = _axes(height=16.0)
    levels = np.linspace(0.05, 0.95, 12)
    curves = [axes.plot(X, np.full_like(X, level))[0] for level in levels]
    assert not label_curves(axes, curves, [f"curve {level:.2f}" for level in levels])
    assert not axes.texts
