"""Real data with a known answer: the unworn smooth sphere in partial slip, in closed form."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr
import yaml

from fretwear.data.dataset import case_dataset, history_dataset
from fretwear.data.files import write_case
from fretwear.study.case import Case
from fretwear.study.study import Study, load_study
from fretwear.theory import CattaneoMindlin, HertzContact


class Results(NamedTuple):
    """What a run gives: the snapshots and the dense history."""

    dataset: xr.Dataset
    history: xr.Dataset


class Arrays(NamedTuple):
    """The same before it is labelled."""

    x: np.ndarray
    y: np.ndarray
    cycles: np.ndarray
    fields: dict[str, np.ndarray]
    scalars: dict[str, np.ndarray]


@pytest.fixture
def make_case() -> Callable[..., Case]:
    def make(**changes: object) -> Case:
        given = {
            "radius": "10 mm",
            "youngs_modulus": "208 GPa",
            "poisson_ratio": 0.3,
            "load": "50 N",
            "tangential_ratio": 0.8,
            "friction": 0.5,
            "wear_coefficient": "7e-13 / Pa",
            "cycles": 1000,
            "cell": ("10 um", "12 um"),
        }
        return Case(**(given | changes))

    return make


@pytest.fixture
def case(make_case: Callable[..., Case]) -> Case:
    return make_case()


def _arrays(case: Case, extent: float = 1.3, cycles: tuple[int, ...] = (0, 1000)) -> Arrays:
    """Closed forms at cell centres of the quarter; wear at the unworn rate, so linear in time."""
    dx, dy = case.grid_spacing
    x = (np.arange(math.ceil(extent * case.hertz_radius / dx)) + 0.5) * dx
    y = (np.arange(math.ceil(extent * case.hertz_radius / dy)) + 0.5) * dy
    hertz = HertzContact(case.radius, case.load, case.composite_modulus)
    state = CattaneoMindlin(
        hertz,
        friction=case.friction,
        tangential_load=case.tangential_load,
        coupling=case.coupling,
    )
    r = np.hypot(x[:, None], y[None, :])
    slip = np.where(r < hertz.contact_radius, state.slip(r), 0.0)
    wear_rate = 4.0 * case.wear_coefficient * hertz.pressure(r) * slip
    inside = np.where(r < state.stick_radius, 2, np.where(r < hertz.contact_radius, 1, 0))
    number = np.array(cycles, dtype=float)

    def held(values: np.ndarray | float) -> np.ndarray:
        return np.repeat(np.asarray(values, dtype=float)[None], number.size, axis=0)

    wear_depth = number[:, None, None] * wear_rate
    fields = {
        "pressure": held(hertz.pressure(r)),
        "shear_traction": held(state.shear_traction(r)),
        "slip": held(slip),
        "wear_depth": wear_depth,
        "wear_rate": held(wear_rate),
        "plastic_depth": held(np.zeros_like(r)),
        "gap": held(hertz.gap(r)) + wear_depth,
        "contact_state": held(inside).astype(int),
    }
    scalars = {
        "approach": held(hertz.approach),
        "tangential_displacement": held(state.tangential_displacement),
        "contact_half_width_x": held(hertz.contact_radius),
        "contact_half_width_y": held(hertz.contact_radius),
        "stick_half_width_x": held(state.stick_radius),
        "stick_half_width_y": held(state.stick_radius),
        "contact_area": held(math.pi * hertz.contact_radius**2),
        "stick_area": held(math.pi * state.stick_radius**2),
        "peak_pressure": held(hertz.peak_pressure),
        "central_pressure": held(hertz.peak_pressure),
        "wear_volume": 4.0 * wear_depth.sum(axis=(1, 2)) * dx * dy,
        "plastic_volume": held(0.0),
        "dissipated_energy": held(state.dissipated_energy),
    }
    return Arrays(x, y, number, fields, scalars)


@pytest.fixture
def make_arrays() -> Callable[..., Arrays]:
    return _arrays


@pytest.fixture
def make_results() -> Callable[..., Results]:
    def make(case: Case, **kwargs: object) -> Results:
        arrays = _arrays(case, **kwargs)
        steps = np.linspace(0.0, case.cycles, 5)
        dense = {
            name: np.interp(steps, arrays.cycles, values) for name, values in arrays.scalars.items()
        }
        return Results(
            case_dataset(case, *arrays),
            history_dataset(steps, dense, np.full(5, 1e-3), np.full(5, 40)),
        )

    return make


@pytest.fixture
def results(case: Case, make_results: Callable[..., Results]) -> Results:
    return make_results(case)


@pytest.fixture
def case_path(tmp_path: Path, results: Results) -> Path:
    path = tmp_path / "cases" / "case.nc"
    write_case(*results, path)
    return path


STUDY = {
    "title": "Loads and limits",
    "base": {
        "radius": "10 mm",
        "youngs_modulus": "208 GPa",
        "poisson_ratio": 0.3,
        "load": "50 N",
        "tangential_ratio": 0.8,
        "friction": 0.5,
        "wear_coefficient": "7e-13 / Pa",
        "plastic_limit": "none",
        "roughness": "none",
        "cycles": 1000,
        "cell": ["10 um", "12 um"],
    },
    "output": {"cycles": [0, 100, 1000]},
}


@pytest.fixture
def make_study(tmp_path: Path) -> Callable[..., Study]:
    def make(vary: dict[str, object], **sections: object) -> Study:
        base = {name: v for name, v in STUDY["base"].items() if name not in vary}
        if "tangential_load" in vary:
            del base["tangential_ratio"]
        if any(name.startswith("roughness.") for name in vary):
            base["roughness"] = {"kind": "wavy", "slope_x": "0.2 deg", "slope_y": "0.2 deg"}
        path = tmp_path / "study.yaml"
        content = {**STUDY, "base": base, "vary": vary, **sections}
        path.write_text(yaml.safe_dump(content, sort_keys=False))
        return load_study(path)

    return make


@pytest.fixture
def run_study(tmp_path: Path, make_results: Callable[..., Results]) -> Callable[[Study], Path]:
    """Write the closed forms of every case of a study; gives the folder of the case files."""

    def run(study: Study) -> Path:
        for name, case in study.cases().items():
            results = make_results(case, cycles=case.output_cycles)
            write_case(*results, tmp_path / "cases" / f"{name}.nc")
        return tmp_path / "cases"

    return run
