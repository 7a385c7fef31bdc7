"""A case in, a dataset out: case, problem, steps, run record, dataset."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fretwear.data.labels import Labelled, labelled_case, labelled_history, labelled_loops
from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.geometry import Array, Geometry, Workspace
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.geometry.line import Line
from fretwear.mechanics.geometry.rings import Rings
from fretwear.mechanics.integrator import WearError, evolve
from fretwear.mechanics.loop import Loop, loop
from fretwear.mechanics.measures import Measures, measure
from fretwear.mechanics.state import State, WearProblem, in_contact
from fretwear.mechanics.stroke import StrokeState, slide
from fretwear.mechanics.team import Team
from fretwear.running.errors import estimated_errors
from fretwear.running.resources import require_memory
from fretwear.study.doubts import doubts
from fretwear.study.tree import CaseTree
from fretwear.vocabulary import BODY_FIELDS, FIELDS, LINE_SCALARS, SCALARS, SYMMETRIES, ContactState

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.study.case import Case

_MARGIN = 1.15
_CURVES = ("force", "displacement")


@dataclass(frozen=True)
class Step:
    """One accepted step of a run, as passed to observers."""

    state: State  # fields and numbers of the contact
    measures: Measures  # scalars of the whole contact
    last_cycle: int  # where the run ends


Observer = Callable[[Step], None]


@dataclass
class RunRecord:
    """The record of a run: for its dataset, and to resume where it stopped."""

    # States whose fields the dataset holds.
    snapshots: list[State | StrokeState] = field(default_factory=list)
    # A row for every step: ``cycle``, ``error_estimate``, ``convolutions`` spent so far, and
    # every scalar of `Measures`.
    history: list[dict[str, float]] = field(default_factory=list)
    # The state that the run has reached; None before the first loading.
    last: State | StrokeState | None = None

    def add(self, step: Step, *, keep_fields: bool) -> None:
        """Add a step."""
        self.last = state = step.state
        self.history.append(
            {
                "cycle": state.cycle,
                "error_estimate": state.error_estimate,
                "convolutions": state.convolutions,
                **asdict(step.measures),
            }
        )
        if keep_fields:
            self.snapshots.append(state)


class DoubtfulResultWarning(UserWarning):
    """The results of a case are doubtful."""


@dataclass(frozen=True)
class Result:
    """The results of a run: dataset of the case, history of every step, loops of cycles."""

    labelled: tuple[Labelled, Labelled, Labelled]

    @cached_property
    def dataset(self) -> xr.Dataset:
        """The dataset of the case."""
        return self.labelled[0].dataset()

    @cached_property
    def history(self) -> xr.Dataset:
        """The scalars at every step."""
        return self.labelled[1].dataset()

    @cached_property
    def loops(self) -> xr.Dataset:
        """Force and displacement round a cycle at the snapshots."""
        return self.labelled[2].dataset()


def simulate(
    case: Case,
    observers: Sequence[Observer] = (),
    *,
    quarter: bool = False,
    threads: int = 1,
    progress: bool = False,
) -> xr.Dataset:
    """Run a case.

    A smooth indenter with rotational symmetry is computed on concentric rings: scalars are those
    of the rings, fields are sampled on a quarter of the grid that `cell` asks for.

    Parameters
    ----------
    case
        What to run.
    observers
        Called with each accepted `Step`, cycle 0 included.
    quarter
        Return only the computed part: one side of the contact along each axis in which it is even,
        usually a quarter. By default the dataset holds the whole contact.
    threads
        Number of threads; the result does not depend on it, to the last bit.
    progress
        Whether to show a progress bar, in a terminal or a notebook.

    Returns
    -------
    xarray.Dataset
        The whole contact, or one side of it, see ``symmetry``. Fields over ``cycle``, ``x``, ``y``
        and scalars over ``cycle`` at the case's `output_cycles`; scalar coordinates of every
        parameter.

    Raises
    ------
    fretwear.mechanics.integrator.WearError, fretwear.mechanics.contact.ContactError
        When the solution does not converge.
    MemoryError
        When the case certainly does not fit in the memory.

    Warns
    -----
    DoubtfulResultWarning
        For each reason to doubt the results, known beforehand or found by the run.
    """
    if not isinstance(case, CaseTree):
        example = "fretwear.Case(load='50 N', ...)"
        raise TypeError(f"simulate() takes a case, {example}, not a {type(case).__name__}.")
    require_memory(case)
    before = doubts(case)
    for doubt in before:
        warnings.warn(str(doubt), DoubtfulResultWarning, stacklevel=2)
    bar: AbstractContextManager[list[Observer]] = _bar(case) if progress else nullcontext([])
    with bar as shown:
        dataset = run(case, [*observers, *shown], threads=threads).dataset
    for found in dataset.attrs["warnings"].splitlines()[len(before) :]:
        warnings.warn(found, DoubtfulResultWarning, stacklevel=2)
    if quarter:
        return dataset
    from fretwear.data.dataset import mirrored

    return mirrored(dataset)


@contextmanager
def _bar(case: Case) -> Iterator[list[Observer]]:
    """Yield an observer that updates a progress bar."""
    from rich.progress import Progress

    with Progress() as bar:
        task = bar.add_task(case.case_id, total=case.cycles)
        yield [lambda step: bar.update(task, completed=step.state.cycle)]


def run(
    case: Case,
    observers: Sequence[Observer] = (),
    *,
    record: RunRecord | None = None,
    geometry: type[Geometry] | None = None,
    threads: int = 1,
    title: str = "",
    command: str = "fretwear.simulate",
) -> Result:
    """Run a case as `simulate` does, and keep its history too.

    The record takes every step; one that an earlier run has left makes this one resume there, with
    the same result to the last bit. A geometry is that of other cells than the usual ones of the
    case; title and command are attributes of the dataset.
    """
    record = RunRecord() if record is None else record
    problem = wear_problem(case, geometry, threads)
    twin = _Twin(case, geometry, threads) if case.error_estimate else None
    for step in _steps(case, problem, record.last):
        record.add(step, keep_fields=step.state.cycle in case.output_cycles)
        for observer in observers:
            observer(step)
        if twin is not None:
            twin.follow(len(record.snapshots))
    return _result(case, record, problem, twin, title, command)


def steps(
    case: Case, *, start: State | None = None, geometry: type[Geometry] | None = None
) -> Iterator[Step]:
    """Yield each accepted step of a case: cycle 0 and all others, or those after ``start``."""
    return _steps(case, wear_problem(case, geometry), start)


def _steps(case: Case, problem: WearProblem, start: State | None) -> Iterator[Step]:
    for state in _states(case, problem, start):
        yield Step(state, measure(problem.of(state), state), case.cycles)


def _states(case: Case, problem: WearProblem, start: Any) -> Iterator[Any]:
    stops = [float(cycle) for cycle in case.output_cycles]
    march = slide if problem.loading.stroke else evolve
    return march(problem, stops, case.tolerance, start)


class _Twin:
    """The same case on wider cells, run alongside: the difference gives the errors of its results.

    It is not stored in checkpoints: a resumed run starts its twin anew.
    """

    def __init__(self, case: Case, geometry: type[Geometry] | None, threads: int) -> None:
        coarser = case.coarser
        problem = wear_problem(coarser, geometry, threads, case.times_coarser)
        self._workspace = Workspace(problem)
        self._states = _states(coarser, problem, None)
        self._cycles = case.output_cycles
        # Every scalar at each snapshot, and why there are no more, for the warnings.
        self.rows: list[dict[str, float]] = []
        self.trouble = ""

    def follow(self, snapshots: int) -> None:
        """Run up to a number of snapshots, or until an error."""
        try:
            while len(self.rows) < snapshots and not self.trouble:
                state = next(self._states)
                if state.cycle in self._cycles:
                    turn = loop(self._workspace, state, contacts=1)
                    self.rows.append(_scalars(self._workspace.problem, state, turn))
        except (ContactError, WearError) as error:
            self.trouble = str(error) or type(error).__name__


def _scalars(problem: WearProblem, state: State, turn: Loop) -> dict[str, float]:
    """Every scalar of a state: the measures of each step, and those of its loop."""
    found = asdict(measure(problem.of(state), state))
    full = 4.0 * turn.opening * found["tangential_force"]
    found["sliding_criterion"] = found["dissipated_energy"] / full if full else 0.0
    for body, share in zip(("indenter", "flat"), problem.wear_law.shares or (), strict=False):
        found[f"wear_volume_{body}"] = share * found["wear_volume"]
    return found


def _result(
    case: Case,
    record: RunRecord,
    problem: WearProblem,
    twin: _Twin | None,
    title: str,
    command: str,
) -> Result:
    columns = {name: np.array([row[name] for row in record.history]) for name in record.history[0]}
    steps_at = columns.pop("cycle")
    of_steps, convolutions = columns.pop("error_estimate"), columns.pop("convolutions")
    cycles = [state.cycle for state in record.snapshots]
    plane = record.snapshots[-1].geometry.plane(problem.spacing)
    in_line = case.indenter.is_line
    symmetry = next(name for name, even in SYMMETRIES.items() if even == plane.even)
    workspace = Workspace(problem)
    loops = [loop(workspace, state) for state in record.snapshots]
    of_both = zip(record.snapshots, loops, strict=True)
    rows = [_scalars(problem, state, turn) for state, turn in of_both]
    fields = _snapshot_fields(workspace, record.snapshots)
    errors = {}
    if twin is not None:
        twin.follow(len(rows))
        if not twin.trouble:
            errors = estimated_errors(rows, twin.rows, case.times_coarser)
    scalars = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    if in_line:
        symmetry = "even_x"
        columns, scalars, errors = (
            {name: values for name, values in each.items() if not name.endswith("_y")}
            for each in (columns, scalars, errors)
        )
    dataset = labelled_case(
        case,
        plane.x,
        None if in_line else plane.y,
        cycles,
        fields,
        scalars,
        errors,
        trouble="" if twin is None else twin.trouble,
        symmetry=symmetry,
        title=title,
        command=command,
    )
    variables = LINE_SCALARS if in_line else SCALARS
    spent = np.diff(convolutions, prepend=0)
    history = labelled_history(steps_at, columns, of_steps, spent, variables)
    curves = {name: np.array([getattr(each, name) for each in loops]) for name in _CURVES}
    return Result((dataset, history, labelled_loops(cycles, curves, in_line=in_line)))


def wear_problem(
    case: Case, geometry: type[Geometry] | None = None, threads: int = 1, coarseness: float = 1.0
) -> WearProblem:
    """The mechanical problem of a case, on its default cells or others; rings may be wider."""
    # A contact at the limit everywhere is the smallest one that carries the load.
    spread = _MARGIN * max(1.0, case.hertz.spread_radius(case.plastic_limit) / case.hertz_radius)
    x, y = case.indenter.half_widths(case.hertz)
    usual = Line if case.indenter.is_line else Rings if case.is_on_rings else Grid
    problem = WearProblem(
        indenter=case.indenter,
        roughness=case.rough,
        bodies=case.bodies,
        normal=case.normal,
        loading=case.loading,
        friction=case.friction_law,
        wear_law=case.wear_law,
        slip_model=case.slip_model,
        limit=case.plastic_limit,
        spacing=case.grid_spacing,
        extent=(spread * x, spread * y),
        team=Team(threads),
        geometry=geometry or usual,
        debris_fraction=case.debris_fraction,
        coarseness=coarseness,
    )
    following: WearProblem | None = None
    for end, block in reversed([*case.in_blocks()]):
        assert block is not None
        loading = block.loading if block.loading.is_force else block.plain_loading
        now = replace(
            problem, normal=block.normal, loading=loading, friction=block.friction_law, end=end
        )
        if following is None or now != replace(following, end=end, following=None):
            following = replace(now, end=end if following else inf, following=following)
    assert following is not None
    return following


def _snapshot_fields(workspace: Workspace, snapshots: Sequence[State]) -> dict[str, NDArray[Any]]:
    """The fields of a dataset over all snapshots on one plane, from the start as stored.

    Lists of many snapshots in double precision, then stacked, would take most of a run's memory.
    """
    last = snapshots[-1].geometry
    plane = last.plane(workspace.problem.spacing)
    in_line = workspace.problem.indenter.is_line
    shape = (len(snapshots), *(plane.shape[:1] if in_line else plane.shape))
    shared = workspace.problem.wear_law.shares is not None
    known = (*FIELDS, *(BODY_FIELDS if shared else ()))
    fields = {field.name: np.empty(shape, dtype=field.dtype) for field in known}
    for row, snapshot in enumerate(snapshots):
        state = snapshot.on(workspace, snapshot.geometry.extended(last))
        problem = workspace.problem.of(state)
        written = state.geometry.written(_fields(problem, state), plane)
        if plane != state.geometry:
            # Cells that an edge cuts touch where they carry load, and slip as far as they wear.
            loaded, touch = written["pressure"] > 0.0, written["contact_state"]
            written["gap"][loaded] = 0.0
            touch[loaded] = np.maximum(touch[loaded], ContactState.SLIP)
            if not problem.loading.stroke:
                path = 4.0 * problem.wear_coefficient * written["pressure"][loaded]
                written["slip"][loaded] = written["wear_rate"][loaded] / path
        for name, values in fields.items():
            values[row] = written[name][:, 0] if in_line else written[name]
    return fields


def _fields(problem: WearProblem, state: State) -> dict[str, Array]:
    """The fields of a dataset of one state."""
    reduced = state.reduced
    slip = problem.slip(reduced)
    closed = in_contact(state)
    contact_state = np.where(closed, ContactState.SLIP, ContactState.OPEN)
    contact_state[reduced.stick & closed] = ContactState.STICK
    rate = 4.0 * problem.wear_coefficient * state.pressure * slip
    bodies = [share * state.wear for share in problem.wear_law.shares or ()]
    if isinstance(state, StrokeState):
        rate = state.rates.sum(axis=0)
        bodies = [state.wear_indenter, state.wear_flat] if bodies else []
    return {
        "pressure": state.pressure,
        "shear_traction": problem.shear_traction(state.pressure, reduced),
        "slip": slip,
        "wear_depth": state.wear,
        "wear_rate": rate,
        "plastic_depth": state.plastic,
        "gap": state.gap,
        "contact_state": contact_state,
        **{each.name: wear for each, wear in zip(BODY_FIELDS, bodies, strict=False)},
    }
