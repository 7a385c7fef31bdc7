"""Files that are whole or not there, what is never written through, locks of real processes."""

import copy
import errno
import json
import os
import signal
import tempfile
import threading
import time
from concurrent.futures import BrokenExecutor
from pathlib import Path

import pytest

from fretwear.data import safe
from fretwear.data.safe import DataFileError, Lock, _host
from fretwear.mechanics.integrator import WearError
from fretwear.run.batch import reason_of
from fretwear.units import size_text

from .conftest import python


def test_an_error_names_the_file_the_problem_and_the_remedy_and_can_be_copied():
    error = copy.copy(DataFileError(Path("a.nc"), "it is damaged", "Run it"))
    assert str(error) == "a.nc: it is damaged. Run it"
    assert error.path == Path("a.nc")
    assert reason_of(error) == (str(error), False)
    assert reason_of(WearError("as it says")) == ("as it says", False)
    assert reason_of(TimeoutError()) == ("TimeoutError", False)
    words, is_defect = reason_of(BrokenExecutor())
    assert "out of memory?" in words
    assert not is_defect


def test_a_lack_of_memory_is_known_under_all_its_names():
    wrapped = RuntimeError("NetCDF: HDF error")
    wrapped.__cause__ = MemoryError()
    for error in (
        MemoryError(),
        SystemError("error return without exception set"),
        RuntimeError("FT_Open_Face failed with error 0x40: out of memory"),
        ImportError("libx.so: cannot allocate memory in static TLS block"),
        OSError(errno.ENOMEM, os.strerror(errno.ENOMEM)),
        wrapped,
    ):
        words, is_defect = reason_of(error)
        assert words.startswith("there is not enough memory")
        assert not is_defect
    assert not safe.is_of_memory(ValueError("of the memory of Hertz"))


def test_who_is_to_blame_is_told_by_where_an_error_arose():
    for fail, told in (
        (lambda: size_text("a lot"), "this is a defect of fretwear, please report it: TypeE"),
        (lambda: json.loads("{"), "a library failed (JSONDecodeError: "),
    ):
        with pytest.raises((TypeError, ValueError)) as error:
            fail()
        words, is_defect = reason_of(error.value)
        assert words.startswith(told)
        assert is_defect


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
    error = safe.write_error(tmp_path / "a.nc", OSError(number, "text of the system"))
    assert str(error).startswith(f"{tmp_path / 'a.nc'}: not written")
    assert words in str(error)


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt, SystemExit])
def test_a_file_appears_on_a_clean_exit_and_a_failure_leaves_the_old_one(tmp_path, failure):
    target = tmp_path / "new" / "folder" / "a.txt"
    with safe.atomic_path(target) as temporary:
        assert temporary.parent == target.parent
        assert not target.exists()
    safe.write_text(target, "load,µ\r\n1,2\n")

    def write_half():
        with safe.atomic_path(target) as temporary:
            temporary.write_text("half")
            raise failure

    with pytest.raises(failure):
        write_half()
    assert target.read_bytes() == "load,µ\r\n1,2\n".encode()
    assert list(target.parent.iterdir()) == [target]


def test_two_writers_of_one_file_do_not_mix(tmp_path):
    target = tmp_path / "a.txt"
    with safe.atomic_path(target) as first, safe.atomic_path(target) as second:
        assert first != second
        first.write_text("first" * 1000)
        second.write_text("second")
    assert target.read_text() == "first" * 1000
    assert list(tmp_path.iterdir()) == [target]
    log = tmp_path / "a.log"
    with safe.open_log(log) as first, safe.open_log(log) as second:
        first.write("first\n")
        second.write("second\n")
    assert log.read_text() == "first\nsecond\n"


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs /proc")
def test_a_folder_that_takes_no_files_is_named(tmp_path):
    with pytest.raises(DataFileError, match=r"/proc/fretwear.txt: not written"):
        safe.write_text(Path("/proc/fretwear.txt"), "")
    (tmp_path / "results").write_text("")
    target = tmp_path / "results" / "a.txt"
    with pytest.raises(DataFileError, match="is not a folder") as error:
        safe.write_text(target, "")
    assert str(error.value).startswith(str(target))
    assert safe.why_not_writable(tmp_path) == ""
    assert "no path with a backslash" in safe.why_not_writable(tmp_path / "back\\slash" / "results")


WORKER = """
import sys
from concurrent.futures import BrokenExecutor
from pathlib import Path
from fretwear.data.safe import Lock, atomic_path
path = Path(sys.argv[1])
with Lock(path, print), atomic_path(path) as temporary:
    temporary.write_text("half")
    print("at work")
    sys.stdin.readline()
"""


@pytest.fixture
def path(tmp_path):
    return tmp_path / "cases" / "a.nc"


@pytest.fixture
def holder(path):
    """Another process that locks and writes a file until a line is sent to it."""
    with python(WORKER, path) as process:
        assert process.stdout.readline() == "at work\n"
        yield process
        process.kill()


def test_what_a_killed_writer_left_is_removed_by_the_next(path, holder):
    lock = Lock(path).file
    (left,) = {*path.parent.iterdir()} - {lock}
    assert safe.remove_stale_temporaries(path.parent, path.name) == [], "the writer is still alive"
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert {*path.parent.iterdir()} == {left, lock}
    safe.write_text(path, "whole")
    assert {*path.parent.iterdir()} == {path, lock}


def test_a_temporary_of_another_machine_or_container_is_left_for_a_week(tmp_path, monkeypatch):
    spaces = iter(["pid:[1]", "pid:[2]"])
    monkeypatch.setattr("fretwear.data.safe.os.readlink", lambda _: next(spaces))
    mine, container = (_host.__wrapped__() for _ in range(2))
    assert mine != container, "containers may share a host name"
    monkeypatch.setattr("fretwear.data.safe._host", lambda: mine)
    gone, far, near, other = (
        tmp_path / f".{name}.{host}.{process}.0123abcd.tmp"
        for name, host, process in (
            ("a.txt", mine, 999_999_999),
            ("a.txt", "other-machine", 1),
            ("a.txt", container, 999_999_999),
            ("b.a.txt", "other-machine", 1),
        )
    )
    endless = tmp_path / f".a.txt.{mine}.{10**19}.0123abcd.tmp"  # no process has this number
    eight_days_ago = time.time() - 8 * 24 * 3600
    for file in (gone, far, near, other, endless):
        file.write_text("half")
    assert safe.remove_stale_temporaries(tmp_path, "a.txt") == [gone]
    for file in (far, other):
        os.utime(file, (eight_days_ago, eight_days_ago))
    assert safe.remove_stale_temporaries(tmp_path, "a.txt") == [far]
    assert safe.remove_stale_temporaries(tmp_path, "b.a.txt") == [other]
    assert {*tmp_path.iterdir()} == {near, endless}


@pytest.fixture
def precious(tmp_path):
    """A file of the user's, elsewhere."""
    file = tmp_path / "elsewhere" / "old.tex"
    file.parent.mkdir()
    file.write_text("mine")
    return file


def point_to(name, precious, how):
    name.parent.mkdir(parents=True, exist_ok=True)
    if how == "pipe":
        os.mkfifo(name)
    else:
        (name.symlink_to if how == "link" else name.hardlink_to)(precious)


@pytest.mark.parametrize("how", ["link", "second name", "pipe"])
def test_nothing_elsewhere_is_read_emptied_or_written_to(tmp_path, precious, how):
    target = tmp_path / "results" / "a.txt"
    left = target.with_name(f".a.txt.{_host()}.999999999.deadbeef.tmp")
    log, lock, index = (target.with_name(name) for name in ("a.log", ".a.nc.lock", "index.json"))
    for name in (left, log, lock, index):
        point_to(name, precious, how)
    safe.write_text(target, "whole")
    with safe.open_log(log) as stream:
        stream.write("new")
    with pytest.raises(DataFileError, match=str(target.with_name("a.nc"))):
        Lock(target.with_name("a.nc")).acquire()
    if how != "second name":
        with pytest.raises(OSError, match=r"symbolic links|not a regular file"):
            safe.read_data(index, 100)
    assert precious.read_text() == "mine"
    assert log.read_text() == "new"
    assert not log.is_symlink()
    assert {*target.parent.iterdir()} == {target, log, lock, index}
    assert safe.read_data(precious, 4) == b"mine"
    with pytest.raises(OSError, match="larger than 3 bytes"):
        safe.read_data(precious, 3)


class AskedError(Exception):
    """What the handlers of these tests raise."""


STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.fixture
def ask():
    """A handler of Ctrl-C, SIGTERM and SIGHUP that raises."""

    def ask(number, _):
        raise AskedError(number)

    before = {each: signal.signal(each, ask) for each in STOPS}
    yield ask
    for each, handler in before.items():
        signal.signal(each, handler)


@pytest.mark.parametrize("asked", STOPS)
def test_a_signal_waits_until_the_outermost_work_is_done(ask, asked):
    done = []

    def work():
        with safe.uninterrupted():
            with safe.uninterrupted():
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
    with pytest.raises(ValueError, match="work"), safe.uninterrupted():
        raise ValueError("work")
    assert signal.getsignal(signal.SIGINT) is signal.getsignal(signal.SIGTERM) is ask
    entered = []

    def work():
        with safe.uninterrupted():
            entered.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert entered == [ask], "only the main thread receives signals"


COUNTER = """
import sys
from concurrent.futures import BrokenExecutor
from pathlib import Path
from fretwear.data.safe import Lock
path = Path(sys.argv[1])
for _ in range(30):
    with Lock(path):
        number = int(path.read_text())
        # Two inside at once would lose a count here.
        path.write_text("")
        path.write_text(str(number + 1))
"""


def quiet(line):
    raise AssertionError(line)


def test_a_lock_without_rivals_leaves_nothing_behind_and_one_on_a_removed_file_does_not_count(
    path, monkeypatch
):
    with Lock(path, quiet) as first:
        assert not first.waited
        first.ensure()
        opened = os.open(first.file, os.O_RDWR)
    assert list(path.parent.iterdir()) == []
    with Lock(path, quiet), monkeypatch.context() as patch:
        # This one opened the file before it was removed, and nobody else holds a lock on that.
        patch.setattr(os, "open", lambda *_: opened)
        assert not Lock(path, quiet)._try()


def test_who_waits_is_told_for_which_process_on_which_machine_and_can_be_interrupted(path, holder):
    with python(WORKER, path) as waiting:
        assert "waiting" in waiting.stdout.readline()
        waiting.send_signal(signal.SIGINT)
        waiting.communicate(timeout=30)
    assert holder.poll() is None
    told = []

    def tell(line):
        told.append(line)
        holder.communicate("go\n")

    host = os.uname().nodename
    with Lock(path, tell) as lock:
        assert lock.waited
        assert lock.holder() == f"process {os.getpid()} on {host}"
    assert told == [f"{path}: process {holder.pid} on {host} is computing this; waiting for it"]


def test_a_lock_dies_with_its_process_however_that_dies(path, holder):
    rival = Lock(path, quiet)
    assert not rival._try()
    rival.file.write_text("")
    assert rival.holder() == "another process"
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert rival.file.exists(), "nobody was there to remove it"
    with rival:
        assert not rival.waited


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can act as another user")
def test_the_lock_of_another_user_is_waited_for_or_named_with_its_owner():
    with tempfile.TemporaryDirectory(dir="/tmp") as name:
        folder, told = Path(name), []
        folder.chmod(0o777)  # shared
        path = folder / "case.nc"
        holder = Lock(path).acquire()
        holder.file.chmod(0o644)  # whatever the umask
        try:
            os.seteuid(65534)

            def tell(line):
                told.append(line)
                os.seteuid(0)
                # Dies without removing its file.
                os.close(holder._descriptor)
                holder._descriptor = None
                os.seteuid(65534)

            with Lock(path, tell) as lock:
                assert lock.waited
                assert lock.file.stat().st_uid == 65534
                assert lock.holder() == f"process {os.getpid()} on {os.uname().nodename}"
            words = f"process {os.getpid()} on {os.uname().nodename} of user root"
            assert told == [f"{path}: {words} is computing this; waiting for it"]
            os.seteuid(0)
            with Lock(path) as private:
                private.file.chmod(0o600)
                os.seteuid(65534)
                with pytest.raises(DataFileError, match=r"case.nc.lock of user root may not be"):
                    Lock(path).acquire()
                os.seteuid(0)
            folder.chmod(0o755)  # not shared at all
            os.seteuid(65534)
            with pytest.raises(DataFileError, match="may not be written to"):
                Lock(path).acquire()
        finally:
            os.seteuid(0)


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_a_file_system_without_locks_is_told(path, monkeypatch, number):
    def refuse(*_):
        raise OSError(number, "no locks")

    monkeypatch.setattr("fcntl.flock", refuse)
    told = []
    with Lock(path, told.append) as lock:
        lock.ensure()
    assert told == [f"{path}: no locks on this file system; let one process compute it"]


def test_many_processes_are_never_inside_at_once(path):
    path.parent.mkdir()
    path.write_text("0")
    counters = [python(COUNTER, path) for _ in range(4)]
    assert [counter.wait() for counter in counters] == [0] * 4
    assert path.read_text() == "120"
