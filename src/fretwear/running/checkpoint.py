"""Runs that lose no more than a minute when their process dies."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from fretwear.data.dataset import source
from fretwear.data.files import add_checksum, damage
from fretwear.data.safe import DataFileError, atomic_path
from fretwear.running.simulate import RunRecord, Step

if TYPE_CHECKING:
    from fretwear.study.case import Case

_NUMBERS = "numbers"
_START_ANEW = "The run starts at cycle 0"


class CheckpointError(DataFileError):
    """A checkpoint that cannot be used: damaged, or of another run."""


def write_checkpoint(
    path: Path,
    arrays: Mapping[str, NDArray[Any]],
    numbers: Mapping[str, Any],
    identity: Mapping[str, Any],
) -> None:
    """Write a checkpoint; it appears under its name only when it is whole.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    arrays : mapping of str to numpy.ndarray
        Numeric arrays of any shape.
    numbers : mapping
        Anything that JSON can hold.
    identity : mapping
        What the run is (version, parameters): must be equal when it is read.

    Raises
    ------
    DataFileError
        When it cannot be written.
    """
    text = json.dumps({"identity": identity, "numbers": numbers}, sort_keys=True)
    encoded = np.frombuffer(text.encode(), dtype=np.uint8)
    with atomic_path(path) as temporary:
        with temporary.open("wb") as stream:
            np.savez(stream, allow_pickle=False, **{_NUMBERS: encoded}, **arrays)
        add_checksum(temporary)


def read_checkpoint(
    path: Path, identity: Mapping[str, Any]
) -> tuple[dict[str, NDArray[Any]], dict[str, Any]] | None:
    """Read what `write_checkpoint` wrote; None where there is no such file.

    Raises
    ------
    CheckpointError
        When the file is damaged, or when its identity is another one.
    """
    if not path.exists():
        return None
    # The container has checksums of its own, but none of its headers.
    if problem := damage(path, "checkpoint"):
        raise CheckpointError(path, f"this checkpoint is damaged ({problem})", _START_ANEW)
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        content = json.loads(arrays.pop(_NUMBERS).tobytes())
        found, numbers = content["identity"], content["numbers"]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, BadZipFile) as cause:
        problem = "this is no checkpoint, or one of another version"
        raise CheckpointError(path, problem, _START_ANEW) from cause
    expected = json.loads(json.dumps(identity))
    if found != expected:
        keys = sorted(key for key in {*found, *expected} if found.get(key) != expected.get(key))
        problem = f"this checkpoint is of another run (another {', '.join(keys)})"
        raise CheckpointError(path, problem, _START_ANEW)
    return arrays, numbers


SECONDS_BETWEEN = 30.0
_SNAPSHOT_SHARE = 0.2


class Checkpoint:
    """The checkpoint of a run: an observer that keeps the record on disk.

    Used as a context: what interrupts the run leaves a checkpoint of the last accepted step, and
    a run that comes to its end removes it once the caller has stored the result.

    Parameters
    ----------
    path
        The file; read at once if it is there.
    case
        What is run.
    tell
        Takes a line for people: why a checkpoint was not used, or where the run goes on.
    interval
        Longest time between two writings of the file, s, but for a single step that takes longer;
        snapshots are written sooner.
    clock
        Seconds, increasing.

    Attributes
    ----------
    record
        To be given to `fretwear.running.simulate.run`.
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
        self._saved_steps = 0
        self._is_discarded = False
        self.record = self._read()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._is_discarded:
            return
        if kind is None:
            self.discard()
            return
        if len(self.record.history) > self._saved_steps:
            try:
                self.save()
            except DataFileError as failure:
                # What interrupted the run is the news; a full disk must not hide it.
                if str(failure) != str(error):
                    self._tell(str(failure))
        if self._saved_steps and self.path.exists():
            cycle = self.record.history[self._saved_steps - 1].cycle
            self._tell(f"{self.path}: kept; the same command goes on after cycle {cycle:.6g}")

    def __call__(self, step: Step) -> None:
        """Observe a step: save it where it is time to."""
        since = self._clock() - self._saved
        is_snapshot = step.state.cycle in self._case.output_cycles
        if since >= (_SNAPSHOT_SHARE if is_snapshot else 1.0) * self._interval:
            self.save()

    def save(self) -> None:
        """Write the record to the file.

        Raises
        ------
        fretwear.data.safe.DataFileError
            When it cannot be written.
        """
        arrays, numbers = self.record.packed()
        write_checkpoint(self.path, arrays, numbers, self._identity())
        self._saved = self._clock()
        self._saved_steps = len(self.record.history)

    def discard(self) -> None:
        """Remove the file: the result is stored."""
        self._is_discarded = True
        try:
            self.path.unlink(missing_ok=True)
        except OSError as error:
            # What is left over is used by no later run without a check.
            self._tell(f"{self.path}: not removed: {error.strerror}")

    def _identity(self) -> dict[str, Any]:
        return {
            # Files of a checkout that were changed may as well be those of a study.
            "version": source().replace("-dirty", ""),
            "parameters": self._case.canonical_parameters(),
            "output cycles": list(self._case.output_cycles),
        }

    def _read(self) -> RunRecord:
        try:
            stored = read_checkpoint(self.path, self._identity())
        except CheckpointError as error:
            self._tell(str(error))
            return RunRecord()
        if stored is None:
            return RunRecord()
        try:
            record = RunRecord.unpacked(*stored, last_cycle=self._case.cycles)
        except (KeyError, IndexError, TypeError, ValueError):
            self._tell(
                f"{self.path}: this checkpoint has another content. The run starts at cycle 0"
            )
            return RunRecord()
        self._saved_steps = len(record.history)
        assert record.last is not None
        self._tell(f"{self.path}: going on after cycle {record.last.cycle:.6g}")
        return record
