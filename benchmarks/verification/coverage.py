"""Whether the estimated errors of results hold: each against the true one."""

import math
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
from benchmarks.pages import Check, Data, Section, table
from numpy.typing import NDArray

from fretwear import Case
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.integrator import evolve
from fretwear.mechanics.measures import measure
from fretwear.running.simulate import estimated_errors, wear_problem
from fretwear.study.doubts import LARGE_ERROR, doubts
from fretwear.vocabulary import SCALARS

BASE: dict[str, Any] = {
    "youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "wear_coefficient": "7e-13 / Pa",
    "cycles": 3000,
}  # fmt: skip
CYCLES = (0.0, 100.0, 1000.0, 3000.0)
# How many cases of each family; every other one is elastic where the name does not say.
FAMILIES = {
    "smooth elastic": 6, "smooth capped": 6, "elliptical": 6, "rough elastic": 8,
    "rough capped": 8, "line": 6, "rig": 8,
}  # fmt: skip
SEED = 20260
RATIOS, LOADS, RADII = (0.1, 0.95), (10.0, 50.0), (5.0, 20.0)  # X, N, mm
LOADS_OF_LINE = (100.0, 600.0)  # N/mm
AMPLITUDES, SLOPES = (0.06, 0.2), (1.0, 4.0)  # um, deg
LIMITS = (2.5, 6.0)  # plastic limit over Hertz's pressure
# How much finer cells and steps of the truth are.
REFERENCE, FINER = 4.0, 2.0
# What is smaller is no result but a trace; what errs less errs by rounding and the reference.
TRACE, LEAST_ERROR = 0.01, 1e-4
WITHIN, LARGEST_RATIO = 0.9, 6.0
# Runs are repeated for so long, s, to time them.
QUICK = 1.0
# What is imposed is no result.
IMPOSED = ("regime", "normal_force")
JUDGED = [each.name for each in SCALARS if each.is_headline and each.name not in IMPOSED]
HALVES = ("by which estimates were tuned", "others")


def cases() -> Iterator[tuple[str, Case, Case]]:
    """A name, the case, and that of its truth; drawn at random, X evenly."""
    for family, count in FAMILIES.items():
        rng = np.random.default_rng([SEED, *family.encode()])
        places = (rng.permutation(count) + 0.5) / count
        for number, place in enumerate(places):
            given, name = _drawn(family, number, RATIOS[0] + place * (RATIOS[1] - RATIOS[0]), rng)
            case = Case(**given)
            if family == "elliptical":
                # The same shape, of which a case does not know that rings would do.
                axes = dict.fromkeys(("radius_x", "radius_y"), given["indenter"]["radius"])
                yield name, case.replace(indenter={"kind": "ellipsoid", **axes}), case
            else:
                narrow = [each / REFERENCE for each in case.grid_spacing]
                yield name, case, case.replace(cell=narrow)


def _drawn(family: str, number: int, ratio: float, rng: np.random.Generator) -> tuple[Data, str]:
    """Arguments of a case, and its name."""

    def between(least: float, most: float) -> float:
        return float(f"{math.exp(rng.uniform(math.log(least), math.log(most))):.2g}")

    is_line = family == "line" or (family == "rig" and number % 4 == 3)
    force = between(*(LOADS_OF_LINE if is_line else LOADS))
    load = f"{force:g} N/mm" if is_line else f"{force:g} N"
    radius, friction, limit = between(*RADII), between(0.3, 0.8), between(*LIMITS)
    waves = [between(*AMPLITUDES), between(*SLOPES), between(1.0, 2.0)]
    kind = "cylinder" if is_line else "sphere"
    given = {
        **BASE, "load": load, "friction": friction, "tangential_ratio": round(ratio, 3),
        "indenter": {"kind": kind, "radius": f"{radius} mm"},
    }  # fmt: skip
    words = [family, f"X = {ratio:.2f}"]
    if family == "rig":
        words = ["rig, line" if is_line else "rig", f"U/U_t = {ratio:.2f}"]
        del given["tangential_ratio"]
        if is_line:
            compliance = between(0.005, 0.05)
            given["tangential_compliance"] = f"{compliance} um/(N/mm)"
            given["displacement_amplitude"] = f"{ratio * friction * force * compliance:.3g} um"
        else:
            given["displacement_ratio"] = round(ratio, 3)
    rough = "rough" in family or (family == "rig" and number % 4 >= 2 and not is_line)
    if rough:
        angles = {"slope_x": f"{waves[1]} deg", "slope_y": f"{waves[2]} deg"}
        given["roughness"] = {"kind": "wavy", "amplitude": f"{waves[0]} um", **angles}
        words.append(f"A = {waves[0]} um")
    if "capped" in family or ("elastic" not in family and number % 2):
        pressure = limit * Case(**given).hertz.peak_pressure
        given["plastic_limit"] = f"{pressure * 1e-6:.0f} MPa"
        words.append(f"{limit:g} p0")
    return given, ", ".join([*words, load, f"{radius:g} mm"])


def values(case: Case, wider: float = 1.0, tolerance: float = 1.0) -> tuple[Data, float]:
    """Scalars at the snapshots on wider rings or strips, and what the run took, s."""
    began = time.process_time()
    problem = wear_problem(case, coarseness=wider)
    states = evolve(problem, CYCLES[1:], tolerance * case.tolerance)
    rows = [vars(measure(problem.of(state), state)) for state in states if state.cycle in CYCLES]
    found = {
        name: " ".join(f"{row[name]:.6g}" for row in rows) for name in JUDGED if name in rows[0]
    }
    return found, time.process_time() - began


def measured(name: str, case: Case, true: Case) -> Data:
    """A case, its twin and its truth."""
    # Of the shortest of several runs, since most are short.
    runs = [(values(case), values(case.coarser, case.times_coarser))]
    while sum(each for run in runs for _, each in run) < QUICK:
        runs.append((values(case), values(case.coarser, case.times_coarser)))
    (result, _), (twin, _) = runs[0]
    seconds, beside = (min(run[which][1] for run in runs) for which in (0, 1))
    # Steps on a grid err far less than its cells.
    finer = 1.0 if wear_problem(true).geometry is Grid else 1.0 / FINER
    truth, longer = values(true, 1.0 / REFERENCE, finer)
    print(f"{name}: {seconds:.1f} s, truth {longer:.0f} s", flush=True)
    return {
        "seconds": seconds + beside + longer, "cost": beside / seconds,
        "result": result, "twin": twin, "truth": truth,
    }  # fmt: skip


def run() -> Data:
    """Two cases at a time."""
    drawn = list(zip(*cases(), strict=True))
    with ProcessPoolExecutor(2) as pool:
        return dict(zip(drawn[0], pool.map(measured, *drawn), strict=True))


def _numbers(of_run: Data) -> dict[str, NDArray[np.float64]]:
    return {name: np.array(text.split(), dtype=float) for name, text in of_run.items()}


def judged(entry: Data, case: Case) -> Data:
    """True and estimated errors of a case relative to the values, and whether it is warned of."""
    result, twin, truth = (_numbers(entry[each]) for each in ("result", "twin", "truth"))
    estimates = estimated_errors(result, twin, case.times_coarser)
    found: dict[str, list[float]] = {"true": [], "estimated": []}
    largest = {}
    for name in truth:
        # A zone that is not there has nothing.
        right, own, estimate = (np.nan_to_num(of[name]) for of in (truth, result, estimates))
        counts = np.abs(right) > TRACE * np.abs(right).max()
        size = np.abs(right[counts])
        found["true"] += list(np.abs(own - right)[counts] / size)
        found["estimated"] += list(estimate[counts] / size)
        largest[name] = float((estimate[counts] / size).max(initial=0.0))
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
    missed = 1.0 - found["within"]
    return [
        Check("results whose true error is not within the estimate", missed, 1.0 - WITHIN),
        Check(
            "cases with a true error above 5 % and no warning",
            found["silent"] / found["count"],
            0.0,
        ),
    ]


def text(data: Data) -> str:
    everything = all_judged(data)
    names = list(everything)
    groups = {family: [name for name in names if name.startswith(family)] for family in FAMILIES}
    # Every other pair, so that both halves have elastic and capped ones.
    for half, label in enumerate(HALVES):
        groups[label] = [name for at, name in enumerate(names) if at // 2 % 2 == half]
    groups["all"] = names
    lines = []
    for label, members in groups.items():
        if not members:
            continue
        found = summary([everything[name] for name in members])
        cost = np.median([data[name]["cost"] for name in members])
        lines.append([
            label, str(found["count"]), str(found["results"]), f"{found['within']:.1%}",
            f"{found['ratio']:.1f}", f"{found['true']:.2%}", f"{found['largest']:.1%}",
            str(found["told"]), str(found["silent"]), f"{cost:+.0%}",
        ])  # fmt: skip
    of_each = table(
        ["", "cases", "results", "within", "estimate / true", "true, median", "true, largest",
         "warned of", "above 5 %, not warned of", "cost"],
        lines,
    )  # fmt: skip
    minutes = math.ceil(sum(each["seconds"] for each in data.values()) / 60)
    return f"""\
{len(everything)} of {sum(FAMILIES.values())} cases of {BASE["cycles"]} cycles, drawn at random:
X = {_range(RATIOS)}, sphere and cylinder of {_range(RADII)} mm, {_range(LOADS)} N or
{_range(LOADS_OF_LINE)} N/mm, friction 0.3 to 0.8, waves of {_range(AMPLITUDES)} µm and up to
{SLOPES[1]:g}°, plastic limits of {_range(LIMITS)} p0. Half of the elliptical, line and rig cases
are capped; "rig" has an imposed displacement, on a sphere, smooth and rough, and on a cylinder.
Each is run as a user gets it, and beside it its twin, by which errors are estimated. The truth has
cells, rings or strips {REFERENCE:g} times narrower, and on rings and strips 1/{FINER:g} of the
tolerance; elliptical cases are round, and their truth is on rings.
A result is the value of a scalar at one of the cycles 0,
100, 1000 and 3000, if it is more than a hundredth of the largest of them. Half of the cases, every
other pair, were looked at when the constants of the estimates were chosen.

{of_each}

"Estimate / true" is the median ratio of both errors (allowed: {LARGEST_RATIO:g}), the cost that of
the twin in processor time relative to the steps of the run alone, without what is made of them. It
takes about {minutes} minutes, and is measured where its name is given only.
"""


def _range(ends: tuple[float, float]) -> str:
    return f"{ends[0]:g} to {ends[1]:g}"


SECTION = Section("coverage", "Estimated against true errors", run, text, checks, on_request=True)
