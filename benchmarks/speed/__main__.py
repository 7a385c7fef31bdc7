"""Command line of the table of speeds."""

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

from benchmarks.speed import contacts, resources, runs
from benchmarks.speed.rows import Row, document, falling_short, header, line

DEFAULT = Path("benchmarks/results/speed.json")

Group = Callable[[], Iterator[Row]]


def groups(full: bool, coarser: float, repeats: int) -> dict[str, Group]:
    """What can be measured, by name; ``coarser`` makes grids coarser, to try the command out."""

    def contact() -> Iterator[Row]:
        cells = max(16, round(256 / coarser))
        yield contacts.cold_contact(rough=False, cells=cells, repeats=repeats)
        yield contacts.cold_contact(rough=True, cells=cells, repeats=repeats)

    def memory() -> Iterator[Row]:
        yield resources.peak_memory(256 / coarser)

    return {
        "contact": contact,
        "smooth": partial(runs.smooth_rows, 128 / coarser),
        "rough": partial(runs.rough_rows, coarser, halved=full),
        "peers": partial(_peers, full, coarser),
        "memory": memory,
        "start": partial(resources.start_times, 2 * repeats - 1),
    }


def _peers(full: bool, coarser: float) -> Iterator[Row]:
    from benchmarks.peers.rows import rows, unmeasured

    if full:
        yield from rows(coarser)
    else:
        yield from unmeasured("with --full and the extra bench")


def measure(wanted: dict[str, Group]) -> list[Row]:
    """Measure some groups and print each line as it comes."""
    table = []
    print(header())
    for group in wanted.values():
        for row in group():
            table.append(row)
            print(line(row), flush=True)
    return table


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table and write the JSON file; 1 where a row falls short of what is asked."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.speed", description=__doc__)
    names = list(groups(full=False, coarser=1.0, repeats=5))
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
    wanted = groups(options.full, options.coarser, options.repeats)
    wanted = {name: wanted[name] for name in options.group or names}
    started = time.perf_counter()
    table = measure(wanted)
    seconds = round(time.perf_counter() - started, 1)
    result = document(table, seconds=seconds, coarser=options.coarser)
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", "utf-8")
    print(f"{seconds:.0f} s; written to {options.output}")
    return 1 if falling_short(table) else 0


if __name__ == "__main__":
    sys.exit(main())
