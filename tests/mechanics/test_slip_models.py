"""The disc and slip of Cattaneo and Mindlin over whole runs, on surfaces that they ignore."""

import numpy as np
import pytest

import fretwear
from fretwear.running.simulate import simulate
from fretwear.theory import HertzContact
from fretwear.vocabulary import ContactState

from ..studies import WAVES, steel

SLOPING = {**WAVES, "slope_x": "2.9 deg"}
SIMPLE = {
    "slip_model": "cattaneo_mindlin",
    "cell": ("1.9 um", "4 um"),
    "cycles": 3000,
    "output_cycles": (1, 100, 1000),
}


@pytest.fixture(scope="module", params=["smooth elastic", "rough elastic", "rough plastic"])
def case(request: pytest.FixtureRequest) -> fretwear.Case:
    rough = {"roughness": SLOPING} if "rough" in request.param else {}
    plastic = {"plastic_limit": "4500 MPa"} if "plastic" in request.param else {}
    return steel(**SIMPLE, **rough, **plastic)


@pytest.fixture(scope="module")
def dataset(case):
    return simulate(case, quarter=True)


def stick_contact(case):
    return HertzContact(case.radius, case.stick_load, case.composite_modulus)


def radii(dataset):
    return np.hypot(dataset["x"].values[:, None], dataset["y"].values[None, :])


def test_slip_is_the_closed_form_in_every_cycle_smooth_and_rough(case, dataset):
    assert float(dataset["x"][-1]) > 1.25 * case.hertz_radius, "the window should have grown"
    expected = case.friction * case.coupling * stick_contact(case).gap(radii(dataset))
    for cycle in dataset["cycle"].values:
        slip = dataset["slip"].sel(cycle=cycle).values
        # Stored in single precision; on rings means over cells, weighted by the pressure, and at
        # the edge of contact over the part of a cell that carries load.
        error = np.full_like(expected, 1e-6)
        if not case.roughness:
            edge = float(dataset["contact_half_width_x"].sel(cycle=cycle))
            cut = np.abs(radii(dataset) - edge) < np.hypot(*case.grid_spacing)
            error = np.where(cut, 0.03, (max(case.grid_spacing) / case.hertz_radius) ** 2)
        assert (np.abs(slip - expected) <= 1e-6 * expected + error * expected.max()).all()


def test_stick_zone_is_the_disc_for_ever(case, dataset):
    disc = radii(dataset) < stick_contact(case).contact_radius
    assert float(np.ptp(dataset["stick_area"].values)) == 0.0
    for cycle in dataset["cycle"].values:
        stick = dataset["contact_state"].sel(cycle=cycle).values == ContactState.STICK
        assert not stick[~disc].any()


def test_a_tighter_tolerance_hardly_changes_the_wear():
    case = steel(**{**SIMPLE, "cycles": 7000}, roughness=SLOPING, plastic_limit="4500 MPa")
    coarse, fine = (
        float(simulate(case.replace(tolerance=tolerance))["wear_volume"][-1])
        for tolerance in (0.01, 0.0025)
    )
    assert coarse == pytest.approx(fine, rel=2e-3)
