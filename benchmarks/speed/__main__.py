"""Command line of the table of speeds."""

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from benchmarks.pages import write_json
from benchmarks.peers import __main__ as peers
from benchmarks.speed.jobs import groups, measure
from benchmarks.speed.table import Row, document, falling_short

DEFAULT = Path("benchmarks/results/speed.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table and write the JSON file; 1 if a row falls short of its requirement."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.speed", description=__doc__)
    names = [*groups(), "peers"]
    parser.add_argument("group", nargs="*", help=f"what to measure, of {', '.join(names)}")
    parser.add_argument("--full", action="store_true", help="half the spacing and peers too")
    parser.add_argument("--repeats", type=int, default=5, help="repetitions of the short jobs")
    parser.add_argument(
        "--coarser", type=float, default=1.0, help="coarser grids by this factor: a try, no result"
    )
    parser.add_argument("--output", type=Path, default=DEFAULT, help="the JSON file")
    options = parser.parse_args(arguments)
    if unknown := sorted(set(options.group) - set(names)):
        parser.error(f"no such group: {', '.join(unknown)}; there are {', '.join(names)}")
    known = groups(full=options.full, coarser=options.coarser, repeats=options.repeats)
    known["peers"] = partial(_peers, options.full, options.coarser)
    started = time.perf_counter()
    table = measure(known[name] for name in options.group or names)
    seconds = round(time.perf_counter() - started, 1)
    result = document(table, seconds=seconds, coarser=options.coarser)
    write_json(options.output, result)
    print(f"{seconds:.0f} s; written to {options.output}")
    return 1 if falling_short(table) else 0


def _peers(full: bool, coarser: float) -> Iterator[Row]:
    if full:
        return peers.rows(coarser)
    return peers.unmeasured("with --full and the extra bench")


if __name__ == "__main__":
    sys.exit(main())
