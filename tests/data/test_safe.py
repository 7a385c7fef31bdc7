"""Files that are whole or not there, locks held by real processes, and what is said of trouble."""

import copy
import errno
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from fretwear.data.safe import (
    CaseFileError,
    CaseFilesError,
    DataFileError,
    Lock,
    atomic_path,
    locked,
    remove_stale_temporaries,
    uninterrupted,
    write_error,
    write_text,
)


def python(code: str, *arguments: object) -> subprocess.Popen[str]:
    """Start a process with pipes; what it prints comes at once."""
    command = [sys.executable, "-u", "-c", code, *map(str, arguments)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def test_an_error_names_the_file_the_problem_and_the_remedy_and_can_be_copied():
    errors = [CaseFileError(Path(name), "it is damaged", "Run it") for name in ("a.nc", "b.nc")]
    both = CaseFilesError(errors)
    assert str(errors[0]) == "a.nc: it is damaged. Run it"
    assert str(both) == "a.nc: it is damaged. Run it\nb.nc: it is damaged. Run it"
    assert both.path == Path("a.nc")
    for error in (errors[0], both):
        assert str(copy.copy(error)) == str(error)
        assert type(copy.copy(error)) is type(error)


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOSPC, "the disk (or the quota on it) is full"),
        (errno.EDQUOT, "the disk (or the quota on it) is full"),
        (errno.EROFS, "may not be written to"),
        (errno.EACCES, "may not be written to"),
        (errno.ENOTDIR, "is not a folder"),
        (errno.EIO, "Check the free space, the quota and the disk"),
    ],
)
def test_why_a_file_was_not_written_is_said_in_words(tmp_path, number, words):
    error = write_error(tmp_path / "a.nc", OSError(number, "text of the system"))
    assert str(error).startswith(f"{tmp_path / 'a.nc'}: not written")
    assert words in str(error)


def test_the_name_appears_on_a_clean_exit_only(tmp_path):
    target = tmp_path / "new" / "folder" / "a.txt"
    with atomic_path(target) as temporary:
        assert temporary.parent == target.parent
        assert not target.exists()
    write_text(target, "load,µ\r\n1,2\n")
    assert target.read_bytes() == "load,µ\r\n1,2\n".encode()
    assert list(target.parent.iterdir()) == [target]


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt, SystemExit])
def test_a_failure_leaves_the_old_file_and_no_temporary(tmp_path, failure):
    target = tmp_path / "a.txt"
    target.write_text("old")

    def write_half() -> None:
        with atomic_path(target) as temporary:
            temporary.write_text("half")
            raise failure

    with pytest.raises(failure):
        write_half()
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_two_writers_of_one_file_do_not_mix(tmp_path):
    target = tmp_path / "a.txt"
    with atomic_path(target) as first, atomic_path(target) as second:
        assert first != second
        first.write_text("first" * 1000)
        second.write_text("second")
    assert target.read_text() == "first" * 1000
    assert list(tmp_path.iterdir()) == [target]


def test_a_file_in_the_place_of_the_folder_is_named(tmp_path):
    (tmp_path / "results").write_text("")
    target = tmp_path / "results" / "a.txt"
    with pytest.raises(DataFileError, match="is not a folder") as error:
        write_text(target, "")
    assert str(error.value).startswith(str(target))


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs /proc")
def test_a_folder_that_takes_no_files_is_named():
    with pytest.raises(DataFileError, match=r"/proc/fretwear.txt: not written"):
        write_text(Path("/proc/fretwear.txt"), "")


WRITER = """
import sys
from pathlib import Path
from fretwear.data.safe import atomic_path
with atomic_path(Path(sys.argv[1])) as temporary:
    temporary.write_text("half")
    print("writing")
    sys.stdin.readline()
"""


def test_what_a_killed_writer_left_is_removed_by_the_next(tmp_path):
    target = tmp_path / "a.txt"
    with python(WRITER, target) as writer:
        assert writer.stdout.readline() == "writing\n"
        (left,) = tmp_path.iterdir()
        assert remove_stale_temporaries(target) == [], "the writer is still alive"
        writer.send_signal(signal.SIGKILL)
    assert not target.exists()
    write_text(target, "whole")
    assert list(tmp_path.iterdir()) == [target]
    assert not left.exists()


def test_a_temporary_of_another_machine_is_left_for_a_week_and_that_of_another_file_alone(tmp_path):
    target = tmp_path / "a.txt"
    foreign = tmp_path / ".a.txt.other-machine.1.0123abcd.tmp"
    other = tmp_path / ".b.a.txt.other-machine.1.0123abcd.tmp"
    eight_days_ago = time.time() - 8 * 24 * 3600
    foreign.write_text("half")
    assert remove_stale_temporaries(target) == []
    other.write_text("half")
    for file in (foreign, other):
        os.utime(file, (eight_days_ago, eight_days_ago))
    assert remove_stale_temporaries(target) == [foreign]
    assert remove_stale_temporaries(tmp_path / "b.a.txt") == [other]


HOLDER = """
import sys
from pathlib import Path
from fretwear.data.safe import locked
with locked(Path(sys.argv[1]), print):
    print("held")
    sys.stdin.readline()
"""
COUNTER = """
import sys
from pathlib import Path
from fretwear.data.safe import locked
path = Path(sys.argv[1])
for _ in range(30):
    with locked(path, lambda line: None):
        number = int(path.read_text())
        # Two inside at once would lose a count here.
        path.write_text("")
        path.write_text(str(number + 1))
"""


@pytest.fixture
def path(tmp_path):
    return tmp_path / "cases" / "a.nc"


@pytest.fixture
def holder(path):
    """Another process that holds the lock until a line is sent to it."""
    with python(HOLDER, path) as process:
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def quiet(line):
    raise AssertionError(line)


def test_a_lock_without_rivals_leaves_nothing_behind(path):
    with locked(path, quiet) as lock:
        assert not lock.waited
        assert lock.file.exists()
        lock.ensure(quiet)
    assert list(path.parent.iterdir()) == []


def test_who_waits_is_told_for_which_process_on_which_machine(path, holder):
    told = []

    def tell(line):
        told.append(line)
        holder.communicate("go\n")

    host = os.uname().nodename
    with locked(path, tell) as lock:
        assert lock.waited
        assert lock.holder() == f"process {os.getpid()} on {host}"
    assert told == [f"{path}: process {holder.pid} on {host} is computing this; waiting for it"]


def test_a_lock_dies_with_its_process_however_that_dies(path, holder):
    rival = Lock(path)
    assert not rival._try(quiet)
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert rival.file.exists(), "nobody was there to remove it"
    rival.acquire(quiet)
    assert not rival.waited
    rival.release()


def test_a_lock_whose_file_was_removed_is_not_held_beside_another(path, holder):
    with locked(path.with_name("b.nc"), quiet) as lock:
        lock.file.unlink()
        lock.ensure(quiet)
        assert lock.file.exists(), "nobody has come, so it is taken again"
    mine = Lock(path)
    # A lock got on the file of another name: as if the holder had come after a removal.
    mine._descriptor = os.open(path.parent / "removed", os.O_CREAT | os.O_RDWR)
    with pytest.raises(DataFileError, match=f"process {holder.pid} on .* is computing it now"):
        mine.ensure(quiet)
    mine.release()
    assert not Lock(path)._try(quiet), "the other one still holds its lock"


def test_a_lock_got_on_a_removed_file_does_not_count(path, monkeypatch):
    first, second, third = (Lock(path) for _ in range(3))
    first.acquire(quiet)
    opened = os.open(first.file, os.O_RDWR)
    first.release()
    second.acquire(quiet)
    with monkeypatch.context() as patch:
        # The third opened the file before it was removed, and nobody else holds a lock on that.
        patch.setattr(os, "open", lambda *_: opened)
        assert not third._try(quiet)
    second.release()


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_a_file_system_without_locks_is_told(path, monkeypatch, number):
    def refuse(*_):
        raise OSError(number, "no locks")

    monkeypatch.setattr("fcntl.flock", refuse)
    told = []
    with locked(path, told.append) as lock:
        lock.ensure(quiet)
    assert told == [f"{path}: no locks on this file system; let one process compute it"]


def test_many_processes_are_never_inside_at_once(path):
    path.parent.mkdir()
    path.write_text("0")
    counters = [python(COUNTER, path) for _ in range(4)]
    assert [counter.wait() for counter in counters] == [0] * 4
    assert path.read_text() == "120"


def test_a_link_in_the_place_of_the_lock_is_not_followed(path, tmp_path):
    path.parent.mkdir()
    precious = tmp_path / "precious"
    precious.write_text("mine")
    Lock(path).file.symlink_to(precious)
    with pytest.raises(DataFileError, match=str(path)):
        Lock(path).acquire(quiet)
    assert precious.read_text() == "mine"


@pytest.mark.usefixtures("holder")
def test_a_holder_that_does_not_say_its_name_is_another_process(path):
    lock = Lock(path)
    lock.file.write_text("")
    assert lock.holder() == "another process"
    assert not lock._try(quiet)


def test_waiting_can_be_interrupted(path, holder):
    with python(HOLDER, path) as waiting:
        assert "waiting" in waiting.stdout.readline()
        waiting.send_signal(signal.SIGINT)
        waiting.communicate(timeout=30)
    assert holder.poll() is None


class AskedError(Exception):
    """What the handlers of these tests raise."""


@pytest.fixture
def ask():
    """A handler of Ctrl-C and SIGTERM that raises."""

    def ask(number, _):
        raise AskedError(number)

    before = {each: signal.signal(each, ask) for each in (signal.SIGINT, signal.SIGTERM)}
    yield ask
    for each, handler in before.items():
        signal.signal(each, handler)


@pytest.mark.parametrize("asked", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_waits_until_the_outermost_work_is_done(ask, asked):
    done = []

    def work():
        with uninterrupted():
            with uninterrupted():
                os.kill(os.getpid(), asked)
                done.append("inner")
            done.append("outer")
        done.append("more")

    with pytest.raises(AskedError) as error:
        work()
    assert error.value.args == (asked,)
    assert done == ["inner", "outer"]
    assert signal.getsignal(asked) is ask


def test_without_a_signal_only_a_failure_of_the_work_is_told(ask):
    with uninterrupted():
        pass
    with pytest.raises(ValueError, match="work"), uninterrupted():
        raise ValueError("work")
    assert signal.getsignal(signal.SIGINT) is signal.getsignal(signal.SIGTERM) is ask


def test_other_threads_have_nothing_to_put_off():
    entered = []

    def work():
        with uninterrupted():
            entered.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert entered == [signal.getsignal(signal.SIGINT)]
