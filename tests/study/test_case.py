"""A case: what it takes, what it refuses and what would do instead, its default grid."""

import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fretwear.mechanics.surfaces.roughness import WavyRoughness
from fretwear.study.case import Case, CaseError
from fretwear.study.case_warnings import case_warnings
from fretwear.study.discretisation import rounded_down

from ..studies import WAVES, line_contact, near, refusal, steel

# Waves much longer than a slip annulus.
FALLING = {"slow": 4e-13, "fast": 1e-13, "decay": 11e-6, "frequency": 10.0}
# As a dataset has it: without the file itself.
MEASURED = {"kind": "measured", "file": f"disc.x3p sha256:{64 * 'a'}", "body": "flat"}
WAVY = {name: value for name, value in WAVES.items() if name != "kind"}


def test_text_with_units_and_si_numbers_make_the_same_case():
    keys = {"radius": 0.01, "youngs_modulus": 208e9, "poisson_ratio": 0.3, "load": 50}
    keys |= {"tangential_load": np.float32(20.0), "friction": np.float64(0.5)}
    numbers = Case(**keys, wear_coefficient=7e-13, cycles=np.int64(30000))
    assert numbers == steel(tangential_load="20 N", cycles=30000, output_cycles=None)
    assert (type(numbers.load), type(numbers.cycles)) == (float, int)
    with pytest.raises(FrozenInstanceError):
        numbers.load = 3.0


def test_composite_moduli_and_hertz_values_of_one_material_and_of_two():
    reference = steel()
    assert reference.composite_modulus == near(208e9 / (2 * (1 - 0.09)))
    assert reference.hertz_radius == near(148.6e-6, rel=1e-4)
    assert reference.hertz_pressure == near(1081e6, rel=1e-3)
    assert reference.hertz.approach == near(2.208e-6, rel=1e-3)
    assert reference.coupling == near((2 - 0.3) / (2 * (1 - 0.3)))
    case = steel(youngs_modulus=["208 GPa", "70 GPa"], poisson_ratio=[0.3, 0.33])
    compliance = (1 - 0.3**2) / 208e9 + (1 - 0.33**2) / 70e9
    shear = (2 - 0.3) / (4 * 208e9 / 2.6) + (2 - 0.33) / (4 * 70e9 / 2.66)
    assert case.composite_modulus == near(1 / compliance)
    assert case.composite_modulus / case.coupling == near(1 / shear)


def test_tangential_load_and_ratio_are_two_names_for_one_thing():
    by_ratio, by_load = steel(), steel(tangential_load="20 N")
    assert by_ratio.tangential_load == near(by_load.tangential_load)
    assert by_ratio.tangential_ratio == near(by_load.tangential_ratio)
    assert by_ratio.stick_load == near(50 - 20 / 0.5)
    assert by_ratio.stick_radius / by_ratio.hertz_radius == near(0.2 ** (1 / 3))


def test_waves_have_the_lengths_of_the_study_and_without_amplitude_are_none():
    rough = WavyRoughness(**WAVY)
    assert rough.finest[0] == near(4 * 0.2e-6 / math.tan(math.radians(5.7)))
    assert rough.finest[1] == near(45.8e-6, rel=0.01)
    assert rough.wavenumbers[0] * rough.finest[0] == near(2 * math.pi)
    ridges = WavyRoughness(**{**WAVY, "slope_y": 0.0})
    assert (ridges.wavenumbers[1], ridges.finest[1]) == (0.0, math.inf)
    assert WavyRoughness(**{**WAVY, "amplitude": "0 um"}).finest[0] == math.inf
    with pytest.raises(ValueError, match="slope larger than zero"):
        WavyRoughness(amplitude=1e-7, slope_x=0.0, slope_y=0.0)
    words = [{"roughness": "none"}, {"roughness": {**WAVES, "amplitude": 0.0}}]
    words += [{"plastic_limit": "none"}, {"plastic_limit": math.inf}]
    assert all(steel(**word) == steel() for word in words)


@pytest.mark.parametrize(
    ("cycles", "asked", "snapshots"),
    [
        (1, None, (0, 1)),
        (1000, None, (0, 1, 3, 10, 30, 100, 300, 1000)),
        (30000, None, (0, 1, 10, 100, 1000, 3000, 10000, 30000)),
        (10**6, "auto", (0, *(10**n for n in range(7)))),
        (1000, [700, 100, 700], (0, 100, 700, 1000)),
    ],
)
def test_snapshots_are_those_asked_for_or_even_in_the_logarithm(cycles, asked, snapshots):
    assert steel(cycles=cycles, output_cycles=asked).output_cycles == snapshots


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        (
            {"tangential_load": "15 N", "friction": {"cycles": [0, 9], "values": [0.5, 0.2]}},
            ["gross sliding: Q must be less than µP = 10 N"],
        ),
        (
            {"wear_coefficient": None, "energy_wear_coefficient": {**FALLING, "slow": [1e-12, -1]}},
            ["energy_wear_coefficient.slow[1] = -1: must be at least 0"],
        ),
        (
            {"wear_coefficient": None, "energy_wear_coefficient": {**FALLING, "frequency": 0}},
            ["frequency: is missing, on which the energy law of wear depends"],
        ),
        (
            {"roughness": MEASURED, "counterface": MEASURED},
            ["counterface.body = flat: is also the body of roughness"],
        ),
        (
            {"tangential_ratio": 1.5, "plastic_limit": 1.0, "roughness": WAVES, "cell": 5e-6},
            ["gross sliding", "too low to carry", "too coarse"],
        ),
    ],
)
def test_what_is_wrong_is_refused_by_name_and_rule_all_at_once(changes, parts):
    message = refusal(**changes)
    assert all(part in message for part in parts)


LINE, LINE_LOAD = line_contact("10 mm"), line_contact("10 mm", "135 N/mm")
ELLIPSE = {"kind": "ellipsoid", "radius_x": "10 mm", "radius_y": "40 mm"}
FORCES = {"load": "135 N", "tangential_ratio": None, "tangential_load": "138 N"}


@pytest.mark.parametrize(
    ("wrong", "keys"),
    [
        ({**LINE, **FORCES}, ["load", "tangential_load"]),
        ({**LINE, "load": "135 N", "bulk_stress": "100 MPa"}, ["load"]),
        ({"load": "135 N/mm", "bulk_stress": "100 MPa"}, ["load"]),
        ({**LINE, "load": "135 kN", "sliding_amplitude": "3 mm", "tangential_ratio": None,
          "wear_coefficient": ["1e-14 / Pa", "1e-14 / Pa"]}, ["load"]),
        ({**LINE, "load": "100 N/mm", "cycles": None, "tangential_ratio": None,
          "blocks": [{"cycles": 5, "load": "30 N", "tangential_load": "25 N/mm"}]}, ["blocks"]),
    ],
)  # fmt: skip
def test_no_rule_is_tried_on_a_value_that_is_refused(wrong, keys):
    """A force in place of a force per length would break others by a factor of a thousand."""
    with pytest.raises(CaseError) as caught:
        steel(**wrong)
    assert [mistake.key for mistake in caught.value.mistakes] == keys
    assert "per length" in str(caught.value)


def test_a_contact_may_be_as_wide_as_a_fifth_of_the_radius():
    """Half-space theory ends there; Hertz: a³ = 3PR/4E*."""
    largest = 4 / 3 * steel().composite_modulus * 0.2**3 * 10e-3**2
    assert steel(load=0.99 * largest).hertz_radius < 2e-3
    assert "more than 2 mm, the most in half-space theory" in refusal(load=1.01 * largest)


def test_the_default_grid_is_square_under_a_smooth_contact_and_follows_the_waves():
    dx, dy = steel().grid_spacing
    assert dx == dy == float(f"{dx:.1e}") == near(2.3e-6)
    narrow = steel(tangential_ratio=0.2)
    slip_annulus = narrow.hertz_radius - narrow.stick_radius
    assert narrow.grid_spacing[0] == near(slip_annulus / 12, rel=0.02)
    dx, dy = steel(roughness=WAVES).grid_spacing
    assert dx < 0.5e-6
    assert dy == 2.3e-6
    lengths = [float(f"{digits}e{power}") for digits in range(10, 100) for power in (-9, -7, -5)]
    assert [*map(rounded_down, lengths)] == lengths


@settings(max_examples=settings.default.max_examples // 4)
@given(
    st.floats(0.02, 0.98),
    st.floats(1e-8, 1e-6),
    st.one_of(st.just(0.0), st.floats(1e-30, 0.5)),
    st.floats(0.001, 0.5),
)
def test_the_default_resolves_contact_zones_and_waves(ratio, amplitude, slope_x, slope_y):
    waves = {"amplitude": amplitude, "slope_x": slope_x, "slope_y": slope_y}
    case = steel(tangential_ratio=ratio, roughness=waves)
    dx, dy = case.grid_spacing
    radius, stick = case.hertz_radius, case.stick_radius
    assert dx <= case.roughness.finest[0] / 16
    assert dy <= case.roughness.finest[1] / 16
    assert max(dx, dy) <= min(radius / 64, stick / 8, (radius - stick) / 4)
    # The default passes the rules that a given spacing has to pass.
    assert case.replace(cell=(dx, dy)).cell == (dx, dy)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"load": "80 kN"}, "harder than"),  # 12.6 GPa
        ({"load": "80 kN", "plastic_limit": "11 GPa"}, "wide beside"),
        ({"youngs_modulus": "208 MPa", "load": "80 N"}, "wide beside"),
        ({**LINE, "load": "30 kN/mm"}, "harder than"),
        ({"load": "3 kN"}, ""),
        ({"friction": 5}, "coefficient of friction"),  # or 5 % of a coating?
        ({"friction": {"cycles": [0, 9], "values": [0.2, 4.0]}}, "coefficient of friction"),
        ({"friction": 3.0}, ""),
        ({"youngs_modulus": "2 MPa", "load": "0.02 N"}, ""),
    ],
)
def test_unusual_pressures_widths_and_friction_are_told_once(changes, words):
    told = [str(each) for each in case_warnings(steel(**changes))]
    assert [words in each for each in told] == [True] * bool(words), told


@pytest.mark.parametrize("model", ["jaeger", "cerruti", "coupled"])
def test_one_coupling_in_all_directions_is_told_of_the_model_that_has_it(model):
    told = case_warnings(steel(radius=None, indenter=ELLIPSE, slip_model=model))
    assert any("elongated" in str(each) for each in told) == (model == "jaeger")


def test_a_case_is_shown_as_lines():
    case = steel()
    first, *lines = repr(case).splitlines()
    assert first == f"<Case {case.case_id}>"
    assert [*map(str.strip, lines)][:2] == ["sphere radius              10 mm", lines[1].strip()]
    assert "normal load                50 N" in repr(case)
    assert len(lines) == len(case.scalar_coordinates())


@pytest.mark.parametrize("shape", [{}, {"radius": None, "indenter": ELLIPSE}, LINE_LOAD])
def test_a_cell_is_refused_if_fewer_than_four_cover_half_the_contact(shape):
    case = steel(**shape)
    for axis, half_width in enumerate(
        case.indenter.half_widths(case.hertz)[: len(case.frame.axes)]
    ):
        cell = list(case.grid_spacing)
        cell[axis] = half_width / 4.01
        assert case.replace(cell=cell).grid_spacing == tuple(cell)
        cell[axis] = half_width / 3.99
        with pytest.raises(CaseError, match="too coarse for the contact") as refused:
            case.replace(cell=cell)
        cell[axis] = str(refused.value).split("at most ")[1].split(",")[0]
        assert case.replace(cell=cell)


def test_cells_of_a_stroke_need_not_fit_into_the_unworn_contact():
    stroke = steel(**LINE_LOAD, tangential_ratio=None, sliding_distance="1 m", cycles=None)
    width = stroke.hertz_radius
    assert stroke.replace(cell=width).grid_spacing[0] == width
