"""The steel sphere of the tests, studies of it, and their results without the workflow."""

import os
import subprocess
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml

from fretwear.data.files import write_case
from fretwear.data.merge import merge_study
from fretwear.run.simulate import run
from fretwear.study.case import Case, CaseError
from fretwear.study.study import Study

TITANIUM = {
    "indenter": {"kind": "cylinder", "radius": "80 mm"},
    "youngs_modulus": "119 GPa",
    "poisson_ratio": 0.287,
    "load": "1066 N/mm",
    "sliding_amplitude": "75 um",
    "friction": 0.6,
    "wear_coefficient": ["1e-13 / Pa", "1e-13 / Pa"],
    "plastic_limit": "none",
    "roughness": "none",
    "cycles": 500,
}
"""Keys of a case of a cylinder that slides as a whole, of both bodies' wear."""

_AREA = 4 * 2e-13 * 1066e3 * 75e-6 * 500  # m², 4 K P δ N
VOLUME = {"quantity": "wear_volume", "value": f"{_AREA * 1e6} mm^2", "error": "2 %"}
"""What a fit is told of the wear of both of these bodies together."""

STEEL = {
    "radius": "10 mm",
    "youngs_modulus": "208 GPa",
    "poisson_ratio": 0.3,
    "load": "50 N",
    "tangential_ratio": 0.8,
    "friction": 0.5,
    "wear_coefficient": "7e-13 / Pa",
    "cycles": 1000,
}
WAVES = {"kind": "wavy", "amplitude": "0.2 um", "slope_x": "5.7 deg", "slope_y": "1 deg"}
SELF_AFFINE = {
    "kind": "self_affine",
    "rms_height": "0.1 um",
    "hurst": 0.8,
    "rolloff_wavelength": "60 um",
    "shortest_wavelength": "16 um",
}


def steel(**changes: object) -> Case:
    """The steel sphere with changes; a tangential load takes the place of the ratio.

    It has the snapshots of cycle 0 and the last, if no others are asked for.
    """
    parameters = (
        STEEL
        | {"output_cycles": ()}
        | ({"tangential_ratio": None} if "tangential_load" in changes else {})
    )
    return Case(**(parameters | changes))


def line_contact(radius: str, load: str | None = None) -> dict[str, object]:
    """Keys that make the steel sphere a cylinder of a radius, under a load per length."""
    return {"radius": None, "indenter": {"kind": "cylinder", "radius": radius}, "load": load}


def study_case(**changes: object) -> Case:
    """A rough sphere that yields, with changes."""
    parameters = {"plastic_limit": "4500 MPa", "roughness": WAVES, "cycles": 30000}
    return steel(**{"tangential_load": "20 N", **parameters, "cell": ["0.5 um", "2 um"], **changes})


def two_loads(**sections: object) -> dict[str, object]:
    """The content of a small sound study of two loads, as plain values."""
    vary = {"load": ["25 N", "50 N"]}
    return {"title": "Two loads", "base": base(), "vary": vary, **sections}


def near(expected: float, rel: float = 1e-6) -> object:
    """Equal within a relative tolerance alone.

    The absolute one that `pytest.approx` adds, 1e-12, is more than many a value in SI units.
    """
    return pytest.approx(expected, rel=rel, abs=0.0)


def refusal(**changes: object) -> str:
    """Why a steel sphere with these changes is no case."""
    with pytest.raises(CaseError) as caught:
        steel(**changes)
    return str(caught.value)


def base(**changes: object) -> dict[str, object]:
    """The steel sphere as the base of a study, smooth and elastic; None removes a key."""
    parameters = {**STEEL, "plastic_limit": "none", "roughness": "none"} | changes
    return {name: value for name, value in parameters.items() if value is not None}


def write_study(file: Path, content: object) -> Path:
    """Write a study file, of a text or of its content."""
    file.parent.mkdir(parents=True, exist_ok=True)
    text = content if isinstance(content, str) else yaml.safe_dump(content, sort_keys=False)
    file.write_text(text, encoding="utf-8")
    return file


def printed(*command: object, folder: Path | None = None, **environment: str) -> str:
    """What a command prints; it must succeed."""
    done = subprocess.run(
        [*map(str, command)],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    return done.stdout


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


computed = cache(run)
"""Results of a case, which some studies share."""


def run_study(study: Study, folder: Path, case_ids: Iterable[str] | None = None) -> Path:
    """Run the cases of a study, or some of them, and merge them into a folder of results."""
    for case_id in study.cases() if case_ids is None else case_ids:
        result = computed(study.cases()[case_id])
        write_case(result.dataset, result.history, folder / "cases" / f"{case_id}.nc", result.loops)
    merge_study(study, folder / "cases", folder / "summary.nc")
    return folder


def sampled(unit: np.ndarray, volume: np.ndarray) -> xr.Dataset:
    """Return a merged study of points of the unit cube, as the report reads it."""
    names = ("load", "friction", "radius")[: unit.shape[1]]
    along = {"drawn_from": 0.0, "drawn_to": 1.0, "drawn_on": "linear"}
    return xr.Dataset(
        {
            "status": ("point", np.zeros(len(unit), dtype="int8")),
            "wear_volume": (("point", "cycle"), np.stack([0 * volume, volume], axis=1)),
        },
        {
            "case_id": ("point", [f"case {place}" for place in range(len(unit))]),
            "cycle": [0.0, 100.0],
            **{name: ("point", u, along) for name, u in zip(names, unit.T, strict=True)},
        },
    )
