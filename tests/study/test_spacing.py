import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretwear.study.case import Case

STEEL = {
    "radius": 0.01,
    "youngs_modulus": 208e9,
    "poisson_ratio": 0.3,
    "load": 50.0,
    "friction": 0.5,
    "wear_coefficient": 7e-13,
    "cycles": 1000,
}


def test_the_waves_of_the_study_get_an_anisotropic_grid():
    waves = {"amplitude": "0.2 um", "slope_x": "5.7 deg", "slope_y": "1 deg"}
    case = Case(**STEEL, tangential_ratio=0.8, roughness=waves)
    assert case.grid_spacing == (0.5e-6, 2.3e-6)


def test_a_smooth_contact_gets_a_square_grid():
    dx, dy = Case(**STEEL, tangential_ratio=0.8).grid_spacing
    assert dx == dy


@given(
    st.floats(0.02, 0.98),
    st.floats(1e-8, 1e-6),
    st.one_of(st.just(0.0), st.floats(1e-30, 0.5)),
    st.floats(0.001, 0.5),
)
def test_the_default_resolves_contact_zones_and_waves(ratio, amplitude, slope_x, slope_y):
    waves = {"amplitude": amplitude, "slope_x": slope_x, "slope_y": slope_y}
    case = Case(**STEEL, tangential_ratio=ratio, roughness=waves)
    dx, dy = case.grid_spacing
    assert dx <= case.roughness.wavelength_x / 16
    assert dy <= case.roughness.wavelength_y / 16
    for spacing in (dx, dy):
        assert spacing <= case.hertz_radius / 64
        assert spacing <= case.stick_radius / 8
        assert spacing <= (case.hertz_radius - case.stick_radius) / 4
    # The default passes the rules that a given spacing has to pass.
    assert case.replace(cell=(dx, dy)).cell == (dx, dy)


@given(st.floats(1e-2, 1e2))
def test_the_default_is_hardly_finer_than_it_must_be(load):
    case = Case(**{**STEEL, "load": load}, tangential_ratio=0.8)
    needed = case.hertz_radius / 64
    assert 0.9 * needed < case.grid_spacing[0] <= needed


def test_the_default_has_two_digits():
    spacing = Case(**STEEL, tangential_ratio=0.8).grid_spacing[0]
    assert spacing == float(f"{spacing:.1e}")
    assert not math.isclose(spacing, 148.6e-6 / 64, rel_tol=1e-6)
    assert spacing == pytest.approx(2.3e-6)
