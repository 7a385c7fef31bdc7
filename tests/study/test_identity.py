import math
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ..studies import WAVES, steel


def study_case(**changes):
    given = {"plastic_limit": "4500 MPa", "roughness": WAVES, "cycles": 30000}
    return steel(**{"tangential_load": "20 N", **given, "cell": ["0.5 um", "2 um"], **changes})


def test_the_id_of_a_case_says_its_main_parameters_and_stays_what_it_is():
    assert study_case().case_id == "P50N-Q20N-mu0.5-A0.2um-Y4500MPa-N30000-610518fc"
    plain = study_case(roughness=None, plastic_limit="none", cycles=7000)
    assert plain.case_id.startswith("P50N-Q20N-mu0.5-smooth-elastic-N7000-")


def test_the_same_case_said_otherwise_has_the_same_id():
    other_units = study_case(
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
    assert other_units.case_id == study_case(output_cycles=[10, 100]).case_id
    assert other_units.case_id == study_case().case_id
    # 0.8·0.5·50 is not 20 to the last bit in every order of multiplication.
    for load in (20, 30, 50, 70):
        by_ratio = study_case(load=load, tangential_load=None, tangential_ratio=0.7)
        assert by_ratio.case_id == study_case(load=load, tangential_load=0.35 * load).case_id
    flat = {"amplitude": 0, "slope_x": "1 deg", "slope_y": "1 deg"}
    assert study_case(roughness=flat).case_id == study_case(roughness=None).case_id
    by_default = study_case(cell=None)
    assert study_case(cell=by_default.grid_spacing).case_id == by_default.case_id
    zeros = {steel(poisson_ratio=zero).case_id for zero in (0, 0.0, -0.0)}
    assert len(zeros) == 1


@settings(max_examples=settings.default.max_examples // 4)
@given(
    st.floats(1e-3, 100.0),
    st.floats(0.01, 2.0),
    st.floats(0.01, 0.99),
    st.one_of(st.just(math.inf), st.floats(1e8, 1e12)),
)
def test_ids_are_safe_in_paths_and_shells(load, friction, ratio, limit):
    case = study_case(
        load=load,
        friction=friction,
        tangential_load=None,
        tangential_ratio=ratio,
        plastic_limit=limit,
        cell=None,
    )
    assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{1,100}", case.case_id)


def test_coordinates_are_in_si_units_and_complete():
    coordinates = study_case().scalar_coordinates()
    assert coordinates["load"] == (50.0, "N", "normal load")
    assert coordinates["plastic_limit"][:2] == (4.5e9, "Pa")
    assert coordinates["roughness_amplitude"][:2] == (2e-7, "m")
    assert coordinates["roughness_slope_x"][:2] == (math.radians(5.7), "rad")
    assert coordinates["tangential_load"][0] == 20.0
    assert coordinates["tangential_ratio"][0] == pytest.approx(0.8)
    assert (coordinates["cell_x"][0], coordinates["cell_y"][0]) == (5e-7, 2e-6)
    assert coordinates["hertz_radius"][0] == study_case().hertz_radius
    assert coordinates["slip_model"][0] == "jaeger"
    smooth = study_case(roughness=None, plastic_limit="none").scalar_coordinates()
    names = ("roughness_amplitude", "roughness_slope_x", "roughness_slope_y")
    assert [smooth[name][0] for name in ("plastic_limit", *names)] == [math.inf, 0.0, 0.0, 0.0]
