"""Real data with a known answer: the unworn smooth sphere in partial slip, in closed form."""

import math
import subprocess
import sys
from functools import partial
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr

from fretwear.data.files import write_case
from fretwear.data.labels import labelled_case, labelled_history
from fretwear.data.merge import merge_study
from fretwear.study.study import load_study
from fretwear.theory import CattaneoMindlin, HertzContact
from fretwear.vocabulary import AT_SNAPSHOTS, SCALARS

from ..studies import base as study_base
from ..studies import steel, write_study

CELL = ["10 um", "12 um"]


class Results(NamedTuple):
    """What a run gives: the snapshots and the dense history."""

    dataset: xr.Dataset
    history: xr.Dataset


class Arrays(NamedTuple):
    x: np.ndarray
    y: np.ndarray
    cycles: np.ndarray
    fields: dict[str, np.ndarray]
    scalars: dict[str, np.ndarray]


def python(code, *arguments):
    """Start a process with pipes; what it prints comes at once."""
    command = [sys.executable, "-u", "-c", code, *map(str, arguments)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def make_case(**changes):
    return steel(**{"cell": CELL, **changes})


def make_arrays(case, cycles=(0, 1000)):
    """Closed forms at cell centres of the quarter; wear at the unworn rate, so linear in time."""
    x, y = (
        (np.arange(math.ceil(1.3 * case.hertz_radius / spacing)) + 0.5) * spacing
        for spacing in case.grid_spacing
    )
    hertz = HertzContact(case.radius, case.load, case.composite_modulus)
    state = CattaneoMindlin(
        hertz,
        friction=case.friction_law.coefficient,
        tangential_load=case.tangential_load,
        coupling=case.coupling,
    )
    r = np.hypot(x[:, None], y[None, :])
    slip = np.where(r < hertz.contact_radius, state.slip(r), 0.0)
    wear_rate = 4.0 * case.wear_coefficient * hertz.pressure(r) * slip
    number = np.array(cycles, dtype=float)
    wear_depth = number[:, None, None] * wear_rate
    constant = {
        "pressure": hertz.pressure(r),
        "shear_traction": state.shear_traction(r),
        "slip": slip,
        "wear_rate": wear_rate,
        "plastic_depth": np.zeros_like(r),
        "contact_state": np.where(r < state.stick_radius, 2, r < hertz.contact_radius),
    }
    fields = {name: np.stack([each] * number.size) for name, each in constant.items()}
    fields |= {"wear_depth": wear_depth, "gap": hertz.gap(r) + wear_depth}
    # No test compares other scalars with the fields.
    scalars = {variable.name: np.full(number.size, 0.5) for variable in SCALARS} | {
        "approach": np.full(number.size, hertz.approach),
        "peak_pressure": np.full(number.size, hertz.peak_pressure),
        "wear_volume": 4.0 * wear_depth.sum(axis=(1, 2)) * math.prod(case.grid_spacing),
        "maximum_wear_depth": wear_depth.max(axis=(1, 2)),
    }
    return Arrays(x, y, number, fields, scalars)


def make_results(case, cycles=(0, 1000)):
    arrays = make_arrays(case, cycles)
    steps = np.linspace(0.0, case.cycles, 5)
    dense = {
        name: np.interp(steps, arrays.cycles, values)
        for name, values in arrays.scalars.items()
        if name not in AT_SNAPSHOTS
    }
    return Results(
        labelled_case(case, *arrays).dataset(),
        labelled_history(steps, dense, np.full(5, 1e-3), np.full(5, 40)).dataset(),
    )


def study_in(folder, vary, **sections):
    base = study_base(cell=CELL)
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
    """Write the closed forms of every case of a study; return the folder of the case files."""
    for name, case in study.cases().items():
        write_case(*make_results(case, case.output_cycles), folder / "cases" / f"{name}.nc")
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
    return make_case(output_cycles=())


@pytest.fixture
def results(case):
    return make_results(case)


@pytest.fixture
def case_path(tmp_path, results):
    path = tmp_path / "cases" / "case.nc"
    write_case(*results, path)
    return path
