"""Files that are whole or not there, one writer to a file, and errors that say what to do."""

from __future__ import annotations

import errno
import fcntl
import os
import re
import secrets
import shutil
import signal
import socket
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType

_AGAIN = "then run the same command again"
_NEARLY_FULL = 1 << 20
_NO_SPACE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_WHY_NOT_WRITTEN = (
    (
        _NO_SPACE,
        "not written, because the disk (or the quota on it) is full",
        f"Free some space or choose another folder, {_AGAIN}; what was there before is unchanged",
    ),
    (
        {errno.EACCES, errno.EPERM, errno.EROFS},
        "not written, because the folder {folder} may not be written to",
        "Choose another folder or ask for the right to write there",
    ),
    (
        {errno.ENOENT, errno.ENOTDIR, errno.EEXIST},
        "not written, because {folder} is not a folder and cannot be made one",
        "Choose another folder",
    ),
)

_FOREIGN_LIFETIME = 7 * 24 * 3600.0

_SIGNALS = (signal.SIGINT, signal.SIGTERM)

_HELD_BY_ANOTHER = {errno.EWOULDBLOCK, errno.EACCES}
_NO_LOCKS_HERE = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}
_SECONDS_BETWEEN_TRIES = (0.1, 2.0)


class DataFileError(Exception):
    """A file that cannot be read or written as a whole.

    Attributes
    ----------
    path : pathlib.Path
        The file.
    problem : str
        What is wrong with it.
    remedy : str
        What to do.
    """

    def __init__(self, path: Path, problem: str, remedy: str) -> None:
        super().__init__(path, problem, remedy)
        self.path = path
        self.problem = problem
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{self.path}: {self.problem}. {self.remedy}"


class CaseFileError(DataFileError):
    """A case file that is missing, unfinished, damaged or of another case."""


class CaseFilesError(CaseFileError):
    """Several case files that cannot be used, each with what is wrong and what to do.

    Attributes
    ----------
    errors : tuple of CaseFileError
        One for each file; `path`, `problem` and `remedy` are those of the first.
    """

    def __init__(self, errors: Sequence[CaseFileError]) -> None:
        super().__init__(*errors[0].args)
        self.errors = tuple(errors)
        # Exceptions are copied by calling their class with `args`.
        self.args = (self.errors,)

    def __str__(self) -> str:
        return "\n".join(str(error) for error in self.errors)


def write_error(path: Path, cause: OSError | RuntimeError) -> DataFileError:
    """Say why a file could not be written and what to do.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    cause : OSError or RuntimeError
        What was raised; the netCDF library raises a RuntimeError without a number when a disk is
        full, so the free space of the folder counts too.

    Returns
    -------
    DataFileError
        To be raised from `cause`.
    """
    number = cause.errno if isinstance(cause, OSError) else None
    with suppress(OSError):
        usage = shutil.disk_usage(path.parent)
        if usage.total > 0 and usage.free < _NEARLY_FULL:
            number = errno.ENOSPC
    for numbers, problem, remedy in _WHY_NOT_WRITTEN:
        if number in numbers:
            return DataFileError(path, problem.format(folder=path.parent), remedy)
    remedy = f"Check the free space, the quota and the disk of the folder, {_AGAIN}"
    return DataFileError(path, f"not written: {cause}", remedy)


def why_not_writable(path: Path) -> str:
    """Say why a folder can neither be written to nor be made; empty where it can.

    Nothing is left behind: a folder that does not exist is not made, its nearest parent is tried.
    """
    existing = Path("/")
    # A path below a file counts as missing, and so does one whose folder may not be entered.
    for candidate in (path, *path.absolute().parents):
        with suppress(OSError):
            candidate.lstat()
            existing = candidate
            break
    if not existing.is_dir():
        return f"{path}: cannot be written to, because {existing} is not a folder"
    try:
        # Rights, read-only disks and quotas have one test in common: a file can be made or not.
        with tempfile.TemporaryFile(dir=existing):
            return ""
    except OSError as error:
        reason = os.strerror(error.errno or 0)
        return f"{path}: cannot be written to: {reason}; choose another place"


def why_leading_out(folder: Path) -> str:
    """Say why results would be written outside of the folder of all results; empty if they stay.

    The folder of all results may be a link, to a larger disk for example: that is a choice for all
    studies. A link in the place of one study, or of a folder in it, could come from anywhere.

    Parameters
    ----------
    folder
        Folder of one study's results, in the folder of all results.
    """
    root = folder.parent.resolve()
    links: list[Path] = []
    with suppress(OSError):
        links = sorted(Path(entry) for entry in os.scandir(folder) if entry.is_symlink())
    for each in (folder, *links):
        target = each.resolve()
        if not target.is_relative_to(root):
            return (
                f"{each}: is a link that leads out of {folder.parent}, to {target}; remove it, "
                f"make {folder.parent} itself the link, or name the folder by --results"
            )
    return ""


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Give a temporary name in the same folder; the file gets its own name on a clean exit.

    The temporary name is unique, so two processes that write the same file never mix. File and
    folder are flushed to the disk before and after the renaming. Whatever goes wrong in the
    ``with`` block, an interrupt included, the temporary file is removed and a file that was there
    before stays as it was. Only a process that is killed outright leaves its temporary file; the
    next one that writes the same file removes it.

    Parameters
    ----------
    path : pathlib.Path
        The file to write; its folder is made if need be.

    Yields
    ------
    pathlib.Path
        Where to write: an empty file.

    Raises
    ------
    DataFileError
        When the folder cannot be made or written to or the disk is full.
    """
    temporary = path.with_name(f".{path.name}.{_host()}.{os.getpid()}.{secrets.token_hex(4)}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        remove_stale_temporaries(path)
        # The netCDF library calls every failure to make a file a lack of permission.
        temporary.touch(exist_ok=False)
    except OSError as cause:
        raise write_error(path, cause) from cause
    try:
        yield temporary
        _flush(temporary)
        temporary.replace(path)
        _flush(path.parent)
    except (OSError, RuntimeError) as cause:
        # Removing the file gives the space back that says whether the disk was full.
        error = write_error(path, cause)
        _remove(temporary)
        raise error from cause
    except BaseException:
        _remove(temporary)
        raise


def write_text(path: Path, text: str) -> None:
    """Write a text file (UTF-8, line ends as given) as `atomic_path` does."""
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")


def remove_stale_temporaries(path: Path) -> list[Path]:
    """Remove what killed processes have left of a file.

    A temporary file of this machine is stale when its process is gone; one of another machine
    (a shared folder) when nothing has been written to it for a week.

    Parameters
    ----------
    path : pathlib.Path
        The file under its final name.

    Returns
    -------
    list of pathlib.Path
        The temporary files that were removed.
    """
    temporary = re.compile(rf"\.{re.escape(path.name)}\.([^.]+)\.(\d+)\.[0-9a-f]{{8}}\.tmp")
    removed = []
    for candidate in path.parent.iterdir():
        name = temporary.fullmatch(candidate.name)
        if name is None:
            continue
        if name[1] == _host():
            is_stale = not _is_alive(int(name[2]))
        else:
            try:
                is_stale = time.time() - candidate.stat().st_mtime > _FOREIGN_LIFETIME
            except OSError:
                continue
        if is_stale:
            _remove(candidate)
            removed.append(candidate)
    return removed


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _host() -> str:
    return re.sub(r"[^A-Za-z0-9-]", "-", socket.gethostname())[:32] or "host"


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _remove(path: Path) -> None:
    # After a failure HDF5 keeps the file open until the process ends, which would hold the space
    # of a file that is removed but not emptied.
    with suppress(OSError):
        os.truncate(path, 0)
    with suppress(OSError):
        path.unlink()


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Put off Ctrl-C and SIGTERM until the ``with`` block is left; then they do what they do.

    Python raises what a signal handler raises wherever the process is. Inside a library that
    holds a lock, as xarray does around the netCDF library, that leaves the lock taken, and closing
    the file then waits for it for ever. Only the main thread receives signals: in another one
    there is nothing to put off.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        del frame
        received.append(number)

    # None stands for a handler that is not Python's and could not be put back.
    before = {number: handler for number in _SIGNALS if (handler := signal.getsignal(number))}
    for number in before:
        signal.signal(number, note)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if received:
            signal.raise_signal(received[0])


class Lock:
    """The lock of a file that this process holds or waits for.

    It is a lock of the operating system on a small file beside the other and ends with its
    process, however that ends, so none is ever stale. Linux passes it on to the server of a
    network file system, so it holds between the nodes of a cluster as well. The small file says
    who has the lock. It is removed with the lock; a lock on a file that has been removed meanwhile
    does not count, so that no two processes hold locks on two files of one name. That is told by
    the name, since a network file system keeps a removed file that is open under another one.

    Parameters
    ----------
    path
        The file that only one process is to write.

    Attributes
    ----------
    file : pathlib.Path
        The small file that is locked.
    waited : bool
        Whether another process had the lock before.
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

        Raises
        ------
        DataFileError
            When somebody has removed the lock's file and another process has got a lock since.
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

    def holder(self) -> str:
        """Say which process on which machine has the lock."""
        name = ""
        with suppress(OSError):
            name = self.file.read_text(encoding="utf-8", errors="replace")[:200].strip()
        return name or "another process"

    def _try(self, tell: Callable[[str], None]) -> bool:
        """Try to get the lock; True as well where there are no locks."""
        flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            # Network file systems want the file open for writing.
            descriptor = os.open(self.file, flags, 0o666)
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
    """Hold the lock of a file, after waiting for whoever has it.

    Parameters
    ----------
    path : pathlib.Path
        The file that only one process is to write; its folder is made if need be.
    tell : callable
        Takes a line for people: who has the lock.

    Raises
    ------
    DataFileError
        When the lock's file cannot be made.
    """
    lock = Lock(path)
    lock.acquire(tell)
    try:
        yield lock
    finally:
        lock.release()
