"""What makes a case the same case: canonical parameters, id and dataset coordinates.

Two cases with the same physics have the same id, however they were written: units are gone,
numbers count to twelve digits, Q/(µP) and Q are one thing, a pair of equal values is one value,
a zero amplitude is smooth, and the default spacing is the spacing it comes to.
"""

from __future__ import annotations

import hashlib
import json
import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fretwear.study.case import Case

_SIGNIFICANT_DIGITS = 12


def canonical_parameters(case: Case) -> dict[str, Any]:
    """Return every parameter but the snapshots in SI units, in a form that JSON can hold.

    Full precision; infinity is the word ``none``.  `Case` accepts the result as keywords.
    """
    rough = case.roughness
    return {
        "radius": case.radius,
        "youngs_modulus": list(case.youngs_modulus_pair),
        "poisson_ratio": list(case.poisson_ratio_pair),
        "load": case.load,
        "tangential_load": case.tangential_force,
        "friction": case.friction,
        "wear_coefficient": case.wear_coefficient,
        "plastic_limit": "none" if math.isinf(case.plastic_limit) else case.plastic_limit,
        "roughness": None if rough is None else rough.model_dump(),
        "cycles": case.cycles,
        "cell": list(case.grid_spacing),
        "tolerance": case.tolerance,
        "slip_model": case.slip_model,
    }


def case_id(case: Case) -> str:
    """Return ``<slug>-<hash>``: main parameters for people, eight digits of a hash of all.

    The characters are letters, digits, ``.``, ``-`` and ``_``, safe in paths and shells.
    """
    rounded = _rounded(canonical_parameters(case))
    text = json.dumps(rounded, sort_keys=True, separators=(",", ":"))
    return f"{_slug(case)}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def _slug(case: Case) -> str:
    rough, capped = case.roughness, not math.isinf(case.plastic_limit)
    parts = (
        f"P{_short(case.load)}N",
        f"Q{_short(case.tangential_force)}N",
        f"mu{_short(case.friction)}",
        f"A{_short(rough.amplitude * 1e6)}um" if rough is not None else "smooth",
        f"Y{_short(case.plastic_limit * 1e-6)}MPa" if capped else "elastic",
        f"N{case.cycles}",
    )
    return "-".join(parts)


def _short(number: float) -> str:
    return f"{number:.4g}".replace("+", "")


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.{_SIGNIFICANT_DIGITS - 1}e}")
    return value


def scalar_coordinates(case: Case) -> dict[str, tuple[float | str, str, str]]:
    """Return every parameter as a scalar coordinate of a dataset.

    Returns
    -------
    dict
        Name → (value in SI units, units in UDUNITS notation, long name).  An elastic case has a
        `plastic_limit` of inf, a smooth one zero amplitude and slopes.  Materials that differ
        between the bodies appear as ``youngs_modulus_1``, ``youngs_modulus_2`` and so on.
    """
    rough = case.roughness
    cell_x, cell_y = case.grid_spacing
    moduli = _per_body("youngs_modulus", case.youngs_modulus_pair, "Pa", "Young's modulus")
    ratios = _per_body("poisson_ratio", case.poisson_ratio_pair, "1", "Poisson's ratio")
    slopes = (rough.slope_x, rough.slope_y) if rough is not None else (0.0, 0.0)
    return {
        "radius": (case.radius, "m", "sphere radius"),
        **moduli,
        **ratios,
        "load": (case.load, "N", "normal load P"),
        "tangential_ratio": (case.load_ratio, "1", "tangential load ratio Q/(µP)"),
        "tangential_load": (case.tangential_force, "N", "tangential load amplitude Q"),
        "friction": (case.friction, "1", "coefficient of friction"),
        "wear_coefficient": (case.wear_coefficient, "Pa-1", "Archard wear coefficient"),
        "plastic_limit": (case.plastic_limit, "Pa", "plastic limit of the pressure"),
        "roughness_amplitude": (rough.amplitude if rough else 0.0, "m", "roughness amplitude"),
        "roughness_slope_x": (slopes[0], "rad", "mean slope of the roughness along x"),
        "roughness_slope_y": (slopes[1], "rad", "mean slope of the roughness along y"),
        "cycles": (case.cycles, "1", "number of cycles"),
        "cell_x": (cell_x, "m", "grid spacing along x"),
        "cell_y": (cell_y, "m", "grid spacing along y"),
        "tolerance": (case.tolerance, "1", "relative tolerance of the wear integration"),
        "slip_model": (case.slip_model, "", "slip model"),
        "hertz_radius": (case.hertz_radius, "m", "Hertz contact radius"),
        "hertz_pressure": (case.hertz_pressure, "Pa", "Hertz peak pressure"),
    }


def _per_body(
    name: str, pair: tuple[float, float], units: str, long_name: str
) -> dict[str, tuple[float | str, str, str]]:
    if pair[0] == pair[1]:
        return {name: (pair[0], units, long_name)}
    return {
        f"{name}_{body}": (value, units, f"{long_name} of body {numeral}")
        for body, numeral, value in zip((1, 2), ("I", "II"), pair, strict=True)
    }
