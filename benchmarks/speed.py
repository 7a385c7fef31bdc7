"""How fast the simulator is, in units that do not depend on the machine.

    python benchmarks/speed.py [--full] [--output FILE.json]

One CE is the time of one bare convolution by scipy.fft on the same quarter window (cosine
transform of the rows that are not zero, of all columns, multiplication, inverse), measured in the
same process on one thread. Times are processor times, which other work on the machine disturbs
less than the clock.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import scipy.fft

import fretwear
from fretwear import simulation
from fretwear.mechanics.contact import solve_contact
from fretwear.mechanics.contact_problem import ContactProblem
from fretwear.mechanics.halfspace import half_space
from fretwear.mechanics.state import State, WearProblem
from fretwear.mechanics.theory import HertzContact, LimitingState
from fretwear.mechanics.wear import evolve
from fretwear.mechanics.window import Window

CASE = {
    "radius": "10 mm",
    "youngs_modulus": "208 GPa",
    "poisson_ratio": 0.3,
    "load": "50 N",
    "tangential_load": "20 N",
    "friction": 0.5,
    "wear_coefficient": "7e-13 / Pa",
    "cycles": 30000,
}
WAVES = {"amplitude": "0.2 um", "slope_x": "5.7 deg", "slope_y": "1 deg"}


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    job: str
    measured: float
    unit: str
    bound: float
    note: str = ""


@dataclass
class Transforms:
    """Processor time spent inside scipy.fft."""

    seconds: float = 0.0

    @contextmanager
    def counted(self) -> Iterator[None]:
        """Count the time of every transform in the block."""
        names = ("dct", "idct", "dctn", "idctn")
        originals = {name: getattr(scipy.fft, name) for name in names}

        def timed(function: Callable[..., object]) -> Callable[..., object]:
            def call(*args: object, **keywords: object) -> object:
                started = time.process_time()
                result = function(*args, **keywords)
                self.seconds += time.process_time() - started
                return result

            return call

        for name in names:
            setattr(scipy.fft, name, timed(originals[name]))
        try:
            yield
        finally:
            for name in names:
                setattr(scipy.fft, name, originals[name])


def one_convolution(shape: tuple[int, int], repeats: int = 15) -> float:
    """Median processor time, s, of one bare convolution on a quarter window: one CE."""
    nx, ny = shape
    generator = np.random.default_rng(1)
    pressure, spectrum = generator.random(shape), generator.random((2 * nx, 2 * ny))
    times = []
    for _ in range(repeats + 2):
        started = time.process_time()
        rows = scipy.fft.dct(pressure, n=2 * ny, axis=1)
        both = scipy.fft.dct(rows, n=2 * nx, axis=0)
        both *= spectrum
        rows = scipy.fft.idct(both, axis=0, overwrite_x=True)[:nx]
        scipy.fft.idct(rows, axis=1, overwrite_x=True)[:, :ny].copy()
        times.append(time.process_time() - started)
    return float(np.median(times[2:]))


def timed(job: Callable[[], object]) -> tuple[float, object]:
    """Processor time, s, and result of a job."""
    started = time.process_time()
    result = job()
    return time.process_time() - started, result


def cold_contact(limit: float, waves: dict[str, str] | None, bound: float, job: str) -> Row:
    """A normal contact from nothing on 256 × 256 quarter cells, residual 1e-6."""
    problem = _problem(plastic_limit=limit, roughness=waves)
    hertz = HertzContact(problem.surface.radius, problem.load, problem.composite_modulus)
    size = 1.15 * hertz.contact_radius / 256
    window = Window((256, 256), (size, size))
    contact = ContactProblem(
        half_space(window, problem.composite_modulus),
        problem.surface.shape(window),
        problem.load,
        limit,
    )
    seconds, solution = timed(lambda: solve_contact(contact, tolerance=1e-6))
    unit = one_convolution(window.shape)
    return Row(job, seconds / unit, "CE", bound, f"{solution.convolutions} convolutions")


def wear_run(job: str, bound: float, **changes: object) -> tuple[Row, State, float, float]:
    """A whole run: its row, last state, processor seconds and share inside transforms."""
    case = fretwear.Case(**{**CASE, **changes})
    problem = simulation.wear_problem(case)
    transforms = Transforms()

    def last() -> State:
        with transforms.counted():
            return deque(evolve(problem, [case.cycles], case.tolerance), maxlen=1)[0]

    seconds, state = timed(last)
    unit = one_convolution(state.window.shape)
    note = (
        f"{state.step} steps, {state.convolutions} convolutions, {seconds:.1f} s, "
        f"{state.window.shape[0]} × {state.window.shape[1]} cells"
    )
    return Row(job, seconds / unit, "CE", bound, note), state, seconds, transforms.seconds / seconds


def peak_memory() -> Row:
    """Peak memory of a run in arrays of the padded window."""
    code = (
        "import resource, fretwear\n"
        "from fretwear import simulation\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        f"case = fretwear.Case(**{CASE | {'cell': ('0.58 um', '0.58 um'), 'cycles': 3000}!r})\n"
        "for step in simulation.steps(case): pass\n"
        "peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before\n"
        "nx, ny = step.state.window.shape\n"
        "print(peak * 1024 / (4 * nx * ny * 8))\n"
    )
    arrays = float(subprocess.check_output([sys.executable, "-c", code], text=True))
    return Row("peak memory of a run, smooth, a/256", arrays, "padded arrays", 25)


def command(job: str, arguments: list[str], bound: float) -> Row:
    """Shortest of five times of a command, as a user waits for it."""
    times = []
    for _ in range(5):
        started = time.perf_counter()
        call = [sys.executable, "-m", "fretwear", *arguments]
        subprocess.run(call, check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - started)
    return Row(job, min(times), "s", bound)


def rows(full: bool) -> Iterator[Row]:
    """The table, line by line."""
    yield cold_contact(math.inf, None, 50, "cold contact, smooth, 256²")
    yield cold_contact(4.5e9, WAVES, 120, "cold contact, rough, 4500 MPa, 256²")
    radius = fretwear.Case(**CASE).hertz_radius
    row, *_ = wear_run(
        "smooth elastic, 30000 cycles, a/110: time", 10, cell=(radius / 110, radius / 110)
    )
    seconds = float(row.note.split(", ")[2].removesuffix(" s"))
    yield Row(row.job, seconds, "s", 10, row.note)
    row, state, _, share = wear_run(
        "smooth elastic, 30000 cycles, a/128", 900, cell=(radius / 128, radius / 128)
    )
    yield row
    yield Row("  its steps", state.step, "steps", 25)
    problem = _problem()
    limit = LimitingState(
        HertzContact(problem.surface.radius, problem.load, problem.composite_modulus),
        fretwear.Case(**CASE).load_ratio,
    )
    error = abs(state.window.integral(state.wear) / limit.wear_volume - 1.0)
    yield Row("  its wear volume against the limit", 100 * error, "%", 0.5)
    yield Row("  its share inside transforms", 100 * share, "% (at least)", 60)
    rough = {"roughness": WAVES, "plastic_limit": "4500 MPa", "cycles": 7000}
    row, state, seconds, share = wear_run(
        "rough, 4500 MPa, 7000 cycles, 0.5 × 2 µm", 3000, cell=("0.5 um", "2 um"), **rough
    )
    yield row
    yield Row("  its share inside transforms", 100 * share, "% (at least)", 60)
    if full:
        per_cell = seconds / math.prod(state.window.shape)
        _, state, seconds, _ = wear_run("", 0, cell=("0.25 um", "1 um"), **rough)
        ratio = seconds / math.prod(state.window.shape) / per_cell
        yield Row("  time per cell at half the spacing", ratio, "×", 1.3, f"{seconds:.0f} s")
    yield peak_memory()
    yield command("fretwear --help", ["--help"], 0.4)
    yield command("fretwear plan, 24 points", ["plan", "studies/demo.yaml"], 1.5)


def _problem(**changes: object) -> WearProblem:
    return simulation.wear_problem(fretwear.Case(**{**CASE, **changes}))


def main() -> None:
    """Print the table and write the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--full", action="store_true", help="the long rows too (some minutes)")
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/speed.json"))
    options = parser.parse_args()
    table = []
    for row in rows(options.full):
        table.append(row)
        line = f"{row.job:<44} {row.measured:9.3g} {row.unit:<14} bound {row.bound:<6g} {row.note}"
        print(line, flush=True)
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text(json.dumps([asdict(row) for row in table], indent=1) + "\n")


if __name__ == "__main__":
    main()
