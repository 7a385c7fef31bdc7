"""A system without locks of files, users, child processes by fork and SIGHUP, as Windows is."""

import subprocess
import sys

import fretwear

from ..studies import write_study
from .conftest import TINY

# Nothing of the program has been imported yet.
ELSEWHERE = """
import os, signal, sys
import psutil  # whose version for Linux needs them
hidden = {"fcntl", "pwd", "resource", "grp", "termios"}
for name in hidden:
    sys.modules.pop(name, None)
class Hide:
    def find_spec(self, name, *_):
        if name in hidden:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Hide())
lacking = "fork geteuid getppid pwrite sched_getaffinity O_NOFOLLOW O_NONBLOCK O_CLOEXEC"
for name in lacking.split():
    delattr(os, name)
for name in ("SIGHUP", "SIGALRM", "alarm", "pthread_sigmask"):
    delattr(signal, name)
sys.argv = ["fretwear", *sys.argv[1:]]
from fretwear.cli import main
main()
"""


def test_a_case_runs_where_there_are_no_locks_and_no_fork(tmp_path):
    write_study(tmp_path / "tiny.yaml", TINY)

    def call(*arguments):
        command = [sys.executable, "-c", ELSEWHERE, *arguments]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)

    done = call("run", "tiny.yaml", "--set", "load=50 N", "-o", "a.nc")
    assert done.returncode == 0, done.stderr
    assert "no locks on this file system" in done.stderr
    with fretwear.open_case(tmp_path / "a.nc") as case:
        assert case.wear_volume.values[-1] > 0.0
    wrong = call("plan", "none.yaml")
    assert (wrong.returncode, "there is no such file" in wrong.stderr) == (2, True)
