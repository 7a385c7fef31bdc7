"""Files that are complete or absent, with one writer each, without links, with helpful errors."""

from __future__ import annotations

import errno
import hashlib
import os
import re
import signal
import socket
import stat
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any, BinaryIO, Self, TextIO

from fretwear.data.atomic import (  # noqa: F401 - some are for others
    DataFileError,
    _write_error,
    atomic_path,
    why_not_writable,
    write_text,
)
from fretwear.platform import PLAINLY, STOPPING, lock_file, other_user

_AGAIN = "run the same command again"
_NO_CHECKSUM = "unfinished, cut short or changed by another program"
_MARK = b"\nfretwear crc32 "
_LENGTH = len(_MARK) + 8 + 1
_BLOCK_BYTES = 1 << 20
_NEARLY_FULL = 1 << 20
_NO_SPACE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_NO_RIGHT = {errno.EACCES, errno.EPERM, errno.EROFS}
_NO_FOLDER = {errno.ENOENT, errno.ENOTDIR, errno.EEXIST}
_FOREIGN_LIFETIME = 7 * 24 * 3600.0
_OF_MEMORY = re.compile(r"(out of|not enough) memory|alloc", re.IGNORECASE)
_HELD_BY_ANOTHER = {errno.EWOULDBLOCK, errno.EACCES}
_NO_LOCKS_HERE = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}
_SECONDS_BETWEEN_TRIES = (0.1, 2.0)


def add_checksum(path: Path) -> None:
    """Append the checksum to a file, which must not be changed afterwards."""
    with path.open("r+b") as stream:
        checksum = _checksum(stream, path.stat().st_size)
        stream.seek(0, os.SEEK_END)
        stream.write(_checksum_line(checksum))


def damage(path: Path, kind: str) -> str:
    """Return the problem of a file that should end with its checksum; empty if it is intact."""
    if not path.is_file():
        return "it is not a file" if path.exists() else "there is no such file"
    try:
        with path.open("rb") as stream:
            content = path.stat().st_size - _LENGTH
            stream.seek(max(content, 0))
            last_line = stream.read()
            if not last_line.startswith(_MARK):
                return f"it is not a complete {kind}: {_NO_CHECKSUM}"
            stream.seek(0)
            is_whole = last_line == _checksum_line(_checksum(stream, content))
    except OSError as cause:
        return f"it cannot be read ({cause.strerror or cause})"
    return "" if is_whole else "it is damaged: its checksum does not match"


def _checksum(stream: BinaryIO, content: int) -> int:
    checksum = 0
    while content > 0 and (block := stream.read(min(content, _BLOCK_BYTES))):
        checksum = zlib.crc32(block, checksum)
        content -= len(block)
    return checksum


def _checksum_line(checksum: int) -> bytes:
    return _MARK + f"{checksum:08x}\n".encode()


def is_of_netcdf(error: BaseException) -> bool:
    """Return whether an error of the netCDF library means that it cannot use a file."""
    kinds = (RuntimeError, AttributeError, IndexError)
    return isinstance(error, kinds) and bool(re.match(r"NetCDF: |\w+ not found in /", str(error)))


def is_of_memory(error: BaseException | None) -> bool:
    """Return whether memory ran out, as reported by Python or by a library in its own words."""
    while error is not None:
        if isinstance(error, MemoryError | SystemError) or _OF_MEMORY.search(str(error)):
            return True
        error = error.__cause__ or error.__context__
    return False


def why_leading_out(folder: Path, root: Path | None = None) -> str:
    """Return why results might end up outside their folder; empty if they cannot.

    The folder of all results may be a link, which its owner chose for all studies. A link in place
    of one study, or inside it, could come from anyone, and Snakemake and its shells would write
    through it. `root` is None if the user named the folder.
    """
    if root is not None and not folder.resolve().is_relative_to(root.resolve()):
        return (
            f"{folder}: is a link that leads out of {root}, to {folder.resolve()}; remove it, "
            f"make {root} itself the link, or name the folder by --results"
        )
    for place, folders, files in os.walk(folder):
        for link in (Path(place, name) for name in sorted([*folders, *files])):
            if link.is_symlink():
                return (
                    f"{link}: is a link that leads to {link.readlink()}; remove it: the results of "
                    "a study hold no links, which could make a run overwrite other files"
                )
    return ""


def _open_plainly(path: Path, flags: int) -> int:
    """Open a regular file; one to be written must have a single name.

    Links are not followed, and opening a pipe does not wait.
    """
    descriptor = os.open(path, flags | PLAINLY, 0o666)
    status, is_written = os.fstat(descriptor), flags & (os.O_WRONLY | os.O_RDWR)
    if not stat.S_ISREG(status.st_mode) or (is_written and status.st_nlink > 1):
        os.close(descriptor)
        raise OSError(errno.EINVAL, "is not a regular file of one name", str(path))
    return descriptor


def open_data(path: Path) -> BinaryIO:
    """Open a file of a results folder for reading; OSError if it is not a regular file."""
    return os.fdopen(_open_plainly(path, os.O_RDONLY), "rb")


def read_data(path: Path, most: int) -> bytes:
    """Read a small file of a results folder; OSError if it is larger or not a regular file."""
    with open_data(path) as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        raise OSError(errno.EFBIG, f"is larger than {most} bytes", str(path))
    return content


class Unfailing:
    """A text stream (or None) that ignores failures such as a full disk or a closed pipe."""

    def __init__(self, stream: TextIO | Unfailing | None) -> None:
        self._stream: Any = StringIO() if stream is None else stream

    def write(self, text: str) -> int:
        """Write a text if possible."""
        with suppress(OSError, ValueError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Flush the buffer if possible."""
        with suppress(OSError, ValueError):
            self._stream.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        with suppress(OSError):
            self._stream.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def open_log(path: Path) -> Unfailing:
    """Open a log for appending after emptying it; anything but a regular file is replaced.

    The log is emptied rather than replaced, because a left-over process may still write to it.
    """
    stream, flags = None, os.O_WRONLY | os.O_APPEND
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            descriptor = _open_plainly(path, flags)
            os.ftruncate(descriptor, 0)
        except OSError:
            path.unlink(missing_ok=True)
            descriptor = _open_plainly(path, flags | os.O_CREAT | os.O_EXCL)
        stream = os.fdopen(descriptor, "a", 1, encoding="utf-8", errors="backslashreplace")
    return Unfailing(stream)


def remove_stale_temporaries(folder: Path, of: str | None = None) -> list[Path]:
    """Remove the temporary files that killed processes left in a folder, of one file or of all.

    A temporary file of this machine is stale if its process is gone; one of another machine or
    container, in a shared folder, if it has not been written to for a week.
    """
    import psutil

    name = ".+" if of is None else re.escape(of)
    temporary = re.compile(rf"\.{name}\.([^.]+)\.(\d{{1,9}})\.[0-9a-f]{{8}}\.tmp")
    removed = []
    for candidate in folder.iterdir():
        match = temporary.fullmatch(candidate.name)
        if match is None:
            continue
        is_stale = match[1] == _host() and not psutil.pid_exists(int(match[2]))
        if match[1] != _host():
            with suppress(OSError):
                is_stale = time.time() - candidate.lstat().st_mtime > _FOREIGN_LIFETIME
        if is_stale:
            _remove(candidate)
            removed.append(candidate)
    return removed


@cache
def _host() -> str:
    """Name of the machine and of its process namespace.

    Containers may share a host name, and a process of one would seem gone to the other.
    """
    space = ""
    with suppress(OSError):
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii")
        space = boot + os.readlink("/proc/self/ns/pid")  # noqa: PTH115
    name = re.sub(r"[^A-Za-z0-9-]", "-", socket.gethostname())[:32] or "host"
    return f"{name}-{hashlib.sha256(space.encode()).hexdigest()[:8]}"


def _remove(path: Path) -> None:
    # After a failure HDF5 keeps the file open until the process ends, which would hold its space
    # if the file were removed without being emptied.
    with suppress(OSError):
        descriptor = _open_plainly(path, os.O_WRONLY)
        os.ftruncate(descriptor, 0)
        os.close(descriptor)
    with suppress(OSError):
        path.unlink()


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Defer Ctrl-C, SIGTERM and SIGHUP until the ``with`` block ends.

    An exception raised while a library holds a lock, as xarray does around the netCDF library,
    leaves the lock taken, and closing the file waits for it forever. Only the main thread receives
    signals.
    """
    received: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()
    # A handler of None was not set by Python and could not be restored.
    before = {n: handler for n in STOPPING if is_main and (handler := signal.getsignal(n))}
    for number in before:
        signal.signal(number, lambda number, _: received.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if received:
            signal.raise_signal(received[0])


class Lock:
    """The lock of a file, which this process holds within a ``with`` statement.

    The operating system locks a small file beside the other, which names the holder. The lock ends
    with its process, however that ends, and holds between the nodes of a cluster, since Linux
    passes it on to the server of a network file system. The small file is removed with the lock. A
    lock on a file that was removed meanwhile does not count, so that no two processes hold locks on
    two files of one name.

    `tell` takes a line for people: for whom this process waits, or that a file system has no locks.
    Without locks two processes may do the same work twice, but their files never mix.
    """

    def __init__(self, path: Path, tell: Callable[[str], None] = lambda _: None) -> None:
        self.path, self._tell = path, tell
        self.file = path.with_name(f".{path.name}.lock")
        self.waited = False
        self._descriptor: int | None = None

    def acquire(self) -> Self:
        """Wait until this process has the lock."""
        pause, longest = _SECONDS_BETWEEN_TRIES
        while not self._try():
            if not self.waited:
                self._tell(f"{self.path}: {self.holder()} is computing this; waiting for it")
            self.waited = True
            time.sleep(pause)
            pause = min(1.5 * pause, longest)
        return self

    def ensure(self) -> None:
        """Raise `DataFileError` if the lock's file was removed and another process has a lock."""
        if self._descriptor is None or self._is_current(self._descriptor):
            return
        self.release()
        if not self._try():
            raise DataFileError(
                self.path,
                f"not written, because its lock {self.file} was removed from outside and "
                f"{self.holder()} is computing it now",
                f"Leave it to that process, or stop it and {_AGAIN}",
            )

    def release(self, *_: object) -> None:
        """Release the lock and remove its file."""
        if self._descriptor is None:
            return
        if self._is_current(self._descriptor):
            with suppress(OSError):
                self.file.unlink()
        os.close(self._descriptor)
        self._descriptor = None

    __enter__, __exit__ = acquire, release

    def remove_if_abandoned(self) -> None:
        """Remove a file left by a killed process or a power failure, if no process holds it."""
        with suppress(OSError, DataFileError):
            if self.file.exists() and self._try():
                self.release()

    def holder(self) -> str:
        """Return the process and the machine that have the lock, in words."""
        name = b""
        with suppress(OSError):
            name = read_data(self.file, 200)
        return (name.decode(errors="replace").strip() or "another process") + self._owner()

    def _try(self) -> bool:
        """Try to get the lock; True also if the file system has no locks."""
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            # Network file systems want the file open for writing.
            descriptor = _open_plainly(self.file, os.O_RDWR | os.O_CREAT)
            is_ours = True
        except PermissionError as cause:
            descriptor, is_ours = self._opened_of_another(cause), False
        except OSError as cause:
            raise _write_error(self.path, cause) from cause
        try:
            lock_file(descriptor)
        except OSError as cause:
            os.close(descriptor)
            if cause.errno in _NO_LOCKS_HERE:
                self._tell(f"{self.path}: no locks on this file system; let one process compute it")
                return True
            if cause.errno in _HELD_BY_ANOTHER:
                return False
            raise _write_error(self.path, cause) from cause
        if not self._is_current(descriptor):
            os.close(descriptor)
            return False
        if not is_ours:  # its holder has died; a new file can name this process
            with suppress(OSError):
                self.file.unlink()
                os.close(descriptor)
                return self._try()
        self._descriptor = descriptor
        # A full disk need not stop the run: the name of the holder is a convenience.
        with suppress(OSError):
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)
        return True

    def _opened_of_another(self, cause: OSError) -> int:
        """Open the lock of another user, who alone may write to it."""
        with suppress(OSError):
            return _open_plainly(self.file, os.O_RDONLY)
        if not os.path.lexists(self.file):
            raise _write_error(self.path, cause) from cause
        raise DataFileError(
            self.path,
            f"not written, because its lock {self.file}{self._owner()} may not be opened",
            "Ask its owner whether a process computes this case; if none does, remove the lock",
        ) from cause

    def _owner(self) -> str:
        """Return the user whose lock this is, in words; empty if it is of this process's user."""
        with suppress(OSError):
            if user := other_user(self.file.stat().st_uid):
                return f" of user {user}"
        return ""

    def _is_current(self, descriptor: int) -> bool:
        """Whether the locked file still has the lock's name."""
        try:
            return os.path.samestat(os.fstat(descriptor), self.file.stat())
        except OSError:
            return False
