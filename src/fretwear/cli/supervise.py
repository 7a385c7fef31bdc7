"""Processes that are asked to stop, are killed, or crash."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import NoReturn

_WORDS = {
    signal.SIGINT: "by Ctrl-C",
    signal.SIGTERM: "by SIGTERM",
    signal.SIGHUP: "because its terminal was closed",
}

# A terminal and a workflow may both ask a process to stop; only a later signal counts as a second
# one.
_SAME_WISH_SECONDS = 1.0
_LONGEST_CLEANING_SECONDS = 60.0
_PARENT_DEATH_SIGNAL = 1  # of prctl, Linux
_WHY = ": out of memory, or a failing disk? The same command resumes from what is there"


class Stopped(BaseException):
    """The process was asked to stop; not an error, so that no error handler catches it.

    Its exit status is the one that shells give to a process ended by the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(_WORDS[signal.Signals(number)])
        self.number, self.exit_status = number, 128 + number

    def leave(self) -> NoReturn:
        """End the process before it has a log, with a message and the exit status."""
        _end(self.number, str(self))


@contextmanager
def stopping() -> Iterator[None]:
    """Raise `Stopped` wherever the process is when asked to stop, so that it cleans up."""
    # A process started by nohup must outlive its terminal.
    heard = [number for number in _WORDS if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, _stop) for number in heard}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _stop(number: int, _frame: FrameType | None) -> NoReturn:
    begun = time.monotonic()

    def hurry(number: int, _frame: FrameType | None) -> None:
        if time.monotonic() - begun > _SAME_WISH_SECONDS:
            _end(number)

    # The scheduler's signal must not interrupt the clean-up after the first; a user who presses
    # Ctrl-C again means it. Files are complete or absent, so nothing is damaged.
    for each in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(each, signal.SIG_IGN)
    signal.signal(signal.SIGINT, hurry)
    # A library interrupted at work may be unable to clean up.
    watch = threading.Timer(_LONGEST_CLEANING_SECONDS, _end, [number])
    watch.daemon = True
    watch.start()
    raise Stopped(number)


def _end(number: int, told: str = "at once, without cleaning up") -> NoReturn:
    with suppress(OSError):
        os.write(2, f"fretwear: stopped: {told}\n".encode())
    os._exit(128 + number)


def watch() -> None:
    """Return in a child process; this one waits, says what that could not, and ends as it did.

    A library that crashes and a kernel that is out of memory leave a process no time for a word.
    """
    if not hasattr(os, "fork") or "--supervise" in sys.argv:  # that has a parent to tell of it
        return
    try:
        child = _fork()
    except OSError:  # no memory for it
        return
    if child == 0:
        return
    status = _exit_status_of(child)
    if status < 0:
        with suppress(OSError):
            os.write(2, f"fretwear: error: {_ending(status)}{_WHY}\n".encode())
    os._exit(status if status >= 0 else 128 - status)


def supervise(case_ids: Collection[str], results: Path) -> None:
    """Return in a child process; this one waits, and starts another child if it is killed.

    The kernel kills what takes too much memory. The case during which a child vanished is
    recorded, so that the next child leaves it to the end: there is another one as long as each
    comes farther than the one before. Then this process ends as the last child did. A fork costs
    neither another start of Python nor another reading of the study, with the cases of these ids
    and a folder of results.
    """
    from fretwear.data.safe import Unfailing
    from fretwear.running.workflow import ENDED, failures

    vanished: set[str] = set()
    while hasattr(os, "fork"):
        for stream in (sys.stdout, sys.stderr):
            Unfailing(stream).flush()
        child = _fork()
        if child == 0:
            return
        status, before = _exit_status_of(child), vanished
        reasons = {case_id: failure.reason for case_id, failure in failures(results).items()}
        vanished = {case_id for case_id in case_ids if reasons.get(case_id) == ENDED}
        if status >= 0:  # the child has already reported
            os._exit(status)
        lost = ", ".join(sorted(vanished - before))
        out = Unfailing(sys.stderr)
        out.write(f"{_ending(status)}{f' during {lost}' if lost else ''}: out of memory?\n")
        if not lost:
            os._exit(128 - status)
        out.write("the other cases run first, then this one is tried again\n")


def _fork() -> int:
    """Fork; the child is asked to stop when this process is killed, and neither when it is new."""
    parent = os.getpid()
    signal.pthread_sigmask(signal.SIG_BLOCK, _WORDS)
    child = os.fork()
    if child == 0:
        if sys.platform == "linux":
            import ctypes

            ctypes.CDLL(None).prctl(_PARENT_DEATH_SIGNAL, signal.SIGTERM, 0, 0, 0)
        if os.getppid() != parent:
            os.kill(os.getpid(), signal.SIGTERM)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _WORDS)
    return child


def _exit_status_of(child: int) -> int:
    """Wait for a child; return its exit status, or the negative number of the signal it died of."""
    try:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _WORDS)
        status = os.waitpid(child, 0)[1]
    except Stopped as stopped:
        # From now on signals are ignored here; the child reports.
        os.kill(child, stopped.number)
        status = os.waitpid(child, 0)[1]
    return os.waitstatus_to_exitcode(status)


def _ending(status: int) -> str:
    return "killed" if status == -signal.SIGKILL else f"crashed ({signal.Signals(-status).name})"
