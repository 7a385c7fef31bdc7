"""Command line of the page of performance."""

import argparse
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.performance import page
from benchmarks.performance.parts import PARTS
from benchmarks.speed.rows import ROOT


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the parts and write the page; with ``--render`` or ``--check`` measure none."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.performance", description=__doc__)
    names = [part.name for part in PARTS]
    parser.add_argument("part", nargs="*", help=f"what to measure, of {', '.join(names)}")
    parser.add_argument("--render", action="store_true", help="write the page from stored data")
    parser.add_argument("--check", action="store_true", help="say whether the page is up to date")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs", help="folder of the page")
    options = parser.parse_args(arguments)
    if unknown := sorted(set(options.part) - set(names)):
        parser.error(f"no such part: {', '.join(unknown)}; there are {', '.join(names)}")
    if options.check:
        return page.check(options.docs)
    parts = [part for part in PARTS if not options.part or part.name in options.part]
    if options.render:
        parts = []
    if len(parts) == 1:
        page.measure(options.docs, parts[0])
    else:
        # Each in a process of its own: memory of the largest child counts all that a process had.
        for part in parts:
            alone = [sys.executable, "-m", "benchmarks.performance", part.name]
            subprocess.run([*alone, "--docs", str(options.docs)], check=True, cwd=ROOT)
    page.write(options.docs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
