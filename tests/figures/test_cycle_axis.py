"""An axis of cycles is logarithmic and still shows cycle 0."""

import numpy as np
import pytest
from matplotlib.axes import Axes

from fretwear.figures.axes import set_cycle_axis
from fretwear.figures.style import JournalFigure


def _axes(cycles: list[float]) -> Axes:
    axes = JournalFigure(1, 60.0).subplots()
    axes.plot(cycles, cycles)
    set_cycle_axis(axes, cycles)
    return axes


def _at(axes: Axes, cycle: float) -> float:
    """Return where a cycle lies along the axis, from 0 to 1."""
    return float(axes.transAxes.inverted().transform(axes.transData.transform((cycle, 0.0)))[0])


def test_decades_are_equally_long_and_zero_lies_before_them() -> None:
    axes = _axes([0, 10, 100, 1000, 30000])
    positions = [_at(axes, cycle) for cycle in (0, 10, 100, 1000, 10000)]
    steps = np.diff(positions)
    np.testing.assert_allclose(steps[1:], steps[1], rtol=1e-9)
    assert 0.0 <= positions[0] < 0.05
    assert 0.3 * steps[1] < steps[0] < steps[1]
    assert _at(axes, 30000) <= 1.0


def _words(axes: Axes) -> list[str]:
    axes.figure.draw_without_rendering()
    return [label.get_text() for label in axes.get_xticklabels() if label.get_text()]


def test_ticks_name_zero_and_every_decade_and_the_last_cycle() -> None:
    assert _words(_axes([0, 10, 100, 1000, 7000])) == ["0", "10", "100", "1000", "7000"]
    assert _words(_axes([0, 10, 1000])) == ["0", "10", "100", "1000"]


def test_a_decade_whose_number_would_touch_that_of_the_last_cycle_is_not_named() -> None:
    words = _words(_axes([0, 10, 100, 1000, 12000]))
    assert words == ["0", "10", "100", "1000", "12\u2009000"]


@pytest.mark.parametrize("cycles", [[0, 30000], [0, 2000, 7000], [0], [5, 7]])
def test_cycles_within_a_decade_are_on_a_linear_axis(cycles: list[float]) -> None:
    axes = _axes(cycles)
    assert axes.get_xscale() == "linear"
    assert axes.get_xlabel() == "Cycle"


def test_without_cycle_zero_there_is_no_break() -> None:
    axes = _axes([10, 100, 1000])
    assert [line.get_label() for line in axes.get_lines()].count("_break") == 0
    assert 0.0 < _at(axes, 10) < 0.1
