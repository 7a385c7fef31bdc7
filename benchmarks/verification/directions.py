"""Slip by friction along x, `cerruti`, against friction as a vector, `coupled`."""

from typing import Any

import numpy as np
from benchmarks.pages import Check, Data, Section, table

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
        "cycles": 1000, "output_cycles": [0, 300, 1000],
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
LARGEST = {"slip": 0.01, "wear": 0.007, "depth": 0.007, "volume": 0.005, "energy": 0.01}
USUAL_POISSON = 0.3


def measured(changes: dict[str, Any]) -> Data:
    """The largest differences over the snapshots."""
    case = Case(**{**CONTACT, **changes})
    one, both = (
        simulate(case.replace(slip_model=model), quarter=True) for model in ("cerruti", "coupled")
    )
    touches = both.pressure > 0.0

    def field(name: str) -> float:
        missed, size = np.abs(one[name] - both[name]), both[name]
        shares = missed.where(touches, 0.0).sum(("x", "y")) / size.where(touches).sum(("x", "y"))
        return float(shares[1:].max())

    def apart(name: str) -> float:
        return float(np.abs(one[name] / both[name] - 1.0)[1:].max())

    missed = np.abs(one.dissipated_energy - both.dissipated_energy)
    return {
        "poisson": changes["poisson_ratio"],
        "slip": field("slip"),
        "wear": field("wear_depth"),
        "depth": apart("maximum_wear_depth"),
        "volume": apart("wear_volume"),
        "energy": float(missed.max() / both.dissipated_energy.max()),
    }


def run() -> Data:
    found = {}
    for name, changes in CASES.items():
        found[name] = measured(changes)
        print(name, found[name], flush=True)
    return found


def checks(data: Data) -> list[Check]:
    usual = [row for row in data.values() if row["poisson"] <= USUAL_POISSON]
    return [
        Check(f"{what} by `cerruti` against `coupled`", max(row[what] for row in usual), most)
        for what, most in LARGEST.items()
    ]


def text(data: Data) -> str:
    rows = [[name, *(f"{row[what]:.2%}" for what in LARGEST)] for name, row in data.items()]
    return f"""\
`cerruti` leaves out traction across the direction of motion. Largest differences from `coupled` on the same cells, over
{CONTACT["output_cycles"][1]} to {CONTACT["cycles"]} cycles: slip and wear depth as ∫|Δs| / ∫s, energy relative to its largest value. In single
cells beside the edge of stick, where it has an infinite slope at last, slip differs by several per cent.

{table(["", "slip", "wear depth", "deepest wear", "volume", "energy"], rows)}
"""


SECTION = Section("directions", "Friction along x against friction as a vector", run, text, checks)
