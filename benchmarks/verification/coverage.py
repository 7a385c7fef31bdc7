"""Whether the estimated errors of results hold: each against the true one."""

import re
import time
from collections.abc import Iterator
from dataclasses import asdict
from functools import cache
from typing import Any

import numpy as np
from benchmarks.pages import Check, Data, Section, table
from numpy.typing import NDArray

from fretwear import Case
from fretwear.mechanics.integrator import evolve
from fretwear.mechanics.measures import measure
from fretwear.running.errors import estimated_errors
from fretwear.running.simulate import wear_problem
from fretwear.study.doubts import LARGE_ERROR, doubts
from fretwear.study.tree import COARSER
from fretwear.vocabulary import SCALARS

BASE: dict[str, Any] = {
    "youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "load": "20 N",
    "friction": 0.5, "wear_coefficient": "7e-13 / Pa", "cycles": 3000,
}  # fmt: skip
RADIUS = "10 mm"
CYCLES = (0.0, 100.0, 1000.0, 3000.0)
WAVES = (
    ("0.1 um", "1.5 deg", "1 deg"),
    ("0.2 um", "3 deg", "1.5 deg"),
    ("0.05 um", "1 deg", "1 deg"),
)
RATIOS = (0.1, 0.3, 0.5, 0.8, 0.95)
REFERENCE = 4.0
# How much finer steps and rings of the truth are.
FINER = 2.0
# A rough case on its default cells would have a reference that takes minutes.
WIDER = 2.0
# What is smaller is no result but a trace; what errs less errs by rounding and the reference.
TRACE, LEAST_ERROR = 0.01, 1e-4
WITHIN, LARGEST_RATIO = 0.9, 6.0
# What is imposed is no result.
IMPOSED = ("regime", "normal_force", "tangential_force")
JUDGED = [each.name for each in SCALARS if each.is_headline and each.name not in IMPOSED]


def cases() -> Iterator[tuple[str, Case, Case]]:
    """A name, the case, and that of its truth."""
    for limit in (None, "4500 MPa"):
        words = "capped" if limit else "elastic"
        for ratio in RATIOS:
            given = {**BASE, "tangential_ratio": ratio, "plastic_limit": limit}
            sphere = Case(**given, indenter={"kind": "sphere", "radius": RADIUS})
            # The same shape, of which a case does not know that rings would do.
            body = Case(
                **given, indenter={"kind": "ellipsoid", "radius_x": RADIUS, "radius_y": RADIUS}
            )
            yield f"smooth on rings, {words}, X = {ratio}", sphere, sphere
            yield f"smooth on a grid, {words}, X = {ratio}", body, sphere
        for waves in WAVES:
            rough = dict(zip(("amplitude", "slope_x", "slope_y"), waves, strict=True))
            for ratio in RATIOS[1::2] if limit else RATIOS:
                given = {**BASE, "tangential_ratio": ratio, "plastic_limit": limit}
                case = Case(**given, radius=RADIUS, roughness={"kind": "wavy", **rough})
                case = case.replace(cell=[WIDER * each for each in case.grid_spacing])
                narrow = case.replace(cell=[each / REFERENCE for each in case.grid_spacing])
                yield f"rough, A = {waves[0]}, {words}, X = {ratio}", case, narrow


def values(case: Case, wider: float = 1.0, tolerance: float = 1.0) -> tuple[Data, float]:
    """Scalars at the snapshots on wider rings, and what the run took, s."""
    began = time.process_time()
    problem = wear_problem(case, coarseness=wider)
    states = evolve(problem, CYCLES[1:], tolerance * case.tolerance)
    rows = [asdict(measure(problem, state)) for state in states if state.cycle in CYCLES]
    found = {
        name: " ".join(f"{row[name]:.6g}" for row in rows) for name in JUDGED if name in rows[0]
    }
    return found, time.process_time() - began


def run() -> Data:
    return {name: compared(case, true) for name, case, true in cases()}


def compared(case: Case, true: Case) -> Data:
    """Scalars of a case, of its twin and of its truth, and the cost of the twin."""
    result, seconds = values(case)
    twin, beside = values(case.coarser, COARSER)
    return {"cost": beside / seconds, "result": result, "twin": twin, "truth": truth_of(true)}


@cache
def truth_of(case: Case) -> Data:
    """Scalars of the case of a truth, on narrower rings where it is on rings."""
    finer = 1.0 / FINER if case.is_on_rings else 1.0
    return values(case, finer, finer)[0]


def _numbers(of_run: Data) -> dict[str, NDArray[np.float64]]:
    return {name: np.array(text.split(), dtype=float) for name, text in of_run.items()}


def judged(entry: Data, case: Case) -> Data:
    """True and estimated errors of a case relative to the values, and whether it is warned of."""
    result, twin, truth = (_numbers(entry[each]) for each in ("result", "twin", "truth"))
    rows = [
        [{name: each[name][at] for name in each} for at in range(len(CYCLES))]
        for each in (result, twin)
    ]
    estimates = estimated_errors(*rows)
    found: dict[str, list[float]] = {"true": [], "estimated": []}
    largest = {}
    for name, right in truth.items():
        counts = np.abs(right) > TRACE * np.abs(right).max()
        size = np.abs(right[counts])
        found["true"] += list(np.abs(result[name] - right)[counts] / size)
        found["estimated"] += list(estimates[name][counts] / size)
        largest[name] = float((estimates[name][counts] / size).max(initial=0.0))
    # That an ellipsoid may be elongated is no doubt of a round one.
    told = [each for each in doubts(case, largest) if "elongated" not in each.what]
    return {**found, "told": bool(told)}


def summary(entries: list[Data]) -> Data:
    """What holds of some cases."""
    true, estimated = (
        np.concatenate([each[key] for each in entries]) for key in ("true", "estimated")
    )
    within = true <= np.maximum(estimated, LEAST_ERROR)
    matters = (true > LEAST_ERROR) & (estimated > 0)
    silent = [max(each["true"]) > LARGE_ERROR and not each["told"] for each in entries]
    return {
        "count": len(entries),
        "results": true.size,
        "within": float(within.mean()),
        "ratio": float(np.median(estimated[matters] / true[matters])),
        "true": float(np.median(true)),
        "largest": float(true.max()),
        "told": sum(each["told"] for each in entries),
        "silent": sum(silent),
    }


def all_judged(data: Data) -> dict[str, Data]:
    return {name: judged(data[name], case) for name, case, _ in cases() if name in data}


def checks(data: Data) -> list[Check]:
    found = summary(list(all_judged(data).values()))
    return [
        Check(
            "results whose true error is not within the estimate",
            1.0 - found["within"],
            1.0 - WITHIN,
        ),
        Check(
            "cases with a true error above 5 % and no warning",
            found["silent"] / found["count"],
            0.0,
        ),
    ]


def text(data: Data) -> str:
    everything = all_judged(data)
    groups = {
        "smooth on rings": "smooth on rings",
        "smooth on a grid": "smooth on a grid",
        "rough, elastic": "rough.*elastic",
        "rough, capped": "rough.*capped",
        "all": "",
    }
    lines = []
    for label, pattern in groups.items():
        names = [name for name in everything if re.match(pattern, name)]
        if not names:
            continue
        found = summary([everything[name] for name in names])
        cost = np.median([data[name]["cost"] for name in names])
        lines.append([
            label, str(found["count"]), str(found["results"]), f"{found['within']:.1%}",
            f"{found['ratio']:.1f}", f"{found['true']:.2%}", f"{found['largest']:.0%}",
            str(found["told"]), str(found["silent"]), f"{cost:+.0%}",
        ])  # fmt: skip
    of_each = table(
        ["", "cases", "results", "within", "estimate / true", "true, median", "true, largest",
         "warned of", "above 5 %, not warned of", "cost"],
        lines,
    )  # fmt: skip
    return f"""\
{len(everything)} varied cases of {BASE["load"]}, {BASE["cycles"]} cycles, X = {RATIOS[0]} to
{RATIOS[-1]}: smooth ones on rings, which is how they are computed, and on a grid, as elliptical
contacts are; wavy ones of three amplitudes; elastic and with a plastic limit of 4500 MPa. Each is
run on its usual cells, rough ones on cells {WIDER:g} times wider, and beside it its twin, by which
errors are estimated. The truth has cells {REFERENCE:g} times narrower, of smooth ones rings half as
wide and half the tolerance. A result is the value of a scalar at one of the cycles 0, 100, 1000 and
3000, if it is more than a hundredth of the largest of them.

{of_each}

"Estimate / true" is the median ratio of both errors (allowed: {LARGEST_RATIO:g}), the cost that of
the twin in processor time relative to the run. It takes half an hour, and is measured where its
name is given only.
"""


SECTION = Section("coverage", "Estimated against true errors", run, text, checks, on_request=True)
