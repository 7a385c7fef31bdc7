"""Memory and time of analyses across a thousand cases: merging them, and reducing their fields.

    python -m benchmarks.stack [--cases 1000] [--cycles 10] [--cells 256] [--folder FOLDER]

One case is simulated; its file is copied under the ids of the others, which takes some GB in the
folder (removed afterwards). Each measurement is a process of its own.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import netCDF4
import numpy as np
import yaml
from benchmarks.cases import STUDY

from fretwear.run.cases import simulate_to_file
from fretwear.study.reading import load_study
from fretwear.study.study import Study

# The kernel's figures for a child that has ended include the parent that it was forked from.
PEAK = """
import re
from pathlib import Path
peak = int(re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1])
print(f"  largest memory {peak / 1e3:.0f} MB")
"""
MERGE = """
from fretwear.data.merge import merge_study
from fretwear.study.reading import load_study
merge_study(load_study("stack.yaml"), "results/stack/cases", "results/stack/summary.nc")
"""
REDUCE = """
import fretwear
with fretwear.open_study("results/stack") as stack:
    {reduction}.compute()
"""
REDUCTIONS = {
    "deepest wear of every case and cycle": "stack.wear_depth.max(('x', 'y'))",
    "mean pressure over all cases": "stack.pressure.mean('load')",
    "standard deviation of the gap over all": "stack.gap.std()",
}


def study_of(folder: Path, cases: int, cycles: int, cells: int) -> Study:
    """A study of loads a thousandth apart, so that one contact stands for all."""
    snapshots = [int(cycle) for cycle in np.linspace(0, 1000, cycles)]
    content = {
        "title": "A stack",
        "base": {
            **{name: value for name, value in STUDY.items() if name not in ("load", "cycles")},
            "plastic_limit": "none",
            "roughness": "none",
            "cycles": 1000,
            "cell": f"{175.0 / cells:.4g} um",
        },
        "vary": {"load": [f"{50.0 + 1e-3 * number:.3f} N" for number in range(cases)]},
        "output": {"cycles": snapshots},
    }
    file = folder / "stack.yaml"
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return load_study(file)


def copied(first: Path, path: Path, case_id: str) -> None:
    """Copy a case file under another id."""
    shutil.copyfile(first, path)
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr("case_id", case_id)


def measure(title: str, program: str, folder: Path) -> None:
    """Run a program; print its time and its largest memory."""
    print(title, flush=True)
    started = time.monotonic()
    process = subprocess.Popen([sys.executable, "-c", program + PEAK], cwd=folder)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"failed: {program}")
    spent = usage.ru_utime + usage.ru_stime
    print(f"  {time.monotonic() - started:.1f} s, of which {spent:.1f} s of processor time")


def main() -> None:
    """Make the stack, merge it, reduce it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--cycles", type=int, default=10)
    parser.add_argument("--cells", type=int, default=256)
    parser.add_argument("--folder", type=Path, help="where to put the files for the time being")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        folder = Path(name)
        study = study_of(folder, options.cases, options.cycles, options.cells)
        cases = folder / "results/stack/cases"
        first, *others = study.cases().items()
        simulate_to_file(first[1], cases / f"{first[0]}.nc", tell=print, command="benchmark")
        for case_id, _ in others:
            copied(cases / f"{first[0]}.nc", cases / f"{case_id}.nc", case_id)
        with netCDF4.Dataset(cases / f"{first[0]}.nc") as file:
            shape = file["pressure"].shape
        size = sum(path.stat().st_size for path in cases.iterdir()) / 1e9
        print(f"{options.cases} cases of {' x '.join(map(str, shape))} cells: {size:.1f} GB")
        measure("merging them", MERGE, folder)
        for title, reduction in REDUCTIONS.items():
            measure(title, REDUCE.format(reduction=reduction), folder)


if __name__ == "__main__":
    main()
