"""Whole runs: time in CE, steps, accuracy, share of the transforms, time per cell."""

import math
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from statistics import mean, median

from benchmarks.speed.cases import rough_case, smooth_case
from benchmarks.speed.rows import Row
from benchmarks.speed.units import Spent, Stopwatch, Transforms, Units

from fretwear import Case
from fretwear.mechanics import contact, convolution, kernels
from fretwear.mechanics.integrator import evolve
from fretwear.mechanics.state import State
from fretwear.running import simulate
from fretwear.theory import HertzContact, LimitingState

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
        Of the run.
    units
        The same in CE: the time of each step over the unit of the step's own window.
    in_last_unit
        Processor time over the unit of the last window, the dearest of all.
    share
        Of the processor time inside transforms.
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


def timed_run(case: Case) -> Run:
    """Run a case; after each step the unit of its window is sampled, outside of the time."""
    units, inside = Units(), Transforms()
    steps: list[tuple[tuple[int, int], Spent]] = []
    with inside.counted():
        watch = Stopwatch()
        problem = simulate.wear_problem(case)
        for state in evolve(problem, [float(case.cycles)], case.tolerance):
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
    yield _share("rough_share", job, case, 3)
    if halved:
        yield _half_spacing(f"{job}: time per cell at half the spacing", case, spacing, cycles)


def _half_spacing(job: str, case: Case, spacing: float, cycles: int) -> Row:
    """Time per cell at half the spacing, relative to that of the case.

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
    if kernels.COMPILED:
        with _numpy_alone():
            notes.append(_without("the compiled kernels", case))
    if convolution.ducc0 is not None:
        with _scipy_alone():
            notes.append(_without("ducc0", case))
    job = f"{job}: inside transforms"
    return Row(name, job, median(shares), "%", 60, 80, at_least=True, note="; ".join(notes))


def _without(what: str, case: Case) -> str:
    run = timed_run(case)
    return f"{100 * run.share:.0f} % without {what}, where the run takes {run.units.cpu:.0f} CE"


@contextmanager
def _numpy_alone() -> Iterator[None]:
    """Kernels in NumPy, as where there is no compiler."""
    with ExitStack() as changes:
        for name, kernel in kernels.IN_NUMPY.items():
            for module in (kernels, contact):
                if hasattr(module, name):
                    changes.callback(setattr, module, name, getattr(module, name))
                    setattr(module, name, kernel)
        yield


@contextmanager
def _scipy_alone() -> Iterator[None]:
    """Transforms by scipy.fft, as where ducc0 is not installed."""
    ducc0, convolution.ducc0 = convolution.ducc0, None
    try:
        yield
    finally:
        convolution.ducc0 = ducc0
