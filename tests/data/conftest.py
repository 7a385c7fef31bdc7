"""Results of coarse runs, of a case and of the cases of a study."""

import shutil
from functools import partial
from pathlib import Path

import pytest

from fretwear.data.files import write_case
from fretwear.run.simulate import run
from fretwear.study.reading import load_study

from ..studies import base, run_study, steel, two_loads, write_study

COARSE = {"cell": ["10 um", "12 um"], "error_estimate": False}


def study_in(folder, vary, **sections):
    parameters = base(**COARSE)
    if any(name.startswith("roughness.") for name in vary):
        parameters["roughness"] = {"kind": "wavy", "slope_x": "0.2 deg", "slope_y": "0.2 deg"}
    replaced = {*vary, "tangential_ratio"} if "tangential_load" in vary else vary
    parameters = {name: value for name, value in parameters.items() if name not in replaced}
    usual = {"base": parameters, "vary": vary, "output": {"cycles": [0, 100, 1000]}}
    return load_study(write_study(folder / "study.yaml", two_loads(**{**usual, **sections})))


@pytest.fixture
def make_study(tmp_path):
    return partial(study_in, tmp_path)


@pytest.fixture
def merged(tmp_path):
    return partial(run_study, folder=tmp_path)


@pytest.fixture(scope="session")
def case():
    return steel(**COARSE)


@pytest.fixture(scope="session")
def results(case):
    return run(case)


@pytest.fixture(scope="session")
def written(results, tmp_path_factory):
    path = tmp_path_factory.mktemp("written") / "case.nc"
    write_case(results.dataset, results.history, path)
    return path


@pytest.fixture
def case_path(tmp_path, written):
    """A copy of the file of a case, to be spoilt."""
    folder = tmp_path / "cases"
    folder.mkdir()
    return Path(shutil.copy(written, folder))
