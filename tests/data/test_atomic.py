import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fretwear.data.safe import DataFileError, atomic_path, remove_stale_temporaries, write_text


def test_the_name_appears_on_a_clean_exit_only(tmp_path):
    target = tmp_path / "new" / "folder" / "a.txt"
    with atomic_path(target) as temporary:
        temporary.write_text("whole")
        assert temporary.parent == target.parent
        assert not target.exists()
    assert target.read_text() == "whole"
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


def test_text_is_written_as_it_is(tmp_path):
    write_text(tmp_path / "a.csv", "load,µ\r\n1,2\n")
    assert (tmp_path / "a.csv").read_bytes() == "load,µ\r\n1,2\n".encode()


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


def test_a_folder_that_takes_no_files_is_named():
    target = Path("/proc/fretwear.txt")
    if not target.parent.is_dir():
        pytest.skip("no /proc here")
    with pytest.raises(DataFileError, match=r"/proc/fretwear.txt: not written"):
        write_text(target, "")


def test_what_a_killed_writer_left_is_removed_by_the_next(tmp_path):
    target = tmp_path / "a.txt"
    code = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from fretwear.data.safe import atomic_path\n"
        "with atomic_path(Path(sys.argv[1])) as temporary:\n"
        "    temporary.write_text('half')\n"
        "    print('writing', flush=True)\n"
        "    time.sleep(60)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, target], stdout=subprocess.PIPE, text=True
    ) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == "writing\n"
        (left,) = tmp_path.iterdir()
        assert remove_stale_temporaries(target) == [], "the writer is still alive"
        writer.send_signal(signal.SIGKILL)
    assert not target.exists()
    write_text(target, "whole")
    assert list(tmp_path.iterdir()) == [target]
    assert not left.exists()


def test_a_temporary_of_another_machine_is_left_for_a_week(tmp_path):
    target = tmp_path / "a.txt"
    foreign = tmp_path / ".a.txt.other-machine.1.0123abcd.tmp"
    foreign.write_text("half")
    assert remove_stale_temporaries(target) == []
    eight_days_ago = time.time() - 8 * 24 * 3600
    os.utime(foreign, (eight_days_ago, eight_days_ago))
    assert remove_stale_temporaries(target) == [foreign]


def test_temporaries_of_other_files_are_left_alone(tmp_path):
    other = tmp_path / ".b.a.txt.other-machine.1.0123abcd.tmp"
    other.write_text("half")
    os.utime(other, (0.0, 0.0))
    assert remove_stale_temporaries(tmp_path / "a.txt") == []
    assert remove_stale_temporaries(tmp_path / "b.a.txt") == [other]
