"""Going on with a batch when its process is killed, as the kernel does when memory runs out."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Collection
from pathlib import Path
from typing import NoReturn

from fretwear.cli.signals import Stopped
from fretwear.running.records import ENDED, failures

_PARENT_DEATH_SIGNAL = 1  # of prctl, Linux


def outlive_kills(case_ids: Collection[str], results: Path) -> None:
    """Return in a child process; this one waits, and starts another child if that is killed.

    The case during which a child vanished is recorded, so that the next one leaves it to the end:
    there is another child as long as each comes farther than the one before. Then this process
    ends as the last one did.

    Parameters
    ----------
    case_ids : collection of str
        The cases of the batch.
    results : pathlib.Path
        Folder of the study's results.
    """
    if not hasattr(os, "fork"):
        return
    known: set[str] = set()
    while True:
        sys.stdout.flush()
        sys.stderr.flush()
        child = os.fork()
        if child == 0:
            _stop_with_parent()
            return
        status = _status_of(child)
        vanished = _vanished(case_ids, results)
        if status != -signal.SIGKILL or vanished <= known:
            _leave(status)
        print(
            f"killed during {', '.join(sorted(vanished - known))}: out of memory?\n"
            "the other cases are done first, then it is tried once more",
            file=sys.stderr,
        )
        known = vanished


def _vanished(case_ids: Collection[str], results: Path) -> set[str]:
    return {
        case_id
        for case_id, failure in failures(results).items()
        if case_id in case_ids and failure.reason == ENDED
    }


def _status_of(child: int) -> int:
    """Wait for a child; its exit status, or the negative number of the signal that ended it."""
    try:
        status = os.waitpid(child, 0)[1]
    except Stopped:
        # From now on signals are ignored here, and the child says what there is to say.
        os.kill(child, signal.SIGTERM)
        status = os.waitpid(child, 0)[1]
    return os.waitstatus_to_exitcode(status)


def _leave(status: int) -> NoReturn:
    # Nothing of what the child has said at its end is to be said again.
    os._exit(status if status >= 0 else 128 - status)


def _stop_with_parent() -> None:
    """Have the kernel stop this process when its parent is killed, where it can."""
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_PARENT_DEATH_SIGNAL, signal.SIGTERM, 0, 0, 0)
