"""From a case to a dataset: problem, steps, run record, and results with estimated errors."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

from fretwear.data.labels import case_dataset, history_dataset, loops_dataset, mirrored
from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactError
from fretwear.mechanics.wear.integrator import WearError
from fretwear.mechanics.wear.measures import (
    Measures,
    largest_pressure,
    outline_spots,
    share_beyond_friction,
)
from fretwear.mechanics.wear.state import State, Workspace
from fretwear.mechanics.wear.stroke import StrokeState
from fretwear.results import CONTACT_SPOTS, RESULTS, STICK_SPOTS, SYMMETRIES
from fretwear.run.accuracy import GridRun, next_width, relative_errors, unreached
from fretwear.run.errors import (
    ScalarValues,
    cell_errors,
    columns_of,
    model_errors,
    wear_in_errors,
)
from fretwear.run.fields import snapshot_fields
from fretwear.run.progress import Observer, Step, progress_bar
from fretwear.run.resources import require_memory
from fretwear.run.states import states, wear_problem
from fretwear.run.twin import Twin
from fretwear.study.case import Case
from fretwear.study.case_warnings import case_warnings


@dataclass
class RunRecord:
    """The record of a run: for its dataset, and to resume where it stopped."""

    # States whose fields the dataset holds.
    snapshots: list[State | StrokeState] = field(default_factory=list)
    # A row for every step: ``cycle``, ``error_estimate``, ``convolutions`` spent so far and, unless
    # narrower cells must follow, spots that moved the outlines, and every scalar.
    history: list[dict[str, float]] = field(default_factory=list)
    # The state that the run has reached; None before the first loading.
    last: State | StrokeState | None = None
    # Finished runs on wider cells, the widest first, of a case with a requested accuracy.
    rounds: list[GridRun] = field(default_factory=list)
    # Width of the cells of the present run over the default; None before it has begun.
    width: float | None = None
    # Work of the present run: cells times convolutions, or cubed cells times solutions of their
    # matrices, summed over steps; for a stroke, cells in contact at all positions.
    work: float = 0.0

    def add(self, step: Step, keep_fields: bool, keep_scalars: bool) -> None:
        """Add a step, with its fields to the snapshots and its scalars to the history."""
        state, geometry, previous = step.state, step.state.geometry, self.last
        spent, self.last = getattr(previous, "convolutions", 0), state
        if isinstance(state, StrokeState):
            self.work += len(state.pressures) * float(np.count_nonzero(state.pressure)) ** 3
        else:
            work = float(state.pressure.size) ** (1 if type(geometry) is Grid else 3)
            self.work += max(1, state.convolutions - spent) * work
        numbers = {"cycle": state.cycle, "error_estimate": state.error_estimate}
        numbers["convolutions"] = state.convolutions
        if keep_scalars:
            spots = outline_spots(previous, state) if previous else (0, 0)
            numbers |= zip((CONTACT_SPOTS.name, STICK_SPOTS.name), spots, strict=True)
            numbers |= step.measures.scalars({}, of_steps=True)
        self.history.append(numbers)
        if keep_fields:
            self.snapshots.append(state)

    def begin_anew(self, finished: Sequence[GridRun], width: float) -> None:
        """Begin a run on narrower cells after those that have finished."""
        self.rounds = list(finished)
        self.width, self.work = width, 0.0
        self.snapshots, self.history, self.last = [], [], None


class ResultWarning(UserWarning):
    """Results of a case are less accurate than usual, or outside the model."""


class Result(NamedTuple):
    """The results of a run."""

    dataset: xr.Dataset  # of the case
    history: xr.Dataset  # scalars at every step
    loops: xr.Dataset  # force and displacement round a cycle at the snapshots
    errors: ScalarValues  # estimates at the snapshots, of cells and steps but not the slip model


def simulate(
    case: Case,
    observers: Sequence[Observer] = (),
    *,
    quarter: bool = False,
    progress: bool = False,
) -> xr.Dataset:
    """Run a case.

    Smooth indenters with rotational symmetry may be computed on concentric rings: scalars then come
    from the rings, and fields are means over a quarter of the grid that `cell` asks for.

    `observers` are called with each accepted `Step`, cycle 0 included. `progress` shows
    a bar on a terminal and in a notebook.

    The dataset holds the whole contact or, with `quarter`, the part computed: one side along each
    axis in which the contact is even, see ``symmetry``. Its fields are over ``cycle``, ``x`` and
    ``y``, its scalars over ``cycle``, at the case's `output_cycles`; every parameter is a scalar
    coordinate.

    A WearError or a ContactError says that the solution does not converge, a MemoryError that the
    case certainly does not fit in the memory. Each `ResultWarning` says what is less accurate or
    outside the model. A TypeError says how to get a case from a file or parameters.
    """
    if not isinstance(case, Case):
        if isinstance(case, Mapping):
            remedy = "fretwear.Case(**parameters) makes one"
        elif isinstance(case, list | tuple):
            remedy = "[fretwear.simulate(case) for case in cases] runs several"
        else:
            file = repr(str(case)) if isinstance(case, str | Path) else "file"
            remedy = f"[*fretwear.load_study({file}).cases().values()] are those of a study"
        raise TypeError(f"simulate takes a Case, not {type(case).__name__}: {remedy}")
    require_memory(case)

    def warn(text: str) -> None:
        warnings.warn(text, ResultWarning, stacklevel=4)

    with progress_bar(case) if progress else nullcontext(lambda _: None) as show:
        dataset = run(case, [*observers, show], warn=warn).dataset
    return dataset if quarter else mirrored(dataset)


def run(
    case: Case,
    observers: Sequence[Observer] = (),
    *,
    record: RunRecord | None = None,
    command: str = "fretwear.simulate",
    warn: Callable[[str], None] = lambda _: None,
) -> Result:
    """Run a case as `simulate` does, and keep its history too.

    Every step is added to the record; a run resumes at the end of an earlier record with the same
    result to the last bit. The command is an attribute of the dataset. Warnings are passed to
    `warn`.

    A twin on wider cells, from which errors are estimated, runs alongside. It is not stored in
    checkpoints: a resumed run starts its twin anew.
    """
    record = record or RunRecord()
    foreseen = case_warnings(case) if case.asked_accuracy is None else ()
    for warning in foreseen:
        warn(str(warning))
    if record.width is None:
        record.width = next_width(case, ())
    if case.loading.stroke:
        import scipy.linalg  # noqa: F401 - loads its BLAS, so that the limit applies
    # Matrix products on one thread: cases run side by side, and threads only wait.
    with threadpool_limits(1, user_api="blas"):
        while True:
            assert record.width is not None
            try:
                computed = _run_on_cells(case, record.width, record, observers)
            except (ContactError, WearError):
                if record.width <= 1.0:
                    raise
                # Default cells may succeed where wider ones fail.
                record.begin_anew((), 1.0)
                continue
            width = next_width(case, computed.rounds)
            if width is None:
                return _labelled(case, computed, record, command, warn, len(foreseen))
            record.begin_anew(computed.rounds, width)


@dataclass(frozen=True)
class _Computed:
    """Results of a run on cells of one width at its snapshots."""

    case: Case  # on these cells
    workspace: Workspace
    measures: Sequence[Measures]  # of each snapshot
    rounds: Sequence[GridRun]  # this run, after those on wider cells
    scalars: ScalarValues
    errors: ScalarValues  # estimates of those of cells and steps
    trouble: str  # why requested errors are missing


def _run_on_cells(
    asked: Case, width: float, record: RunRecord, observers: Sequence[Observer]
) -> _Computed:
    """Run a case to the end of its record on cells of some width over the default.

    Errors are estimated from the last run of the record, whose cells are wider, or from a twin.
    """
    case, coarseness = asked.on_cells(width), width * asked.coarseness
    # Equal cells need a run on default cells anyway, whose twin is this run.
    for_errors = width > 1.0 and asked.has_equal_cells
    times, twin = asked.times_coarser, None
    if record.rounds:
        times = record.rounds[-1].width / width
    elif case.error_estimate and not for_errors:
        twin = Twin(asked.on_cells(times * width), times * coarseness)
    problem = wear_problem(case, None, coarseness)
    workspace, snapshots = Workspace(problem), record.snapshots
    # Without errors, wider cells are only the twin of default ones.
    keep_scalars = width <= 1.0 or bool(twin or record.rounds)
    for state in states(case, problem, record.last, for_errors=for_errors):
        step = Step(state, Measures(problem.of(state), state), case.cycles)
        record.add(step, state.cycle in case.output_cycles, keep_scalars)
        for observer in observers:
            observer(step)
        if twin:
            twin.advance(len(snapshots))
    if twin:  # of a record that had reached its end
        twin.advance(len(snapshots))
    measures = [Measures(problem.of(state), state, workspace) for state in snapshots]
    known = {row["cycle"]: row for row in record.history}
    rows = [each.scalars(known[each.state.cycle]) for each in measures]
    trouble = twin.trouble if twin else ""
    wider = twin.rows if twin else [row for run in record.rounds[-1:] for row in run.rows]
    scalars, errors = columns_of(rows), ScalarValues()
    if wider and not trouble:
        bounds = np.array([largest_pressure(each.problem, each.state) for each in measures])
        unresolved = np.maximum(bounds / scalars["peak_pressure"], 1.0) - 1.0
        early = cell_errors(case, scalars, columns_of(wider), times, unresolved)
        errors = wear_in_errors(case, scalars, early)
    # Narrower cells hardly reduce errors of the energies of late cycles.
    reducible = {n: early[n] if RESULTS[n].error_kind == "cycle" else e for n, e in errors.items()}
    finished = GridRun(width, rows, relative_errors(scalars, reducible), record.work)
    return _Computed(
        case, workspace, measures, [*record.rounds, finished], scalars, errors, trouble
    )


def _labelled(
    asked: Case,
    computed: _Computed,
    record: RunRecord,
    command: str,
    warn: Callable[[str], None],
    warned: int,
) -> Result:
    """Label the results of a finished run, and warn of anything not in `warned`."""
    case, problem, snapshots = computed.case, computed.workspace.problem, record.snapshots
    plane = snapshots[-1].geometry.plane(problem.spacing)
    axes = case.frame.axes
    even = tuple(axis in axes and is_even for axis, is_even in zip("xy", plane.even, strict=True))
    cycles = [state.cycle for state in snapshots]
    of_model = model_errors(case, computed.scalars)
    dataset = case_dataset(
        asked,
        plane.x,
        plane.y,
        cycles,
        snapshot_fields(computed.workspace, snapshots),
        computed.scalars,
        {name: np.hypot(error, of_model[name]) for name, error in computed.errors.items()},
        computed=case,
        trouble=computed.trouble,
        unreached=unreached(asked, computed.rounds),
        beyond_friction=max(share_beyond_friction(problem.of(each), each) for each in snapshots),
        symmetry=next(name for name, sides in SYMMETRIES.items() if sides == even),
        command=command,
    )
    for text in dataset.attrs["warnings"].splitlines()[warned:]:
        warn(text)
    history = columns_of(record.history)
    history["convolutions"] = np.diff(history["convolutions"], prepend=0)
    loops = [each.loop for each in computed.measures]
    curves = {
        "force": np.array([curve.force for curve in loops]),
        "displacement": np.array([curve.displacement for curve in loops]),
    }
    return Result(
        dataset,
        history_dataset(history, case.frame),
        loops_dataset(cycles, curves, case.frame),
        computed.errors,
    )


def steps(
    case: Case, *, start: State | None = None, geometry: type[Geometry] | None = None
) -> Iterator[Step]:
    """Yield each accepted step of a case: cycle 0 and all others, or those after ``start``."""
    problem = wear_problem(case, geometry)
    for state in states(case, problem, start):
        yield Step(state, Measures(problem.of(state), state), case.cycles)
