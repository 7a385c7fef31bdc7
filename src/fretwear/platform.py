"""What not every operating system has: locks of files, names of users, signals, flags of files.

Linux and macOS have all of it. Elsewhere two processes may compute the same case twice, and no
child process watches over another.
"""

from __future__ import annotations

import errno
import os
import signal
import sys
from contextlib import suppress
from typing import TYPE_CHECKING

try:
    import fcntl
    import pwd
except ImportError:  # Windows
    HAS_LOCKS = False
else:
    HAS_LOCKS = True

HAS_FORK = hasattr(os, "fork")
CAN_FLUSH_FOLDERS = HAS_FORK  # which Windows cannot open like files

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor

STOPPING = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""Signals that ask a process to stop: Ctrl-C, a scheduler, a closed terminal."""

PLAINLY = sum(
    getattr(os, name, 0) for name in ("O_CLOEXEC", "O_NOFOLLOW", "O_NONBLOCK", "O_BINARY")
)
"""Flags with which a file is opened without following links or waiting for a pipe."""


_PARENT_DEATH_SIGNAL = 1  # of prctl, Linux


def end_with_parent(parent: int) -> None:
    """Have this process, a child of `parent`, receive SIGTERM when its parent ends."""
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_PARENT_DEATH_SIGNAL, signal.SIGTERM, 0, 0, 0)
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGTERM)


def pool_of(processes: int) -> ProcessPoolExecutor:
    """Return a pool of processes that end with this one, and at Ctrl-C without a traceback."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    return ProcessPoolExecutor(processes, get_context("spawn"), _serve, (os.getpid(),))


def _serve(parent: int) -> None:
    end_with_parent(parent)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def lock_file(descriptor: int) -> None:
    """Lock an open file; an OSError if another process has it, or there are no locks."""
    if not HAS_LOCKS:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def other_user(user: int) -> str:
    """Return the name, or else the number, of a user; empty for the present one."""
    if not HAS_LOCKS or user == os.geteuid():
        return ""
    with suppress(KeyError):
        return pwd.getpwuid(user).pw_name
    return str(user)
