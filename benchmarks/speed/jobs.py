"""The jobs of the table: cold contacts, whole runs, memory, and the start of commands."""

import json
import math
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from statistics import mean, median

import yaml
from benchmarks.pages import ROOT
from benchmarks.speed.cases import (
    LIMIT,
    STUDY,
    WAVES,
    first_contact,
    rough_case,
    smooth_case,
    study_case,
)
from benchmarks.speed.table import Row, header, line
from benchmarks.speed.units import Spent, Stopwatch, Transforms, Unit, Units

from fretwear import Case
from fretwear.mechanics import convolution
from fretwear.mechanics.contact import Accuracy, Contact, solve_contact
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.integrator import evolve
from fretwear.mechanics.state import State
from fretwear.running import simulate
from fretwear.study.plan import USUAL_ACCURACY
from fretwear.study.spacing import STEPS_PER_ACCURACY
from fretwear.theory import HertzContact, LimitingState

RESIDUAL = 1e-6


def cold_contact(*, rough: bool, cells: int = 256, repeats: int = 5) -> Row:
    """The time from a shape to its pressure, influence coefficients included.

    Each solve stands between two samples of the unit; the row is the median of the ratios.
    """
    # One-off work of a process, such as imports, belongs to none of the solves.
    solve_contact(first_contact(16, rough=rough))
    unit = Unit((cells, cells))
    ratios: list[Spent] = []
    bare: list[float] = []
    before = unit.sample(5)
    for _ in range(repeats):
        watch = Stopwatch()
        problem = first_contact(cells, rough=rough)
        start = watch.read()
        contact = solve_contact(problem, tolerance=RESIDUAL)
        solve = watch.read()
        after = unit.sample(5)
        near = Spent(0.5 * (before.cpu + after.cpu), 0.5 * (before.wall + after.wall))
        ratios.append((start + solve).over(near))
        bare.append(solve.over(near).cpu)
        before = after
    kind, asked, aim = ("rough, 4500 MPa", 120, 70) if rough else ("smooth", 50, 30)
    return Row(
        name=f"cold_{'rough' if rough else 'smooth'}",
        job=f"cold normal contact, {kind}, {cells}² quarter cells",
        measured=median(ratio.cpu for ratio in ratios),
        unit="CE",
        asked=asked,
        aim=aim,
        note=_note(contact, median(bare), median(ratio.wall for ratio in ratios), unit),
    )


def beside_a_power_of_two(*, rough: bool, cells: int = 256, repeats: int = 5) -> Row:
    """The cold solve on so many cells, with a note of the same on a few cells less.

    Where the cells are a power of two the unit itself is dear, and the number small for that.
    """
    row = cold_contact(rough=rough, cells=cells, repeats=repeats)
    fewer = round(cells * 250 / 256)
    other = cold_contact(rough=rough, cells=fewer, repeats=repeats)
    return replace(row, note=f"{row.note}; on {fewer}² cells {other.measured:.0f} CE")


def _note(contact: Contact, bare: float, wall: float, unit: Unit) -> str:
    return (
        f"{contact.convolutions} convolutions, residual {contact.residual:.0e}; "
        f"{bare:.0f} CE without the influence coefficients; {wall:.0f} CE by the clock; "
        f"1 CE = {1e3 * unit.time.cpu:.2f} ms"
    )


_LEAST_SAMPLES = 9
_COARSE_AT_ONCE = 4


@dataclass(frozen=True)
class Run:
    """A whole run.

    Attributes
    ----------
    state
        The last one.
    time
        Time of the run.
    units
        The same in CE: the time of each step over the unit of the step's own window.
    in_last_unit
        Processor time over the unit of the last window, the dearest of all.
    share
        Share of the processor time inside transforms.
    """

    state: State
    time: Spent
    units: Spent
    in_last_unit: float
    share: float

    @property
    def cells(self) -> int:
        """Quarter cells of the last window."""
        return math.prod(self.state.geometry.shape)

    def note(self) -> str:
        nx, ny = self.state.geometry.shape
        return (
            f"{self.state.step} steps, {self.state.convolutions} convolutions, {nx} × {ny} cells "
            f"at the end; {self.time.cpu:.1f} s ({self.time.wall:.1f} s by the clock, "
            f"{self.units.wall:.0f} CE); {self.in_last_unit:.0f} CE of the last window"
        )


def timed_run(case: Case, asked: float | None = None) -> Run:
    """Run a case; after each step the unit of its window is sampled, outside of the time.

    With an accuracy that is asked for, it has the steps and contacts of default cells.
    """
    tolerance, accuracy = case.tolerance, Accuracy()
    if asked is not None:
        tolerance, accuracy = STEPS_PER_ACCURACY * asked, accuracy.within(asked)
    units, inside = Units(), Transforms()
    steps: list[tuple[tuple[int, int], Spent]] = []
    with inside.counted():
        watch = Stopwatch()
        problem = simulate.wear_problem(case, Grid)
        states = evolve(problem, [float(case.cycles)], tolerance, accuracy=accuracy)
        for state in states:
            shape = state.geometry.shape
            steps.append((shape, watch.read()))
            units[shape].sample()
            watch.read()
    if inside.calls < state.convolutions:
        raise RuntimeError("the run used transforms that this benchmark does not know")
    units.complete(_LEAST_SAMPLES)
    time, total = Spent(), Spent()
    for shape, spent in steps:
        time += spent
        total += spent.over(units[shape].time)
    last = time.cpu / units[state.geometry.shape].time.cpu
    return Run(state, time, total, last, inside.seconds / time.cpu)


def smooth_rows(cells_on_radius: float = 128.0) -> Iterator[Row]:
    """The smooth elastic run of 30000 cycles against its limiting state."""
    case = smooth_case(cells_on_radius)
    run = timed_run(case)
    job = f"smooth elastic, 30000 cycles, a/{cells_on_radius:g}"
    yield Row("smooth_run", job, run.units.cpu, "CE", 900, 400, note=run.note())
    yield Row("smooth_steps", f"{job}: steps", run.state.step, "steps", 25, 25)
    hertz = HertzContact(case.radius, case.load, case.composite_modulus)
    limit = LimitingState(hertz, case.tangential_ratio).wear_volume
    error = abs(run.state.geometry.integral(run.state.wear) / limit - 1.0)
    yield Row("smooth_volume", f"{job}: wear volume off the limit", 100 * error, "%", 0.5, 0.5)
    yield _share("smooth_share", job, case, 5)


def rough_rows(coarser: float = 1.0, *, halved: bool = False) -> Iterator[Row]:
    """The rough capped run of 7000 cycles, and with ``halved`` again at half the spacing."""
    # Beyond twice the spacing a wave has too few cells; a shorter run is a try as well.
    cycles = max(100, round(7000 / coarser**2))
    spacing = min(coarser, 2.0)
    case = rough_case(spacing, cycles)
    dx, dy = (1e6 * size for size in case.grid_spacing)
    job = f"rough, 4500 MPa, {cycles} cycles, {dx:g} × {dy:g} µm"
    run = timed_run(case)
    yield Row("rough_run", job, run.units.cpu, "CE", 3000, 1500, note=run.note())
    run = timed_run(case, USUAL_ACCURACY)
    asked = f"{job}: with the steps and contacts of {100 * USUAL_ACCURACY:g} %"
    yield Row("rough_asked", asked, run.units.cpu, "CE", 1500, 1000, note=run.note())
    yield _share("rough_share", job, case, 3)
    if halved:
        yield _half_spacing(f"{job}: time per cell at half the spacing", case, spacing, cycles)


def _half_spacing(job: str, case: Case, spacing: float, cycles: int) -> Row:
    """Time per cell at half the spacing, relative to the case.

    Other work on the machine slows the finer grid most, which needs the memory that all share, and
    it comes and goes within a minute: the runs on the coarser grid take as long in all and lie
    before, between and after those on the finer one.
    """
    coarse = [timed_run(case) for _ in range(_COARSE_AT_ONCE)]
    fine = []
    for _ in range(2):
        fine.append(timed_run(rough_case(0.5 * spacing, cycles)))
        coarse += [timed_run(case) for _ in range(_COARSE_AT_ONCE)]
    per_cell, per_coarse_cell = (
        mean(run.time.cpu for run in runs) / runs[0].cells for runs in (fine, coarse)
    )
    last = fine[-1]
    note = (
        f"means of {len(fine)} runs, {_range(fine)} s, and of {len(coarse)} between, "
        f"{_range(coarse)} s; {last.units.cpu:.0f} CE; {last.note()}"
    )
    return Row("half_spacing", job, per_cell / per_coarse_cell, "×", 1.3, 1.1, note=note)


def _range(runs: list[Run]) -> str:
    times = sorted(run.time.cpu for run in runs)
    return f"{times[0]:.1f} to {times[-1]:.1f}"


def _share(name: str, job: str, case: Case, repeats: int) -> Row:
    shares = [100 * timed_run(case).share for _ in range(repeats)]
    notes = [f"median of {repeats} runs, {min(shares):.1f} to {max(shares):.1f}"]
    if convolution.ducc0 is not None:
        with _scipy_alone():
            run = timed_run(case)
        share, time = 100 * run.share, run.units.cpu
        notes.append(f"{share:.0f} % without ducc0, where the run takes {time:.0f} CE")
    job = f"{job}: inside transforms"
    return Row(name, job, median(shares), "%", 60, 80, at_least=True, note="; ".join(notes))


@contextmanager
def _scipy_alone() -> Iterator[None]:
    """Transforms by scipy.fft, as where ducc0 is not installed."""
    ducc0, convolution.ducc0 = convolution.ducc0, None
    try:
        yield
    finally:
        convolution.ducc0 = ducc0


_RUN = """
import json, sys, time
from pathlib import Path
import fretwear, netCDF4, scipy.fft
from fretwear.running import simulate
import fretwear.data.labels

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
# From here on the high-water mark counts anew: memory held by imports does not count.
Path("/proc/self/clear_refs").write_text("5")
before = held("VmRSS")
started, wall = time.process_time(), time.perf_counter()
simulate.run(cases[1], [keep])
print(json.dumps({
    "cpu": time.process_time() - started,
    "wall": time.perf_counter() - wall,
    "start_bytes": before,
    "peak_bytes": held("VmHWM"),
    "shape": last.geometry.shape,
    "steps": last.step,
    "convolutions": last.convolutions,
}))
"""


def run_alone(cells_on_radius: float, cycles: int) -> dict:
    """Run the smooth case in a process of its own: its times, peak memory, steps and window.

    The run is the whole of `fretwear.running.simulate.run`, with the two snapshots that it keeps
    and the dataset that it makes; the memory that the process holds before it is given apart. Linux
    only: it resets the high-water mark of the process.
    """
    size = study_case().hertz_radius / cells_on_radius
    study = {name: value for name, value in STUDY.items() if name != "radius"}
    # The same sphere on a grid; by its own name it is computed on rings.
    study["indenter"] = {"kind": "ellipsoid", **dict.fromkeys(("radius_x", "radius_y"), "10 mm")}
    study["output_cycles"] = []
    tiny = {**study, "cell": "10 um", "cycles": 10}
    case = {**study, "cell": [size, size], "cycles": cycles}
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
    """Shortest of some times: other work of the machine can only add to it."""
    script = Path(sys.executable).with_name("fretwear")
    start = [str(script)] if script.exists() else [sys.executable, "-m", "fretwear"]
    walls, before = [], children_seconds()
    for _ in range(repeats):
        started = time.perf_counter()
        subprocess.run([*start, *arguments], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
        walls.append(time.perf_counter() - started)
    cpu = (children_seconds() - before) / repeats
    note = f"shortest of {repeats}; median {median(walls):.2f} s, {cpu:.2f} s of the processor"
    return Row(name, job, min(walls), "s", asked, aim, note=note)


def children_seconds() -> float:
    """Processor time of all processes that were started and have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


Group = Callable[[], Iterator[Row]]


def groups(*, full: bool = False, coarser: float = 1.0, repeats: int = 5) -> dict[str, Group]:
    """The measurements, by name.

    Parameters
    ----------
    full
        Whether to run at half the spacing too, which takes minutes.
    coarser
        Factor on the spacings, to try the command out.
    repeats
        Repetitions of the short jobs.
    """

    def contact() -> Iterator[Row]:
        for rough in (False, True):
            yield beside_a_power_of_two(
                rough=rough, cells=max(16, round(256 / coarser)), repeats=repeats
            )

    def memory() -> Iterator[Row]:
        yield peak_memory(256 / coarser)

    return {
        "contact": contact,
        "smooth": partial(smooth_rows, 128 / coarser),
        "rough": partial(rough_rows, coarser, halved=full),
        "memory": memory,
        "start": partial(start_times, 2 * repeats - 1),
    }


def measure(wanted: Iterable[Group]) -> list[Row]:
    """Measure some groups and print each line as it comes."""
    rows = []
    print(header(), flush=True)
    for group in wanted:
        for row in group():
            rows.append(row)
            print(line(row), flush=True)
    return rows
