"""How time and memory grow with the cells of a case and with the cases of a study.

``python -m benchmarks.scale`` prints both curves and writes them as JSON.
"""

import argparse
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from benchmarks.pages import ROOT, points, write_json
from benchmarks.speed.cases import STUDY
from benchmarks.speed.jobs import children_seconds, run_alone
from benchmarks.speed.table import surroundings
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from fretwear.figures.style import MUTED, JournalFigure, styled

SIZES = (64, 128, 256, 512, 1024, 2048)
QUICK_SIZES = SIZES[:4]
LARGEST = 3
"""Number of the largest sizes from which exponents are fitted."""

# Half-width of the last window of the run over the Hertz radius.
_REACH = 1.5


def cells_curve(sizes: Sequence[int] = SIZES) -> dict[str, Any]:
    """Run 30000 cycles on about so many quarter cells along x and y, each in its own process."""
    points = []
    for size in sizes:
        found = run_alone(size / _REACH, 30000)
        nx, ny = found["shape"]
        points.append({"cells": nx * ny, **found})
        print(
            f"{nx:>6} × {ny:<6}{found['cpu']:9.1f} s processor {found['wall']:9.1f} s clock "
            f"{found['peak_bytes'] / 1e6:8.0f} MB ({found['arrays']:.1f} arrays) "
            f"{found['steps']} steps, {found['convolutions']} convolutions",
            flush=True,
        )
    cells = [point["cells"] for point in points]
    above = [point["peak_bytes"] - point["start_bytes"] for point in points]
    return {
        "points": points,
        "time_exponent": exponent(cells, [point["cpu"] for point in points], LARGEST),
        "memory_exponent": exponent(cells, above, LARGEST),
    }


COUNTS = (1, 10, 100, 1000)
QUICK_COUNTS = COUNTS[:2]
CORES = 2


def tiny_study(cases: int) -> dict[str, Any]:
    """A study of so many cases that each take a fraction of a second: 100 cycles, 10 µm cells."""
    base = {key: value for key, value in STUDY.items() if key != "load"}
    loads = [f"{50 + 50 * point / cases:.6g} N" for point in range(cases)]
    return {
        "title": f"{cases} tiny cases",
        "base": {
            **base,
            "cell": "10 um",
            "cycles": 100,
            "plastic_limit": "none",
            "roughness": "none",
        },
        "vary": {"load": loads},
    }


def cases_curve(counts: Sequence[int] = COUNTS) -> dict[str, Any]:
    """Run the workflow for so many cases, each in a fresh folder."""
    points = [_workflow(count) for count in counts]
    many = [point for point in points if point["cases"] >= 10] or points
    return {
        "cores": CORES,
        "points": points,
        "time_exponent": exponent(
            [point["cases"] for point in many], [point["wall"] for point in many]
        ),
    }


def _workflow(cases: int) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copy(ROOT / "Snakefile", folder)
        shutil.copytree(ROOT / "profiles", folder / "profiles")
        (folder / "studies").mkdir()
        study = yaml.safe_dump(tiny_study(cases), sort_keys=False)
        (folder / "studies" / "demo.yaml").write_text(study, encoding="utf-8")
        log = folder / "log"
        before, started = children_seconds(), time.perf_counter()
        with log.open("w", encoding="utf-8") as stream:
            done = subprocess.run(
                [sys.executable, "-m", "snakemake", "--cores", str(CORES)],
                cwd=folder,
                env=os.environ | {"OMP_NUM_THREADS": "1"},
                stdout=stream,
                stderr=subprocess.STDOUT,
                check=False,
            )
        wall, cpu = time.perf_counter() - started, children_seconds() - before
        if done.returncode:
            raise RuntimeError(log.read_text(encoding="utf-8")[-2000:])
        results = folder / "results" / "demo"
        written = sum(1 for _ in (results / "cases").glob("*.nc"))
        if written != cases:
            raise RuntimeError(f"the workflow wrote {written} cases instead of {cases}")
        size = sum(file.stat().st_size for file in results.rglob("*") if file.is_file())
    peak = 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    print(
        f"{cases:>6} cases {wall:9.1f} s clock {cpu:9.1f} s processor, largest process "
        f"{peak / 1e6:.0f} MB, results {size / 1e6:.1f} MB",
        flush=True,
    )
    return {"cases": cases, "wall": wall, "cpu": cpu, "peak_bytes": peak, "result_bytes": size}


def exponent(size: Sequence[float], amount: Sequence[float], last: int | None = None) -> float:
    """Power with which an amount grows with a size: slope of the logarithms, least squares.

    ``last`` takes only so many of the largest sizes, where constant costs no longer count.
    """
    first = 0 if last is None else max(0, len(size) - last)
    if len(size) - first < 2:
        return float("nan")
    slope, _ = np.polyfit(np.log(size[first:]), np.log(amount[first:]), 1)
    return float(slope)


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


DEFAULT = Path("benchmarks/results/scale.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """Print both curves and write the JSON file."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scale", description=__doc__)
    parser.add_argument("--full", action="store_true", help="to 2048² cells and 1000 cases")
    parser.add_argument("--cells", type=int, nargs="*", help="quarter cells along x and y")
    parser.add_argument("--cases", type=int, nargs="*", help="numbers of cases")
    parser.add_argument("--output", type=Path, default=DEFAULT, help="the JSON file")
    options = parser.parse_args(arguments)
    sizes, counts = options.cells, options.cases
    if sizes is None:
        sizes = SIZES if options.full else QUICK_SIZES
    if counts is None:
        counts = COUNTS if options.full else QUICK_COUNTS
    started = time.perf_counter()
    result = surroundings()
    if sizes:
        result["cells"] = cells_curve(sizes)
        print(f"time grows like cells^{result['cells']['time_exponent']:.2f}, ", end="")
        print(f"memory like cells^{result['cells']['memory_exponent']:.2f}")
    if counts:
        result["cases"] = cases_curve(counts)
        print(f"time grows like cases^{result['cases']['time_exponent']:.2f}")
    result["seconds"] = round(time.perf_counter() - started, 1)
    write_json(options.output, result)
    print(f"{result['seconds']:.0f} s; written to {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
