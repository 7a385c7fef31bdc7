"""The simulator beside other libraries, in the same process and in turn."""

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from benchmarks.pages import write_json
from benchmarks.peers import contacts, wear_loop
from benchmarks.peers.contacts import RESIDUAL
from benchmarks.speed.table import Row, document, header, line, missing

COLD = ("cold_peers", "against the fastest peer, cold, {cells}² whole cells", 10.0, 20.0)
LOOP = ("wear_peers", "against a peer-driven explicit wear loop, a/{cells:g}", 200.0, 1000.0)
CELLS, CELLS_ON_RADIUS = 512, 128.0


def installed() -> bool:
    """Whether the extra ``bench`` is there."""
    return all(find_spec(name) is not None for name in ("tamaas", "ContactMechanics"))


def unmeasured(why: str) -> Iterator[Row]:
    """Both lines without a number."""
    for (name, job, asked, aim), cells in ((COLD, CELLS), (LOOP, CELLS_ON_RADIUS)):
        yield missing(name, job.format(cells=cells), "×", asked, aim, why)


def cold_row(cells: int, results: list[dict[str, Any]]) -> Row:
    """How many times faster than the fastest peer, on one thread."""
    ours, others = results[0], results[2:]
    fastest = min(others, key=lambda entry: entry["cpu"])
    name, job, asked, aim = COLD
    note = (
        f"{ours['cpu']:.2f} s ({results[1]['cpu']:.2f} s without symmetry) against "
        + ", ".join(f"{entry['cpu']:.2f} s {entry['name']}" for entry in others)
        + f"; {fastest['wall'] / ours['wall']:.1f} × by the clock"
    )
    ratio = fastest["cpu"] / ours["cpu"]
    return Row(name, job.format(cells=cells), ratio, "×", asked, aim, at_least=True, note=note)


def loop_row(found: dict[str, Any]) -> Row:
    """How many times faster than the fastest peer's loop at the same residual."""
    equal = [entry for entry in found["peers"] if entry["residual"] <= RESIDUAL]
    fastest = min(equal, key=lambda entry: entry["limit"]["seconds"])
    loop, favored = fastest["limit"], min(e["longer"]["ratio"] for e in found["peers"])
    name, job, asked, aim = LOOP
    note = (
        f"{found['own']['cpu']:.2f} s, {found['own']['steps']} steps against {fastest['name']}: "
        f"{loop['seconds']:.0f} s, {loop['steps']:.0f} steps; {favored:.0f} × where the loop may "
        "be a hundred times less exact and steps get longer late in the run"
    )
    job = job.format(cells=found["cells_on_radius"])
    return Row(name, job, loop["ratio"], "×", asked, aim, at_least=True, note=note)


def rows(coarser: float = 1.0) -> Iterator[Row]:
    """Both lines, measured where the libraries are installed."""
    if not installed():
        yield from unmeasured("the extra bench is not installed")
        return
    cells = max(32, round(CELLS / coarser))
    yield cold_row(cells, [result.as_json() for result in contacts.compare(cells)])
    yield loop_row(wear_loop.compare(CELLS_ON_RADIUS / coarser))


DEFAULT = Path("benchmarks/results/peers.json")


def measure(cells: int, cells_on_radius: float) -> tuple[list[Row], dict[str, Any]]:
    """The cold solve on one and on two threads, and the wear loop on one; printed as they come."""
    rows, found = [], {"cold_cells": cells, "cold": {}}
    for workers in (1, 2):
        results = [result.as_json() for result in contacts.compare(cells, workers)]
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
    write_json(options.output, document(rows, seconds=seconds, **found))
    print(header(), *map(line, rows), f"{seconds:.0f} s; written to {options.output}", sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
