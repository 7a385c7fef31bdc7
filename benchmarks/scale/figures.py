"""The curves of the scale."""

from typing import Any

from benchmarks.scale.cells import LARGEST
from benchmarks.verification.plots import points
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from fretwear.figures.style import MUTED, JournalFigure, styled


@styled
def cells_figure(data: dict[str, Any]) -> Figure:
    """Time and memory against cells."""
    figure = JournalFigure(columns=2, height=72)
    left, right = figure.subplots(1, 2)
    cells = [point["cells"] for point in data["points"]]
    points(left, cells, [point["cpu"] for point in data["points"]], 0, "processor time")
    _power(left, cells, [p["cpu"] for p in data["points"]], data["time_exponent"])
    _log(left, "quarter cells", "processor time (s)")
    memory = [(p["peak_bytes"] - p["start_bytes"]) / 1e6 for p in data["points"]]
    points(right, cells, memory, 1, "memory of the run")
    _power(right, cells, memory, data["memory_exponent"])
    _log(right, "quarter cells", "memory above the interpreter (MB)")
    return figure


@styled
def cases_figure(data: dict[str, Any]) -> Figure:
    """Time of the workflow against cases."""
    figure = JournalFigure(columns=1, height=66)
    axes = figure.subplots()
    cases = [point["cases"] for point in data["points"]]
    points(axes, cases, [p["wall"] for p in data["points"]], 0, "clock")
    points(axes, cases, [p["cpu"] for p in data["points"]], 1, "processor, all processes")
    _log(axes, "cases", "time of the workflow (s)")
    axes.legend()
    return figure


def _log(axes: Axes, x: str, y: str) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    # Labels at the powers of ten alone; markers on the border are whole.
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter(NullFormatter())
    axes.margins(0.06)
    axes.set_xlabel(x)
    axes.set_ylabel(y)


def _power(axes: Axes, x: list[float], y: list[float], power: float) -> None:
    """Say the exponent of the largest sizes beside a line of that slope."""
    first = max(0, len(x) - LARGEST)
    ends = [1.35 * y[-1] * (x[first] / x[-1]) ** power, 1.35 * y[-1]]
    axes.plot([x[first], x[-1]], ends, color=MUTED, lw=0.7, ls=(0, (4, 2)))
    axes.annotate(
        f"cells$^{{{power:.2f}}}$", ((x[first] * x[-1]) ** 0.5, (ends[0] * ends[1]) ** 0.5),
        xytext=(-3, 3), textcoords="offset points", ha="right", va="bottom", color=MUTED,
    )  # fmt: skip
