"""Labels beside curves touch neither curves nor each other, or are left to a legend."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox

from fretwear.figures.direct_labels import Curve, label_curves
from fretwear.figures.style import JournalFigure, style_context

X = np.linspace(0.0, 1.0, 200)


def _axes(height: float = 60.0) -> Axes:
    with style_context():
        axes = JournalFigure(1, height).subplots()
        axes.set_xlim(0.0, 1.0)
        axes.set_ylim(0.0, 1.0)
        return axes


def _crosses(box: Bbox, axes: Axes, curve: Curve) -> bool:
    dense = np.linspace(0.0, 1.0, 5000)
    points = axes.transData.transform(np.column_stack([dense, np.interp(dense, curve.x, curve.y)]))
    return any(box.contains(*point) for point in points)


def test_labels_are_clear_of_every_curve_and_nearest_to_their_own() -> None:
    axes = _axes()
    curves = [Curve(X, 0.9 * (1.0 - X**power), f"n{power}", "k") for power in (1, 2, 4)]
    assert label_curves(axes, curves)
    boxes = {text.get_text(): text.get_window_extent() for text in axes.texts}
    assert set(boxes) == {"n1", "n2", "n4"}
    for name, box in boxes.items():
        assert not any(_crosses(box, axes, curve) for curve in curves)
        assert axes.bbox.containsx(box.x0)
        assert axes.bbox.containsx(box.x1)
        centre = axes.transData.inverted().transform(box.get_points().mean(axis=0))
        away = {c.label: np.hypot(c.x - centre[0], c.y - centre[1]).min() for c in curves}
        assert min(away, key=away.get) == name


def test_curves_that_cannot_be_told_apart_share_a_label() -> None:
    axes = _axes()
    curves = [
        Curve(X, X, "7000", "a"),
        Curve(X, X + 1e-4, "30 000", "b"),
        Curve(X, 0.3 * X, "0", "c"),
    ]
    with style_context():
        coloured = [Curve(c.x, c.y, c.label, f"C{i}") for i, c in enumerate(curves)]
        assert label_curves(axes, coloured)
    assert {text.get_text() for text in axes.texts} == {"7000, 30 000", "0"}


def test_without_room_nothing_is_added() -> None:
    axes = _axes(height=16.0)
    curves = [Curve(X, np.full_like(X, level), f"curve {level:.2f}", "k")
              for level in np.linspace(0.05, 0.95, 12)]  # fmt: skip
    assert not label_curves(axes, curves)
    assert not axes.texts
