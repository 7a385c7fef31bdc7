"""From a case to a dataset: problem, steps, run record, and results with estimated errors."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from fretwear.data.labels import case_dataset, history_dataset, loops_dataset, mirrored
from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import Accuracy, ContactError
from fretwear.mechanics.surfaces.setup import Setup
from fretwear.mechanics.wear.integrator import WearError, evolve
from fretwear.mechanics.wear.loops import loop
from fretwear.mechanics.wear.measures import (
    Described,
    Measures,
    described,
    fractions,
    share_beyond_friction,
    uncertainty,
)
from fretwear.mechanics.wear.pulsating import evolve_pulsating
from fretwear.mechanics.wear.state import State, WearProblem, Workspace
from fretwear.mechanics.wear.stroke import StrokeState, slide
from fretwear.results import BODY_FIELDS, FIELDS, FRICTION_FIELD, SYMMETRIES, VECTOR_FIELDS
from fretwear.run.accuracy import (
    GridRun,
    Margins,
    columns_of,
    errors_of_sums,
    errors_of_wear_in,
    estimated_errors,
    next_width,
    relative_errors,
    unreached,
    without_jumps,
)
from fretwear.run.progress import Observer, Step, progress_bar
from fretwear.run.resources import require_memory
from fretwear.study.case import Case
from fretwear.study.case_warnings import case_warnings
from fretwear.variable import ContactState

_MARGIN = 1.15
# Results in error with the slip model.
_OF_SLIP = ("dissipated_energy", "sliding", "wear_volume", "maximum_wear_depth")


@dataclass
class RunRecord:
    """The record of a run: for its dataset, and to resume where it stopped."""

    # States whose fields the dataset holds.
    snapshots: list[State | StrokeState] = field(default_factory=list)
    # A row for every step: ``cycle``, ``error_estimate``, ``convolutions`` spent so far, and every
    # scalar.
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

    def add(self, step: Step, *, keep_fields: bool) -> None:
        """Add a step."""
        spent, self.last = getattr(self.last, "convolutions", 0), step.state
        state, geometry = step.state, step.state.geometry
        if isinstance(state, StrokeState):
            self.work += len(state.pressures) * float(np.count_nonzero(state.pressure)) ** 3
        else:
            work = float(state.pressure.size) ** (1 if type(geometry) is Grid else 3)
            self.work += max(1, state.convolutions - spent) * work
        numbers = {"cycle": state.cycle, "error_estimate": state.error_estimate}
        numbers["convolutions"] = state.convolutions
        self.history.append(numbers | step.measures.at_step())
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
        else:
            remedy = f"[*fretwear.load_study({str(case)!r}).cases().values()] are those of a study"
        raise TypeError(f"simulate takes a Case, not {type(case).__name__}: {remedy}")
    require_memory(case)

    def warn(text: str) -> None:
        warnings.warn(text, ResultWarning, stacklevel=4)

    with progress_bar(case) if progress else nullcontext(lambda _: None) as show:
        dataset = run(case, [*observers, show], warn=warn).dataset
    return dataset if quarter else mirrored(dataset)


@contextmanager
def _one_thread(case: Case) -> Iterator[None]:
    """Matrix products on one thread: cases run side by side, and threads only wait."""
    if case.loading.stroke:
        import scipy.linalg  # noqa: F401 - loads its BLAS, so that the limit applies
    with threadpool_limits(1, user_api="blas"):
        yield


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
            break
        record.begin_anew(computed.rounds, width)
    return _labelled(case, computed, record, command, warn, len(foreseen))


@dataclass(frozen=True)
class _Computed:
    """Results of a run on cells of one width at its snapshots."""

    case: Case  # on these cells
    workspace: Workspace
    rounds: Sequence[GridRun]  # this run, after those on wider cells
    scalars: Mapping[str, NDArray[np.float64]]
    errors: Mapping[str, NDArray[np.float64]]
    trouble: str  # why requested errors are missing


def _run_on_cells(
    asked: Case, width: float, record: RunRecord, observers: Sequence[Observer]
) -> _Computed:
    """Run a case to the end of its record on cells of some width over the default.

    The run on wider cells from which errors are estimated is the last one of the record or, if
    there is none, runs alongside. It is not stored in checkpoints: a resumed run starts it anew.
    """
    times = record.rounds[-1].width / width if record.rounds else asked.times_coarser
    case, coarser_case = asked.on_cells(width), asked.on_cells(times * width)
    wider = record.rounds[-1:]
    twin: Iterator[Described]
    twin = (Described(*pair) for run in wider for pair in zip(run.rows, run.tips, strict=True))
    # Equal cells need a run on default cells anyway, whose twin is this run.
    if case.error_estimate and not record.rounds and not (width > 1.0 and asked.has_equal_cells):
        twin = _described_twin(coarser_case, times * width * asked.coarseness)
    coarser: list[Described] = []
    trouble = ""

    def advance_twin() -> None:
        nonlocal trouble
        try:
            coarser.extend(islice(twin, len(record.snapshots) - len(coarser)))
        except (ContactError, WearError) as error:
            trouble = str(error) or type(error).__name__

    problem = wear_problem(case, None, width * asked.coarseness)
    workspace, snapshots = Workspace(problem), record.snapshots
    with _one_thread(case):
        for state in _states(case, problem, record.last):
            step = Step(state, Measures(problem.of(state), state), case.cycles)
            record.add(step, keep_fields=state.cycle in case.output_cycles)
            for observer in observers:
                observer(step)
            advance_twin()
        advance_twin()
        found = [described(workspace, state) for state in snapshots]
        # Errors of edges are needed only with a run on wider cells.
        compared = zip(snapshots, found, strict=True) if wider or coarser else ()
        uncertain = [
            uncertainty(problem.of(state), state, one.scalars["peak_pressure"])
            for state, one in compared
        ]
    finished = GridRun.of(width, found, record.work)
    scalars = columns_of(finished.rows)
    errors: dict[str, NDArray[np.float64]] = {}
    if coarser and not (trouble or wider):
        wider = [GridRun.of(times * width, coarser)]
    if wider and not trouble:
        deviations, missed = zip(*uncertain, strict=True)
        spread = columns_of(deviations)
        comparable, jumps = without_jumps(finished, wider[-1], problem.wavelengths)
        margins = Margins.of(case)
        errors = estimated_errors(scalars, comparable, times, spread, case.tolerance, margins)
        errors |= {name: np.maximum(errors[name], jump) for name, jump in jumps.items()}
        errors["peak_pressure"] = np.hypot(errors["peak_pressure"], missed)
    late: dict[str, NDArray[np.float64]] = {}
    if errors:
        least = errors_of_wear_in(case, scalars)
        late = {name: np.maximum(errors[name], of_time) for name, of_time in least.items()}
        for name, summed in errors_of_sums(scalars, errors | late).items():
            errors[name] = np.maximum(errors[name], summed)
    finished = replace(finished, errors=relative_errors(scalars, errors))
    if errors:
        errors |= late
        of_directions = [case.cells.error_of_directions(cycle) for cycle in case.output_cycles]
        for name in (name for name in errors if name.startswith(_OF_SLIP)):
            of_model = case.cells.error_of_slip_model * np.abs(scalars[name])
            errors[name] = np.hypot(errors[name], of_model)
        errors["maximum_wear_depth"] += of_directions * scalars["maximum_wear_depth"]
    rounds = [*(record.rounds or wider), finished]
    return _Computed(case, workspace, rounds, scalars, errors, trouble)


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
    dataset = case_dataset(
        asked,
        plane.x,
        plane.y,
        cycles,
        _snapshot_fields(computed.workspace, snapshots),
        computed.scalars,
        computed.errors,
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
    with _one_thread(case):
        loops = [loop(computed.workspace, state) for state in snapshots]
    curves = {
        "force": np.array([curve.force for curve in loops]),
        "displacement": np.array([curve.displacement for curve in loops]),
    }
    return Result(
        dataset,
        history_dataset(history, case.frame),
        loops_dataset(cycles, curves, case.frame),
    )


def steps(
    case: Case, *, start: State | None = None, geometry: type[Geometry] | None = None
) -> Iterator[Step]:
    """Yield each accepted step of a case: cycle 0 and all others, or those after ``start``."""
    problem = wear_problem(case, geometry)
    for state in _states(case, problem, start):
        yield Step(state, Measures(problem.of(state), state), case.cycles)


def _states(case: Case, problem: WearProblem, start: State | None = None) -> Iterator[State]:
    stops = [*map(float, case.output_cycles)]
    if problem.loading.stroke:
        assert start is None or isinstance(start, StrokeState)
        return slide(problem, stops, case.tolerance, start)
    if problem.normal.pulsating_load < 1.0:
        return evolve_pulsating(problem, stops, case.tolerance, start)
    accuracy = Accuracy()
    if problem.geometry is Grid and math.isfinite(case.accuracy):
        accuracy = accuracy.loosened(case.accuracy)
    return evolve(problem, stops, case.tolerance, start, accuracy)


def _described_twin(case: Case, coarseness: float) -> Iterator[Described]:
    """Yield the snapshots of a case in numbers."""
    problem = wear_problem(case, None, coarseness)
    workspace = Workspace(problem)
    for state in _states(case, problem):
        if state.cycle in case.output_cycles:
            yield described(workspace, state)


def wear_problem(
    case: Case,
    geometry: type[Geometry] | None = None,
    coarseness: float | None = None,
) -> WearProblem:
    """The mechanical problem of a case, on its default cells or others; rings may be wider."""
    # A contact entirely at the limit is the smallest one that carries the load.
    spread = _MARGIN * max(1.0, case.hertz.spread_radius(case.slip_limit) / case.hertz_radius)
    x, y = case.indenter.half_widths(case.hertz)
    blocks: list[tuple[float, Setup]] = []
    for end, block in case.in_blocks():
        assert block is not None
        loading = block.loading if block.loading.is_force else block.plain_loading
        setup = block.changed(loading=loading).setup
        if blocks and blocks[-1][1] == setup:
            blocks.pop()
        blocks.append((end, setup))
    blocks[-1] = math.inf, blocks[-1][1]
    return WearProblem(
        **vars(blocks[0][1]),
        slip_model=case.cells.solved_slip_model,
        spacing=case.grid_spacing,
        extent=(spread * x, spread * y),
        geometry=geometry or case.cells.geometry,
        coarseness=coarseness or case.coarseness,
        blocks=tuple(blocks) if len(blocks) > 1 else (),
    )


def _snapshot_fields(
    workspace: Workspace, snapshots: Sequence[State]
) -> dict[str, NDArray[np.generic]]:
    """The fields of a dataset over all snapshots on one plane, in the stored precision.

    Fields in double precision, listed and then stacked, would take most of a run's memory.
    """
    last = snapshots[-1].geometry
    plane = last.plane(workspace.problem.spacing)
    shape = plane.shape[: len(workspace.problem.frame.axes)]
    fields = (
        *FIELDS,
        *(BODY_FIELDS if snapshots[-1].wear_of_each(workspace.problem.wear_law) else ()),
    )
    fields += VECTOR_FIELDS if snapshots[-1].reduced.sheared is not None else ()
    fields += (FRICTION_FIELD,) if workspace.problem.friction_law.follows_slip else ()
    stored = {field.name: np.empty((len(snapshots), *shape), field.dtype) for field in fields}
    for row, snapshot in enumerate(snapshots):
        state = snapshot.on(workspace, snapshot.geometry.extended(last))
        problem = workspace.problem.of(state)
        reduced, closed = state.reduced, state.in_contact
        slip = problem.slip(reduced)
        contact_state = np.where(closed, ContactState.SLIP, ContactState.OPEN)
        contact_state[reduced.stick & closed] = ContactState.STICK
        law = problem.friction_law
        path = 4.0 * state.pressure * slip
        worn = problem.combined_wear_coefficient * problem.wear_ratio * path
        rate = np.maximum(worn - problem.withheld_depth, 0.0)
        shearing = law.ratio * state.pressure
        if isinstance(state, StrokeState):
            rate = state.rates.sum(axis=0)
        elif state.pulse is not None:
            rate = problem.combined_wear_coefficient * state.pulse.path
            slip = slip * state.pulse.share
            shearing = 0.5 * (state.pressure + state.pulse.least)
        bodies = state.wear_of_each(problem.wear_law).values()
        values_of = {
            "pressure": state.pressure,
            "reduced": reduced.pressure,
            "shearing": shearing,
            "slip": slip,
            "wear_depth": state.wear,
            "wear_rate": rate,
            "path": path,
            "plastic_depth": state.plastic,
            "gap": state.gap,
            "contact_state": contact_state,
            **{field.name: wear for field, wear in zip(BODY_FIELDS, bodies, strict=False)},
        }
        if reduced.sheared is not None:
            ways = reduced.sheared.ways * slip
            values_of |= {"slip_x": ways[0], "slip_y": ways[1]}
            traction = reduced.sheared.traction
            values_of |= {"shear_traction": traction[0], "shear_traction_y": traction[1]}
        if law.follows_slip:
            values_of[FRICTION_FIELD.name] = law.coefficient * np.asarray(law.ratio)
        written = state.geometry.written(values_of, plane)
        if law.follows_slip:
            # This makes it a bound of the mean traction by the mean pressure.
            sheared = law.coefficient * np.asarray(written["shearing"])
            np.divide(
                sheared,
                written["pressure"],
                out=written[FRICTION_FIELD.name],
                where=written["pressure"] > 0.0,
            )
        if reduced.sheared is None:
            # Means over a cell that slips in part obey Coulomb's law if computed from mean
            # pressures.
            sticking = replace(reduced, pressure=written["reduced"])
            written["shear_traction"] = problem.shear_traction(written["shearing"], sticking)
        written["contact_fraction"], written["stick_fraction"] = fractions(problem, state, plane)
        cells: object = state.geometry
        if plane != cells:
            # Cells cut by an edge touch if they carry load, and slip or stick like most of their
            # pressure.
            loaded, touch = written["pressure"] > 0.0, written["contact_state"]
            written["gap"][loaded] = 0.0
            touch[loaded] = np.maximum(touch[loaded], ContactState.SLIP)
            if not (problem.loading.stroke or state.pulse):
                carried = 4.0 * written["pressure"][loaded]
                written["slip"][loaded] = written["path"][loaded] / carried
            if reduced.sheared is not None:
                _obey_friction(written, problem.friction_law.coefficient)
        off_punch = np.hypot(plane.x[:, None], plane.y) > problem.indenter.end
        for name, value in (("gap", np.nan), ("slip", 0.0)):
            written[name][off_punch & (written["pressure"] == 0.0)] = value
        for name, values in stored.items():
            values[row] = written[name].reshape(shape)
    return stored


def _obey_friction(written: dict[str, NDArray[np.generic]], friction: float) -> None:
    """Give means of vectors over cells the lengths and directions of friction.

    The traction is at most µp. In cells that slip as a whole it is µp along the slip, as the mean
    of vectors that turn would be slightly shorter. The slip is as long as its mean amplitude.
    """
    least = np.finfo(np.float64).tiny
    traction, slip = (
        np.stack([written[name], written[partner]])
        for name, partner in (("shear_traction", "shear_traction_y"), ("slip_x", "slip_y"))
    )
    bound = friction * np.asarray(written["pressure"])
    slips = (written["stick_fraction"] == 0.0) & (bound > 0.0)
    of_traction, of_slip = (
        vector / np.maximum(np.hypot(*vector), least) for vector in (traction, slip)
    )
    length = np.where(slips, bound, np.minimum(np.hypot(*traction), bound))
    written["shear_traction"], written["shear_traction_y"] = of_traction * length
    way = np.where(slips, of_traction, of_slip)
    written["slip_x"], written["slip_y"] = way * written["slip"]
