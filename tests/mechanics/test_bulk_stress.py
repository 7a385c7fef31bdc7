"""A bulk stress in phase with the force moves the stick zone: slip and wear on both sides."""

import numpy as np
import pytest

import fretwear
from fretwear.mechanics.contact.cells import ContactError
from fretwear.mechanics.contact.strips import Row
from fretwear.mechanics.slip.models import Cerruti, Coupled
from fretwear.mechanics.surfaces.indenters import Cylinder
from fretwear.mechanics.surfaces.materials import Coulomb
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.wear.integrator import evolve, first_loading
from fretwear.study.case import CaseError
from fretwear.theory import LineContact

from ..studies import near
from .problems import MODULUS, P0, A, fretting

LINE = LineContact(6e-3, 4e5, MODULUS)
HALF = LINE.contact_radius
FRICTION, RATIO = 0.6, 0.4


def cylinder(stress, cells=80):
    """A cylinder on strips of both sides; the stress over its peak pressure."""
    return fretting(
        load_ratio=RATIO,
        geometry=Row,
        indenter=Cylinder(6e-3),
        normal=NormalLoad(4e5),
        friction_law=Coulomb(FRICTION),
        spacing=(HALF / cells, HALF / cells),
        extent=(1.15 * HALF, 1.15 * HALF),
        bulk_stress=stress * LINE.peak_pressure,
    )


def worn_once(problem):
    """Energy of the first cycle, and the deepest wear in it on either side."""
    state = first_loading(problem)
    rate = state.pressure * problem.slip(state.reduced)
    x, energy = state.geometry.x, problem.dissipated_energy(state, state.geometry)
    return np.array([energy, rate[x < 0.0].max(), rate[x > 0.0].max()]), state


@pytest.mark.parametrize(
    ("stress", "expected"),
    [(0.143, (1.21, 0.54, 1.61)), (0.286, (1.84, 0.22, 2.36)), (0.43, (2.91, 0.04, 3.3))],
)
def test_energy_and_wear_are_those_of_a_direct_solution_in_increments(stress, expected):
    (alone, _), (found, state) = worn_once(cylinder(0.0)), worn_once(cylinder(stress))
    energy, low, high = found / alone
    assert energy == near(expected[0], rel=0.01)
    assert (low, high) == pytest.approx(expected[1:], rel=0.015, abs=0.005)
    # The stick zone is as wide as without it, and moved by e = aσ/(4µp0).
    stuck = state.geometry.x[state.reduced.stick[:, 0]]
    assert stuck.mean() == pytest.approx(-stress / (4.0 * FRICTION) * HALF, abs=HALF / 80)
    assert np.ptp(stuck) == near(2.0 * HALF * np.sqrt(1.0 - RATIO), rel=0.02)


def test_the_scar_of_a_cylinder_is_deeper_on_one_side():
    problem = cylinder(0.286, cells=40)
    *_, state = evolve(problem, [2.0 / (problem.wear_growth * LINE.peak_pressure)])
    x, wear = state.geometry.x, state.wear[:, 0]
    assert wear[x > 0.0].max() > 2.0 * wear[x < 0.0].max()


def test_friction_as_a_vector_gives_the_same_for_a_sphere():
    (found, state), (exact, other) = (
        worn_once(fretting(12, slip_model=model, load_ratio=0.6, bulk_stress=0.1 * P0))
        for model in (Cerruti(), Coupled())
    )
    np.testing.assert_allclose(found, exact, rtol=0.02)
    assert state.reduced.stick.sum() == near(other.reduced.stick.sum(), rel=0.03)
    x = state.geometry.x[:, None] * state.reduced.stick
    assert x.sum() / state.reduced.stick.sum() < -0.02 * A


def test_a_stress_that_reverses_slip_is_refused():
    with pytest.raises(ContactError, match="beyond the contact"):
        first_loading(cylinder(0.6))
    given = {"youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "wear_coefficient": "7e-13 / Pa"}
    given |= {"indenter": {"kind": "cylinder", "radius": "6 mm"}, "load": "400 N/mm"}
    given |= {"friction": FRICTION, "tangential_ratio": RATIO, "cycles": 10}
    peak = fretwear.Case(**given).hertz_pressure
    fretwear.Case(**given, bulk_stress=0.5 * peak)
    with pytest.raises(CaseError, match="beyond the contact, where slip reverses"):
        fretwear.Case(**given, bulk_stress=0.6 * peak)
