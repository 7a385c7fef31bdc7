"""How often intervals of fits hold the truth, on synthetic scars: ``python -m benchmarks.fits``.

Scars of this program with an offset, a tilt, a shift and noise of 2 to 10 % of their depth at 41 to
801 positions are fitted, one of them together with a loop, and scars in partial slip of an
independent integrator on rings. The noise is white, is correlated, or is the sum of both. Printed are the coverage of intervals, with the probability of a
coverage as far from the level, how often the best value lies inside its interval, a test of the
ranks of the truth among draws from the posterior, which are uniform where it is calibrated (Talts
et al., "Validating Bayesian inference algorithms with simulation-based calibration", 2018), errors
and runs.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.verification.reference_rings import Resolution, worn_rings
from tests.studies import SELF_AFFINE, TITANIUM

import fretwear
from fretwear.arrays import Array
from fretwear.run.simulate import run
from fretwear_fit.estimate import LEVELS
from fretwear_fit.noise import Noise
from fretwear_fit.search import fit

Numbers = dict[str, tuple[float, float]]
SPHERE = {
    "radius": "10 mm",
    "youngs_modulus": "208 GPa",
    "poisson_ratio": 0.3,
    "load": "50 N",
    "plastic_limit": "none",
    "roughness": "none",
    "cycles": 3000,
}
# Base, its wear coefficient from a number, ranges of the truth and of the search, half-width of the
# line, m.
RINGS, LOOP = "rings", "loop"
LINE = {n: v for n, v in SPHERE.items() if n != "radius"} | {
    "indenter": {"kind": "cylinder", "radius": "10 mm"}, "load": "100 N/mm"
}  # fmt: skip
COATING = {"youngs_modulus": "400 GPa", "poisson_ratio": 0.2}
SLIDES = {"sliding_amplitude": "20 um", "wear_coefficient": ["1e-16 / Pa", "2e-14 / Pa"]}
# The base of a coated cylinder, thickness and wear coefficient of the coating, their ranges (all
# coatings wear through, some just so), and half-width of the line.
COATED: dict[str, tuple[dict[str, Any], Numbers, float]] = {
    "stroke": (
        LINE | SLIDES | {"friction": 0.6, "cycles": 60000},
        {"thickness": (0.8e-6, 1.85e-6), "wear_coefficient": (0.65e-15, 2.1e-15)},
        700e-6,
    ),
    "partial": (
        LINE
        | {"tangential_load": "50 N/mm", "friction": 0.6, "wear_coefficient": "4e-13 / Pa"}
        | {"cycles": 8000},
        {"thickness": (0.04e-6, 0.09e-6), "wear_coefficient": (0.5e-13, 1.4e-13)},
        300e-6,
    ),
}
KINDS: dict[str, tuple[dict[str, Any], Numbers, Numbers, float]] = {
    "force": (
        SPHERE | {"tangential_load": "20 N"},
        {"wear_coefficient": (2e-13, 6e-13), "friction": (0.45, 0.6)},
        {"wear_coefficient": (2e-14, 1e-11), "friction": (0.41, 0.9)},
        300e-6,
    ),
    "displacement": (
        SPHERE | {"displacement_amplitude": "0.8 um"},
        {"wear_coefficient": (2e-13, 6e-13), "friction": (0.45, 0.6)},
        {"wear_coefficient": (2e-14, 1e-11), "friction": (0.38, 1.0)},
        300e-6,
    ),
    "line": (
        LINE | {"tangential_load": "40 N/mm"},
        {"wear_coefficient": (2e-13, 6e-13), "friction": (0.45, 0.6)},
        {"wear_coefficient": (2e-14, 1e-11), "friction": (0.41, 0.9)},
        200e-6,
    ),
    "debris": (
        TITANIUM | {"cycles": 5000},
        {"wear_coefficient": (1e-13, 4e-13), "debris_fraction": (0.5, 0.95)},
        {"wear_coefficient": (1e-14, 1e-11), "debris_fraction": (0.0, 1.0)},
        4.5e-3,
    ),
    "capped": (
        SPHERE | {"tangential_load": "20 N", "plastic_limit": "900 MPa"},
        {"wear_coefficient": (2e-13, 6e-13), "friction": (0.45, 0.6)},
        {"wear_coefficient": (2e-14, 1e-11), "friction": (0.41, 0.9)},
        300e-6,
    ),
    "rough": (
        SPHERE
        | {"tangential_load": "20 N", "friction": 0.5}
        | {"roughness": SELF_AFFINE | {"shortest_wavelength": "24 um", "seed": 1}},
        {"wear_coefficient": (2e-13, 6e-13), "roughness.rms_height": (5e-8, 2e-7)},
        {"wear_coefficient": (2e-14, 1e-11), "roughness.rms_height": (2e-8, 4e-7)},
        300e-6,
    ),
    LOOP: (
        SPHERE | {"displacement_amplitude": "4 um", "rig_stiffness": "30 N/um"},
        {"wear_coefficient": (2e-14, 6e-14), "friction": (0.45, 0.6), "rig_stiffness": (2e7, 5e7)},
        {"wear_coefficient": (2e-15, 1e-12), "friction": (0.3, 1.0), "rig_stiffness": (1e7, 1e8)},
        300e-6,
    ),
    RINGS: (
        SPHERE | {"friction": 0.5, "slip_model": "jaeger"},
        {"wear_coefficient": (2e-13, 6e-13)},
        {"wear_coefficient": (2e-14, 1e-11)},
        300e-6,
    ),
}
# Shares of the variance of the noise that are correlated, over a length in half-widths.
NOISES = {"white": 0.0, "correlated": 1.0, "both": 0.5}
LENGTHS = (0.01, 0.1)
LOOP_NOISE = 0.02e-6, 0.3  # of displacements, m, and forces, N
RATIOS = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9)  # Q/µP of the scars on rings
RESOLUTION = Resolution(swept_width=0.01, edge_width=5e-4, widest=0.025, step=0.1)
UNITS = {
    "wear_coefficient": " / Pa", "roughness.rms_height": " m", "rig_stiffness": " N/m",
    "coating.thickness": " m", "coating.wear_coefficient": " / Pa",
}  # fmt: skip


def written(name: str, value: float) -> object:
    """The value of a key as study files have it."""
    return f"{value!r}{UNITS[name]}" if name in UNITS else value


for _name, (_base, _ranges, _half) in COATED.items():
    # What is not sought lies in the middle of its range.
    _usual = {part: float(f"{np.sqrt(np.prod(ends)):.2g}") for part, ends in _ranges.items()}
    for _part, (_low, _high) in _ranges.items():
        coating = COATING | {p: written(f"coating.{p}", v) for p, v in _usual.items()}
        KINDS[f"coated {_name}, {_part.replace('_', ' ')}"] = (
            _base | {"coating": coating},
            {f"coating.{_part}": (_low, _high)},
            {f"coating.{_part}": (0.2 * _low, 5.0 * _high)},
            _half,
        )


def with_values(base: dict[str, Any], values: dict[str, float]) -> dict[str, Any]:
    """The keys of a study with values of what is sought; a pair keeps its shares."""
    changed = dict(base)
    for name, value in values.items():
        key, _, part = name.partition(".")
        if part:
            changed[key] = base[key] | {part: written(name, value)}
        elif isinstance(base.get(name), list):
            changed[name] = [written(name, value / 2)] * 2
        else:
            changed[name] = written(name, value)
    return changed


def write_readings(file: Path, names: str, columns: list[Array]) -> None:
    """Write two columns of numbers."""
    rows = "\n".join(f"{a:.8g},{b:.8g}" for a, b in zip(*columns, strict=True))
    file.write_text(f"{names}\n{rows}\n")


def scar_on_rings(case: fretwear.Case, ratio: float) -> tuple[Array, Array]:
    """Positions and depths by an integrator that shares nothing with the program, m."""
    radius = case.indenter.radius
    rate = 4.0 * case.friction * case.coupling * case.hertz_pressure * case.cycles
    r, worn = worn_rings(ratio, case.wear_coefficient * rate, RESOLUTION)
    x, depth = r * case.hertz_radius, worn * case.hertz_radius**2 / radius
    return np.concatenate([-x[::-1], x]), np.concatenate([depth[::-1], depth])


def one(kind: str, number: int, folder: Path) -> dict[str, Any]:
    """Make and fit one scar."""
    generator = np.random.default_rng([number, *kind.encode()])
    base, truth, ranges, half = KINDS[kind]
    values = {}
    for name, (low, high) in truth.items():
        share = generator.uniform()
        logarithmic = name.endswith("wear_coefficient")
        values[name] = low * (high / low) ** share if logarithmic else low + share * (high - low)
    ratio = RATIOS[number // 8 * 3 % len(RATIOS)]
    base = base | ({"tangential_ratio": ratio} if kind == RINGS else {})
    case = fretwear.Case(**with_values(base, values), error_estimate=False, output_cycles=[0])
    quantity = "wear_depth_flat" if "sliding_amplitude" in base else "wear_depth"
    data: list[dict[str, Any]] = [{"file": "scar.csv", "quantity": quantity}]
    if kind == RINGS:
        worn_x, worn = scar_on_rings(case, ratio)
    else:
        if case.coating is not None:
            # The front of the bare substrate is far sharper than a scar.
            finer = {"cell": [0.5 * each for each in case.grid_spacing], "tolerance": 0.001}
            case = case.replace(**finer)
        worn_case = fretwear.simulate(case).isel(cycle=-1)
        assert case.coating is None or worn_case["worn_through_cycle"] < case.cycles
        line = worn_case[data[0]["quantity"]]
        line = line if "y" not in line.dims else line.sel(y=0.0, method="nearest")
        worn_x, worn = line["x"].values, line.values
    if kind == LOOP:
        loop, parts = run(case).loops.isel(cycle=-1), []
        for name, scatter, unit in zip(
            ("displacement", "force"), LOOP_NOISE, (1e6, 1.0), strict=True
        ):
            whole = loop[name].values
            few = np.interp(np.linspace(0, whole.size - 1, 90), np.arange(whole.size), whole)
            parts.append(unit * (few + scatter * (generator.normal(size=90) + 3.0)))
        write_readings(folder / "loop.csv", "displacement (um),force (N)", parts)
        noises = {"noise": f"{LOOP_NOISE[0]} m", "force_noise": f"{LOOP_NOISE[1]} N"}
        data.append({"file": "loop.csv", "quantity": "loop"} | noises)
    noise = [*NOISES][number % len(NOISES)]
    x = np.linspace(-half, half, int(41 * (801 / 41) ** generator.uniform()))
    correlated = half * LENGTHS[0] * (LENGTHS[1] / LENGTHS[0]) ** generator.uniform()
    size = generator.uniform(0.02, 0.1) * float(worn.max())
    shift = generator.normal(scale=0.02 * half)
    depth = np.interp(x - shift, worn_x, worn, left=0.0, right=0.0)
    for share, length in ((NOISES[noise], correlated), (1.0 - NOISES[noise], 0.0)):
        depth += Noise(size * np.sqrt(share), length).drawn(x, generator)
    depth += 3.0 * size * (generator.normal() + generator.normal() * x / half)
    write_readings(folder / "scar.csv", "x (um),depth (um)", [x * 1e6, depth * 1e6])
    free = {name: [written(name, end) for end in ends] for name, ends in ranges.items()}
    start = {name: 0.7 * values[name] + 0.3 * ranges[name][1] for name in values}
    for name in values:
        if name.endswith("wear_coefficient"):
            start[name] = values[name] * float(generator.choice([0.3, 3.0]))
    content = {"base": with_values(base, start), "fit": {"free": free, "data": data}}
    file = folder / "scar.yaml"
    file.write_text(json.dumps(content))
    found = fit(file, folder=folder / "runs", seed=number)
    row: dict[str, Any] = {"kind": kind, "number": number, "noise": noise, "runs": found.runs}
    row |= {"points": x.size, "length": correlated / half, "warnings": [*found.warnings]}
    for place, unknown in enumerate(found.unknowns):
        true = values[unknown.name]
        best = found.values[unknown.name]
        ends = [found.interval(unknown.name, level) for level in LEVELS]
        draws = unknown.value(found.posterior.draws[..., place]).ravel()[::40]
        row[unknown.name] = {
            "true": true,
            "found": best,
            "ends": ends,
            "inside": [bool(low <= true <= high) for low, high in ends],
            "best_inside": all(low <= best <= high for low, high in ends),
            "rank": float((draws < true).mean()),
        }
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scars", type=int, default=30)
    parser.add_argument("--first", type=int, default=0, help="number of the first scar")
    parser.add_argument("--kinds", default="", help="only kinds that begin so, such as coated")
    parser.add_argument("--output", type=Path, default=Path("results/fits.jsonl"))
    options = parser.parse_args()
    options.output.parent.mkdir(parents=True, exist_ok=True)
    kinds = [kind for kind in KINDS if kind.startswith(options.kinds)]
    for number in range(options.first, options.first + options.scars):
        with tempfile.TemporaryDirectory() as folder, options.output.open("a") as stream:
            row = one(kinds[number % len(kinds)], number, Path(folder))
            stream.write(json.dumps(row) + "\n")
            print(json.dumps(row), flush=True)
    report([json.loads(line) for line in options.output.read_text().splitlines()])


def report(rows: list[dict[str, Any]]) -> None:
    """Print coverage, ranks, errors and runs: of all intervals, by noise, and by parameter."""
    from scipy.stats import binomtest, kstest

    names = {name for _, truth, _, _ in KINDS.values() for name in truth}

    def told(head: str, chosen: list[dict[str, Any]]) -> None:
        each = [row[name] for row in chosen for name in names if name in row]
        parts = []
        for place, level in enumerate(LEVELS):
            held = sum(one["inside"][place] for one in each)
            chance = binomtest(held, len(each), level).pvalue
            parts.append(f"{held} of {len(each)} within {100 * level:.0f} % (p = {chance:.2f})")
        inside = sum(one["best_inside"] for one in each)
        errors = 100.0 * np.median([abs(np.log(one["found"] / one["true"])) for one in each])
        ranks = kstest([one["rank"] for one in each], "uniform").pvalue
        runs = [row["runs"] for row in chosen]
        print(
            f"{head}: {', '.join(parts)}; best inside {inside}; median error {errors:.1f} %; ranks "
            f"uniform with p = {ranks:.2f}; {np.median(runs):.0f} runs, at most {max(runs)}"
        )

    told("all", rows)
    for key in ("noise", "kind"):
        for value in dict.fromkeys(row[key] for row in rows):
            told(value, [row for row in rows if row[key] == value])
    for name in sorted(name for name in names if any(name in row for row in rows)):
        told(name, [row for row in rows if name in row])


if __name__ == "__main__":
    main()
