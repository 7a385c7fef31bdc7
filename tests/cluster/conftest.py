"""The workflow as a user has it, in a folder of its own."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from ..studies import write_study

REPOSITORY = Path(__file__).parents[2]
PAGE = REPOSITORY / "docs/how-to/cluster.md"


def documented_commands():
    text = PAGE.read_text(encoding="utf-8")
    blocks = re.findall(r"^```bash\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [line for block in blocks for line in block.splitlines()]


def eventually(condition, seconds, what):
    until = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < until, f"waited {seconds} s in vain until {what}"
        time.sleep(0.2)
    return found


class Workflow:
    """A run of Snakemake that goes on beside the test, in a process group like a terminal's."""

    def __init__(self, folder, command):
        self.folder = folder
        self.log = folder / "snakemake.log"
        environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
        with self.log.open("w") as stream:
            self._process = subprocess.Popen(
                ["bash", "-c", f"exec {command}"],
                cwd=folder,
                env=environment,
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
        self.folder = folder
        self._running = []
        shutil.copy(REPOSITORY / "Snakefile", folder)
        for part in ("profiles", "studies"):
            shutil.copytree(REPOSITORY / part, folder / part)

    def change_study(self, name, **sections):
        file = self.folder / f"studies/{name}.yaml"
        write_study(file, yaml.safe_load(file.read_text(encoding="utf-8")) | sections)

    def write_one_case(self, name, **base):
        """Write a study of one case that differs from the default one in some parameters."""
        content = yaml.safe_load((self.folder / "studies/demo.yaml").read_text(encoding="utf-8"))
        base = {**content["base"], **base}
        cycles = [each for each in content["output"]["cycles"] if each <= base["cycles"]]
        study = {"title": f"One case: {name}", "base": base, "output": {"cycles": cycles}}
        write_study(self.folder / f"studies/{name}.yaml", study)

    def start(self, command):
        run = Workflow(self.folder, command)
        self._running.append(run)
        return run

    def stop(self):
        for run in self._running:
            run.stop()

    def simulations(self):
        """Ids of the processes that simulate cases of this folder."""
        return [int(each.name) for each in Path("/proc").glob("[0-9]*") if self._simulates(each)]

    def _simulates(self, process):
        try:
            is_here = (process / "cwd").resolve() == self.folder
            return is_here and b"\0-m\0fretwear\0" in (process / "cmdline").read_bytes()
        except OSError:
            return False


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    made = Checkout(tmp_path_factory.mktemp("checkout").resolve())
    yield made
    made.stop()
