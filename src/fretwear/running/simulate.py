"""A case in, a dataset out: where the study, the mechanics and the data meet."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.arrays import Array
from fretwear.mechanics.measures import Measures, in_contact, measure
from fretwear.mechanics.slip import (
    CattaneoMindlinSlip,
    Friction,
    JaegerSlip,
    ReducedContact,
    SlipModel,
)
from fretwear.mechanics.state import State, WearProblem
from fretwear.mechanics.surfaces import Surface, Waves
from fretwear.mechanics.wear import evolve
from fretwear.mechanics.window import Window
from fretwear.theory import HertzContact
from fretwear.vocabulary import FIELDS, ContactState

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.study.case import Case

_STATE_ARRAYS = ("pressure", "gap", "wear", "plastic", "pressure_rate", "source_rate")
_REDUCED_ARRAYS = ("pressure", "gap")
_MEASURES = tuple(each.name for each in fields(Measures))


@dataclass(frozen=True)
class Step:
    """One accepted step of a run, as observers see it.

    Attributes
    ----------
    state
        Fields and numbers of the contact.
    measures
        Scalars of the whole contact.
    last_cycle
        Where the run ends.
    """

    state: State
    measures: Measures
    last_cycle: int


@dataclass(frozen=True)
class Record:
    """What the history keeps of a step: everything but the fields."""

    cycle: float
    measures: Measures
    error_estimate: float
    convolutions: int

    @classmethod
    def of(cls, step: Step) -> Record:
        """The record of a step."""
        state = step.state
        return cls(state.cycle, step.measures, state.error_estimate, state.convolutions)


@dataclass
class RunRecord:
    """Snapshots and history of a run so far.

    Attributes
    ----------
    snapshots
        Steps whose fields are kept.
    history
        Every step without its fields.
    last
        The state that the run has reached; None before the first loading.
    """

    snapshots: list[Step] = field(default_factory=list)
    history: list[Record] = field(default_factory=list)
    last: State | None = None

    def note(self, step: Step, *, keep_fields: bool) -> None:
        """Add a step."""
        self.last = step.state
        self.history.append(Record.of(step))
        if keep_fields:
            self.snapshots.append(step)

    def packed(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        """The record as named arrays and a mapping for JSON, both without any loss."""
        arrays: dict[str, NDArray[Any]] = {}
        states = [step.state for step in self.snapshots]
        states += [] if self.last is None else [self.last]
        numbers = [_pack_state(state, f"state{i}.", arrays) for i, state in enumerate(states)]
        arrays["history.cycle"] = np.array([record.cycle for record in self.history])
        arrays["history.error"] = np.array([record.error_estimate for record in self.history])
        arrays["history.convolutions"] = np.array([record.convolutions for record in self.history])
        arrays["history.measures"] = np.array(
            [[getattr(record.measures, name) for name in _MEASURES] for record in self.history]
        )
        measures = [asdict(step.measures) for step in self.snapshots]
        return arrays, {"states": numbers, "measures": measures}

    @classmethod
    def unpacked(
        cls, arrays: Mapping[str, NDArray[Any]], numbers: Mapping[str, Any], last_cycle: int
    ) -> RunRecord:
        """The record that `packed` made these of."""
        states = [
            _unpack_state(state, f"state{i}.", arrays) for i, state in enumerate(numbers["states"])
        ]
        rows = zip(
            arrays["history.cycle"].tolist(),
            arrays["history.measures"].tolist(),
            arrays["history.error"].tolist(),
            arrays["history.convolutions"].tolist(),
            strict=True,
        )
        return cls(
            snapshots=[
                Step(state, Measures(**measures), last_cycle)
                for state, measures in zip(states[:-1], numbers["measures"], strict=True)
            ],
            history=[
                Record(cycle, Measures(*measures), error, convolutions)
                for cycle, measures, error, convolutions in rows
            ],
            last=states[-1],
        )


def _pack_state(state: State, prefix: str, arrays: dict[str, NDArray[Any]]) -> dict[str, Any]:
    arrays |= {prefix + name: getattr(state, name) for name in _STATE_ARRAYS}
    arrays |= {f"{prefix}reduced.{name}": getattr(state.reduced, name) for name in _REDUCED_ARRAYS}
    numbers = {
        each.name: getattr(state, each.name)
        for each in fields(State)
        if each.name not in (*_STATE_ARRAYS, "window", "reduced")
    }
    return {
        "numbers": numbers,
        "window": asdict(state.window),
        "reduced": {
            "approach": state.reduced.approach,
            "convolutions": state.reduced.convolutions,
        },
    }


def _unpack_state(
    packed: Mapping[str, Any], prefix: str, arrays: Mapping[str, NDArray[Any]]
) -> State:
    window = packed["window"]
    own: dict[str, Any] = {name: arrays[prefix + name] for name in _STATE_ARRAYS}
    inner: dict[str, Any] = {name: arrays[f"{prefix}reduced.{name}"] for name in _REDUCED_ARRAYS}
    return State(
        **own,
        **packed["numbers"],
        window=Window(tuple(window["shape"]), tuple(window["spacing"]), window["quarter"]),
        reduced=ReducedContact(**inner, **packed["reduced"]),
    )


_MARGIN = 1.15

Observer = Callable[[Step], None]


@dataclass(frozen=True)
class Result:
    """What a run leaves: the dataset of the case and the history of every step."""

    dataset: xr.Dataset
    history: xr.Dataset


def simulate(case: Case, observers: Sequence[Observer] = (), *, quarter: bool = True) -> xr.Dataset:
    """Run a case.

    Parameters
    ----------
    case
        What to run.
    observers
        Called with each accepted `Step`, cycle 0 included.
    quarter
        Compute only the quarter x > 0, y > 0 of the contact, which is even in both.

    Returns
    -------
    xarray.Dataset
        Fields over ``cycle``, ``x``, ``y`` and scalars over ``cycle`` at the case's
        `output_cycles`; scalar coordinates of every parameter.

    Raises
    ------
    fretwear.mechanics.wear.WearError, fretwear.mechanics.contact.ContactError
        When the solution does not converge.
    """
    return run(case, observers, quarter=quarter).dataset


def run(
    case: Case,
    observers: Iterable[Observer] = (),
    *,
    record: RunRecord | None = None,
    quarter: bool = True,
    title: str = "",
    command: str = "fretwear.simulate",
) -> Result:
    """Run a case and keep its history too.

    Parameters
    ----------
    case, observers, quarter
        As for `simulate`.
    record
        Takes every step; one that an earlier run has left makes this one go on from there, with
        the same result to the last bit.
    title, command
        For the attributes of the dataset.
    """
    record = RunRecord() if record is None else record
    observers = list(observers)
    wanted = set(case.output_cycles)
    for step in steps(case, start=record.last, quarter=quarter):
        record.note(step, keep_fields=step.state.cycle in wanted)
        for observer in observers:
            observer(step)
    return _result(case, record, quarter, title, command)


def steps(case: Case, *, start: State | None = None, quarter: bool = True) -> Iterator[Step]:
    """Yield each accepted step of a case: cycle 0 and all others, or those after ``start``."""
    problem = wear_problem(case, quarter=quarter)
    stops = [float(cycle) for cycle in case.output_cycles]
    for state in evolve(problem, stops, case.tolerance, start):
        yield Step(state, measure(state, problem.friction), case.cycles)


def _result(case: Case, record: RunRecord, quarter: bool, title: str, command: str) -> Result:
    from fretwear.data.dataset import case_dataset, history_dataset

    problem = wear_problem(case, quarter=quarter)
    snapshots, history = record.snapshots, record.history
    window = snapshots[-1].state.window
    dataset = case_dataset(
        case,
        window.x,
        window.y,
        [step.state.cycle for step in snapshots],
        _snapshot_fields(problem, snapshots, window),
        _stacked(asdict(step.measures) for step in snapshots),
        symmetry="even_xy" if quarter else "none",
        title=title,
        command=command,
    )
    return Result(
        dataset,
        history_dataset(
            [record.cycle for record in history],
            _stacked(asdict(record.measures) for record in history),
            [record.error_estimate for record in history],
            np.diff([record.convolutions for record in history], prepend=0),
        ),
    )


def wear_problem(case: Case, *, quarter: bool = True) -> WearProblem:
    """The mechanical problem of a case."""
    hertz = HertzContact(case.radius, case.load, case.composite_modulus)
    # A contact at the limit everywhere is the smallest one that carries the load.
    carrying = math.sqrt(case.load / (math.pi * case.plastic_limit))
    half_width = _MARGIN * max(hertz.contact_radius, carrying)
    return WearProblem(
        surface=_surface(case),
        composite_modulus=case.composite_modulus,
        load=case.load,
        friction=Friction(case.friction, case.coupling),
        slip_model=_slip_model(case, hertz),
        wear_coefficient=case.wear_coefficient,
        limit=case.plastic_limit,
        spacing=case.grid_spacing,
        extent=(half_width, half_width),
        quarter=quarter,
    )


def _surface(case: Case) -> Surface:
    roughness = case.roughness
    if roughness is None:
        return Surface(case.radius)
    waves = Waves(roughness.amplitude, roughness.wavenumber_x, roughness.wavenumber_y)
    return Surface(case.radius, waves)


def _slip_model(case: Case, hertz: HertzContact) -> SlipModel:
    if case.slip_model == "cattaneo_mindlin":
        return CattaneoMindlinSlip(hertz.with_load(case.stick_load))
    return JaegerSlip(case.stick_load)


def _snapshot_fields(
    problem: WearProblem, snapshots: Sequence[Step], window: Window
) -> dict[str, NDArray[Any]]:
    """The fields of a dataset over all snapshots, from the start as they are stored.

    Many snapshots in double precision, listed and then stacked, took most of a run's memory.
    """
    shape = (len(snapshots), *window.shape)
    fields = {field.name: np.empty(shape, dtype=field.dtype) for field in FIELDS}
    for row, step in enumerate(snapshots):
        for name, values in _fields(problem, step.state, window).items():
            fields[name][row] = values
    return fields


def _fields(problem: WearProblem, state: State, window: Window) -> dict[str, Array]:
    """The fields of a dataset on a window that contains the state's own."""
    state = state.on(problem, window)
    friction, reduced = problem.friction, state.reduced
    slip = friction.slip(reduced)
    closed = in_contact(state)
    contact_state = np.where(closed, ContactState.SLIP, ContactState.OPEN)
    contact_state[reduced.stick & closed] = ContactState.STICK
    return {
        "pressure": state.pressure,
        "shear_traction": friction.shear_traction(state.pressure, reduced),
        "slip": slip,
        "wear_depth": state.wear,
        "wear_rate": 4.0 * problem.wear_coefficient * state.pressure * slip,
        "plastic_depth": state.plastic,
        "gap": state.gap,
        "contact_state": contact_state,
    }


def _stacked(records: Iterable[dict[str, Any]]) -> dict[str, Any]:
    """Records with the same names, one array a name with the records along the first axis."""
    listed = list(records)
    return {name: np.stack([record[name] for record in listed]) for name in listed[0]}
