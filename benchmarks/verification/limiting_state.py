"""The smooth elastic sphere after 30000 cycles against the limit of infinitely many."""

import numpy as np
from benchmarks.pages import Data, Section, named, worst
from benchmarks.verification.problems import DEPTH, VOLUME, Snapshot, snapshots
from matplotlib.figure import Figure
from tests.mechanics.problems import HERTZ, P0, A, fretting

from fretwear.figures.style import JournalFigure, sequential_colours, styled
from fretwear.theory import LimitingState

CYCLES = 30000.0
CELLS, RATIOS = 110, (0.2, 0.5, 0.9)
NAMES = {
    "central_pressure": "central pressure",
    "deepest_wear": "depth",
    "wear_volume": "volume",
    "half_width": "contact radius",
}
APART = 6  # cells between points that are kept of profiles
NARROW = 0.2
WHOLE, POSITIONS = 102, 10
"""Whole cells on the stick radius of X = 0.2, and positions of its edge within the next one."""


def values(snapshot: Snapshot) -> dict[str, float]:
    """Results in units of the Hertzian contact."""
    found = snapshot.measures
    return {
        "central_pressure": found.central_pressure / P0,
        "deepest_wear": snapshot.deepest_wear / DEPTH,
        "wear_volume": found.wear_volume / VOLUME,
        "half_width": found.contact_half_width_x / A,
    }


def limits(ratio: float) -> dict[str, float]:
    """The same of the limiting state."""
    state = LimitingState(HERTZ, ratio)
    return {
        "central_pressure": state.central_pressure / P0,
        "deepest_wear": state.deepest_wear / DEPTH,
        "wear_volume": state.wear_volume / VOLUME,
        "half_width": state.contact_radius / A,
    }


def _last(cells: float, ratio: float) -> Snapshot:
    return snapshots(fretting(cells, load_ratio=ratio), [CYCLES])[CYCLES]


def along_x(snapshot: Snapshot) -> dict[str, list[float]]:
    """Pressure and wear depth along x in some cells, in units of the Hertzian contact."""
    state = snapshot.state
    some = slice(0, None, APART)
    return {
        "x": [float(x) for x in state.geometry.x[some] / A],
        "pressure": [float(p) for p in state.pressure[some, 0] / P0],
        "wear_depth": [float(w) for w in state.wear[some, 0] / DEPTH],
    }


def run() -> Data:
    stick = LimitingState(HERTZ, NARROW).stick_radius / A
    edges = [(WHOLE + position / POSITIONS) / stick for position in range(POSITIONS)]
    last = {ratio: _last(CELLS, ratio) for ratio in RATIOS}
    return {
        "ratios": [{"ratio": ratio, **values(one)} for ratio, one in last.items()],
        "along_x": [{"ratio": ratio, **along_x(one)} for ratio, one in last.items()],
        "scatter": [values(_last(cells, NARROW)) for cells in edges],
    }


def deviation(row: Data, ratio: float, name: str) -> float:
    return row[name] / limits(ratio)[name] - 1


def rows(data: Data) -> list[list[str]]:
    wide = [row for row in data["ratios"] if row["ratio"] != NARROW]
    found = {
        words: worst(deviation(row, row["ratio"], name) for row in wide)
        for name, words in NAMES.items()
    }
    narrow = {
        NAMES[name]: worst(deviation(row, NARROW, name) for row in data["scatter"])
        for name in ("deepest_wear", "wear_volume")
    }
    against = "closed forms of the limit"
    return [
        [f"sphere after {CYCLES:.0f} cycles, X = 0.5 and 0.9", against, named(found)],
        [f"the same, X = {NARROW}: the worn ring is 12 cells wide", against, named(narrow)],
    ]


@styled
def draw(data: Data) -> Figure:
    """Pressure and wear depth along x: computed points on the curves of theory."""
    figure = JournalFigure(2, 66.0)
    left, right = figure.subplots(1, 2)
    radius = np.linspace(0.0, 1.7, 700)
    colors = sequential_colours(len(data["along_x"]))
    for points, color in zip(data["along_x"], colors, strict=True):
        state = LimitingState(HERTZ, points["ratio"])
        inside = radius * A < 0.999 * state.stick_radius
        pressure = np.where(inside, state.pressure(np.where(inside, radius * A, 0.0)), 0.0)
        left.plot(radius, pressure / P0, color=color, lw=0.9)
        label = f"$Q/µP$ = {points['ratio']}"
        right.plot(radius, state.wear_depth(radius * A) / DEPTH, color=color, lw=0.9, label=label)
        for axes, name in ((left, "pressure"), (right, "wear_depth")):
            axes.plot(points["x"], points[name], "o", ms=2.6, color=color)
    left.set(ylabel="Pressure over $p_0$", ylim=(0.0, 3.0))
    right.set(ylabel="Wear depth over $a^2/R$", ylim=(0.0, 0.75))
    for axes in (left, right):
        axes.set(xlabel="$x/a$", xlim=(0.0, 1.7))
    right.legend(loc="upper left")
    return figure


SECTION = Section(
    "limiting_state",
    "The limit of many cycles, smooth and elastic",
    run,
    figures=lambda data: {"": draw(data)},
)
