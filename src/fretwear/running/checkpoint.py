"""Checkpoints: an interrupted run loses at most a minute, and resumes bit for bit.

A checkpoint is the run record: its arrays in numpy's container, read without pickle, everything
else as JSON beside them, followed by a checksum.
"""

from __future__ import annotations

import json
import math
import time
import tokenize
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, cast, get_args, get_origin, get_type_hints
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.lib import format as numpy_format
from numpy.typing import NDArray

from fretwear.data.files import add_checksum, damage
from fretwear.data.safe import DataFileError, atomic_path, remove_stale_temporaries
from fretwear.running.simulate import RunRecord, Step
from fretwear.version import code_digest

if TYPE_CHECKING:
    from fretwear.study.case import Case

SECONDS_BETWEEN = 30.0
_SNAPSHOT_SHARE = 0.2
_CONTENT, _ARRAY = "content", "array"
_START_ANEW = "The run starts at cycle 0"
_NO_ARRAY = (NotImplementedError, SyntaxError, tokenize.TokenError)  # from headers
_UNREADABLE = (LookupError, TypeError, ValueError, RecursionError)


class CheckpointError(DataFileError):
    """A checkpoint that cannot be used: damaged, or of another run."""


class Checkpoint:
    """The checkpoint of a run: an observer that keeps the run record on disk.

    Used as a context manager: an interrupted run leaves a checkpoint of the last accepted step, and
    a finished one removes it once the caller has stored the result. An existing file is read at
    once; a message says why it was not used, or where the run resumes. It is written after
    `interval` seconds, or a single longer step, and sooner at snapshots.
    """

    def __init__(
        self,
        path: Path,
        case: Case,
        tell: Callable[[str], None],
        interval: float = SECONDS_BETWEEN,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.path = path
        self._interval = interval
        self._case = case
        self._tell = tell
        self._clock = clock
        self._saved = clock()
        self._is_discarded = False
        try:
            stored = read_checkpoint(path, identity_of(case))
        except CheckpointError as error:
            tell(str(error))
            stored = None
        self.record = stored or RunRecord()
        self._saved_steps = len(self.record.history)
        if self._saved_steps:
            tell(f"{path}: resuming after cycle {self._saved_cycle:.6g}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        if self._is_discarded:
            return
        if kind is None:
            self.discard()
            return
        if len(self.record.history) > self._saved_steps:
            try:
                self.save()
            except DataFileError as failure:
                # The interruption is what matters; a full disk must not hide it.
                if str(failure) != str(error):
                    self._tell(str(failure))
        if self._saved_steps and self.path.exists():
            self._tell(
                f"{self.path}: kept; the same command resumes after cycle {self._saved_cycle:.6g}"
            )

    def __call__(self, step: Step) -> None:
        """Observe a step; save it when it is time."""
        since = self._clock() - self._saved
        is_snapshot = step.state.cycle in self._case.output_cycles
        if since >= (_SNAPSHOT_SHARE if is_snapshot else 1.0) * self._interval:
            self.save()

    def save(self) -> None:
        """Write the run record to the file; see `write_checkpoint`."""
        write_checkpoint(self.path, self.record, identity_of(self._case))
        self._saved = self._clock()
        self._saved_steps = len(self.record.history)

    def discard(self) -> None:
        """Remove the file: the result is stored."""
        self._is_discarded = True
        try:
            self.path.unlink(missing_ok=True)
            remove_stale_temporaries(self.path.parent, self.path.name)
        except OSError as error:
            # No later run uses a left-over file without a check.
            self._tell(f"{self.path}: not removed: {error.strerror}")

    @property
    def _saved_cycle(self) -> float:
        return self.record.history[self._saved_steps - 1]["cycle"]


def identity_of(case: Case) -> dict[str, Any]:
    """What a run must share with the one that wrote a checkpoint in order to resume from it."""
    return {
        "code": code_digest(),
        "parameters": case.canonical_parameters(),
        "output cycles": list(case.output_cycles),
    }


def write_checkpoint(path: Path, record: RunRecord, identity: Mapping[str, Any]) -> None:
    """Write a run record; the file appears complete, or not at all with a `DataFileError`."""
    arrays: dict[str, NDArray[Any]] = {}
    packed = {"identity": identity, "record": pack(record, "record", arrays)}
    content = np.frombuffer(json.dumps(packed, sort_keys=True).encode(), dtype=np.uint8)
    with atomic_path(path) as temporary:
        with temporary.open("wb") as stream:
            np.savez(stream, allow_pickle=False, **{_CONTENT: content}, **arrays)
        add_checksum(temporary)


def read_checkpoint(path: Path, identity: Mapping[str, Any]) -> RunRecord | None:
    """Read a file written by `write_checkpoint`; None if there is none.

    `CheckpointError` if it is damaged or belongs to another run.
    """
    if not path.exists():
        return None
    # The container has checksums of its own, but none of its headers.
    if problem := damage(path, "checkpoint"):
        raise CheckpointError(path, f"this checkpoint is damaged ({problem})", _START_ANEW)
    try:
        arrays = _read_arrays(path)
        content = json.loads(arrays.pop(_CONTENT).tobytes())
        found, packed = dict(content["identity"]), content["record"]
    except (*_UNREADABLE, OSError, AttributeError, BadZipFile, *_NO_ARRAY) as cause:
        problem = "this is not a checkpoint, or one of another version"
        raise CheckpointError(path, problem, _START_ANEW) from cause
    expected = json.loads(json.dumps(identity))
    if found != expected:
        keys = sorted(key for key in {*found, *expected} if found.get(key) != expected.get(key))
        problem = f"this checkpoint is of another run (another {', '.join(keys)})"
        raise CheckpointError(path, problem, _START_ANEW)
    try:
        record: RunRecord = unpack(RunRecord, packed, arrays)
        _check(record)
    except _UNREADABLE as cause:
        raise CheckpointError(
            path, "the content of this checkpoint is not as expected", _START_ANEW
        ) from cause
    return record


def _read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Read the arrays of the container; ValueError if one claims to be larger than the file."""
    with ZipFile(path) as container:
        entries = container.infolist()
        if sum(entry.file_size for entry in entries) > path.stat().st_size:
            raise ValueError("the file is smaller than it announces")
        for entry in entries:
            with container.open(entry) as stream:
                if numpy_format.read_magic(stream) != (1, 0):
                    raise ValueError("an array is of another format")
                shape, _, dtype = numpy_format.read_array_header_1_0(stream)
                if math.prod(shape) * dtype.itemsize != entry.file_size - stream.tell():
                    raise ValueError("an array is not as large as it says")
    with np.load(path, allow_pickle=False) as stored:
        return {name: stored[name] for name in stored.files}


def _check(record: RunRecord) -> None:
    """Raise a ValueError for a run record that no run could have left."""
    states = [*record.snapshots, *([] if record.last is None else [record.last])]
    if bool(record.history) != bool(states):
        raise ValueError("states and history do not match")
    if not all(map(math.isfinite, (number for row in record.history for number in row.values()))):
        raise ValueError("the history has a value that is not finite")
    for state in states:
        reduced = state.reduced
        fields = (state.pressure, state.gap, state.wear, state.plastic, reduced.pressure)
        rates = (reduced.gap, state.pressure_rate, state.source_rate)
        if {each.shape for each in (*fields, *rates)} != {tuple(state.geometry.shape)}:
            raise ValueError("the shape of a field does not match its geometry")
        if not state.is_finite:
            raise ValueError("a field is not finite")


def pack(value: Any, name: str, arrays: dict[str, NDArray[Any]]) -> Any:
    """Turn a dataclass into JSON, and its arrays into ``arrays`` by name.

    Nested dataclasses, lists and tuples are included. An array that occurs several times is stored
    once.
    """
    if isinstance(value, np.ndarray):
        kept = next((known for known, array in arrays.items() if array is value), name)
        arrays[kept] = value
        return {_ARRAY: kept}
    if is_dataclass(value):
        names = [each.name for each in fields(value)]
        return {each: pack(getattr(value, each), f"{name}.{each}", arrays) for each in names}
    if isinstance(value, list | tuple):
        return [pack(item, f"{name}.{index}", arrays) for index, item in enumerate(value)]
    return value


def unpack(kind: Any, packed: Any, arrays: Mapping[str, NDArray[Any]]) -> Any:
    """Restore a value of an annotated type from the result of `pack`.

    Of a union of dataclasses, the one with the packed fields is chosen. Raises KeyError, TypeError
    or ValueError if something else was packed.
    """
    parts = tuple(part for part in get_args(kind) if part is not ...)
    if isinstance(packed, list):
        kinds = parts if len(parts) == len(packed) else parts[:1] * len(packed)
        items = (unpack(*each, arrays) for each in zip(kinds, packed, strict=True))
        return list(items) if get_origin(kind) is list else tuple(items)
    if get_origin(kind) is dict:
        return {str(name): unpack(parts[1], value, {}) for name, value in packed.items()}
    if not isinstance(packed, dict):
        allowed = {kind, *parts} | ({int} if float in (kind, *parts) else set())
        if type(packed) not in allowed:
            raise TypeError(f"{packed!r} is no {kind}")
        return packed
    if packed.keys() == {_ARRAY}:
        return arrays[packed[_ARRAY]]
    for each in (kind, *parts):
        if is_dataclass(each) and {own.name for own in fields(each)} == packed.keys():
            types = get_type_hints(each)
            values = {name: unpack(types[name], packed[name], arrays) for name in packed}
            return cast("type[Any]", each)(**values)
    raise TypeError(f"{kind} has no fields {', '.join(packed)}")
