"""How well the plan of a study predicts the time and memory of its cases on this machine.

    python -m benchmarks.cost [--quick] [--output FILE.json]
    python -m benchmarks.cost --measured FILE.json
    python -m benchmarks.cost --study FILE.yaml [--every N]
    python -m benchmarks.cost --speed

Runs a spread of cases on cells of their own, each in a process of its own on one thread, and prints
estimated against measured numbers of steps, convolutions, processor seconds and memory. The
constants at the top of `fretwear.study.plan` have to be changed until no ratio of seconds leaves
the range from 0.5 to 2; with ``--measured`` the numbers of an earlier call are compared with what
is expected now. With ``--study`` the cases of a study, or every N-th of them, are run as written,
so that an accuracy chooses their cells; steps and convolutions are then of the last run. What
``--speed`` prints belongs at the top of `fretwear.running.resources`: the time of a bare transform
on the machine of the other constants.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import yaml
from benchmarks.speed.cases import STUDY, WAVES

from fretwear.data.files import open_case, open_history
from fretwear.running.resources import machine_speed, transform_seconds
from fretwear.study.case import Case
from fretwear.study.plan import Estimate, estimate
from fretwear.study.reading import load_study

BASE: dict[str, Any] = {
    **{name: value for name, value in STUDY.items() if name != "tangential_load"},
    "tangential_ratio": 0.8,
    "plastic_limit": "none",
    "roughness": "none",
    "cycles": 7000,
    "accuracy": "none",
}
LONG_WAVES = {"kind": "wavy", "amplitude": "0.2 um", "slope_x": "2 deg", "slope_y": "1 deg"}
FLAT = {"kind": "wavy", "amplitude": "0.05 um", "slope_x": "1 deg", "slope_y": "1 deg"}
CAPPED = {"plastic_limit": "4500 MPa"}

SPREAD: dict[str, dict[str, Any]] = {
    "smooth": {},
    "smooth, coarse, few cycles": {"cell": "10 um", "cycles": 100},
    "smooth, fine": {"cell": "0.6 um"},
    "smooth, 30000 cycles": {"cycles": 30000, "tangential_ratio": 0.5},
    "smooth, low load": {"load": "5 N", "tangential_ratio": 0.3},
    "smooth, Q close to µP": {"tangential_ratio": 0.95, "cycles": 2000},
    "smooth, tight tolerance": {"tolerance": 0.001},
    "smooth, Cattaneo-Mindlin": {"slip_model": "cattaneo_mindlin"},
    "smooth, capped": CAPPED,
    "smooth, capped, tight tolerance": {**CAPPED, "tolerance": 0.003, "cycles": 3000},
    "smooth, capped low": {"plastic_limit": "2000 MPa", "cycles": 2000},
    "smooth, capped, coarse": {**CAPPED, "cell": "3 um", "cycles": 2000},
    "rough": {"roughness": WAVES},
    "rough, long waves": {"roughness": LONG_WAVES},
    "rough, flat": {"roughness": FLAT},
    "rough, 30000 cycles": {"roughness": LONG_WAVES, "cycles": 30000},
    "rough, few cycles": {"roughness": LONG_WAVES, "cycles": 100},
    "rough, tight tolerance": {"roughness": LONG_WAVES, "tolerance": 0.002},
    "rough, Cattaneo-Mindlin": {"roughness": LONG_WAVES, "slip_model": "cattaneo_mindlin"},
    "rough, capped": {"roughness": WAVES, **CAPPED},
    "rough, capped, long waves": {"roughness": LONG_WAVES, **CAPPED},
    "rough, capped, flat": {"roughness": FLAT, **CAPPED, "cycles": 2000},
    "rough, capped low": {"roughness": LONG_WAVES, "plastic_limit": "2500 MPa", "cycles": 2000},
    "rough, capped, few cycles": {"roughness": LONG_WAVES, **CAPPED, "cycles": 100},
    "rough, capped, tight tolerance": {
        "roughness": LONG_WAVES,
        **CAPPED,
        "tolerance": 0.002,
        "cycles": 2000,
    },
    "rough, capped, loose tolerance": {"roughness": LONG_WAVES, **CAPPED, "tolerance": 0.05},
    "rough, capped, Cattaneo-Mindlin": {
        "roughness": LONG_WAVES,
        **CAPPED,
        "slip_model": "cattaneo_mindlin",
    },
    "rough, capped, 30000 cycles": {"roughness": LONG_WAVES, **CAPPED, "cycles": 30000},
}


@dataclass(frozen=True)
class Numbers:
    """Time and memory of a case, estimated or measured."""

    cells: int
    steps: float
    convolutions: float
    seconds: float
    memory_mb: float

    @classmethod
    def of(cls, expected: Estimate, speed: float) -> Numbers:
        """The estimate for a machine of some speed."""
        return cls(
            expected.cells,
            expected.steps,
            expected.convolutions,
            expected.seconds / speed,
            expected.memory_bytes / 1e6,
        )


def measure(study: Path, case_id: str) -> Numbers:
    """Run a case in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "case.nc")
        command = [sys.executable, "-m", "fretwear", "run", str(study), "--case", case_id]
        command += ["-o", str(file), "--quiet"]
        process = subprocess.Popen(command, env={**os.environ, "OMP_NUM_THREADS": "1"})
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise SystemExit(f"the case {case_id} failed")
        with open_case(file) as case, open_history(file) as history:
            return Numbers(
                cells=case.sizes["x"] * case.sizes["y"],
                steps=history.sizes["step"] - 1,
                convolutions=int(history["convolutions"].sum()),
                seconds=usage.ru_utime + usage.ru_stime,
                memory_mb=usage.ru_maxrss / 1e3,
            )


def compare(names: list[str], kept: Path | None) -> Iterator[tuple[str, Numbers, Numbers]]:
    """Run the cases, or read their stored data; yield estimates and measurements."""
    earlier = json.loads(kept.read_text(encoding="utf-8")) if kept else {}
    for name in names:
        content = {**BASE, **SPREAD[name]}
        roughness = content["roughness"]
        case = Case(**{**content, "roughness": None if roughness == "none" else roughness})
        expected = estimate(case)
        if kept is None:
            with tempfile.TemporaryDirectory() as folder:
                study = Path(folder, "case.yaml")
                study.write_text(yaml.safe_dump({"base": content}), encoding="utf-8")
                measured = measure(study, case.case_id)
            yield name, Numbers.of(expected, machine_speed()), measured
        elif name in earlier:
            yield name, Numbers.of(expected, 1.0), Numbers(**earlier[name])


def of_study(file: Path, every: int) -> Iterator[tuple[str, Numbers, Numbers]]:
    """Run every so many cases of a study; yield estimates and measurements."""
    for name, case in [*load_study(file).cases().items()][::every]:
        expected = estimate(case)
        yield name[-32:], Numbers.of(expected, machine_speed()), measure(file, name)


def line(name: str, expected: Numbers, measured: Numbers) -> str:
    """One row of the table: estimated, measured, and the ratio, of each number."""
    columns = [f"{name:32s}"]
    for key, digits in (
        ("cells", 0),
        ("steps", 0),
        ("convolutions", 0),
        ("seconds", 1),
        ("memory_mb", 0),
    ):
        first, second = getattr(expected, key), getattr(measured, key)
        columns.append(f"{first:8.{digits}f} {second:8.{digits}f} {first / second:5.2f}")
    return " |".join(columns)


def print_speed() -> None:
    """Print the time of a bare transform: the constant of `fretwear.running.resources`."""
    print(f"SECONDS_PER_TRANSFORM = {min(transform_seconds() for _ in range(5)):.2g}")


def main() -> None:
    """Compare and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="every fourth case only")
    parser.add_argument("--output", type=Path, help="keep what was measured in a JSON file")
    parser.add_argument("--measured", type=Path, help="run nothing, take what such a file holds")
    parser.add_argument("--study", type=Path, help="run the cases of a study instead")
    parser.add_argument("--every", type=int, default=1, help="every N-th case of the study only")
    parser.add_argument("--speed", action="store_true", help="time bare transforms only")
    options = parser.parse_args()
    if options.speed:
        return print_speed()
    titles = ("cells", "steps", "convolutions", "seconds", "memory in MB")
    print(" |".join([f"{'estimated, measured, ratio':32s}", *(f"{t:^23s}" for t in titles)]))
    rows = {}
    names = list(SPREAD)[:: 4 if options.quick else 1]
    compared = compare(names, options.measured)
    if options.study:
        compared = of_study(options.study, options.every)
    for name, expected, measured in compared:
        print(line(name, expected, measured), flush=True)
        rows[name] = (expected, measured)
    for key in ("steps", "convolutions", "seconds", "memory_mb"):
        ratios = [getattr(first, key) / getattr(second, key) for first, second in rows.values()]
        middle = math.exp(statistics.fmean(map(math.log, ratios)))
        print(f"{key}: ratios from {min(ratios):.2f} to {max(ratios):.2f}, about {middle:.2f}")
    expected, measured = (sum(pair[i].seconds for pair in rows.values()) for i in (0, 1))
    print(f"all cases: {expected:.0f} s estimated, {measured:.0f} s measured")
    if options.output:
        kept = {name: asdict(measured) for name, (_, measured) in rows.items()}
        options.output.write_text(json.dumps(kept, indent=1), encoding="utf-8")
    return None


if __name__ == "__main__":
    main()
