"""Time and memory of the smooth run against its cells."""

from collections.abc import Sequence
from typing import Any

from benchmarks.scale.growth import exponent
from benchmarks.speed.resources import run_alone

SIZES = (64, 128, 256, 512, 1024, 2048)
QUICK_SIZES = SIZES[:4]
LARGEST = 3
"""Exponents are those of so many of the largest sizes."""

# Half-width of the last window of the run over the Hertz radius.
_REACH = 1.5


def curve(sizes: Sequence[int] = SIZES) -> dict[str, Any]:
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
