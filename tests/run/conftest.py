"""Cases and studies that take a moment, and the workflow as a user has it."""

import shutil
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
import xarray as xr

from fretwear.data.files import open_case, open_history, open_loops
from fretwear.study.reading import load_study

from ..studies import base, steel, two_loads, write_study

REPOSITORY = Path(__file__).parents[2]

BASE = base(cycles=100, cell="10 um")


def make_case(**changes):
    return steel(**{"cycles": 100, "cell": "10 um", **changes})


def without(content, *keys):
    return {key: value for key, value in content.items() if key not in keys}


TINY = two_loads(
    title="Tiny",
    base={**without(BASE, "load", "tangential_ratio"), "tangential_load": "9 N"},
    output={"cycles": [0, 20]},
    batch=1,
)

# Matter this soft is gone before the shortest step ends, so its case really fails.
HOPELESS = {
    **TINY,
    "base": {**TINY["base"], "load": "50 N"},
    "vary": {"wear_coefficient": ["1 / Pa", "7e-13 / Pa"]},
}


@pytest.fixture
def load(tmp_path):
    return lambda content: load_study(write_study(tmp_path / "study.yaml", content))


class Checkout:
    """A folder with workflow, profiles and studies, as a user has it."""

    def __init__(self, folder):
        self.folder = folder
        self.results = folder / "results/demo"

    @classmethod
    def make(cls, folder):
        shutil.copy(REPOSITORY / "Snakefile", folder)
        shutil.copytree(REPOSITORY / "profiles", folder / "profiles")
        checkout = cls(folder)
        checkout.write(TINY)
        return checkout

    def write(self, content, name="demo"):
        write_study(self.folder / f"studies/{name}.yaml", content)

    def snakemake(self, *arguments, status):
        """Run Snakemake and return what it said; it must end with this status."""
        done = subprocess.run(
            [sys.executable, "-m", "snakemake", "--cores", "2", *arguments],
            cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip
        assert done.returncode == status, done.stdout
        return done.stdout


@pytest.fixture
def start(tmp_path):
    """Start a command of fretwear or another module in a folder, killed when the test ends."""
    started = []

    def begin(*arguments, folder=tmp_path, module="fretwear", **options):
        process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # Tests may run under nohup, which has processes ignore it.
            preexec_fn=partial(signal.signal, signal.SIGHUP, signal.SIG_DFL),
            **options,
        )
        started.append(process)
        return process

    yield begin
    for process in started:
        process.kill()
        process.communicate()


def read_until(process, words):
    said = ""
    while words not in said:
        line = process.stderr.readline()
        assert line, said
        said += line
    return said


def assert_same(first, second):
    """Compare every value of two case files."""
    for opened in (open_case, open_history, open_loops):
        with opened(first) as a, opened(second) as b:
            xr.testing.assert_equal(a.load(), b.load())
