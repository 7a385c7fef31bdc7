"""Files that are complete or absent, links that are never followed, errors that say what to do."""

from __future__ import annotations

import errno
import hashlib
import os
import re
import secrets
import shutil
import signal
import socket
import stat
import tempfile
import threading
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from io import StringIO
from pathlib import Path
from types import FrameType
from typing import Any, BinaryIO, Self, TextIO

_AGAIN = "run the same command again"
_NEARLY_FULL = 1 << 20
_NO_SPACE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_WHY_NOT_WRITTEN = (
    (
        _NO_SPACE,
        "not written, because the disk (or the quota on it) is full",
        f"Free some space or choose another folder, then {_AGAIN}; "
        "what was there before is unchanged",
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

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_OF_MEMORY = re.compile(r"(out of|not enough) memory|alloc", re.IGNORECASE)
_PACKAGE = Path(__file__).parents[1]

# A link is not followed, a pipe is not waited for.
_PLAINLY = os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK


class DataFileError(Exception):
    """A file that cannot be read or written: its path, the problem, the remedy."""

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
    """Several case files that cannot be used, with an error for each."""

    def __init__(self, errors: Sequence[CaseFileError]) -> None:
        super().__init__(*errors[0].args)
        self.errors = tuple(errors)
        # Exceptions are copied by calling their class with `args`.
        self.args = (self.errors,)

    def __str__(self) -> str:
        return "\n".join(str(error) for error in self.errors)


def is_of_netcdf(error: BaseException) -> bool:
    """Return whether the netCDF library raised an error because it cannot use a file."""
    kinds = (RuntimeError, AttributeError, IndexError)
    return isinstance(error, kinds) and bool(re.match(r"NetCDF: |\w+ not found in /", str(error)))


def is_of_memory(error: BaseException | None) -> bool:
    """Say whether memory had run out, also where a library tells of that in its own way."""
    while error is not None:
        if isinstance(error, MemoryError | SystemError) or _OF_MEMORY.search(str(error)):
            return True
        error = error.__cause__ or error.__context__
    return False


def reason_of(error: BaseException) -> str:
    """Say why something failed, and of what should not happen, whom to tell."""
    words = str(error) or type(error).__name__
    if isinstance(error, DataFileError) or (isinstance(error, MemoryError) and str(error)):
        return words
    if is_of_memory(error):
        return f"there is not enough memory ({words})"
    if is_of_netcdf(error):
        return f"a file cannot be read or written, as if memory had run out ({words})"
    return words


def unexpected(error: Exception) -> str:
    """Say of what never should happen whether a library failed, or fretwear itself."""
    cause = f"{type(error).__name__}: {error}".rstrip(": ")
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    if not frames or Path(frames[-1].f_code.co_filename).is_relative_to(_PACKAGE):
        return f"this is a defect of fretwear, please report it: {cause}"
    return (
        f"a library failed ({cause}). If memory or the disk was short, {_AGAIN}; otherwise "
        "please report this"
    )


def write_error(path: Path, cause: OSError | RuntimeError) -> DataFileError:
    """Return an error that says why a file could not be written and what to do.

    The netCDF library raises a RuntimeError without a number when a disk is full, so the free
    space of the folder counts too.
    """
    number = cause.errno if isinstance(cause, OSError) else None
    with suppress(OSError):
        usage = shutil.disk_usage(path.parent)
        if usage.total > 0 and usage.free < _NEARLY_FULL:
            number = errno.ENOSPC
    for numbers, problem, remedy in _WHY_NOT_WRITTEN:
        if number in numbers:
            return DataFileError(path, problem.format(folder=path.parent), remedy)
    remedy = f"Check the free space, the quota and the disk of the folder, then {_AGAIN}"
    return DataFileError(path, f"not written: {cause}", remedy)


def why_not_writable(path: Path) -> str:
    """Return why a folder can be neither written to nor created; empty if it can.

    Nothing is left behind: instead of a missing folder, its nearest parent is tested.
    """
    if "\\" in str(path.absolute()):
        place = path.absolute()
        return f"{place}: cannot be written to: the netCDF library knows no path with a backslash"
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
        # Permissions, read-only disks and quotas share one test: whether a file can be created.
        with tempfile.TemporaryFile(dir=existing):
            return ""
    except OSError as error:
        reason = os.strerror(error.errno or 0)
        return f"{path}: cannot be written to: {reason}; choose another place"


def why_leading_out(folder: Path, root: Path | None = None) -> str:
    """Return why results might be written somewhere else than it seems; empty if they would not.

    The folder of all results may be a link, to a larger disk for example: that is a choice for all
    studies. A link in place of one study, or inside it, could come from anyone, and Snakemake and
    its shells would write through it. `root` is None if the user has named the folder.
    """
    if root is not None and not folder.resolve().is_relative_to(root.resolve()):
        return (
            f"{folder}: is a link that leads out of {root}, to {folder.resolve()}; remove it, "
            f"make {root} itself the link, or name the folder by --results"
        )
    for link in _links(folder):
        return (
            f"{link}: is a link that leads to {link.readlink()}; remove it: the results of a study "
            "hold no links, lest something else be overwritten"
        )
    return ""


def _links(folder: Path) -> Iterator[Path]:
    try:
        with os.scandir(folder) as entries:
            found = sorted(entries, key=lambda entry: entry.name)
    except OSError:
        return
    for entry in found:
        if entry.is_symlink():
            yield Path(entry)
        elif entry.is_dir(follow_symlinks=False):
            yield from _links(Path(entry))


def open_data(path: Path) -> BinaryIO:
    """Open a file of a results folder for reading; OSError if it is not a regular file."""
    stream = os.fdopen(os.open(path, os.O_RDONLY | _PLAINLY), "rb")
    if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
        stream.close()
        raise OSError(errno.EINVAL, "is not a regular file", str(path))
    return stream


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
    """Open an emptied log for appending; anything else of its name is replaced.

    A left-over process may still write to it, so a log is emptied rather than replaced.
    """
    stream = None
    flags = os.O_WRONLY | os.O_APPEND | _PLAINLY
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            descriptor = os.open(path, flags)
            check_own(descriptor)
            os.ftruncate(descriptor, 0)
        except OSError:
            path.unlink(missing_ok=True)
            descriptor = os.open(path, flags | os.O_CREAT | os.O_EXCL, 0o666)
        stream = os.fdopen(descriptor, "a", 1, encoding="utf-8", errors="backslashreplace")
    return Unfailing(stream)


def check_own(descriptor: int) -> None:
    """Refuse and close what is not a regular file, or has hard links."""
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode) or status.st_nlink > 1:
        os.close(descriptor)
        raise OSError(errno.EMLINK, "has another name elsewhere, or is not a regular file")


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Yield a temporary name in the same folder; the file gets its own name on a clean exit.

    The temporary name is unique, so two processes that write the same file never mix. File and
    folder are flushed to the disk before and after the renaming. On any error in the ``with``
    block, interrupts included, the temporary file is removed and an existing file stays unchanged.
    Only a killed process leaves its temporary file, which the next one that writes the same file
    removes. The folder is created if necessary. `DataFileError` if it cannot be created or written
    to, or the disk is full.
    """
    temporary = path.with_name(f".{path.name}.{_host()}.{os.getpid()}.{secrets.token_hex(4)}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        remove_stale_temporaries(path.parent, path.name)
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


def remove_stale_temporaries(folder: Path, of: str | None = None) -> list[Path]:
    """Remove temporary files that killed processes have left: of one file in a folder, or of all.

    A temporary file of this machine is stale when its process is gone; one of another machine or
    container (a shared folder) when nothing has been written to it for a week.
    """
    import psutil

    name = ".+" if of is None else re.escape(of)
    temporary = re.compile(rf"\.{name}\.([^.]+)\.(\d{{1,9}})\.[0-9a-f]{{8}}\.tmp")
    removed = []
    for candidate in folder.iterdir():
        found = temporary.fullmatch(candidate.name)
        if found is None:
            continue
        if found[1] == _host():
            is_stale = not psutil.pid_exists(int(found[2]))
        else:
            try:
                is_stale = time.time() - candidate.lstat().st_mtime > _FOREIGN_LIFETIME
            except OSError:
                continue
        if is_stale:
            _remove(candidate)
            removed.append(candidate)
    return removed


@cache
def _host() -> str:
    """Name of the machine, and of the space in which its processes have their numbers.

    Containers may share a host name, and then a process of one seems gone to the other.
    """
    space = ""
    with suppress(OSError):
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii")
        space = boot + os.readlink("/proc/self/ns/pid")  # noqa: PTH115
    name = re.sub(r"[^A-Za-z0-9-]", "-", socket.gethostname())[:32] or "host"
    return f"{name}-{hashlib.sha256(space.encode()).hexdigest()[:8]}"


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
        descriptor = os.open(path, os.O_WRONLY | _PLAINLY)
        check_own(descriptor)
        os.ftruncate(descriptor, 0)
        os.close(descriptor)
    with suppress(OSError):
        path.unlink()


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Defer Ctrl-C, SIGTERM and SIGHUP until the ``with`` block ends.

    Python raises the exception of a signal handler wherever the process is. Inside a library that
    holds a lock, as xarray does around the netCDF library, that leaves the lock taken, and closing
    the file then waits for it for ever. Only the main thread receives signals; in others there is
    nothing to defer.
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
