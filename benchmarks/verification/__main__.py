"""Command line of the verification."""

import argparse
import sys
from pathlib import Path

from benchmarks.verification import page
from benchmarks.verification.store import Store

ROOT = Path(__file__).resolve().parents[2]


def main() -> int:
    """Run comparisons and write the page; with ``--render`` or ``--check`` run none."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.verification", description=__doc__)
    names = [section.name for section in page.SECTIONS]
    parser.add_argument(
        "sections", nargs="*", metavar="SECTION", help=f"what to run, of {', '.join(names)}"
    )
    parser.add_argument("--render", action="store_true", help="write the page from stored data")
    parser.add_argument("--check", action="store_true", help="say whether the page is up to date")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs", help="folder of the page")
    options = parser.parse_args()
    unknown = sorted(set(options.sections) - set(names))
    if unknown:
        parser.error(f"no such section: {', '.join(unknown)}; there are {', '.join(names)}")
    store = Store(options.docs / "verification.json")
    if options.check:
        return page.check(options.docs, store)
    if not options.render:
        for section in page.SECTIONS:
            if not options.sections or section.name in options.sections:
                store.measure(section)
    page.write(options.docs, store)
    return 0


if __name__ == "__main__":
    sys.exit(main())
