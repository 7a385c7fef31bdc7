"""Results of coarse runs, of a case and of the cases of a study."""

import subprocess
import sys
from functools import partial
from typing import NamedTuple

import pytest
import xarray as xr

from fretwear.data.files import write_case
from fretwear.data.merge import merge_study
from fretwear.running.simulate import run
from fretwear.study.study import load_study

from ..studies import base as study_base
from ..studies import steel, write_study

COARSE = {"cell": ["10 um", "12 um"], "error_estimate": False}


class Results(NamedTuple):
    """What a run gives: the snapshots and the dense history."""

    dataset: xr.Dataset
    history: xr.Dataset


def python(code, *arguments):
    """Start a process with pipes; what it prints comes at once."""
    command = [sys.executable, "-u", "-c", code, *map(str, arguments)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def make_case(**changes):
    return steel(**{**COARSE, **changes})


def make_results(case):
    dataset, history, _ = run(case).labelled
    return Results(dataset.dataset(), history.dataset())


def study_in(folder, vary, **sections):
    base = study_base(**COARSE)
    if any(name.startswith("roughness.") for name in vary):
        base["roughness"] = {"kind": "wavy", "slope_x": "0.2 deg", "slope_y": "0.2 deg"}
    replaced = {*vary, "tangential_ratio"} if "tangential_load" in vary else vary
    content = {
        "title": "Loads and limits",
        "base": {name: value for name, value in base.items() if name not in replaced},
        "vary": vary,
        "output": {"cycles": [0, 100, 1000]},
        **sections,
    }
    return load_study(write_study(folder / "study.yaml", content))


def run_in(folder, study):
    """Run every case of a study; return the folder of the case files."""
    for name, case in study.cases().items():
        write_case(*make_results(case), folder / "cases" / f"{name}.nc")
    return folder / "cases"


def merged_in(folder, study):
    """Write and merge the cases of a study; return the folder of its results."""
    merge_study(study, run_in(folder, study), folder / "summary.nc")
    return folder


@pytest.fixture
def make_study(tmp_path):
    return partial(study_in, tmp_path)


@pytest.fixture
def run_study(tmp_path):
    return partial(run_in, tmp_path)


@pytest.fixture
def merged(tmp_path):
    return partial(merged_in, tmp_path)


@pytest.fixture
def case():
    return make_case()


@pytest.fixture
def results(case):
    return make_results(case)


@pytest.fixture
def case_path(tmp_path, results):
    path = tmp_path / "cases" / "case.nc"
    write_case(*results, path)
    return path
