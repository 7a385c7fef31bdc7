"""The contacts of the table, taken from the source study."""

from typing import Any

from fretwear import Case

STUDY: dict[str, Any] = {
    "radius": "10 mm",
    "youngs_modulus": "208 GPa",
    "poisson_ratio": 0.3,
    "load": "50 N",
    "tangential_load": "20 N",
    "friction": 0.5,
    "wear_coefficient": "7e-13 / Pa",
    "cycles": 30000,
}
SELF_AFFINE = {
    "kind": "self_affine", "rms_height": "0.1 um", "hurst": 0.8, "rolloff_wavelength": "60 um",
    "shortest_wavelength": "8 um", "seed": 1,
}  # fmt: skip
WAVES = {"kind": "wavy", "amplitude": "0.2 um", "slope_x": "5.7 deg", "slope_y": "1 deg"}


def study_case(**changes: Any) -> Case:
    """The study's case with some parameters changed."""
    return Case(**{**STUDY, **changes})
