"""Runs that lose no more than a minute when their process dies."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from fretwear.data.checkpoint import CheckpointError, read_checkpoint, write_checkpoint
from fretwear.data.dataset import source
from fretwear.data.safe import DataFileError
from fretwear.journal import Journal, Step

if TYPE_CHECKING:
    from fretwear.study.case import Case

SECONDS_BETWEEN = 30.0
_SNAPSHOT_SHARE = 0.2


class Checkpoint:
    """The checkpoint of a run: an observer that keeps the journal on disk.

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
    journal
        To be given to `fretwear.simulation.run`.
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
        self.journal = self._read()

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
        if len(self.journal.history) > self._saved_steps:
            try:
                self.save()
            except DataFileError as failure:
                # What interrupted the run is the news; a full disk must not hide it.
                if str(failure) != str(error):
                    self._tell(str(failure))
        if self._saved_steps and self.path.exists():
            cycle = self.journal.history[self._saved_steps - 1].cycle
            self._tell(f"{self.path}: kept; the same command goes on after cycle {cycle:.6g}")

    def __call__(self, step: Step) -> None:
        """Observe a step: save it where it is time to."""
        since = self._clock() - self._saved
        is_snapshot = step.state.cycle in self._case.output_cycles
        if since >= (_SNAPSHOT_SHARE if is_snapshot else 1.0) * self._interval:
            self.save()

    def save(self) -> None:
        """Write the journal to the file.

        Raises
        ------
        fretwear.data.safe.DataFileError
            When it cannot be written.
        """
        arrays, numbers = self.journal.packed()
        write_checkpoint(self.path, arrays, numbers, self._identity())
        self._saved = self._clock()
        self._saved_steps = len(self.journal.history)

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

    def _read(self) -> Journal:
        try:
            stored = read_checkpoint(self.path, self._identity())
        except CheckpointError as error:
            self._tell(str(error))
            return Journal()
        if stored is None:
            return Journal()
        try:
            journal = Journal.unpacked(*stored, last_cycle=self._case.cycles)
        except (KeyError, IndexError, TypeError, ValueError):
            self._tell(
                f"{self.path}: this checkpoint has another content. The run starts at cycle 0"
            )
            return Journal()
        self._saved_steps = len(journal.history)
        assert journal.last is not None
        self._tell(f"{self.path}: going on after cycle {journal.last.cycle:.6g}")
        return journal
