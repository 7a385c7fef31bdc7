"""Command line of the curves of time and memory."""

import argparse
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.scale import cases, cells
from benchmarks.speed.rows import surroundings

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
        sizes = cells.SIZES if options.full else cells.QUICK_SIZES
    if counts is None:
        counts = cases.COUNTS if options.full else cases.QUICK_COUNTS
    started = time.perf_counter()
    result = surroundings()
    if sizes:
        result["cells"] = cells.curve(sizes)
        print(f"time grows like cells^{result['cells']['time_exponent']:.2f}, ", end="")
        print(f"memory like cells^{result['cells']['memory_exponent']:.2f}")
    if counts:
        result["cases"] = cases.curve(counts)
        print(f"time grows like cases^{result['cases']['time_exponent']:.2f}")
    result["seconds"] = round(time.perf_counter() - started, 1)
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", "utf-8")
    print(f"{result['seconds']:.0f} s; written to {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
