"""A few points of each fault, and a few changed files for each reader, of docs/reliability.md."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from benchmarks.faults import DISKS, OPEN, WRITE, replay

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("cc"), reason="needs a compiler"),
]
ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^\| (.+?) \| (\d+)(?: of \d+)? \|((?: \d+ \|)+)$", re.MULTILINE)


@pytest.mark.slow
@pytest.mark.skipif(os.geteuid() != 0, reason="mounting takes rights that are not given here")
def test_after_a_fault_or_a_power_failure_the_same_command_gives_the_same_bits():
    few = ("--every=499", "--commands=2", "--power=2", "--cuts=1", "--only=^(?!start)")
    command = [sys.executable, "-m", "benchmarks.faults", *few]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    rows = ROW.findall(done.stdout)
    assert len(rows) == 16 + len(DISKS), done.stdout + done.stderr
    for name, points, found in rows:
        assert int(points) > 0, name
        *harm, defects, _ = found.strip(" |").split(" | ")
        assert set(harm) == {"0"}, done.stdout
        assert defects == "0" or name == "no memory inside a library", done.stdout


def test_what_was_not_flushed_may_be_gone_and_what_was_flushed_is_there(tmp_path):
    class Always:
        def random(self):
            return 0.9

    create = os.O_CREAT | os.O_WRONLY
    written = [(OPEN, 1, create, "a", b""), (WRITE, 1, 0, "", b"x" * 5000)]
    replay(written, tmp_path, Always())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_every_reader_takes_changed_files_or_refuses_them_by_a_sentence():
    command = [sys.executable, "-m", "benchmarks.fuzz", "--share", "0.001"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    rows = re.findall(r"^\| (.+?) \| (\d+) \|((?: [\d.]+ \|)+)$", done.stdout, re.MULTILINE)
    assert len(rows) == 12, done.stdout + done.stderr
    for name, tried, ends in rows:
        accepted, refused, tracebacks, differ, *_ = ends.replace("|", "").split()
        assert tracebacks == differ == "0", done.stdout
        # What is no run that a fit has kept is run again.
        assert int(refused) > 0 or name == "fits, kept runs", name
        assert int(accepted) + int(refused) > 0.9 * int(tried), name
    assert done.returncode == 0
