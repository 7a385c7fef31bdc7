"""One writer to a file: locks that end with their processes."""

from __future__ import annotations

import errno
import fcntl
import os
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from fretwear.data.safe import DataFileError, check_own, read_data, write_error

_HELD_BY_ANOTHER = {errno.EWOULDBLOCK, errno.EACCES}
_NO_LOCKS_HERE = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}
_SECONDS_BETWEEN_TRIES = (0.1, 2.0)


class Lock:
    """The lock of a file that this process holds or waits for.

    It is a lock of the operating system on a small file beside the other and ends with its
    process, however that ends, so none is ever stale. Linux passes it on to the server of a
    network file system, so it holds between the nodes of a cluster as well. The small file says
    who has the lock. It is removed with the lock; a lock on a file that has been removed meanwhile
    does not count, so that no two processes hold locks on two files of one name. That is told by
    the name, since a network file system keeps a removed file that is open under another one.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.file = path.with_name(f".{path.name}.lock")
        self.waited = False
        self._descriptor: int | None = None

    def acquire(self, tell: Callable[[str], None]) -> None:
        """Wait until this process has the lock, telling for whom.

        On a file system without locks there is nothing to wait for: this is told, and that two
        processes would do the same work twice. Their files would still not be mixed.
        """
        pause, longest = _SECONDS_BETWEEN_TRIES
        while not self._try(tell):
            if not self.waited:
                tell(f"{self.path}: {self.holder()} is computing this; waiting for it")
            self.waited = True
            time.sleep(pause)
            pause = min(1.5 * pause, longest)

    def ensure(self, tell: Callable[[str], None]) -> None:
        """Make sure that this process still has the lock before it writes.

        A `DataFileError` tells where somebody has removed the lock's file and another process has
        got a lock since.
        """
        if self._descriptor is None or self._is_current(self._descriptor):
            return
        self.release()
        if not self._try(tell):
            raise DataFileError(
                self.path,
                f"not written, because its lock {self.file} was removed from outside and "
                f"{self.holder()} is computing it now",
                "Leave it to that process, or stop it and run the same command again",
            )

    def release(self) -> None:
        """Give the lock back and remove its file."""
        if self._descriptor is None:
            return
        if self._is_current(self._descriptor):
            with suppress(OSError):
                self.file.unlink()
        os.close(self._descriptor)
        self._descriptor = None

    def remove_if_abandoned(self) -> None:
        """Remove the file that a killed process or a power failure has left, if nobody holds it."""
        with suppress(OSError, DataFileError):
            if self.file.exists() and self._try(lambda _: None):
                self.release()

    def holder(self) -> str:
        """Say which process on which machine has the lock."""
        name = ""
        with suppress(OSError):
            name = read_data(self.file, 200).decode("utf-8", errors="replace").strip()
        return name or "another process"

    def _try(self, tell: Callable[[str], None]) -> bool:
        """Try to get the lock; True as well where there are no locks."""
        flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            # Network file systems want the file open for writing.
            descriptor = os.open(self.file, flags, 0o666)
            check_own(descriptor)
        except OSError as cause:
            raise write_error(self.path, cause) from cause
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if self._is_current(descriptor):
                self._descriptor = descriptor
        except OSError as cause:
            if cause.errno in _NO_LOCKS_HERE:
                tell(f"{self.path}: no locks on this file system; let one process compute it")
                return True
            if cause.errno not in _HELD_BY_ANOTHER:
                raise write_error(self.path, cause) from cause
        finally:
            if self._descriptor is None:
                os.close(descriptor)
        if self._descriptor is None:
            return False
        # A full disk must not stop those who can do without the name of the holder.
        with suppress(OSError):
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)
        return True

    def _is_current(self, descriptor: int) -> bool:
        """Tell whether the file that is locked is the one of this name."""
        try:
            return os.path.samestat(os.fstat(descriptor), self.file.stat())
        except OSError:
            return False


@contextmanager
def locked(path: Path, tell: Callable[[str], None]) -> Iterator[Lock]:
    """Hold the lock of a file, after waiting for whoever has it, as a line for people tells.

    The folder is made if necessary; it is a `DataFileError` if the lock's file cannot be written.
    """
    lock = Lock(path)
    lock.acquire(tell)
    try:
        yield lock
    finally:
        lock.release()
