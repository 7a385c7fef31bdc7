"""The parameters of the source study."""

from __future__ import annotations

import math
from collections.abc import Mapping

PLASTIC_LIMIT = 4500e6
"""Plastic limit of the study, Pa."""
SHARED = {
    "normal_load": 50.0,
    "tangential_load": 20.0,
    "friction": 0.5,
    "youngs_modulus": 208e9,
    "poisson_ratio": 0.3,
    "wear_coefficient": 7e-13,
    "junction_growth": 0.0,
}
"""Parameters of all four cases, SI units."""
ROUGH = {
    "roughness_amplitude": 0.2e-6,
    "roughness_slope_x": math.radians(5.7),
    "roughness_slope_y": math.radians(1.0),
}
"""Waves of the rough cases, m and rad."""

_SURFACES = {"smooth": {"roughness_amplitude": 0.0}, "rough": ROUGH}
_CASES = {
    f"{surface} {body}": {**SHARED, **waves, "plastic_limit": limit}
    for body, limit in (("elastic", math.inf), ("plastic", PLASTIC_LIMIT))
    for surface, waves in _SURFACES.items()
}
TITLES = tuple(_CASES)
"""The titles of the four cases of the study: smooth and rough, elastic, then plastic."""


def title_of(values: Mapping[str, object]) -> str:
    """Return which of `TITLES` a point with these parameters is; empty if it is none."""

    def near(expected: Mapping[str, float]) -> bool:
        # Text never matches.
        return all(
            isinstance(value := values.get(name), float | int)
            and math.isclose(value, number, rel_tol=1e-6)
            for name, number in expected.items()
        )

    return next((title for title, expected in _CASES.items() if near(expected)), "")
