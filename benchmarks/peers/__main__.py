"""Command line of the comparison with other libraries."""

import argparse
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.peers import cold, wear_loop
from benchmarks.peers.rows import CELLS, CELLS_ON_RADIUS, cold_row, installed, loop_row
from benchmarks.speed.rows import Row, document, header, line

DEFAULT = Path("benchmarks/results/peers.json")


def measure(cells: int, cells_on_radius: float) -> tuple[list[Row], dict[str, Any]]:
    """The cold solve on one and on two threads, and the wear loop on one; printed as they come."""
    rows, found = [], {"cold_cells": cells, "cold": {}}
    for workers in (1, 2):
        results = [result.as_json() for result in cold.compare(cells, workers)]
        found["cold"][str(workers)] = results
        print(f"cold solve, {cells}² whole cells, threads: {workers}")
        for entry in results:
            times = f"{entry['cpu']:9.3f} s processor {entry['wall']:9.3f} s clock"
            print(f"  {entry['name']:<26}{times}   residual {entry['residual']:.1e}", flush=True)
        if workers == 1:
            rows.append(cold_row(cells, results))
    loop = wear_loop.compare(cells_on_radius)
    found["wear_loop"] = loop
    own = loop["own"]
    print(f"whole run of 30000 cycles, a/{cells_on_radius:g}: {own['cpu']:.2f} s by fretwear")
    for entry in loop["peers"]:
        for kind in ("limit", "longer"):
            run = entry[kind]
            print(
                f"  {entry['name']:<26}{run['seconds']:9.0f} s, {run['steps']:6.0f} steps "
                f"({kind}), residual {entry['residual']:.0e}: {run['ratio']:.0f} ×"
            )
    rows.append(loop_row(loop))
    return rows, found


def main(arguments: Sequence[str] | None = None) -> int:
    """Print both comparisons and write the JSON file."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers", description=__doc__)
    parser.add_argument("--cells", type=int, default=CELLS, help="whole cells of the cold solve")
    parser.add_argument(
        "--cells-on-radius", type=float, default=CELLS_ON_RADIUS, help="of the wear run"
    )
    parser.add_argument("--output", type=Path, default=DEFAULT, help="the JSON file")
    options = parser.parse_args(arguments)
    if not installed():
        print("tamaas and ContactMechanics are not installed: pip install -e '.[bench]'")
        return 2
    started = time.perf_counter()
    rows, found = measure(options.cells, options.cells_on_radius)
    seconds = round(time.perf_counter() - started, 1)
    options.output.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(document(rows, seconds=seconds, **found), indent=1, ensure_ascii=False)
    options.output.write_text(text + "\n", "utf-8")
    print(header(), *map(line, rows), f"{seconds:.0f} s; written to {options.output}", sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
