"""Measurements beside the studies, and how they are compared with results."""

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from benchmarks.pages import ROOT, Data, percent, table
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import ArrayLike, NDArray

import fretwear
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.style import MUTED

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
STUDIES = ROOT / "studies" / "experiments"
REPEATS = 0.2  # relative scatter of volumes of one test done again: Fouvry et al. (2017)


def rows(name: str) -> list[dict[str, str]]:
    """The rows of measurements of a file beside the studies."""
    text = (STUDIES / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in text if not line.startswith("#")))


def column(table_: Iterable[Mapping[str, str]], name: str) -> NDArray[np.float64]:
    """Numbers of a column."""
    return np.array([float(row[name]) for row in table_])


def solved(name: str, *changes: str) -> Iterator[xr.Dataset]:
    """The last state of every point of a study, or all states of its snapshots, in order."""
    study = fretwear.load_study(STUDIES / f"{name}.yaml", changes)
    for point in study.points():
        assert point.case is not None
        yield fretwear.simulate(point.case, quarter=True)


def volumes(name: str, length: ArrayLike, *changes: str) -> NDArray[np.float64]:
    """Worn volumes of a study of line contacts of a length in mm, mm³."""
    areas = [1e6 * float(each["wear_volume"].isel(cycle=-1)) for each in solved(name, *changes)]
    return np.array(areas) * length


def scar(case: xr.Dataset, name: str = "wear_depth") -> tuple[NDArray[np.float64], ...]:
    """Positions, mm, and depths, µm, along x of the last snapshot."""
    depth = case[name].isel(cycle=-1)
    return 1e3 * depth["x"].to_numpy().astype(float), 1e6 * depth.to_numpy().astype(float)


def width_at(x: ArrayLike, depth: ArrayLike, level: float) -> float:
    """The position, mm, outside which a scar is shallower than a level."""
    return float(np.interp(level, np.asarray(depth)[::-1], np.asarray(x)[::-1]))


def rms(deviations: ArrayLike) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(deviations))))


def point(label: str, measured: float, computed: float, unit: str, **details: Any) -> Data:
    """A measured and a computed number, with the scatter of the former relative to it."""
    return {"label": label, "measured": measured, "computed": computed, "unit": unit, **details}


def comparison(points: Mapping[str, Sequence[Data]]) -> str:
    """A table of measured and computed numbers, by the name of the experiment."""
    lines = []
    for name, of_one in points.items():
        for each in of_one:
            deviation = percent(each["computed"] / each["measured"] - 1.0)
            basis = f", {each['basis']}" if "basis" in each else ""
            computed = f"{each['computed']:.3g} ({deviation}{basis})"
            measured = f"{each['measured']:.3g} {each['unit']}"
            lines.append([f"{name}, {each['label']}", measured, computed])
    return table(["experiment", "measured", "computed"], lines, left=3)


def profile_figure(draw: Any) -> Figure:
    """A figure of scars, deepest below."""
    with fretwear.figures.style_context():
        figure = Figure(figsize=(3.6, 2.5), layout="constrained")
        axes = figure.subplots()
        draw(axes)
        axes.invert_yaxis()
        axes.legend(fontsize=6.5)
    return figure


def equality(axes: Any, points: Sequence[Data]) -> None:
    """Logarithmic axes with the line of equality and what is within 30 %."""
    values = [each[key] for each in points for key in ("measured", "computed")]
    ends = np.array([0.6 * min(values), 1.7 * max(values)])
    axes.plot(ends, ends, color=MUTED, lw=0.8)
    axes.fill_between(ends, ends / 1.3, 1.3 * ends, color=MUTED, alpha=0.12, lw=0)
    axes.set(xscale="log", yscale="log", xlim=ends, ylim=ends)
    few = (1.0, 2.0, 5.0) if ends[1] < 50.0 * ends[0] else (1.0,)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=few))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())


def mark(axes: Any, points: Sequence[Data], index: int, label: str) -> None:
    """Points of one series with the scatter of what was measured."""
    if points:
        measured = np.array([each["measured"] for each in points])
        spread = measured * [each.get("scatter", 0.0) for each in points]
        axes.errorbar(
            measured,
            [each["computed"] for each in points],
            xerr=spread,
            label=label,
            ls="",
            marker=MARKERS[index % len(MARKERS)],
            ms=3.5,
            elinewidth=0.6,
            color=CATEGORICAL[index % len(CATEGORICAL)],
        )
