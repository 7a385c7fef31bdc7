"""Slip by friction along x, `cerruti`, against friction as a vector, `coupled`."""

from typing import Any

import numpy as np
from benchmarks.pages import Data, Section, named
from numpy.typing import NDArray

from fretwear import Case, simulate

CONTACT: dict[str, Any] = {
    "radius": "10 mm", "youngs_modulus": "208 GPa", "load": "30 N", "friction": 0.5,
    "wear_coefficient": 7e-13, "cycles": 10_000, "output_cycles": [0, 300, 1000, 3000, 10_000],
    "cell": "4 um", "tolerance": 1e-3, "error_estimate": False,
}  # fmt: skip
WAVES = {"kind": "wavy", "amplitude": "0.2 um", "slope_x": "1 deg", "slope_y": "0.7 deg"}
RANDOM = {
    "kind": "self_affine", "rms_height": "0.15 um", "hurst": 0.8, "rolloff_wavelength": "150 um",
    "shortest_wavelength": "40 um", "seed": 3,
}  # fmt: skip
CASES: dict[str, dict[str, Any]] = {
    "smooth, ν = 0.2, X = 0.5": {"poisson_ratio": 0.2, "tangential_ratio": 0.5},
    "smooth, ν = 0.3, X = 0.3": {"poisson_ratio": 0.3, "tangential_ratio": 0.3},
    "smooth, ν = 0.3, X = 0.85": {"poisson_ratio": 0.3, "tangential_ratio": 0.85},
    "smooth, ν = 0.45, X = 0.6": {"poisson_ratio": 0.45, "tangential_ratio": 0.6},
    "smooth, 2000 MPa, ν = 0.3, X = 0.5": {
        "poisson_ratio": 0.3, "tangential_ratio": 0.5, "plastic_limit": "2000 MPa",
        "cycles": 1000, "output_cycles": [0, 300, 600, 1000],
    },
    "wavy, ν = 0.2, X = 0.8": {
        "poisson_ratio": 0.2, "tangential_ratio": 0.8, "roughness": WAVES,
    },
    "wavy, ν = 0.3, X = 0.6": {
        "poisson_ratio": 0.3, "tangential_ratio": 0.6, "roughness": WAVES,
    },
    "wavy, 3000 MPa, ν = 0.3, X = 0.8": {
        "poisson_ratio": 0.3, "tangential_ratio": 0.8, "roughness": WAVES,
        "plastic_limit": "3000 MPa",
    },
    "wavy, 3000 MPa, ν = 0.45, X = 0.7": {
        "poisson_ratio": 0.45, "tangential_ratio": 0.7, "roughness": WAVES,
        "plastic_limit": "3000 MPa",
    },
    "self-affine, ν = 0.3, X = 0.6": {
        "poisson_ratio": 0.3, "tangential_ratio": 0.6, "roughness": RANDOM,
    },
    "wavy, U = 0.7 U_t, ν = 0.3": {
        "poisson_ratio": 0.3, "displacement_ratio": 0.7, "roughness": WAVES,
    },
    "wavy, rig of 10 N/µm, ν = 0.3": {
        "poisson_ratio": 0.3, "displacement_amplitude": "1.5 um", "rig_stiffness": "10 N/um",
        "roughness": WAVES,
    },
}  # fmt: skip


def measured(changes: dict[str, Any]) -> Data:
    """The largest differences over the snapshots but the last one, and those at the last."""
    case = Case(**{**CONTACT, **changes})
    one, both = (
        simulate(case.replace(slip_model=model), quarter=True) for model in ("cerruti", "coupled")
    )
    touches = both.pressure > 0.0

    def field(name: str) -> NDArray[np.float64]:
        missed, size = np.abs(one[name] - both[name]), both[name]
        shares = missed.where(touches, 0.0).sum(("x", "y")) / size.where(touches).sum(("x", "y"))
        return np.asarray(shares[1:])

    def apart(name: str) -> NDArray[np.float64]:
        return np.asarray(np.abs(one[name] / both[name] - 1.0)[1:])

    missed = np.abs(one.dissipated_energy - both.dissipated_energy)[1:]
    found = {
        "slip": field("slip"),
        "wear": field("wear_depth"),
        "depth": apart("maximum_wear_depth"),
        "volume": apart("wear_volume"),
        "energy": np.asarray(missed / both.dissipated_energy.max()),
    }
    late = {f"late_{name}": float(found[name][-1]) for name in ("volume", "energy")}
    return {name: float(values[:-1].max()) for name, values in found.items()} | late


def run() -> Data:
    found = {}
    for name, changes in CASES.items():
        found[name] = measured(changes)
        print(name, found[name], flush=True)
    return found


def rows(data: Data) -> list[list[str]]:
    def largest(*names: str) -> str:
        return named({
            name.rpartition("_")[2]: max(row[name] for row in data.values()) for name in names
        })  # fmt: skip

    *_, earlier, last = CONTACT["output_cycles"]
    against = "`coupled`, same cells"
    return [
        [f"`cerruti` to cycle {earlier}, ν ≤ 0.45", against, largest("slip", "volume", "energy")],
        [f"`cerruti` at cycle {last}", against, largest("late_volume", "late_energy")],
    ]


SECTION = Section("directions", "Friction along x against friction as a vector", run)
