"""Whether the estimated errors of results hold: each against the true one.

``python -m benchmarks.verification.coverage coated`` runs the families that it names.
"""

import math
import re
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
from benchmarks.pages import Data, Section
from numpy.typing import NDArray

from fretwear import Case
from fretwear.results import RESULTS, SCALARS
from fretwear.run.simulate import run as run_case
from fretwear.study.case_warnings import LARGE_ERROR
from fretwear.study.plan import estimate
from fretwear.study.unworn import unworn

BASE: dict[str, Any] = {
    "youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "cycles": 3000, "accuracy": "none",
}  # fmt: skip
CYCLES = (0, 100, 1000, 3000)
# How many cases of each family; every other one is capped where the name does not say.
FAMILIES = {
    "smooth elastic": 3, "smooth capped": 5, "elliptical": 5, "rough elastic": 8,
    "rough capped": 8, "line": 5, "rough line": 8, "punch": 5, "stroke": 5,
    "displacement": 5, "debris": 3, "coated": 20,
}  # fmt: skip
SEED = 20268
# The indenter of the cases of a family, if not a sphere; and the families that are rough.
LINES = {
    "line": range(5), "rough line": range(8), "punch": (0, 1), "stroke": (0, 1, 3),
    "displacement": (2,), "debris": (1,), "coated": [n for n in range(20) if n % 4 < 2],
}  # fmt: skip
# A stroke is every fourth case with a coating; of point contacts, one in two is on rings.
STROKES_OF = {"stroke": range(5), "coated": range(1, 20, 4)}
RINGS_OF = {"coated": range(2, 20, 4)}
PUNCHES = {"punch": range(5), "stroke": (1,), "displacement": (3,)}
ROUGH = {
    "rough elastic": range(8), "rough capped": range(8), "rough line": range(8), "stroke": (3,),
    "displacement": (1,),
}  # fmt: skip
RATIOS, LOADS, RADII = (0.1, 0.95), (10.0, 50.0), (5.0, 20.0)  # X, N, mm
LOADS_OF_LINE, LOADS_OF_RIDGES = (100.0, 600.0), (50.0, 200.0)  # N/mm
MOST_OF_TRANSITION = 1.2  # U/U_t
FLATS = (50.0, 500.0)  # um
STROKES = (5.0, 50.0)  # amplitude, um
WEAR, WEAR_OF_STROKE = 7e-13, 2e-14  # 1/Pa
DEBRIS = (0.3, 0.9)
AMPLITUDES, SLOPES = (0.06, 0.2), (1.0, 4.0)  # um, deg
SLOPES_OF_STROKE = (0.2, 0.5)  # each wave takes more positions
LIMITS = (2.5, 6.0)  # plastic limit over Hertz's pressure
# Of a coating: E and K over those of the substrate, ν, and h over the depth that would wear.
MODULI, COEFFICIENTS, POISSON_RATIOS, DEPTHS = (0.3, 3.0), (0.1, 3.0), (0.15, 0.4), (0.1, 0.8)
# How much finer cells of the truth are, half as much where it would take longer than this, s.
REFERENCE, LONGEST = 4.0, 15.0
# The tolerance over the tolerance of the truth; on a grid steps err far less than cells.
FINER = 10.0
# A smaller value is a trace, no result; a smaller error is due to rounding and the reference.
TRACE, LEAST_ERROR = 0.01, 1e-4
# Imposed quantities are no results.
IMPOSED = ("regime", "normal_force")
JUDGED = [each.name for each in SCALARS if each.is_headline and each.name not in IMPOSED]
JUDGED += ["worn_through_cycle", "exposed_area", "coating_left"]


def cases(families: Iterable[str] = tuple(FAMILIES)) -> Iterator[tuple[str, Case, Case]]:
    """A name, the case, and the case of its truth; drawn at random, X evenly."""
    for family in families:
        count = FAMILIES[family]
        rng = np.random.default_rng([SEED, *family.encode()])
        places = (rng.permutation(count) + 0.5) / count
        for number, place in enumerate(places):
            name, case = _drawn(family, number, place, rng)
            yield name, case, truth_of(case)


def truth_of(case: Case) -> Case:
    """The case by which another one is judged, on wider cells if it would take longer."""
    true = case.replace(cell=[each / REFERENCE for each in case.grid_spacing])
    if estimate(true).seconds > LONGEST and not case.cells.is_graded:
        return case.replace(cell=[2.0 * each for each in true.grid_spacing])
    return true


def _drawn(family: str, number: int, place: float, rng: np.random.Generator) -> tuple[str, Case]:
    """A case of a family and its name; the place is the position of X in its range."""

    def between(least: float, most: float) -> float:
        return float(f"{math.exp(rng.uniform(math.log(least), math.log(most))):.2g}")

    def is_among(which: Mapping[str, Iterable[int]]) -> bool:
        return number in which.get(family, ())

    is_line, is_punch, is_rough = map(is_among, (LINES, PUNCHES, ROUGH))
    of_line = LOADS_OF_RIDGES if is_rough else LOADS_OF_LINE
    force = between(*(of_line if is_line else LOADS))
    load = f"{force:g} N/mm" if is_line else f"{force:g} N"
    radius, friction, limit = between(*RADII), between(0.3, 0.8), between(*LIMITS)
    waves = [between(*AMPLITUDES), between(*SLOPES), between(1.0, 2.0)]
    radius_y, flat, stroke = between(*RADII), between(*FLATS), between(*STROKES)
    kept, gentle = between(*DEBRIS), between(*SLOPES_OF_STROKE)
    indenter: Data = {"kind": "cylinder" if is_line else "sphere", "radius": f"{radius} mm"}
    if is_punch:
        size = "flat_half_width" if is_line else "flat_radius"
        indenter = {"kind": "flat_punch" if is_line else "round_punch"}
        indenter |= {size: f"{flat} um", "edge_radius": f"{radius} mm"}
    elif family == "elliptical":
        radius_y = radius_y if number >= 2 else radius
        indenter = {"kind": "ellipsoid", "radius_x": f"{radius} mm", "radius_y": f"{radius_y} mm"}
    ratio = RATIOS[0] + place * (RATIOS[1] - RATIOS[0])
    parameters = {
        **BASE, "load": load, "friction": friction, "tangential_ratio": round(ratio, 3),
        "indenter": indenter, "wear_coefficient": WEAR,
    }  # fmt: skip
    words = [family, str(indenter["kind"]).replace("_", " "), f"X = {ratio:.2f}"]
    if is_among(STROKES_OF):
        words[-1] = f"stroke {stroke} um"
        del parameters["tangential_ratio"]
        parameters |= {"sliding_amplitude": f"{stroke} um"}
        parameters["wear_coefficient"] = [WEAR_OF_STROKE, WEAR_OF_STROKE]
    if family == "displacement":
        ratio = RATIOS[0] + place * (MOST_OF_TRANSITION - RATIOS[0])
        words[-1] = f"U/U_t = {ratio:.2f}"
        compliance = between(0.005, 0.05) if is_line else 0.0
        del parameters["tangential_ratio"]
        if is_line:
            parameters["tangential_compliance"] = f"{compliance} um/(N/mm)"
            parameters["displacement_amplitude"] = f"{ratio * friction * force * compliance:.3g} um"
        else:
            parameters["displacement_ratio"] = round(ratio, 3)
    if is_rough:
        slope_x = gentle if family == "stroke" else waves[1]
        slope_y = 0.0 if is_line else waves[2]
        angles = {"slope_x": f"{slope_x} deg", "slope_y": f"{slope_y} deg"}
        parameters["roughness"] = {"kind": "wavy", "amplitude": f"{waves[0]} um", **angles}
        words.append(f"A = {waves[0]} um")
    if family == "debris":
        parameters["debris_fraction"] = kept
        words.append(f"{kept:g} kept")
    if family == "coated":
        if is_among(RINGS_OF):
            parameters["slip_model"] = "jaeger"
        bare, stiffer, faster = Case(**parameters), between(*MODULI), between(*COEFFICIENTS)
        # Every fifth coating is too thick to wear through.
        whole = bare.hertz_radius if number % 5 == 4 else min(faster, 1.0) * _depth(bare)
        thickness = float(f"{between(*DEPTHS) * whole:.2g}")
        own = faster * (WEAR_OF_STROKE if is_among(STROKES_OF) else WEAR)
        parameters["coating"] = {
            "thickness": f"{thickness} m", "youngs_modulus": f"{208 * stiffer:.4g} GPa",
            "poisson_ratio": between(*POISSON_RATIOS), "wear_coefficient": f"{own:.3g} / Pa",
        }  # fmt: skip
        words.append(f"h = {1e6 * thickness:.2g} um, E {stiffer:g}, K {faster:g}")
    elif "capped" in family or ("elastic" not in family and number % 2):
        pressure = limit * Case(**parameters).hertz.peak_pressure
        parameters["plastic_limit"] = f"{pressure * 1e-6:.0f} MPa"
        words.append(f"{limit:g} p0")
    return ", ".join([*words, load, f"{radius:g} mm"]), Case(**parameters)


def _depth(case: Case) -> float:
    """About how deep the flat wears without a coating, m: a chord, or the slip annulus evenly."""
    load, stroke = case.hertz.load, case.loading.stroke
    if stroke:
        volume = WEAR_OF_STROKE * load * 4.0 * stroke * case.cycles
        return float((0.75 * volume / math.sqrt(2.0 * case.indenter.radius)) ** (2.0 / 3.0))
    known = unworn(case)
    energy = known["dissipated_energy"] / case.friction_law.coefficient
    slipping = known["contact_area"] - known["stick_area"]
    return WEAR * energy * case.cycles / slipping


def measured(name: str, case: Case, true: Case) -> Data:
    """Results of a case, their estimated errors of cells and steps, and its truth.

    The truth has the same slip model, so that the printed error of that model is left out.
    """
    began = time.process_time()
    found = run_case(case.replace(output_cycles=CYCLES))
    seconds = time.process_time() - began
    finer = case.tolerance / (1.0 if case.has_equal_cells and case.coating is None else FINER)
    exact = true.replace(output_cycles=CYCLES, error_estimate=False, tolerance=finer)
    truth = run_case(exact).dataset
    print(f"{name}: {seconds:.1f} s, in all {time.process_time() - began:.0f} s", flush=True)
    names = [each for each in JUDGED if each in truth and each in found.errors]
    columns = {"result": found.dataset, "estimate": found.errors, "truth": truth}
    texts = {
        key: {each: " ".join(f"{v:.6g}" for v in np.asarray(of[each])) for each in names}
        for key, of in columns.items()
    }
    told = [
        text for text in found.dataset.attrs["warnings"].splitlines() if "elongated" not in text
    ]
    return {"seconds": time.process_time() - began, "told": bool(told), **texts}


def run(families: Iterable[str] = tuple(FAMILIES)) -> Data:
    """Two cases at a time."""
    drawn = list(zip(*cases(families=families), strict=True))
    with ProcessPoolExecutor(2) as pool:
        return dict(zip(drawn[0], pool.map(measured, *drawn), strict=True))


def _numbers(of_run: Data) -> dict[str, NDArray[np.float64]]:
    return {name: np.array(text.split(), dtype=float) for name, text in of_run.items()}


def judged(entry: Data) -> Data:
    """True and estimated errors of a case relative to the values, and whether it is warned of."""
    result, estimates, truth = (_numbers(entry[each]) for each in ("result", "estimate", "truth"))
    found: dict[str, list[float]] = {"true": [], "estimated": []}
    largest, worst = {}, {}
    for name in truth:
        # A zone that is not there has nothing.
        right, own, estimate = (np.nan_to_num(of[name]) for of in (truth, result, estimates))
        counts = np.abs(right) > TRACE * np.abs(right).max()
        size = np.abs(right[counts])
        found["true"] += list(np.abs(own - right)[counts] / size)
        found["estimated"] += list(estimate[counts] / size)
        largest[name] = float((estimate[counts] / size).max(initial=0.0))
        worst[name] = float((np.abs(own - right)[counts] / size).max(initial=0.0))
    missed = max(worst, key=lambda name: worst[name])
    silence = f"{RESULTS[missed].words} {worst[missed]:.1%} off, estimated as {largest[missed]:.1%}"
    return {**found, "told": entry["told"], "silence": silence}


def summary(entries: list[Data]) -> Data:
    """Properties of some cases."""
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
        "largest": float(true.max()),
        "silent": sum(silent),
    }


def all_judged(data: Data) -> dict[str, Data]:
    return {name: judged(data[name]) for name, *_ in cases() if name in data}


def sentence(data: Data) -> str:
    """The paragraph of the page."""
    everything = all_judged(data)
    groups = {
        family: summary(
            [each for name, each in everything.items() if name.startswith(f"{family},")]
        )
        for family in FAMILIES
        if any(name.startswith(f"{family},") for name in everything)
    }
    found = summary(list(everything.values()))
    shares = [group["within"] for group in groups.values()]
    least = min(groups, key=lambda family: groups[family]["within"])
    left_out = sum(FAMILIES.values()) - len(everything)
    without = f" ({left_out} more, which take longest, are left out)" if left_out else ""
    silent = f"All but {found['silent']} cases" if found["silent"] else "All cases"
    text = f"""\
**{found["within"]:.1%} of {found["results"]} true errors lie within their estimates**, which are {found["ratio"]:.1f} times as large in the median. By kind of case,
{min(shares):.0%} ({least}) to {max(shares):.0%} do. The largest true error is {found["largest"]:.0%} (plastic volume and late energy of rough contacts).
{silent} with an error above {LARGE_ERROR:.0%} had a warning.

The {len(everything)} cases of {BASE["cycles"]} cycles were drawn at random{without}: all surfaces, indenters and loadings, X = {_range(RATIOS)}. The
truth comes from cells {REFERENCE:g} times narrower (`python -m benchmarks.verification coverage`).
"""
    return re.sub(r"(?<=\d)%", " %", text)


def _range(ends: tuple[float, float]) -> str:
    return f"{ends[0]:g} to {ends[1]:g}"


SECTION = Section("coverage", "Estimated against true errors", run, on_request=True)

if __name__ == "__main__":
    found = run(sys.argv[1:] or tuple(FAMILIES))
    print(sentence(found))
    for case_name, entry in all_judged(found).items():
        print(f"{case_name}: {summary([entry])['within']:.1%} within, {entry['silence']}")
