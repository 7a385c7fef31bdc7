"""Which way results go when one parameter grows: a line for each parameter and result."""

import pytest

from fretwear.study.case import Case

from ..studies import STEEL, computed, line_contact

# Cheap runs: a tendency is far larger than their error.
_COARSE = {"accuracy": "none", "error_estimate": False, "tolerance": 0.05, "output_cycles": []}
_WEAR = {"poisson_ratio": 0.3, "friction": 0.5, "wear_coefficient": "7e-13 / Pa", "cycles": 300}
SPHERE = {**STEEL, **_WEAR, "slip_model": "jaeger"}
ROUGH = {**STEEL, **_WEAR, "cell": "5 um", "cycles": 1}
CYLINDER = {**SPHERE, **line_contact("10 mm", "20 N/mm")}
FORCE = {"tangential_ratio": None, "tangential_load": "12 N"}
DISPLACED = {**SPHERE, "tangential_ratio": None, "displacement_amplitude": "1 um"}
YIELDING = {**SPHERE, "plastic_limit": "800 MPa", "cycles": 1}
HELD = {**SPHERE, "load": None, "indentation": "2 um"}
STROKE = {
    **CYLINDER,
    "tangential_ratio": None,
    "sliding_amplitude": "60 um",
    "wear_coefficient": ["3e-13 / Pa", "4e-13 / Pa"],
    "cell": "8 um",
    "cycles": 10,
}


def _waves(slope):
    return {"kind": "wavy", "amplitude": "0.2 um", "slope_x": slope, "slope_y": "0.5 deg"}


def _ellipsoid(radius_x):
    return {"kind": "ellipsoid", "radius_x": radius_x, "radius_y": "10 mm"}


GROWS, FALLS = 1, -1
TENDENCIES = [
    # (contact, parameter, lesser value, larger value, cycle, result, direction)
    (SPHERE, "load", "30 N", "60 N", 0, "contact_radius", GROWS),
    (SPHERE, "load", "30 N", "60 N", -1, "wear_volume", GROWS),
    (SPHERE, "load", "30 N", "60 N", 0, "approach", GROWS),
    (CYLINDER, "load", "15 N/mm", "30 N/mm", 0, "contact_half_width_x", GROWS),
    (HELD, "indentation", "1.5 um", "2 um", 0, "normal_force", GROWS),
    (SPHERE, "radius", "5 mm", "10 mm", 0, "contact_radius", GROWS),
    (SPHERE, "radius", "5 mm", "10 mm", 0, "peak_pressure", FALLS),
    (SPHERE, "youngs_modulus", "100 GPa", "208 GPa", 0, "contact_radius", FALLS),
    (SPHERE, "youngs_modulus", "100 GPa", "208 GPa", 0, "dissipated_energy", FALLS),
    (SPHERE, "youngs_modulus", "100 GPa", "208 GPa", -1, "wear_volume", FALLS),
    (SPHERE, "poisson_ratio", 0.1, 0.4, 0, "tangential_displacement", GROWS),
    (SPHERE | FORCE, "friction", 0.3, 0.6, 0, "stick_radius", GROWS),
    (SPHERE | FORCE, "friction", 0.3, 0.6, 0, "dissipated_energy", FALLS),
    (SPHERE, "friction", 0.3, 0.6, -1, "wear_volume", GROWS),
    (SPHERE, "tangential_ratio", 0.4, 0.8, 0, "stick_radius", FALLS),
    (SPHERE, "tangential_ratio", 0.4, 0.8, 0, "tangential_displacement", GROWS),
    (SPHERE, "tangential_ratio", 0.4, 0.8, 0, "dissipated_energy", GROWS),
    (SPHERE, "tangential_ratio", 0.4, 0.8, -1, "maximum_wear_depth", GROWS),
    (DISPLACED, "displacement_amplitude", "0.5 um", "1 um", 0, "tangential_force", GROWS),
    (DISPLACED, "displacement_amplitude", "0.5 um", "1 um", 0, "sliding_ratio", GROWS),
    (DISPLACED, "rig_stiffness", "20 N/um", "60 N/um", 0, "tangential_force", GROWS),
    (SPHERE, "wear_coefficient", "3e-13 / Pa", "7e-13 / Pa", -1, "wear_volume", GROWS),
    (SPHERE, "wear_coefficient", "3e-13 / Pa", "7e-13 / Pa", -1, "contact_radius", GROWS),
    (SPHERE, "wear_coefficient", "3e-13 / Pa", "7e-13 / Pa", -1, "stick_load_share", GROWS),
    (SPHERE, "cycles", 100, 300, -1, "scar_half_width_x", GROWS),
    (SPHERE, "debris_fraction", 0.0, 0.8, -1, "contact_radius", FALLS),
    (SPHERE, "debris_fraction", 0.0, 0.8, -1, "stick_load_share", FALLS),
    (SPHERE, "wear_threshold", "0 mJ/mm^2", "0.02 mJ/mm^2", -1, "wear_volume", FALLS),
    (YIELDING, "plastic_limit", "700 MPa", "900 MPa", 0, "plastic_volume", FALLS),
    (YIELDING, "plastic_limit", "700 MPa", "900 MPa", 0, "contact_area", FALLS),
    (YIELDING, "junction_growth", 0.0, 4.0, 0, "plastic_volume", GROWS),
    (ROUGH, "roughness", _waves("0.5 deg"), _waves("1 deg"), 0, "contact_area", FALLS),
    (ROUGH, "roughness", _waves("0.5 deg"), _waves("1 deg"), 0, "peak_pressure", GROWS),
    (ROUGH | {"radius": None}, "indenter", *map(_ellipsoid, ("8 mm", "12 mm")), 0,
     "contact_half_width_x", GROWS),
    (CYLINDER, "bulk_stress", "0 MPa", "20 MPa", 0, "dissipated_energy", GROWS),
    (STROKE, "sliding_amplitude", "30 um", "60 um", -1, "wear_volume", GROWS),
    (STROKE, "sliding_amplitude", "30 um", "60 um", -1, "scar_half_width_x", GROWS),
]  # fmt: skip


def _result(contact, parameter, value, cycle, result):
    keys = {**contact, **_COARSE, parameter: value}
    case = Case(**{name: one for name, one in keys.items() if one is not None})
    return float(computed(case).dataset[result][cycle])


@pytest.mark.parametrize(
    ("contact", "parameter", "lesser", "larger", "cycle", "result", "direction"),
    TENDENCIES,
    ids=[f"{row[1]}-{row[5]}" for row in TENDENCIES],
)
def test_a_result_goes_the_way_of_the_mechanics(
    contact, parameter, lesser, larger, cycle, result, direction
):
    first, last = (_result(contact, parameter, one, cycle, result) for one in (lesser, larger))
    assert direction * (last - first) > 0.01 * max(abs(first), abs(last))
