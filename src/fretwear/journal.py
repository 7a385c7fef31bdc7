"""What a run remembers: its snapshots, its history and the state to go on from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.measures import Measures
from fretwear.mechanics.slip import ReducedContact
from fretwear.mechanics.state import State
from fretwear.mechanics.window import Window

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
class Journal:
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
        """The journal as named arrays and a mapping for JSON, both without any loss."""
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
    ) -> Journal:
        """The journal that `packed` made these of."""
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
