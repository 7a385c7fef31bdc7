"""Cases drawn at random ask for an accuracy, and are compared with runs on far narrower cells.

``python -m benchmarks.accuracy --minutes 20`` takes sixty cases, those of
`benchmarks.verification.coverage` and of one more seed, in turn from each family, asks each for 1,
2 or 5 %, and compares every result that an accuracy is asked for with a run on cells a quarter of
the default (half, where that would take long) at a tenth of the tolerance. It prints for each case
the largest true error, whether the case tells that it has not reached its accuracy, and its
processor time over the time of the same case on default cells; then the share of results within the
accuracy or told, and within the estimated errors. `costs` are a section of the page Performance.
"""

from __future__ import annotations

import argparse
import math
import time
import warnings
from collections import defaultdict
from collections.abc import Iterator
from itertools import islice, zip_longest

import numpy as np
from benchmarks.pages import Data, points, table
from benchmarks.verification import coverage
from matplotlib.ticker import FixedLocator, NullLocator

from fretwear import Case, simulate
from fretwear.figures.style import JournalFigure, styled
from fretwear.running.accuracy import ASKED, relative_errors
from fretwear.study.plan import estimate

ACCURACIES = (0.02, 0.01, 0.05)
COUNT = 60
# Kinds whose quickest cases show the cost against the error, and the accuracies asked for.
KINDS = ("smooth elastic", "smooth capped", "elliptical", "rough elastic", "rough capped")
LEVELS = (0.05, 0.02, 0.01, 0.005)
QUICK = 3  # runs of which the shortest time counts, if they take less than a second


def cases() -> Iterator[tuple[str, Case, Case]]:
    """A name, a case and the case of its truth, one of each family after the other."""
    for seed in (coverage.SEED, coverage.SEED + 1):
        families = defaultdict(list)
        for each in coverage.cases(seed):
            families[each[0].split(",")[0]].append(each)
        for row in zip_longest(*families.values()):
            yield from filter(None, row)


def timed(case: Case) -> tuple[Data, float]:
    """The results of a case, and its processor time, s."""
    spent: list[float] = []
    while len(spent) < (QUICK if sum(spent) < 1.0 else 1):
        began = time.process_time()
        found = simulate(case, quarter=True)
        spent.append(time.process_time() - began)
    return found, min(spent)


def judged(found: Data, reference: Data) -> tuple[dict[str, float], dict[str, float]]:
    """True errors and estimated ones by result."""
    names = [name for name in ASKED if name in reference and name in found]
    right = {name: np.array(reference[name].split(), dtype=float) for name in names}
    apart = {name: np.abs(found[name].values - right[name]) for name in names}
    estimates = {name: found[f"{name}_error"].values for name in names}
    return relative_errors(right, apart), relative_errors(right, estimates)


def is_told(found: Data) -> bool:
    """Whether a case tells that it has not reached its accuracy."""
    return "less accurately than" in found.attrs["warnings"]


def truth(true: Case) -> Data:
    """The scalars of a true case, in text by name."""
    return coverage.values(true, tolerance=1.0 / coverage.FINER)[0]


def compared(case: Case, true: Case) -> tuple[dict[str, float], dict[str, float], bool, float]:
    """True errors and estimated ones by result, whether they are told, and the relative time."""
    _, usual = timed(case.replace(accuracy="none"))
    found, spent = timed(case)
    return *judged(found, truth(true)), is_told(found), spent / usual


def costs() -> Data:
    """Time and error of a case of each kind on default cells, and for each accuracy."""
    warnings.simplefilter("ignore")
    kinds = []
    for kind in KINDS:
        name, case, _ = min(
            (each for each in cases() if each[0].startswith(f"{kind},")),
            key=lambda each: estimate(each[1]).seconds,
        )
        true = coverage.truth_of(case, math.inf)
        case = case.replace(output_cycles=[int(cycle) for cycle in coverage.CYCLES])
        reference = truth(true)
        found, usual = timed(case)
        runs = [{"accuracy": None, "seconds": usual, "told": False, **_worst(found, reference)}]
        for accuracy in LEVELS:
            found, seconds = timed(case.replace(accuracy=accuracy))
            of_run = {"accuracy": accuracy, "seconds": seconds, "told": is_told(found)}
            runs.append({**of_run, **_worst(found, reference)})
            print(name, runs[-1], flush=True)
        kinds.append({"name": name, "runs": runs})
    return {"kinds": kinds}


def _worst(found: Data, reference: Data) -> Data:
    errors, estimates = judged(found, reference)
    return {"error": max(errors.values()), "estimate": max(estimates.values())}


def costs_text(data: Data) -> str:
    """The table of `costs`."""
    rows = []
    for kind in data["kinds"]:
        usual = kind["runs"][0]["seconds"]
        for run in kind["runs"]:
            asked = "default cells" if run["accuracy"] is None else f"{100.0 * run['accuracy']:g} %"
            missed = ", not reached" if run["told"] else ""
            rows.append([
                kind["name"].split(",")[0], asked + missed, f"{run['seconds']:.2g}",
                f"{run['seconds'] / usual:.2g}",
                *(f"{100.0 * run[key]:.2g} %" for key in ("error", "estimate")),
            ])  # fmt: skip
    header = ["", "asked", "processor, s", "times default", "largest error", "largest estimate"]
    names = "\n".join(f"- {kind['name']}" for kind in data["kinds"])
    return f"""\
One case of each kind asks for 5, 2, 1 and 0.5 %, with `budget: 10`. Errors are the largest of the
results that an accuracy is asked for at the snapshots, against cells a quarter of the default at a
tenth of the tolerance; where a row says "not reached", the case reports that it has not reached its
accuracy. Each is the quickest of its kind among sixty drawn at random, of 3000 cycles:

{names}

{table(header, rows)}

{{figure}}
"""


@styled
def costs_figure(data: Data) -> JournalFigure:
    """Largest error against time over that on default cells."""
    figure = JournalFigure(columns=1, height=72)
    axes = figure.subplots()
    for index, kind in enumerate(data["kinds"]):
        usual, *runs = kind["runs"]
        times = [run["seconds"] / usual["seconds"] for run in runs]
        label = kind["name"].split(",")[0]
        points(axes, times, [100.0 * run["error"] for run in runs], index, label)
        color = axes.lines[-1].get_color()
        axes.plot([1.0], [100.0 * usual["error"]], "o", mfc="none", mec=color, ms=7)
    axes.set(xscale="log", yscale="log", ylabel="largest error (%)")
    axes.margins(0.06)
    axes.set_xlabel("time over that on default cells (circles)")
    for axis, ticks in ((axes.xaxis, (0.5, 1, 2, 5, 10)), (axes.yaxis, (0.03, 0.1, 0.3, 1, 3))):
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
    axes.legend()
    return figure


def main() -> None:
    """Compare until the time is over."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--family", default="", help="only families whose names begin with this")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    began, kept, covered, total = time.monotonic(), 0, 0, 0
    for number, (name, case, true) in enumerate(islice(cases(), COUNT)):
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
        f"seeds {coverage.SEED} and {coverage.SEED + 1}: {kept} of {total} results within the "
        f"accuracy or told, {covered} within their estimates"
    )


if __name__ == "__main__":
    main()
