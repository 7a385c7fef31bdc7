"""Memory of a run and the time until commands answer: measured in processes of their own."""

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median

import yaml
from benchmarks.speed.cases import LIMIT, STUDY, WAVES
from benchmarks.speed.rows import ROOT, Row

_RUN = """
import json, sys, time
from pathlib import Path
import fretwear, netCDF4, scipy.fft
from fretwear.running import simulate
from fretwear.data import dataset as schema

def held(what):
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith(what))

last = None

def keep(step):
    global last
    last = step.state

cases = [fretwear.Case(**case) for case in json.loads(sys.argv[1])]
# The first, tiny, leads the process through everything that it does once.
simulate.run(cases[0])
# From here on the high-water mark counts anew: what imports held for a moment is not the run's.
Path("/proc/self/clear_refs").write_text("5")
before = held("VmRSS")
started, wall = time.process_time(), time.perf_counter()
simulate.run(cases[1], [keep])
print(json.dumps({
    "cpu": time.process_time() - started,
    "wall": time.perf_counter() - wall,
    "start_bytes": before,
    "peak_bytes": held("VmHWM"),
    "shape": last.window.shape,
    "steps": last.step,
    "convolutions": last.convolutions,
}))
"""


def run_alone(cells_on_radius: float, cycles: int) -> dict:
    """Run the smooth case in a process of its own: its times, peak memory, steps and window.

    The run is the whole of `fretwear.running.simulate.run`, with the snapshots that it keeps and
    the dataset that it makes; the memory that the process holds before it is given apart. Linux
    only: it resets the high-water mark of the process.
    """
    from benchmarks.speed.cases import study_case

    size = study_case().hertz_radius / cells_on_radius
    tiny = {**STUDY, "cell": "10 um", "cycles": 10}
    case = {**STUDY, "cell": [size, size], "cycles": cycles}
    command = [sys.executable, "-c", _RUN, json.dumps([tiny, case])]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    result = json.loads(done.stdout)
    nx, ny = result["shape"]
    result["arrays"] = (result["peak_bytes"] - result["start_bytes"]) / (4 * nx * ny * 8)
    return result


def peak_memory(cells_on_radius: float = 256.0) -> Row:
    """Peak memory of a run in arrays of the padded window."""
    found = run_alone(cells_on_radius, 30000)
    nx, ny = found["shape"]
    return Row(
        "memory",
        f"peak memory of a run, smooth, a/{cells_on_radius:g}",
        found["arrays"],
        "arrays",
        25,
        15,
        note=f"of the padded window of {nx} × {ny} quarter cells; "
        f"{(found['peak_bytes'] - found['start_bytes']) / 1e6:.0f} MB above "
        f"{found['start_bytes'] / 1e6:.0f} MB of the process before",
    )


def start_times(repeats: int = 9) -> Iterator[Row]:
    """How long a user waits for the help and for the plan of ten points."""
    yield _command("help", "fretwear --help", ["--help"], 0.4, 0.2, repeats)
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder) / "ten.yaml"
        study.write_text(yaml.safe_dump(_ten_points()), encoding="utf-8")
        yield _command("plan", "fretwear plan, 10 points", ["plan", str(study)], 1.5, 0.8, repeats)


def _ten_points() -> dict:
    base = {**STUDY, "roughness": WAVES}
    del base["load"]
    return {
        "title": "Ten points",
        "base": base,
        "vary": {
            "load": ["50 N", "60 N", "70 N", "80 N", "90 N"],
            "plastic_limit": ["none", LIMIT],
        },
    }


def _command(
    name: str, job: str, arguments: Sequence[str], asked: float, aim: float, repeats: int
) -> Row:
    """Shortest of some times: what else the machine does can only add."""
    script = Path(sys.executable).with_name("fretwear")
    start = [str(script)] if script.exists() else [sys.executable, "-m", "fretwear"]
    walls, before = [], _children()
    for _ in range(repeats):
        started = time.perf_counter()
        subprocess.run([*start, *arguments], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
        walls.append(time.perf_counter() - started)
    cpu = (_children() - before) / repeats
    note = f"shortest of {repeats}; median {median(walls):.2f} s, {cpu:.2f} s of the processor"
    return Row(name, job, min(walls), "s", asked, aim, note=note)


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
