import fcntl
import os
import pty
import re
import shlex
import signal
import subprocess
import sys
import termios
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import fretwear
from fretwear.study.study import select_case

from ..studies import WAVES, base

FRETWEAR = (sys.executable, "-m", "fretwear")


@pytest.mark.parametrize("whole", [True, False])
def test_a_case_chosen_by_its_id_or_its_beginning_is_simulated_and_written(desk, whole):
    case_id = select_case("tiny.yaml", None, ["load=25 N"]).case_id
    chosen = case_id if whole else "P25N"
    result = desk.call("run", "tiny.yaml", "--case", chosen, "-o", "out/one.nc")
    assert result.exit_code == 0
    assert result.stdout.startswith("out/one.nc: ")
    with fretwear.open_case("out/one.nc") as case:
        assert case.attrs["case_id"] == case_id
        assert list(case["cycle"].values) == [0, 20, 200]
        assert float(case["load"]) == 25.0


def test_a_changed_case_has_the_numbers_of_python_and_tells_its_call(desk):
    changes = ["load=30 N", "cycles=50"]
    assert desk.call("run", "tiny.yaml", "--set", changes[0], "--set", changes[1]).exit_code == 0
    case = select_case(desk.folder / "tiny.yaml", None, changes)
    computed = fretwear.simulate(case, quarter=True)
    with fretwear.open_case(f"{case.case_id}.nc") as stored:
        command = "fretwear run tiny.yaml --set 'load=30 N' --set cycles=50"
        assert stored.attrs["history"].endswith(command)
        for name in computed.data_vars:
            np.testing.assert_array_equal(stored[name], computed[name])


@pytest.fixture
def long_run(desk):
    """The arguments of a run that takes a minute where nobody stops it."""
    desk.write({"base": base(cycles=7000, cell="0.5 um", roughness=WAVES)})
    return "run", "tiny.yaml"


@pytest.mark.parametrize(("name", "status"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_a_stopped_run_says_so_and_leaves_no_case_file(desk, long_run, name, status):
    command = (*FRETWEAR, *long_run)
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        seen = ""
        while "cycle 0 of" not in seen:
            line = process.stderr.readline()
            assert line, seen
            seen += line
        process.send_signal(getattr(signal, name))
        message = process.stderr.read()
        assert process.wait(30) == status
    assert re.search(r"fretwear: stopped: (by|because its) ", message)
    assert "Traceback" not in message
    # The lock goes with its process, and so does every temporary file; a checkpoint may stay.
    assert {Path(file).suffix for file in desk.files()} <= {".yaml", ".checkpoint"}


def test_a_run_whose_terminal_is_gone_leaves_its_checkpoint(desk, long_run):
    """The kernel sends SIGHUP when the other end is closed, and fails whatever is written then."""
    near, far = pty.openpty()

    def as_session():
        os.setsid()
        fcntl.ioctl(2, termios.TIOCSCTTY, 0)

    process = subprocess.Popen(
        (*FRETWEAR, *long_run), stderr=far, stdout=far, preexec_fn=as_session
    )
    os.close(far)
    while b"half-width" not in os.read(near, 4096):
        assert process.poll() is None
    os.close(near)
    assert process.wait(60) == 129
    assert {Path(file).suffix for file in desk.files()} == {".yaml", ".checkpoint"}


@pytest.mark.usefixtures("desk")
def test_nohup_outlives_its_terminal():
    command = (*FRETWEAR, "run", "tiny.yaml", "--set", "load=50 N")
    ignore = partial(signal.signal, signal.SIGHUP, signal.SIG_IGN)
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=ignore) as process:
        assert "case" in process.stderr.readline()
        process.send_signal(signal.SIGHUP)
        process.stderr.read()
        assert process.wait(60) == 0


@pytest.mark.parametrize("how", ["2>/dev/full", "2>&-", "| true"])
@pytest.mark.usefixtures("desk")
def test_a_run_whose_messages_find_no_reader_ends_well(how):
    call = shlex.join([*FRETWEAR, "run", "tiny.yaml", "--set", "load=50 N", "-o", "a.nc"])
    done = subprocess.run(["bash", "-o", "pipefail", "-c", f"{call} {how}"], check=False)
    assert done.returncode == 0
    with fretwear.open_case("a.nc") as case:
        assert case.attrs["complete"] == 1


@pytest.mark.parametrize("how", ["| true", ">/dev/full"])
@pytest.mark.usefixtures("desk")
def test_a_table_that_finds_no_reader_ends_without_a_traceback(how):
    call = shlex.join([*FRETWEAR, "schema"])
    command = ["bash", "-o", "pipefail", "-c", f"{call} {how}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    words = "standard output: cannot be written: No space left on device"
    assert done.stderr == (f"fretwear: error: {words}\n" if "full" in how else "")
