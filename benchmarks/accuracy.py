"""Cases drawn at random ask for an accuracy, and are compared with runs on far narrower cells.

``python -m benchmarks.accuracy --minutes 20`` takes the cases of `benchmarks.verification.coverage`
in turn from each family, asks each for 1, 2 or 5 %, and compares every result that an accuracy is
asked for with a run on cells a quarter of the default (half, where that would take long) at a tenth
of the tolerance. It prints for each case the largest true error, whether the case tells that it
has not reached its accuracy, and its processor time over the time of the same case on default
cells; then the share of results within the accuracy or told, and within the estimated errors.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections import defaultdict
from collections.abc import Iterator
from itertools import zip_longest

import numpy as np
from benchmarks.verification import coverage

from fretwear import Case, simulate
from fretwear.running.accuracy import ASKED, relative_errors

ACCURACIES = (0.02, 0.01, 0.05)


def cases() -> Iterator[tuple[str, Case, Case]]:
    """A name, a case and the case of its truth, one of each family after the other."""
    families = defaultdict(list)
    for each in coverage.cases():
        families[each[0].split(",")[0]].append(each)
    for row in zip_longest(*families.values()):
        yield from filter(None, row)


def compared(case: Case, true: Case) -> tuple[dict[str, float], dict[str, float], bool, float]:
    """True errors and estimated ones by result, whether they are told, and the relative time."""
    began = time.process_time()
    usual = case.replace(accuracy=None)
    simulate(usual, quarter=True)
    halfway = time.process_time()
    found = simulate(case, quarter=True)
    spent = (time.process_time() - halfway) / (halfway - began)
    rows = coverage.values(true, tolerance=1.0 / coverage.FINER)[0]
    names = [name for name in ASKED if name in rows and name in found]
    reference = {name: np.array(rows[name].split(), dtype=float) for name in names}
    apart = {name: np.abs(found[name].values - reference[name]) for name in names}
    estimates = {name: found[f"{name}_error"].values for name in names}
    told = "less accurately than" in found.attrs["warnings"]
    return relative_errors(reference, apart), relative_errors(reference, estimates), told, spent


def main() -> None:
    """Compare until the time is over."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--family", default="", help="only families whose names begin with this")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    began, kept, covered, total = time.monotonic(), 0, 0, 0
    for number, (name, case, true) in enumerate(cases()):
        if time.monotonic() - began > 60.0 * given.minutes:
            break
        if not name.startswith(given.family):
            continue
        accuracy = ACCURACIES[number % len(ACCURACIES)]
        asked = case.replace(
            accuracy=accuracy, output_cycles=[int(cycle) for cycle in coverage.CYCLES]
        )
        errors, estimates, told, spent = compared(asked, true)
        worst = max(errors, key=lambda result: errors[result])
        print(
            f"{name}: {accuracy:.0%} asked, {errors[worst]:.2%} off ({worst})"
            f"{', told' if told else ''}, {spent:.2f} times the usual time",
            flush=True,
        )
        total += len(errors)
        kept += sum(told or error <= accuracy for error in errors.values())
        covered += sum(error <= max(estimates[n], 1e-4) for n, error in errors.items())
    print(
        f"seed {coverage.SEED}: {kept} of {total} results within the accuracy or told, "
        f"{covered} within their estimates"
    )


if __name__ == "__main__":
    main()
