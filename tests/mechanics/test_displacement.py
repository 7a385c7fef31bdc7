"""Displacement, held approach, rig, gross slip, debris: closed forms and an independent table."""

import itertools
import math

import numpy as np
import pytest

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactProblem, solve_contact
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.wear.loops import POINTS, loop
from fretwear.mechanics.wear.state import Workspace
from fretwear.run.simulate import steps
from fretwear.run.states import wear_problem
from fretwear.study.case import Case

from ..studies import WAVES, line_contact, near, refusal, steel

pytestmark = pytest.mark.slow

STEEP = {**WAVES, "slope_x": "3 deg"}


def case_of(cycles=1, **changes):
    usual = {"load": None} if "indentation" in changes else {}
    usual |= {"slip_model": "jaeger", "tangential_ratio": None, "output_cycles": None}
    return steel(**{**usual, "cycles": cycles, **changes})


def after(case, *, rings=True):
    """The steps of a run that end at its snapshots."""
    found = {step.state.cycle: step for step in steps(case, geometry=Rings if rings else Grid)}
    return {cycle: found[cycle] for cycle in case.output_cycles}


@pytest.mark.parametrize(("u", "rings"), [(0.5, False), (0.9999, True), (1.5, True)])
def test_mindlin_sphere_under_a_given_displacement_its_loop_and_gross_slip_as_fouvry_has_it(
    u, rings
):
    # δ/U_t = 1 − (1 − Q/µP)^(2/3) at first loading, twice that after a reversal, then gliding.
    case, geometry = case_of(displacement_ratio=u), Rings if rings else Grid
    first = next(steps(case, geometry=geometry))
    state, measures, amplitude = first.state, first.measures, case.displacement_amplitude
    found = loop(Workspace(wear_problem(case, geometry)), state)
    largest = 1 - (1 - min(u, 1.0)) ** 1.5
    assert 1 - state.reduced.load / state.load == near(largest, rel=1e-3)
    assert measures.tangential_displacement == near(amplitude, rel=1e-6)
    assert measures.regime == (u > 1.0)
    if u < 0.9:
        assert state.reduced.approach == near((1 - u) * case.hertz.approach, rel=1e-3)
        edge = math.sqrt(1 - u) * case.hertz_radius
        assert measures.stick_half_width_x == near(edge, rel=5e-3)
    elif rings:
        energy = 4 * 0.5 * 50 * (amplitude - 0.8 * amplitude / u)
        assert measures.dissipated_energy == near(energy, rel=1e-3)
        assert case.unworn_means.slip == near(energy / (4 * 0.5 * 50), rel=1e-3)
    if u == 0.9999:
        assert measures.sliding_ratio == near(0.2, rel=1e-3)
        ratio = energy / (4 * measures.tangential_force * found.opening)
        assert ratio == near(0.76946, rel=1e-3)
    force, way = found.force[: POINTS + 1], found.displacement[: POINTS + 1]
    curve = 2 * (1 - np.cbrt(1 - np.minimum((largest - force / 25) / 2, 1.0)) ** 2)
    assert np.abs(way / amplitude - 1 + curve / u).max() <= 2e-3
    opening = u - 2 * (1 - np.cbrt(1 - largest / 2) ** 2)
    assert found.opening / amplitude == pytest.approx(opening / u, rel=2e-3, abs=2e-4)
    ends = found.displacement[[0, 2 * POINTS, -1]] / amplitude
    np.testing.assert_allclose(ends, [1.0, -1.0, 1.0], rtol=1e-6)


@pytest.mark.parametrize(
    "keys",
    [{"displacement_ratio": 0.8, "rig_stiffness": "28 N/um"},
     {"displacement_ratio": 1.2, "cell": "6 um"},
     {"displacement_ratio": 0.9, "roughness": STEEP, "cell": ["1.9 um", "4 um"]},
     {**line_contact("6 mm", "100 N/mm"), "tangential_ratio": 0.8}],
    ids=["rig", "gross slip", "rough", "cylinder"],
)  # fmt: skip
def test_a_loop_is_that_of_many_contacts_and_holds_the_energy_that_its_cycle_dissipates(keys):
    case = case_of(1000, **keys)
    *_, last = steps(case)
    state, workspace = last.state, Workspace(wear_problem(case))
    problem, ground = workspace.problem, workspace.on(state.geometry)
    shape, low = ground.unworn + state.opening, state.reduced
    places = np.linspace(1.0, np.cbrt(low.load / state.load), 41)
    start, approaches = state.pressure, [state.approach]
    for load in state.load * places[1:-1] ** 3:
        contact = solve_contact(ContactProblem(ground.half_space, shape, load), start)
        start = contact.pressure
        approaches.append(contact.approach)
    approaches.append(low.approach if low.load else shape.min())
    force = 0.5 * state.load * (1 - places**3)
    way = 0.5 * problem.coupling * (state.approach - np.array(approaches))
    dissipated = last.measures.dissipated_energy
    glides = 0.5 * problem.coupling * (approaches[-1] - low.approach)
    area = 8 * (np.trapezoid(force, way) - 0.5 * force[-1] * way[-1]) + 4 * force[-1] * glides
    assert area == near(dissipated, rel=2e-3)
    found = loop(workspace, state)
    assert np.trapezoid(found.force, found.displacement) == near(dissipated, rel=1e-9)
    assert found.force.max() == near(last.measures.tangential_force, rel=1e-9)
    fallen = (force[-1] - found.force[: POINTS + 1]) / 2
    moved = (found.displacement[0] - found.displacement[: POINTS + 1]) / 2
    moved -= fallen * problem.flexibility
    assert np.abs(moved - np.interp(fallen, force, way)).max() <= 5e-3 * way[-1]


# Popov (2014), Sci. Rep. 4, 3749: u, load, central pressure, half-width, deepest wear, volume.
POPOV = [
    (0.5, 0.883883, 1.060660, 1.139701, 0.133058, 0.222937),
    (0.8, 0.626099, 1.341641, 1.251528, 0.345239, 0.947077),
]


@pytest.mark.parametrize(("u", "load", "center", "width", "deepest", "volume"), POPOV)
def test_popov_worn_sphere_at_a_held_approach(u, load, center, width, deepest, volume):
    case = case_of(200_000, indentation="2.2 um", displacement_ratio=u)
    last = after(case)[case.cycles].measures
    hertz = case.hertz
    assert last.normal_force / hertz.load == near(load, rel=1e-3)
    assert last.central_pressure / hertz.peak_pressure == near(center, rel=1e-3)
    assert last.contact_half_width_x / hertz.contact_radius == near(width, rel=4e-3)
    assert last.maximum_wear_depth / hertz.approach == near(deepest, rel=5e-3)
    scale = hertz.contact_radius**4 / hertz.radius
    assert last.wear_volume / scale == near(volume, rel=5e-3)


# An independent integrator: dense, rings of equal width, explicit steps (Heun). Columns: u, spring
# in G* a/S, tau, approach, reduced approach, Q/µP, deepest wear, volume.
KINETICS = [
    (0.8, 0.0, 2, 1.1071, 0.307096, 0.833335, 0.171459, 0.412144),
    (0.8, 0.5, 2, 1.02004, 0.586942, 0.550358, 0.043751, 0.0504264),
    (1.2, 0.0, 1, 1.19289, -0.00711076, 1.0, 0.28693, 0.959246),
]


@pytest.mark.parametrize(
    ("rings", "u", "spring", "tau", "d", "reduced", "ratio", "deepest", "v"),
    [(True, *row) for row in KINETICS] + [(False, *KINETICS[1])],
)
def test_kinetics_at_constant_load(rings, u, spring, tau, d, reduced, ratio, deepest, v):
    force = case_of(tangential_ratio=0.5)
    unit, a = force.hertz.approach, force.hertz_radius
    cycles = round(tau / (force.wear_growth * force.hertz_pressure))
    rig = {"rig_stiffness": force.composite_modulus / force.coupling * a / spring} if spring else {}
    case = case_of(cycles, displacement_ratio=u, **rig)
    last = after(case, rings=rings)[cycles]
    assert last.state.approach / unit == near(d, rel=1e-3)
    assert abs(last.state.reduced.approach / unit - reduced) < 1e-3
    assert last.measures.tangential_force / (0.5 * 50) == near(ratio, rel=1e-3)
    assert last.measures.maximum_wear_depth / unit == near(deepest, rel=2e-3)
    assert last.measures.wear_volume / (a**4 / 0.01) == near(v, rel=2e-3)


def test_debris_that_keeps_all_leaves_the_gap_and_half_of_it_slows_what_wear_does():
    case = case_of(2000, tangential_ratio=0.8, debris_fraction=1.0, output_cycles=[500])
    found = after(case)
    first, middle, last = (found[cycle] for cycle in (0, 500, 2000))
    np.testing.assert_allclose(last.state.gap, first.state.gap, rtol=1e-12, atol=1e-20)
    np.testing.assert_allclose(last.state.pressure, first.state.pressure, rtol=1e-4, atol=1e5)
    assert last.measures.wear_volume == near(4 * middle.measures.wear_volume, rel=1e-6)
    # Archard's law for the unworn contact.
    archard = 7e-13 / 0.5 * first.measures.dissipated_energy * 2000
    assert last.measures.wear_volume == near(archard, rel=1e-4)
    # The gap with γ = 0.75 after 4N cycles equals the gap with γ = 0 after N, and wear is fourfold.
    fine = {"tangential_ratio": 0.8, "tolerance": 0.003}
    plain = after(case_of(500, **fine))[500]
    kept = after(case_of(2000, debris_fraction=0.75, **fine))[2000]
    np.testing.assert_allclose(kept.state.opening, 0.25 * kept.state.wear, rtol=1e-9)
    # The same numbers but for the lengths of the steps.
    assert kept.measures.wear_volume == near(4 * plain.measures.wear_volume, rel=2e-3)
    assert kept.measures.approach == near(plain.measures.approach, rel=1e-5)


def test_debris_that_keeps_all_wears_as_one_that_keeps_nearly_all_while_the_stick_zone_grows():
    """Slip ends within a step where stick begins, and the earlier wear remains."""
    rising = {"cycles": [0, 300], "values": [0.3, 0.9]}
    keys = {"cycles": 300, "displacement_amplitude": "0.9 um", "friction": rising}
    worn = {}
    for kept in (1.0 - 1e-7, 1.0):
        states = [each.state for each in steps(case_of(**keys, debris_fraction=kept))]
        assert states[-1].reduced.stick.sum() > 1.1 * states[0].reduced.stick.sum()
        for earlier, later in itertools.pairwise(states):
            if earlier.geometry == later.geometry:
                assert (later.wear >= earlier.wear).all()
        worn[kept] = states[-1].geometry.integral(states[-1].wear)
    assert worn[1.0] == near(worn[1.0 - 1e-7], rel=1e-3)


def test_wear_per_energy_is_archards():
    law = {"wear_coefficient": None, "energy_wear_coefficient": "1.4e-3 mm^3/J"}
    one, by_energy = (
        after(case_of(500, tangential_ratio=0.8, **each))[500].measures for each in ({}, law)
    )
    assert by_energy.wear_volume == near(one.wear_volume, rel=1e-12)


def test_friction_that_follows_a_table_stops_at_its_kinks_and_a_constant_one_is_a_number():
    constant = {"cycles": [0, 100], "values": [0.5, 0.5]}
    one, table = (
        case_of(500, tangential_ratio=0.8),
        case_of(500, tangential_ratio=0.8, friction=constant),
    )
    assert table.case_id == one.case_id
    falling = {"cycles": [0, 70], "values": [0.5, 0.3]}
    assert "less than µP = 15 N" in refusal(tangential_load="20 N", friction=falling)
    rising = case_of(
        250, displacement_ratio=1.2, friction={"cycles": [0, 70], "values": [0.4, 0.8]}
    )
    assert 70 not in rising.output_cycles
    found = {step.state.cycle: step for step in steps(rising, geometry=Rings)}
    assert 70.0 in found
    # U slides the unworn contact as a whole at µ = 0.4, and not at twice that.
    assert found[0].measures.regime == 1
    assert found[250].measures.regime == 0
    assert found[250].measures.tangential_force < 0.8 * 50


def blocks_of(*blocks, **changes):
    usual = {"cycles": None, "output_cycles": None, "slip_model": "jaeger"}
    return steel(**{**usual, "blocks": blocks, **changes})


def test_blocks_follow_each_other_on_the_same_shape():
    case = blocks_of(
        {"cycles": 300, "load": "30 N"},
        {"cycles": 200},
        {"cycles": 200, "displacement_ratio": 1.2},
        output_cycles=[300, 500],
    )
    found = after(case)
    assert [found[n].measures.normal_force for n in (0, 300, 500, 700)] == [30, 30, 50, 50]
    assert [found[n].measures.regime for n in (300, 500, 700)] == [0, 0, 1]
    alone = after(case_of(300, load="30 N", tangential_ratio=0.8))[300]
    assert found[300].measures.wear_volume == near(alone.measures.wear_volume, rel=2e-3)
    volumes = [found[n].measures.wear_volume for n in (0, 300, 500, 700)]
    assert volumes == sorted(volumes)
    assert Case(**case.canonical_parameters()).case_id == case.case_id


def test_bodies_do_not_heal_where_rings_follow_another_load():
    """Cubics through two plastic depths may cross, so rings are replaced before the depth grows."""
    blocks = (
        {"cycles": n, "load": load} for n, load in ((300, "50 N"), (300, "35 N"), (100, "50 N"))
    )
    case = blocks_of(*blocks, load=None, tangential_ratio=0.2, plastic_limit="1027 MPa")
    run = [step.state for step in steps(case, geometry=Rings)]
    for earlier, state in itertools.pairwise(run):
        then = earlier.geometry.resized(earlier.plastic, state.geometry)
        assert (state.plastic >= then * (1.0 - 1e-12)).all()
    again = [state for state in run if state.cycle > 600]
    # It yields as it is loaded again, and other rings are there.
    assert again[0].plastic.max() > 0.0
    assert len({state.geometry.edges for state in run if state.plastic.any()}) > 1
