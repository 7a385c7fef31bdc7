"""A case in, a dataset out: case, problem, steps, run record, dataset with estimated errors."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from fretwear.data.labels import Labelled, labelled_case, labelled_history, labelled_loops
from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.geometry import Geometry, Workspace
from fretwear.mechanics.integrator import WearError, evolve
from fretwear.mechanics.measures import (
    Measures,
    fractions,
    loop,
    measure,
    scatter,
    share_beyond_friction,
    unresolved_peak,
)
from fretwear.mechanics.setup import Setup
from fretwear.mechanics.state import State, WearProblem, in_contact
from fretwear.mechanics.stroke import StrokeState, slide
from fretwear.mechanics.team import Team, arithmetic
from fretwear.running.resources import require_memory
from fretwear.study.case import Case
from fretwear.study.doubts import doubts
from fretwear.vocabulary import BODY_FIELDS, FIELDS, SCALARS, SYMMETRIES, ContactState, Y

if TYPE_CHECKING:
    import xarray as xr

_MARGIN = 1.15

# Standard deviations in an estimated error, chosen on half of the cases of the verification page.
_DEVIATIONS = 2.0
# Values below this part of the largest have just begun to grow, and do not represent the others.
_TRACE = 0.01
# Words in the names of scalars that follow from the edges of contact and stick. These lie somewhere
# in a cell, so that now and then a scalar is the same in both runs, even throughout an elastic run,
# or jumps by a row of asperities: the upper quartile over all of these scalars measures how well
# the edges are resolved.
_OF_EDGES = ("area", "half_width", "stick")
# Words in the names of scalars that add up over steps or follow from the worn shape, and their
# standard deviation due to steps, over the tolerance: volumes and energies on rings, strips and
# grids differ from runs at a tenth of the tolerance by 0.03 to 0.14 of it.
_OF_STEPS, _STEPPING = ("wear", "plastic", "energy", "sliding"), 0.05


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
    # every scalar of `measure`.
    history: list[dict[str, float]] = field(default_factory=list)
    # What has computed it, `fretwear.mechanics.team.arithmetic`; several if a run was resumed on
    # another processor.
    arithmetic: list[str] = field(default_factory=list)
    # The state that the run has reached; None before the first loading.
    last: State | StrokeState | None = None

    def add(self, step: Step, *, keep_fields: bool) -> None:
        """Add a step."""
        self.last = state = step.state
        numbers = {"cycle": state.cycle, "error_estimate": state.error_estimate}
        numbers["convolutions"] = state.convolutions
        self.history.append(numbers | vars(step.measures))
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

    A smooth indenter with rotational symmetry is computed on concentric rings: scalars come from
    the rings, and fields are means over a quarter of the grid that `cell` asks for.

    `observers` are called with each accepted `Step`, cycle 0 included. The result does not depend
    on the number of `threads`, to the last bit. `progress` shows a bar, also in a notebook.

    The dataset holds the whole contact or, with `quarter`, the part computed: one side along each
    axis in which the contact is even, see ``symmetry``. Its fields are over ``cycle``, ``x`` and
    ``y``, its scalars over ``cycle``, at the case's `output_cycles`; every parameter is a scalar
    coordinate.

    A WearError or a ContactError says that the solution does not converge, a MemoryError that the
    case certainly does not fit in the memory, and each `DoubtfulResultWarning` a reason to doubt
    the results, known beforehand or found by the run.
    """
    from rich.progress import Progress

    if not isinstance(case, Case):
        example = "fretwear.Case(load='50 N', ...)"
        raise TypeError(f"simulate() takes a case, {example}, not a {type(case).__name__}.")

    require_memory(case)

    def warn(doubt: str) -> None:
        warnings.warn(doubt, DoubtfulResultWarning, stacklevel=4)

    with Progress(disable=not progress) as bar:
        task = bar.add_task(case.case_id, total=case.cycles)

        def show(step: Step) -> None:
            bar.update(task, completed=step.state.cycle)

        dataset = run(case, [*observers, show], threads=threads, warn=warn).dataset
    if quarter:
        return dataset
    from fretwear.data.dataset import mirrored

    return mirrored(dataset)


@contextmanager
def _without_threads_of_blas(case: Case) -> Iterator[None]:
    """Products of matrices on one thread each, for a case that has threads of its own.

    More of them change the last bits of a product, and on a loaded machine wait for one another
    ten times as long as they compute.
    """
    if case.loading.stroke:
        import scipy.linalg  # noqa: F401 - loads its BLAS, so that the limit applies
    with threadpool_limits(1, user_api="blas"):
        yield


def run(
    case: Case,
    observers: Sequence[Observer] = (),
    *,
    record: RunRecord | None = None,
    threads: int = 1,
    command: str = "fretwear.simulate",
    warn: Callable[[str], None] = lambda _: None,
) -> Result:
    """Run a case as `simulate` does, and keep its history too.

    Every step is added to the record; a run resumes at the end of a record that an earlier run has
    left, with the same result to the last bit. The command is an attribute of the dataset. Reasons
    to doubt the results are passed to `warn`.

    A twin on wider cells runs alongside, from which errors are estimated. It is not stored in
    checkpoints: a resumed run starts its twin anew.
    """
    record, before = record or RunRecord(), doubts(case)
    if arithmetic() not in record.arithmetic:
        record.arithmetic.append(arithmetic())
    for doubt in before:
        warn(str(doubt))
    problem = wear_problem(case, threads=threads)
    twin = _scalars_of_twin(case, threads) if case.error_estimate else iter(())
    coarser: list[dict[str, float]] = []
    trouble = ""

    def follow() -> None:
        nonlocal trouble
        try:
            coarser.extend(islice(twin, len(record.snapshots) - len(coarser)))
        except (ContactError, WearError) as error:
            trouble = str(error) or type(error).__name__

    workspace, snapshots = Workspace(problem), record.snapshots
    with _without_threads_of_blas(case):
        for state in _states(case, problem, record.last):
            step = Step(state, measure(problem.of(state), state), case.cycles)
            record.add(step, keep_fields=state.cycle in case.output_cycles)
            for observer in observers:
                observer(step)
            follow()
        follow()
        loops = [loop(workspace, state) for state in snapshots]
        of_both = zip(snapshots, loops, strict=True)
        rows = [_scalars(workspace, state, curve.opening) for state, curve in of_both]
        fields = _snapshot_fields(workspace, snapshots)
    scalars, columns = _columns(rows), _columns(record.history)
    errors = {}
    if coarser and not trouble:
        spread = _columns([scatter(state) for state in snapshots])
        of_case = case.times_coarser, spread, case.tolerance
        errors = estimated_errors(scalars, _columns(coarser), *of_case)
        states = zip(snapshots, scalars["peak_pressure"].tolist(), strict=True)
        missed = [unresolved_peak(problem.of(state), state, peak) for state, peak in states]
        errors["peak_pressure"] = np.hypot(errors["peak_pressure"], missed)
    steps_at, of_steps = columns.pop("cycle"), columns.pop("error_estimate")
    spent = np.diff(columns.pop("convolutions"), prepend=0)
    plane = snapshots[-1].geometry.plane(problem.spacing)
    axes = case.frame.axes
    even = tuple(axis in axes and is_even for axis, is_even in zip("xy", plane.even, strict=True))
    symmetry = next(name for name, sides in SYMMETRIES.items() if sides == even)
    lacking = {scalar.name for scalar in SCALARS if scalar.across and Y.name not in axes}
    columns, scalars, errors = (
        {name: values for name, values in table.items() if name not in lacking}
        for table in (columns, scalars, errors)
    )
    cycles = [state.cycle for state in snapshots]
    dataset = labelled_case(
        case,
        plane.x,
        plane.y,
        cycles,
        fields,
        scalars,
        errors,
        trouble=trouble,
        beyond_friction=max(map(share_beyond_friction, snapshots)),
        symmetry=symmetry,
        command=command,
        arithmetic="; then ".join(record.arithmetic),
    )
    for text in dataset.attrs["warnings"].splitlines()[len(before) :]:
        warn(text)
    history = labelled_history(steps_at, columns, of_steps, spent, case.frame)
    curves = {
        "force": np.array([curve.force for curve in loops]),
        "displacement": np.array([curve.displacement for curve in loops]),
    }
    return Result((dataset, history, labelled_loops(cycles, curves, case.frame)))


def steps(
    case: Case, *, start: State | None = None, geometry: type[Geometry] | None = None
) -> Iterator[Step]:
    """Yield each accepted step of a case: cycle 0 and all others, or those after ``start``."""
    problem = wear_problem(case, geometry)
    for state in _states(case, problem, start):
        yield Step(state, measure(problem.of(state), state), case.cycles)


def _states(case: Case, problem: WearProblem, start: State | None = None) -> Iterator[State]:
    stops = [*map(float, case.output_cycles)]
    if problem.loading.stroke:
        assert start is None or isinstance(start, StrokeState)
        return slide(problem, stops, case.tolerance, start)
    return evolve(problem, stops, case.tolerance, start)


def _scalars_of_twin(case: Case, threads: int) -> Iterator[dict[str, float]]:
    """Yield every scalar of the same case on wider cells at each snapshot."""
    coarseness = case.times_coarser * case.coarseness
    problem = wear_problem(case.coarser, None, threads, coarseness)
    workspace = Workspace(problem)
    for state in _states(case.coarser, problem):
        if state.cycle in case.output_cycles:
            yield _scalars(workspace, state, loop(workspace, state, contacts=1).opening)


def _scalars(workspace: Workspace, state: State, opening: float) -> dict[str, float]:
    """All scalars of a state: the measures of every step, and scalars of its loop."""
    scalars = vars(measure(workspace.problem.of(state), state))
    full = 4.0 * opening * scalars["tangential_force"]
    scalars["sliding_criterion"] = scalars["dissipated_energy"] / full if full else math.nan
    shares = workspace.problem.wear_law.shares
    for index, (body, wear) in enumerate(_wear_of_each(workspace.problem, state).items()):
        volume = shares[index] * scalars["wear_volume"] if shares else state.geometry.integral(wear)
        scalars[f"wear_volume_{body}"] = volume
    return scalars


def _wear_of_each(problem: WearProblem, state: State) -> dict[str, NDArray[np.float64]]:
    """Wear depth of indenter and flat, m, if they are known."""
    if isinstance(state, StrokeState):
        each = [state.wear_indenter, state.wear_flat] if problem.wear_law.is_of_each else []
    else:
        each = [share * state.wear for share in problem.wear_law.shares or ()]
    return dict(zip(("indenter", "flat"), each, strict=False))


def _columns(rows: Sequence[Mapping[str, float]]) -> dict[str, NDArray[np.float64]]:
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def estimated_errors(
    scalars: Mapping[str, NDArray[np.float64]],
    coarser: Mapping[str, NDArray[np.float64]],
    times: float,
    spread: Mapping[str, NDArray[np.float64]],
    tolerance: float,
) -> dict[str, NDArray[np.float64]]:
    """Estimate how far results are from the limit of infinitely narrow cells and short steps.

    The scalars by name at the snapshots, shape (n,), belong to a run and to its twin, whose cells
    are some times wider. The estimates have the same names, shapes and units.

    Where the cells are k times wider and the tolerance is k² times larger, results differ by k − 1
    times the error of the run if errors grow with the width of a cell, and by √(k² + 1) times its
    standard deviation if they follow from where edges happen to fall in cells. √(k² − 1) lies
    between. The difference of two runs at one snapshot may be small by chance: the median over the
    snapshots of the difference relative to the value counts if it is larger. It is the median of
    logarithms, so that a hard snapshot beside an easy one does not count for both. A value missing
    in one of the two runs, NaN, counts as zero; if the run itself has none, there is no error.

    A falling value, such as the energy of a contact that wears in, is the rest of a larger one: its
    relative error is no smaller than before. Two runs that agree again merely cross.

    Two runs may differ by less than the uncertainty due to cells alone, above all if the edges do
    not move from one snapshot to the next: the standard deviations that edges within cells cause,
    `fretwear.mechanics.measures.scatter`, are a lower bound. So is a share of the tolerance for
    values that steps add up after the first snapshot: cells and steps may err in opposite
    directions.
    """
    apart, sizes, usual = {}, {}, {}
    for name, values in scalars.items():
        fine, wide = (np.nan_to_num(np.abs(run)) for run in (values, coarser[name]))
        apart[name] = np.where(np.isnan(values), np.nan, np.abs(fine - wide))
        sizes[name] = np.maximum(fine, wide)
        counts = fine > _TRACE * fine.max()
        differs = counts & (apart[name] > 0)
        logarithms = np.log(apart[name][differs] / sizes[name][differs])
        usual[name] = float(np.exp(np.median(logarithms))) if differs.any() else 0.0
    of_edges = [name for name in usual if any(word in name for word in _OF_EDGES)]
    typical = float(np.percentile([usual[name] for name in of_edges] or [0.0], 75.0))
    usual.update((name, max(usual[name], typical)) for name in of_edges)
    part = _DEVIATIONS / math.sqrt(times**2 - 1.0)
    estimates = {name: part * np.maximum(apart[name], usual[name] * sizes[name]) for name in apart}
    for name, deviations in spread.items():
        estimates[name] = np.maximum(estimates[name], _DEVIATIONS * deviations)
    for name in (name for name in estimates if any(word in name for word in _OF_STEPS)):
        least = _DEVIATIONS * _STEPPING * tolerance * np.abs(scalars[name][1:])
        estimates[name][1:] = np.maximum(estimates[name][1:], least)
    for name, errors in estimates.items():
        size = np.abs(scalars[name])
        for now, falls in enumerate(size[1:] < size[:-1], start=1):
            if falls:
                errors[now] = max(errors[now], errors[now - 1] * size[now] / size[now - 1])
    return estimates


def wear_problem(
    case: Case,
    geometry: type[Geometry] | None = None,
    threads: int = 1,
    coarseness: float | None = None,
) -> WearProblem:
    """The mechanical problem of a case, on its default cells or others; rings may be wider."""
    # A contact at the limit everywhere is the smallest one that carries the load.
    spread = _MARGIN * max(1.0, case.hertz.spread_radius(case.plastic_limit) / case.hertz_radius)
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
        spacing=case.grid_spacing,
        extent=(spread * x, spread * y),
        team=Team(threads),
        geometry=geometry or case.geometry,
        coarseness=coarseness or case.coarseness,
        blocks=tuple(blocks) if len(blocks) > 1 else (),
    )


def _snapshot_fields(
    workspace: Workspace, snapshots: Sequence[State]
) -> dict[str, NDArray[np.generic]]:
    """The fields of a dataset over all snapshots on one plane, in the precision that is stored.

    Lists of many snapshots in double precision, then stacked, would take most of a run's memory.
    """
    last = snapshots[-1].geometry
    plane = last.plane(workspace.problem.spacing)
    shape = plane.shape[: len(workspace.problem.frame.axes)]
    about = (*FIELDS, *(BODY_FIELDS if _wear_of_each(workspace.problem, snapshots[-1]) else ()))
    stored = {field.name: np.empty((len(snapshots), *shape), field.dtype) for field in about}
    for row, snapshot in enumerate(snapshots):
        state = snapshot.on(workspace, snapshot.geometry.extended(last))
        problem = workspace.problem.of(state)
        reduced, closed = state.reduced, in_contact(state)
        slip = problem.slip(reduced)
        contact_state = np.where(closed, ContactState.SLIP, ContactState.OPEN)
        contact_state[reduced.stick & closed] = ContactState.STICK
        rate = 4.0 * problem.combined_wear_coefficient * state.pressure * slip
        if isinstance(state, StrokeState):
            rate = state.rates.sum(axis=0)
        bodies = _wear_of_each(workspace.problem, state).values()
        values_of = {
            "pressure": state.pressure,
            "reduced": reduced.pressure,
            "slip": slip,
            "wear_depth": state.wear,
            "wear_rate": rate,
            "plastic_depth": state.plastic,
            "gap": state.gap,
            "contact_state": contact_state,
            **{field.name: wear for field, wear in zip(BODY_FIELDS, bodies, strict=False)},
        }
        written = state.geometry.written(values_of, plane)
        # Means over a cell that slips in part obey Coulomb's law if computed from mean pressures.
        sticking = replace(reduced, pressure=written["reduced"])
        written["shear_traction"] = problem.shear_traction(written["pressure"], sticking)
        if plane != state.geometry:
            # Cells cut by an edge touch if they carry load, and their slip follows from their wear.
            loaded, touch = written["pressure"] > 0.0, written["contact_state"]
            written["gap"][loaded] = 0.0
            touch[loaded] = np.maximum(touch[loaded], ContactState.SLIP)
            if not problem.loading.stroke:
                path = 4.0 * problem.combined_wear_coefficient * written["pressure"][loaded]
                written["slip"][loaded] = written["wear_rate"][loaded] / path
        beyond = np.hypot(plane.x[:, None], plane.y) > problem.indenter.end
        for name, value in (("gap", np.nan), ("slip", 0.0)):
            written[name][beyond & (written["pressure"] == 0.0)] = value
        written["contact_fraction"], written["stick_fraction"] = fractions(state, plane)
        for name, values in stored.items():
            values[row] = written[name].reshape(shape)
    return stored
