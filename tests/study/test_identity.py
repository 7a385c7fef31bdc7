import json
import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretwear.study.case import Case

STEEL = {
    "radius": "10 mm",
    "youngs_modulus": "208 GPa",
    "poisson_ratio": 0.3,
    "load": "50 N",
    "tangential_load": "20 N",
    "friction": 0.5,
    "wear_coefficient": "7e-13 / Pa",
    "plastic_limit": "4500 MPa",
    "roughness": {"amplitude": "0.2 um", "slope_x": "5.7 deg", "slope_y": "1 deg"},
    "cycles": 30000,
    "cell": ["0.5 um", "2 um"],
}


def steel(**changes):
    return Case(**{**STEEL, **changes})


def test_the_id_of_a_case_stays_what_it_is():
    assert steel().case_id == "P50N-Q20N-mu0.5-A0.2um-Y4500MPa-N30000-610518fc"


def test_the_id_says_the_main_parameters():
    assert steel().case_id.startswith("P50N-Q20N-mu0.5-A0.2um-Y4500MPa-N30000-")
    plain = steel(roughness=None, plastic_limit="none", cycles=7000)
    assert plain.case_id.startswith("P50N-Q20N-mu0.5-smooth-elastic-N7000-")


def test_other_units_give_the_same_id():
    other = steel(
        radius="1 cm",
        youngs_modulus=208e9,
        load="0.05 kN",
        wear_coefficient="7e-13 m^2/N",
        plastic_limit="4.5 GPa",
        roughness={
            "amplitude": "200 nm",
            "slope_x": math.radians(5.7),
            "slope_y": f"{math.radians(1.0)} rad",
        },
        cell=[5e-7, "0.002 mm"],
    )
    assert other.case_id == steel().case_id


def test_a_ratio_that_comes_to_the_same_load_gives_the_same_id():
    # 0.8·0.5·50 is not 20 to the last bit in every order of multiplication.
    for load in (20, 30, 50, 70):
        by_ratio = steel(load=load, tangential_load=None, tangential_ratio=0.7)
        by_load = steel(load=load, tangential_load=0.35 * load)
        assert by_ratio.case_id == by_load.case_id


def test_elastic_smooth_and_other_materials_are_other_cases():
    others = (
        {"youngs_modulus": ["208 GPa", "209 GPa"]},
        {"plastic_limit": "none"},
        {"roughness": None},
        {"slip_model": "cattaneo_mindlin"},
    )
    assert len({steel().case_id, *(steel(**change).case_id for change in others)}) == 5


def test_snapshots_are_no_part_of_the_id():
    assert steel(output_cycles=[10, 100]).case_id == steel().case_id


def test_slopes_of_a_smooth_surface_are_no_part_of_the_id():
    flat = {"amplitude": 0, "slope_x": "1 deg", "slope_y": "1 deg"}
    assert steel(roughness=flat).case_id == steel(roughness=None).case_id


def test_naming_the_default_spacing_changes_nothing():
    by_default = steel(cell=None)
    assert steel(cell=by_default.grid_spacing).case_id == by_default.case_id


def test_parameters_survive_json_and_make_the_case_again():
    for case in (steel(), steel(roughness=None, plastic_limit="none", cell=None)):
        parameters = json.loads(json.dumps(case.canonical_parameters(), allow_nan=False))
        again = Case(**parameters)
        assert again.canonical_parameters() == case.canonical_parameters()
        assert again.case_id == case.case_id


@given(
    st.floats(1e-3, 100.0),
    st.floats(0.01, 2.0),
    st.floats(0.01, 0.99),
    st.one_of(st.just(math.inf), st.floats(1e8, 1e12)),
)
def test_ids_are_safe_in_paths_and_shells(load, friction, ratio, limit):
    case = steel(
        load=load,
        friction=friction,
        tangential_load=None,
        tangential_ratio=ratio,
        plastic_limit=limit,
        cell=None,
    )
    assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{1,100}", case.case_id)


def test_coordinates_are_in_si_units_and_complete():
    coordinates = steel().scalar_coordinates()
    assert coordinates["load"] == (50.0, "N", "normal load")
    assert coordinates["plastic_limit"][:2] == (4.5e9, "Pa")
    assert coordinates["roughness_amplitude"][:2] == (2e-7, "m")
    assert coordinates["roughness_slope_x"][:2] == (math.radians(5.7), "rad")
    assert coordinates["tangential_load"][0] == 20.0
    assert coordinates["tangential_ratio"][0] == pytest.approx(0.8)
    assert (coordinates["cell_x"][0], coordinates["cell_y"][0]) == (5e-7, 2e-6)
    assert coordinates["hertz_radius"][0] == steel().hertz_radius
    assert coordinates["slip_model"][0] == "jaeger"


def test_coordinates_of_a_smooth_elastic_case():
    coordinates = steel(roughness=None, plastic_limit="none").scalar_coordinates()
    assert coordinates["plastic_limit"][0] == math.inf
    names = ("roughness_amplitude", "roughness_slope_x", "roughness_slope_y")
    assert [coordinates[name][0] for name in names] == [0.0, 0.0, 0.0]


def test_two_materials_have_a_coordinate_each():
    coordinates = steel(youngs_modulus=["208 GPa", "70 GPa"]).scalar_coordinates()
    assert "youngs_modulus" not in coordinates
    assert coordinates["youngs_modulus_1"][0] == 208e9
    assert coordinates["youngs_modulus_2"][0] == 70e9
    assert coordinates["poisson_ratio"][0] == 0.3
