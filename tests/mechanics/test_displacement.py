"""A sphere under a given displacement: closed forms, and an independent integrator."""

import math

import pytest
from tests.mechanics.problems import near

from fretwear.running.simulate import steps
from fretwear.study.case import Case

SPHERE = {
    "radius": "10 mm",
    "youngs_modulus": "208 GPa",
    "poisson_ratio": 0.3,
    "friction": 0.5,
    "wear_coefficient": "7e-13 / Pa",
}


def case_of(cycles=1, at=(), **loading) -> Case:
    loading.setdefault("load", "50 N" if "indentation" not in loading else None)
    return Case(**SPHERE, cycles=cycles, output_cycles=at, **loading)


@pytest.mark.parametrize("rings", [True, False])
@pytest.mark.parametrize("u", [0.2, 0.5, 0.8])
def test_mindlin_sphere_under_a_given_displacement(u: float, rings: bool):
    case = case_of(displacement_ratio=u)
    first = next(steps(case, rings=rings))
    state, measures = first.state, first.measures
    assert 1 - state.reduced.load / state.load == near(1 - (1 - u) ** 1.5, rel=1e-3)
    assert state.reduced.approach == near((1 - u) * case.hertz.approach, rel=1e-3)
    edge = math.sqrt(1 - u) * case.hertz_radius
    assert measures.stick_half_width_x == near(edge, rel=5e-3)
    assert measures.tangential_displacement == near(case.displacement_amplitude, rel=1e-6)
