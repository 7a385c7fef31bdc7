"""The disc and slip of Cattaneo and Mindlin over whole runs, on surfaces that they ignore."""

import numpy as np
import pytest

import fretwear
from fretwear.running.simulate import simulate
from fretwear.theory import HertzContact
from fretwear.vocabulary import ContactState

WAVES = {"kind": "wavy", "amplitude": "0.2 um", "slope_x": "2.9 deg", "slope_y": "1 deg"}


def study_case(**changes: object) -> fretwear.Case:
    given = {
        "radius": "10 mm",
        "youngs_modulus": "208 GPa",
        "poisson_ratio": 0.3,
        "load": "50 N",
        "tangential_load": "20 N",
        "friction": 0.5,
        "wear_coefficient": 7e-13,
        "cell": ("1.9 um", "4 um"),
        "cycles": 3000,
        "output_cycles": (1, 100, 1000),
    }
    return fretwear.Case(**(given | changes))


@pytest.fixture(scope="module", params=["smooth elastic", "rough elastic", "rough plastic"])
def case(request: pytest.FixtureRequest) -> fretwear.Case:
    changes: dict[str, object] = {"slip_model": "cattaneo_mindlin"}
    if "rough" in request.param:
        changes["roughness"] = WAVES
    if "plastic" in request.param:
        changes["plastic_limit"] = "4500 MPa"
    return study_case(**changes)


@pytest.fixture(scope="module")
def dataset(case):
    return simulate(case)


def stick_contact(case):
    return HertzContact(case.radius, case.stick_load, case.composite_modulus)


def radii(dataset):
    return np.hypot(dataset["x"].values[:, None], dataset["y"].values[None, :])


def test_window_grows_while_it_runs(case, dataset):
    assert float(dataset["x"][-1]) > 1.3 * case.hertz_radius


def test_slip_is_the_closed_form_in_every_cycle_smooth_and_rough(case, dataset):
    expected = case.friction * case.coupling * stick_contact(case).gap(radii(dataset))
    for cycle in dataset["cycle"].values:
        slip = dataset["slip"].sel(cycle=cycle).values
        # Stored in single precision.
        np.testing.assert_allclose(slip, expected, rtol=1e-6, atol=1e-6 * expected.max())


def test_stick_zone_is_the_disc_for_ever(case, dataset):
    disc = radii(dataset) < stick_contact(case).contact_radius
    assert float(np.ptp(dataset["stick_area"].values)) == 0.0
    for cycle in dataset["cycle"].values:
        stick = dataset["contact_state"].sel(cycle=cycle).values == ContactState.STICK
        assert not stick[~disc].any()


def test_shear_balances_the_tangential_load(case, dataset):
    dx, dy = case.grid_spacing
    total = 4.0 * dx * dy * dataset["shear_traction"].astype(np.float64).sum(("x", "y"))
    # The disc's pressure is sampled at cell centres.
    np.testing.assert_allclose(total.values, case.tangential_load, rtol=2e-3)


def test_wear_of_a_cycle_is_that_of_archard(case, dataset):
    path = 4.0 * dataset["slip"].astype(np.float64)
    expected = case.wear_coefficient * dataset["pressure"].astype(np.float64) * path
    np.testing.assert_allclose(
        dataset["wear_rate"].values, expected.values, rtol=1e-5, atol=1e-6 * float(expected.max())
    )


def test_constant_slip_wears_less_than_slip_that_grows_with_wear():
    models = {
        name: simulate(study_case(slip_model=name, cell=("4 um", "4 um"), cycles=3000))
        for name in ("jaeger", "cattaneo_mindlin")
    }
    first = [float(ds["dissipated_energy"][0]) for ds in models.values()]
    # One smooth, unworn sphere: the models agree but for the grid.
    assert first[0] == pytest.approx(first[1], rel=5e-3)
    jaeger, simple = (float(ds["wear_volume"][-1]) for ds in models.values())
    assert simple < 0.7 * jaeger


def test_a_tighter_tolerance_hardly_changes_the_wear():
    case = study_case(
        slip_model="cattaneo_mindlin", roughness=WAVES, plastic_limit="4500 MPa", cycles=7000
    )
    coarse, fine = (
        float(simulate(case.replace(tolerance=tolerance))["wear_volume"][-1])
        for tolerance in (0.01, 0.0025)
    )
    assert coarse == pytest.approx(fine, rel=2e-3)
