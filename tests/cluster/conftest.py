"""The workflow as a user has it, in a folder of its own."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
import yaml

from ..studies import write_study

REPOSITORY = Path(__file__).parents[2]


def eventually(condition, seconds, what):
    until = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < until, f"waited {seconds} s in vain until {what}"
        time.sleep(0.2)
    return found


class Workflow:
    """A run of Snakemake that goes on beside the test, in a process group like a terminal's."""

    def __init__(self, folder, command):
        self.folder, self.log = folder, folder / "snakemake.log"
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        with self.log.open("w") as stream:
            self._process = subprocess.Popen(
                ["bash", "-c", f"exec {command}"],
                cwd=folder,
                env=os.environ | {"PATH": path},
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    @property
    def output(self):
        return self.log.read_text()

    def end(self, seconds):
        """Wait for the end and return the exit status."""
        try:
            return self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.stop()
            pytest.fail(f"still running after {seconds} s:\n{self.output}")

    def press_ctrl_c(self):
        os.killpg(self._process.pid, signal.SIGINT)

    def stop(self):
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()


class Checkout:
    def __init__(self, folder):
        self.folder, self.running = folder, []
        shutil.copy(REPOSITORY / "Snakefile", folder)
        for part in ("profiles", "studies"):
            shutil.copytree(REPOSITORY / part, folder / part)
        self.demo = yaml.safe_load((folder / "studies/demo.yaml").read_text(encoding="utf-8"))

    def write_study(self, name, content):
        return write_study(self.folder / f"studies/{name}.yaml", content)

    def start(self, command):
        self.running.append(Workflow(self.folder, command))
        return self.running[-1]

    def simulations(self):
        """The processes that simulate cases of this folder."""
        return [
            process
            for process in psutil.process_iter(["cwd", "cmdline"])
            if process.info["cwd"] == str(self.folder)
            and "fretwear" in (process.info["cmdline"] or ())
        ]


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    made = Checkout(tmp_path_factory.mktemp("checkout").resolve())
    yield made
    for run in made.running:
        run.stop()
