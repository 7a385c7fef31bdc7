"""The command line: processes that are asked to stop, are killed or crash, and their messages.

No large library is imported before a command needs it, so that help and plans appear at once.
"""

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

from fretwear.platform import HAS_FORK, STOPPING, end_with_parent

_WORDS = dict(
    zip(STOPPING, ("by Ctrl-C", "by SIGTERM", "because its terminal was closed"), strict=False)
)

# A terminal and a workflow may both ask a process to stop; only a later signal is a second request.
_SAME_WISH_SECONDS = 1.0
_LONGEST_CLEANING_SECONDS = 60.0
_WHY = "out of memory, or a failing disk? The same command resumes from what is there"


class Stopped(BaseException):
    """The process was asked to stop; not an error, so that no error handler catches it.

    Its exit status is the status that shells give to a process ended by the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(_WORDS[signal.Signals(number)])
        self.number, self.exit_status = number, 128 + number


def main(*, watched: bool = True) -> None:
    """Run the command line in a watched process, and exit with its status."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # Libraries count on both.
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115, PTH123
    try:
        # A signal to stop may arrive while the process is still starting.
        with stopping():
            if watched:
                watch()
            from fretwear.cli.program import app

            app()
    except Stopped as stopped:
        _leave(stopped.exit_status, f"stopped: {stopped}")
    except MemoryError:  # before a command could open its log
        _leave(1, "error: there is not enough memory to start")


@contextmanager
def stopping() -> Iterator[None]:
    """Raise `Stopped` wherever a request to stop reaches the process, so that it cleans up."""
    # A process started by nohup must outlive its terminal.
    heard = [number for number in _WORDS if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, _stop) for number in heard}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _stop(number: int, _frame: FrameType | None) -> NoReturn:
    begun, message = time.monotonic(), "stopped: at once, without cleaning up"

    def hurry(number: int, _frame: FrameType | None) -> None:
        if time.monotonic() - begun > _SAME_WISH_SECONDS:
            _leave(128 + number, message)

    # A scheduler's second signal must not interrupt the clean-up; a user's second Ctrl-C may. Files
    # are complete or absent, so none is damaged.
    for ignored in STOPPING[1:]:
        signal.signal(ignored, signal.SIG_IGN)
    signal.signal(signal.SIGINT, hurry)
    # An interrupted library may be unable to clean up.
    lost_patience = threading.Timer(_LONGEST_CLEANING_SECONDS, _leave, [128 + number, message])
    lost_patience.daemon = True
    lost_patience.start()
    raise Stopped(number)


def _leave(status: int, message: str = "") -> NoReturn:
    """End the process at once, with a message if there is no log."""
    if message:
        with suppress(OSError):
            os.write(2, f"fretwear: {message}\n".encode())
    os._exit(status)


def watch() -> None:
    """Return in a child process; the parent waits, reports a crash, and exits as the child did.

    A crashing library, and a kernel that is out of memory, leave a process no time for a message.
    """
    if not HAS_FORK or "--supervise" in sys.argv:  # a supervising parent reports
        return
    try:
        child = _fork()
    except OSError:  # out of memory
        return
    if child:
        status, ending = _end_of(child)
        _leave(status, f"error: {ending}: {_WHY}" if ending else "")


def supervise(case_ids: Collection[str], results: Path) -> None:
    """Return in a child process; the parent waits, and starts another child if one is killed.

    The kernel kills processes that take too much memory. The case during which a child vanished is
    recorded, so that the next child leaves it to the end. Children follow as long as each comes
    farther than the one before; then the parent exits as the last child did.
    """
    from fretwear.data.safe import Unfailing
    from fretwear.run.workflow import ENDED, failures

    vanished: set[str] = set()
    while HAS_FORK:
        for stream in (sys.stdout, sys.stderr):
            Unfailing(stream).flush()
        if not (child := _fork()):
            return
        status, ending = _end_of(child)
        before, reasons = vanished, failures(results)
        vanished = {case_id for case_id in case_ids if reasons.get(case_id) == ENDED}
        if not ending:  # the child has already reported
            _leave(status)
        lost = ", ".join(sorted(vanished - before))
        out = Unfailing(sys.stderr)
        out.write(f"{ending}{f' during {lost}' if lost else ''}: out of memory?\n")
        if not lost:
            _leave(status)
        out.write("the other cases run first, then this one is tried again\n")


def _fork() -> int:
    """Fork with signals blocked; the child is asked to stop if its parent is killed."""
    parent = os.getpid()
    signal.pthread_sigmask(signal.SIG_BLOCK, _WORDS)
    child = os.fork()
    if child == 0:
        end_with_parent(parent)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _WORDS)
    return child


def _end_of(child: int) -> tuple[int, str]:
    """Wait for a child; return its exit status, as in shells, and how a signal ended it if any."""
    try:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _WORDS)
        status = os.waitpid(child, 0)[1]
    except Stopped as stopped:
        # The parent ignores signals from now on; the child reports.
        os.kill(child, stopped.number)
        status = os.waitpid(child, 0)[1]
    code = os.waitstatus_to_exitcode(status)
    if code >= 0:
        return code, ""
    killed = code == -signal.SIGKILL
    return 128 - code, "killed" if killed else f"crashed ({signal.Signals(-code).name})"
