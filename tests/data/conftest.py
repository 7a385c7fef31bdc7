"""Real data with a known answer: the unworn smooth sphere in partial slip, in closed form."""

import math
import subprocess
import sys
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


@pytest.fixture
def make_case():
    return lambda **changes: steel(**{"cell": CELL, **changes})


@pytest.fixture
def case(make_case):
    return make_case(output_cycles=())


def _arrays(case, cycles=(0, 1000)):
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
    constant_fields = {
        "pressure": hertz.pressure(r),
        "shear_traction": state.shear_traction(r),
        "slip": slip,
        "wear_rate": wear_rate,
        "plastic_depth": np.zeros_like(r),
        "gap": hertz.gap(r),
        "contact_state": np.where(r < state.stick_radius, 2, r < hertz.contact_radius),
    }
    # No test compares other scalars with the fields.
    constants = {variable.name: 0.5 for variable in SCALARS}
    constants |= {"approach": hertz.approach, "peak_pressure": hertz.peak_pressure}
    fields, scalars = (
        {name: np.repeat(np.asarray(value)[None], number.size, axis=0) for name, value in some}
        for some in (constant_fields.items(), constants.items())
    )
    fields |= {"wear_depth": wear_depth, "gap": fields["gap"] + wear_depth}
    volume = 4.0 * wear_depth.sum(axis=(1, 2)) * math.prod(case.grid_spacing)
    worn = {"wear_volume": volume, "maximum_wear_depth": wear_depth.max(axis=(1, 2))}
    return Arrays(x, y, number, fields, scalars | worn)


@pytest.fixture
def make_arrays():
    return _arrays


@pytest.fixture
def make_results():
    def make(case, **kwargs):
        arrays = _arrays(case, **kwargs)
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

    return make


@pytest.fixture
def results(case, make_results):
    return make_results(case)


@pytest.fixture
def case_path(tmp_path, results):
    path = tmp_path / "cases" / "case.nc"
    write_case(*results, path)
    return path


@pytest.fixture
def make_study(tmp_path):
    def make(vary, **sections):
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
        return load_study(write_study(tmp_path / "study.yaml", content))

    return make


@pytest.fixture
def run_study(tmp_path, make_results):
    """Write the closed forms of every case of a study; gives the folder of the case files."""

    def run(study):
        for name, case in study.cases().items():
            results = make_results(case, cycles=case.output_cycles)
            write_case(*results, tmp_path / "cases" / f"{name}.nc")
        return tmp_path / "cases"

    return run


@pytest.fixture
def merged(run_study):
    """Write and merge the cases of a study; gives the folder of its results."""

    def run(study, remove=()):
        cases = run_study(study)
        for name in remove:
            (cases / f"{name}.nc").unlink()
        merge_study(study, cases, cases.parent / "summary.nc")
        return cases.parent

    return run
