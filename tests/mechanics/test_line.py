"""Line contact on strips against closed forms of plane strain."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from fretwear.mechanics.contact import ContactProblem
from fretwear.mechanics.geometry import Workspace
from fretwear.mechanics.geometry.dense import Line
from fretwear.mechanics.integrator import evolve, first_loading
from fretwear.mechanics.loading import DisplacementRatio, NormalLoad, TangentialRatio
from fretwear.mechanics.materials import ElasticBodies
from fretwear.mechanics.measures import loop, measure
from fretwear.mechanics.roughness import WavyRoughness
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.surfaces import Cylinder, FlatPunch
from fretwear.theory import LineLimitingState, gross_slip_energy

from .problems import FRICTION, P0, fretting

CYLINDER, LOAD = Cylinder(6e-3), 18.5e3
STEEL = ElasticBodies(200e9, 0.3)
HERTZ = CYLINDER.hertz(NormalLoad(LOAD), STEEL.composite_modulus)
A = HERTZ.contact_radius


def rubbing(load_ratio, **changes):
    given = {
        "indenter": CYLINDER,
        "normal": NormalLoad(LOAD),
        "extent": (1.15 * A, 1.15 * A),
        "loading": TangentialRatio(load_ratio),
        "spacing": (A / 64, A / 64),
    }
    return fretting(bodies=STEEL, geometry=Line, **{**given, **changes})


def test_the_influence_is_symmetric_and_positive():
    line = Line((0.0, 1e-6, 3e-6, 8e-6, 1e-5), 6e-3)
    influence = line.areas * line.influence(1e11)
    assert influence == pytest.approx(influence.T, rel=1e-6)
    assert np.linalg.eigvalsh(0.5 * (influence + influence.T)).min() > 0


def test_where_it_yields_the_load_is_kept_and_the_stick_zone_shrinks():
    limit = 1.5 * HERTZ.peak_pressure
    problem = rubbing(0.8, limit=limit / P0)
    first, *_, last = evolve(problem, [10.0 / (problem.growth_rate * HERTZ.peak_pressure)])
    assert last.pressure.max() == pytest.approx(limit)
    assert last.geometry.integral(last.pressure) == pytest.approx(LOAD)
    assert last.plastic.max() > 0
    assert last.reduced.stick.sum() < first.reduced.stick.sum()


def test_first_loading():
    problem = rubbing(0.5)
    state = first_loading(problem)
    found = measure(problem, state)
    sliding = CYLINDER.partial_slip(HERTZ, FRICTION, 0.5 * FRICTION * LOAD, 1.0)
    assert found.approach == pytest.approx(HERTZ.approach, rel=1e-5)
    assert found.central_pressure == pytest.approx(HERTZ.peak_pressure, rel=1e-4)
    assert found.contact_half_width_x == pytest.approx(A, rel=6e-4)
    assert found.stick_half_width_x == pytest.approx(sliding.stick_radius, rel=1e-4)
    assert found.tangential_displacement == pytest.approx(sliding.tangential_displacement, rel=1e-4)
    assert found.dissipated_energy == pytest.approx(sliding.dissipated_energy, rel=1e-3)
    slip = np.interp(A, state.geometry.x, problem.slip(state.reduced)[:, 0])
    assert slip == pytest.approx(float(sliding.slip(A)), rel=1e-3)


@pytest.mark.parametrize("load_ratio", [0.2, 0.5, 0.9])
def test_the_limit_of_many_cycles(load_ratio):
    problem = rubbing(load_ratio)
    limiting = LineLimitingState(HERTZ, load_ratio)
    *_, state = evolve(problem, [1e4 / (problem.growth_rate * HERTZ.peak_pressure)])
    found = measure(problem, state)
    assert found.approach == pytest.approx(limiting.approach, rel=1e-5)
    assert found.central_pressure == pytest.approx(limiting.central_pressure, rel=1e-3)
    assert found.wear_volume == pytest.approx(limiting.wear_volume, rel=1e-3)
    assert state.wear.max() == pytest.approx(limiting.deepest_wear, rel=1e-3)
    assert found.contact_half_width_x == pytest.approx(limiting.contact_radius, rel=2e-4)
    assert found.contact_area == pytest.approx(2.0 * limiting.contact_radius, rel=2e-4)


@pytest.mark.parametrize("share", [0.4, 0.5, 0.8])
def test_a_punch_with_rounded_edges(share):
    """Half-widths of contact and stick, pressures and approach; and many cycles later."""
    punch = FlatPunch(flat_half_width=1e-4, edge_radius=6e-3)
    unit = punch.hertz(NormalLoad(1.0), STEEL.composite_modulus)
    load = unit.load_at(1e-4 / share)
    hertz = unit.with_load(load)
    problem = rubbing(
        0.5,
        indenter=punch,
        normal=NormalLoad(load),
        extent=(1.15 * hertz.contact_radius, 1.15 * hertz.contact_radius),
    )
    state = first_loading(problem)
    found = measure(problem, state)
    assert found.contact_half_width_x == pytest.approx(1e-4 / share, rel=1e-3)
    stick = hertz.with_load(0.5 * load)
    assert found.stick_half_width_x == pytest.approx(stick.contact_radius, rel=1e-4)
    assert found.central_pressure == pytest.approx(float(hertz.pressure(0.0)), rel=1e-4)
    assert found.peak_pressure == pytest.approx(hertz.peak_pressure, rel=1e-3)
    assert found.approach == pytest.approx(hertz.approach, rel=1e-5)
    *_, last = evolve(problem, [1e4 / (problem.growth_rate * hertz.peak_pressure)])
    found, limiting = measure(problem, last), LineLimitingState(hertz, 0.5)
    assert found.central_pressure == pytest.approx(limiting.central_pressure, rel=1e-3)
    assert found.approach == pytest.approx(limiting.approach, rel=1e-4)


COMPLIANCES = [3e-11, 5e-12]  # of large bodies, and of bodies smaller than their radius


def driven(ratio, compliance):
    """A cylinder under a displacement, over that which slides it as a whole unworn."""
    loading = DisplacementRatio(displacement_ratio=ratio, tangential_compliance=compliance)
    return rubbing(0.5, loading=loading.plain(FRICTION, 1.0, HERTZ))


@pytest.mark.parametrize("compliance", COMPLIANCES)
@pytest.mark.parametrize("ratio", [0.2, 0.9, 1.5])
def test_displacement_over_the_slope_of_the_loop(ratio, compliance):
    """U = C Q + (µP/πE*) [X + (1 − X) ln(1 − X)], whatever the approach counts from."""
    problem = driven(ratio, compliance)
    state = first_loading(problem)
    found = measure(problem, state)
    sliding, force = FRICTION * LOAD, found.tangential_force
    stuck = 1.0 - force / sliding
    slip = sliding / (math.pi * STEEL.composite_modulus)
    slip *= 1.0 - stuck + (stuck * math.log(stuck) if stuck > 0.0 else 0.0)
    displacement = problem.loading.displacement_amplitude
    if ratio < 1.0:
        assert compliance * force + slip == pytest.approx(displacement, rel=1e-5)
        assert found.stick_half_width_x == pytest.approx(A * math.sqrt(stuck), rel=1e-4)
    else:
        assert (force, found.regime) == (pytest.approx(sliding), 1.0)
        assert compliance * force + slip == pytest.approx(displacement / ratio, rel=1e-9)
        slid = found.tangential_displacement
        energy = gross_slip_energy(HERTZ, FRICTION, 1.0, slid)
        assert found.dissipated_energy == pytest.approx(energy, rel=1e-3)
    curve = loop(Workspace(problem), state)
    assert curve.energy == pytest.approx(found.dissipated_energy, rel=1e-3)
    assert curve.displacement.max() == pytest.approx(displacement, rel=1e-5)


def test_wear_under_a_displacement_against_explicit_steps():
    """Euler's steps of the contacts under P and P*, the latter by bisection of the condition."""
    problem = driven(0.8, 5e-12)
    cycles = 2.0 / (problem.growth_rate * HERTZ.peak_pressure)
    *_, last = evolve(problem, [cycles])
    line = Line(tuple(np.linspace(0.0, 1.5 * A, 121)), HERTZ.radius)
    bodies, unworn = problem.half_space(line), problem.unworn(line)
    wear, steps, start = np.zeros(line.shape), 40, None
    for step in range(steps + 1):
        shape = unworn + wear
        contact = solve_contact(ContactProblem(bodies, shape, LOAD), start)
        start = contact.pressure

        def excess(load, shape=shape, contact=contact):
            found = solve_contact(ContactProblem(bodies, shape, load), contact.pressure)
            passed = contact.approach - found.approach + problem.flexibility * (LOAD - load)
            return FRICTION * passed - problem.loading.displacement_amplitude

        held = brentq(excess, 1e-3 * LOAD, LOAD, xtol=1e-6 * LOAD)
        stuck = solve_contact(ContactProblem(bodies, shape, held), start)
        if step < steps:
            wear += problem.growth_rate * cycles / steps * start * np.maximum(stuck.gap, 0.0)
    assert last.geometry.integral(last.wear) == pytest.approx(line.integral(wear), rel=2e-3)
    assert last.reduced.load == pytest.approx(held, rel=4e-3)
    assert last.reduced.load > 1.05 * problem.stick_load


def test_waves_across_the_line():
    """In full contact waves A cos kx add −(E*kA/2) cos kx to the pressure: Westergaard (1939)."""
    length = 0.25 * A
    height = 0.2 * HERTZ.peak_pressure * length / (math.pi * STEEL.composite_modulus)
    waves = WavyRoughness(height, math.atan(4.0 * height / length), 0.0)
    problem = rubbing(0.5, roughness=waves, spacing=(length / 32, length / 32))
    state = first_loading(problem)
    x, pressure = state.geometry.x, state.pressure[:, 0]
    inside = x < 2.0 * length
    ripple = (pressure - HERTZ.pressure(x))[inside] / HERTZ.peak_pressure
    expected = -0.2 * np.cos(2.0 * math.pi * x[inside] / length)
    assert ripple == pytest.approx(expected, abs=4e-3)
    assert state.geometry.integral(state.pressure) == pytest.approx(LOAD)
    steep = WavyRoughness(20.0 * height, math.atan(80.0 * height / length), 0.0)
    higher = replace(problem, roughness=steep)
    *_, last = evolve(higher, [20.0 / (problem.growth_rate * HERTZ.peak_pressure)])
    closed = last.pressure[:, 0] > 0
    assert np.diff(np.flatnonzero(closed)).max() > 1  # tips, and none of them beyond the strips
    tips = last.geometry.half_space(STEEL.composite_modulus).displacement(last.pressure)
    gap = (tips + higher.unworn(last.geometry) + last.wear)[:, 0] - last.approach
    assert abs(gap[closed]).max() < 1e-4 * last.approach
    assert gap.min() > -1e-4 * last.approach


def test_a_larger_line_keeps_what_is_known():
    problem = rubbing(0.5)
    state = first_loading(problem)
    larger = state.geometry.ahead_of(
        problem, replace(state, pressure=np.ones(state.geometry.shape))
    )
    assert larger.extent > state.geometry.extent
    moved = state.on(Workspace(problem), larger)
    kept = larger.where(state.geometry)
    assert moved.gap[kept] == pytest.approx(state.gap)
    outside = moved.gap[state.geometry.shape[0] :, 0]
    assert outside == pytest.approx(HERTZ.gap(larger.x[-outside.size :]), rel=1e-3)
    assert math.isclose(larger.integral(moved.pressure), LOAD)
