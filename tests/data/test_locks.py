"""Locks held by real processes."""

import errno
import os
import signal

import pytest

from fretwear.data.locks import Lock, locked
from fretwear.data.safe import DataFileError

from .conftest import python

HOLDER = """
import sys
from pathlib import Path
from fretwear.data.locks import locked
with locked(Path(sys.argv[1]), print):
    print("held")
    sys.stdin.readline()
"""
COUNTER = """
import sys
from pathlib import Path
from fretwear.data.locks import locked
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


def test_a_lock_without_rivals_leaves_nothing_behind_and_one_on_a_removed_file_does_not_count(
    path, monkeypatch
):
    with locked(path, quiet) as lock:
        assert not lock.waited
        assert lock.file.exists()
        lock.ensure(quiet)
    assert list(path.parent.iterdir()) == []
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
