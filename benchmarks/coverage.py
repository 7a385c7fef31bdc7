"""Whether the estimated errors of results hold: run ``python -m benchmarks.coverage [--every N]``.

Forty varied cases, each on wide cells, against the same case on cells four times narrower; smooth
ones against rings. Printed are the share of all results and snapshots whose true error is within
the estimate, the median of estimate over true error, and the cases with a true error above 5 %
about which nothing warns. Even cases are those that constants were chosen on, odd ones judge.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

import fretwear
from fretwear.mechanics.geometry.grid import Grid
from fretwear.running.simulate import run
from fretwear.study.doubts import LARGE_ERROR
from fretwear.vocabulary import SCALARS

REFERENCE = 4.0
# Beyond which an error is one of rounding and of the reference, relative to the value.
LEAST_ERROR = 1e-4
BASE: dict[str, Any] = {
    "radius": "10 mm", "youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "load": "20 N",
    "friction": 0.5, "wear_coefficient": "7e-13 / Pa", "cycles": 3000,
    "output_cycles": [0, 100, 1000, 3000],
}  # fmt: skip
WAVES = (
    None,
    ("0.1 um", "1.5 deg", "1 deg"),
    ("0.2 um", "3 deg", "1.5 deg"),
    ("0.05 um", "1 deg", "1 deg"),
)
RATIOS = (0.1, 0.3, 0.5, 0.8, 0.95)
JUDGED = [each for each in SCALARS if each.is_headline and each.name != "regime"]


def cases() -> Iterator[dict[str, Any]]:
    """Parameters of every case but its cell."""
    for limit in ("none", "4500 MPa"):
        for waves in WAVES:
            rough = waves and dict(zip(("amplitude", "slope_x", "slope_y"), waves, strict=True))
            for ratio in RATIOS:
                yield {
                    **BASE,
                    "roughness": {"kind": "wavy", **rough} if rough else "none",
                    "plastic_limit": limit,
                    "tangential_ratio": ratio,
                }


def compared(given: dict[str, Any]) -> tuple[list[tuple[float, float, float]], bool, float]:
    """Value, true error and estimate of each result; whether a warning is there; cost, parts."""
    case = fretwear.Case(**given)
    narrow = [width / REFERENCE for width in case.grid_spacing]
    smooth = case.roughness is None
    seconds = []
    for wanted in (False, True):
        began = time.process_time()
        one = case.replace(error_estimate=wanted)
        dataset = run(one, geometry=Grid if smooth else None).dataset
        seconds.append(time.process_time() - began)
    finer = case.replace(error_estimate=False, **({} if smooth else {"cell": narrow}))
    truth = run(finer).dataset
    found = []
    for each in JUDGED:
        values, right = dataset[each.name].values, truth[each.name].values
        estimates = dataset[each.error.name].values
        counts = np.abs(right) > 0.01 * np.abs(right).max()
        of_each = zip(right[counts], values[counts], estimates[counts], strict=True)
        found += [(abs(r), abs(v - r), e) for r, v, e in of_each]
    return found, bool(dataset.attrs["warnings"]), seconds[1] / seconds[0] - 1.0


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="only every so many-th case")
    every = parser.parse_args().every
    warnings.simplefilter("ignore")
    halves: dict[str, list[tuple[float, float, float]]] = {"chosen on": [], "judged": []}
    silent, costs = 0, []
    for number, given in enumerate(cases()):
        if number % every:
            continue
        found, told, cost = compared(given)
        halves["judged" if number // every % 2 else "chosen on"] += found
        costs.append(cost)
        worst = max(error / size for size, error, _ in found)
        silent += worst > LARGE_ERROR and not told
        inside = np.mean([error <= max(e, LEAST_ERROR * size) for size, error, e in found])
        print(f"{number:3d} within {inside:5.0%} largest {worst:5.1%} told {told}", flush=True)
    for name, found in halves.items():
        if not found:
            continue
        size, error, estimate = np.array(found).T
        within = error <= np.maximum(estimate, LEAST_ERROR * size)
        matters = (error > LEAST_ERROR * size) & (estimate > 0)
        ratio = np.median(estimate[matters] / error[matters])
        print(f"{name}: {within.mean():.1%} of {size.size} within, median ratio {ratio:.2f}")
    print(f"silent above {LARGE_ERROR:.0%}: {silent}; cost {np.median(costs):+.0%} in the median")


if __name__ == "__main__":
    main()
