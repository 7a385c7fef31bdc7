"""Time and memory of the workflow against the number of tiny cases, on two cores."""

import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml
from benchmarks.scale.growth import exponent
from benchmarks.speed.cases import STUDY
from benchmarks.speed.rows import ROOT

COUNTS = (1, 10, 100, 1000)
QUICK_COUNTS = COUNTS[:2]
CORES = 2


def tiny_study(cases: int) -> dict[str, Any]:
    """A study of so many cases that each take a fraction of a second: 100 cycles, 10 µm cells."""
    base = {key: value for key, value in STUDY.items() if key != "load"}
    loads = [f"{50 + 50 * point / cases:.6g} N" for point in range(cases)]
    return {
        "title": f"{cases} tiny cases",
        "base": {
            **base,
            "cell": "10 um",
            "cycles": 100,
            "plastic_limit": "none",
            "roughness": "none",
        },
        "vary": {"load": loads},
    }


def curve(counts: Sequence[int] = COUNTS) -> dict[str, Any]:
    """Run the workflow for so many cases, each in a fresh folder."""
    points = [_workflow(count) for count in counts]
    many = [point for point in points if point["cases"] >= 10] or points
    return {
        "cores": CORES,
        "points": points,
        "time_exponent": exponent(
            [point["cases"] for point in many], [point["wall"] for point in many]
        ),
    }


def _workflow(cases: int) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copy(ROOT / "Snakefile", folder)
        shutil.copytree(ROOT / "profiles", folder / "profiles")
        (folder / "studies").mkdir()
        study = yaml.safe_dump(tiny_study(cases), sort_keys=False)
        (folder / "studies" / "demo.yaml").write_text(study, encoding="utf-8")
        log = folder / "log"
        before, started = _children(), time.perf_counter()
        with log.open("w", encoding="utf-8") as stream:
            done = subprocess.run(
                [sys.executable, "-m", "snakemake", "--cores", str(CORES)],
                cwd=folder,
                env=os.environ | {"OMP_NUM_THREADS": "1"},
                stdout=stream,
                stderr=subprocess.STDOUT,
                check=False,
            )
        wall, cpu = time.perf_counter() - started, _children() - before
        if done.returncode:
            raise RuntimeError(log.read_text(encoding="utf-8")[-2000:])
        results = folder / "results" / "demo"
        written = sum(1 for _ in (results / "cases").glob("*.nc"))
        if written != cases:
            raise RuntimeError(f"the workflow wrote {written} cases instead of {cases}")
        size = sum(file.stat().st_size for file in results.rglob("*") if file.is_file())
    peak = 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    print(
        f"{cases:>6} cases {wall:9.1f} s clock {cpu:9.1f} s processor, largest process "
        f"{peak / 1e6:.0f} MB, results {size / 1e6:.1f} MB",
        flush=True,
    )
    return {"cases": cases, "wall": wall, "cpu": cpu, "peak_bytes": peak, "result_bytes": size}


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
