"""Smooth contacts on rings and strips: closed forms, an independent reference, their output."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq
from scipy.special import ellipe

from fretwear.mechanics.contact.cells import Region
from fretwear.mechanics.contact.dense import interpolated
from fretwear.mechanics.contact.problem import ContactProblem, solve_contact
from fretwear.mechanics.contact.rings import Rings, mean_influence
from fretwear.mechanics.contact.strips import Strips
from fretwear.mechanics.surfaces.indenters import FlatPunch
from fretwear.mechanics.surfaces.loading import DisplacementRatio
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.surfaces.roughness import WavyRoughness
from fretwear.mechanics.wear import grading
from fretwear.mechanics.wear.grading import Grading, graded_rings
from fretwear.mechanics.wear.integrator import evolve, first_loading
from fretwear.mechanics.wear.loops import loop
from fretwear.mechanics.wear.measures import Measures, half_width
from fretwear.mechanics.wear.state import Workspace
from fretwear.theory import (
    LimitingState,
    LineLimitingState,
    LinePartialSlip,
    PartialSlip,
    gross_slip_energy,
)

from ..studies import near
from .problems import (
    COUPLING,
    CYLINDER_BODIES,
    EDGE,
    FRICTION,
    HERTZ,
    LINE,
    LOAD,
    MODULUS,
    P0,
    PER_LENGTH,
    RADIUS,
    A,
    fretting,
    on_strips,
)


def on_cells(kind, ratio):
    """The problem of a sphere on rings or of a cylinder on strips, and both of its closed forms."""
    if kind == "rings":
        unworn = PartialSlip(HERTZ, FRICTION, ratio * FRICTION * LOAD, COUPLING)
        return fretting(load_ratio=ratio, geometry=Rings), unworn, LimitingState(HERTZ, ratio)
    unworn = LinePartialSlip(LINE, FRICTION, ratio * FRICTION * PER_LENGTH)
    return on_strips(load_ratio=ratio), unworn, LineLimitingState(LINE, ratio)


def at_onset(kind, displacement_ratio):
    """The same on wider cells, under a displacement in units of its value at gross slip."""
    problem, *_ = on_cells(kind, 0.5)
    compliance = {} if kind == "rings" else {"tangential_compliance": 1e-10}
    loading = DisplacementRatio(displacement_ratio=displacement_ratio, **compliance)
    plain = loading.plain(FRICTION, problem.coupling, problem.hertz)
    return replace(problem, loading=plain, coarseness=2.0)


BOTH = pytest.mark.parametrize("kind", ["rings", "strips"])
RATIOS = pytest.mark.parametrize("ratio", [0.2, 0.9])


@BOTH
@RATIOS
def test_unworn_contact_is_that_of_cattaneo_and_mindlin(kind, ratio):
    problem, theory, _ = on_cells(kind, ratio)
    state, hertz = first_loading(problem), theory.hertz
    found, rings = Measures(problem, state), kind == "rings"
    assert found.approach == near(hertz.approach, rel=1e-4 if rings else 1e-5)
    assert found.central_pressure == near(hertz.peak_pressure, rel=1e-4)
    assert found.contact_half_width_x == near(hertz.contact_radius, rel=2e-3 if rings else 6e-4)
    assert found.stick_half_width_x == near(theory.stick_radius, rel=2e-4)
    assert found.tangential_displacement == near(theory.tangential_displacement, rel=2e-4)
    assert found.dissipated_energy == near(theory.dissipated_energy, rel=3e-3 if rings else 1e-3)
    x, slip = state.geometry.x, problem.slip(state.reduced)[:, 0]
    np.testing.assert_allclose(
        slip, theory.slip(x), atol=2e-3 * slip[x < hertz.contact_radius].max()
    )
    weighted = state.geometry.integral(state.pressure * problem.slip(state.reduced))
    assert problem.means(state, state.geometry).slip == near(weighted / state.load, rel=1e-5)
    wide = state.on(Workspace(problem), state.geometry.reaching(2.0 * hertz.contact_radius))
    x_beyond = wide.geometry.x[x.size :]
    np.testing.assert_allclose(wide.gap[x.size :, 0], hertz.gap(x_beyond), rtol=1e-3)
    pressure = state.pressure[:, 0]
    # The cell that the edge crosses has the mean of its pressure.
    error = np.abs(pressure - hertz.pressure(x)) / hertz.peak_pressure
    assert error.max() < 0.03
    assert np.partition(error, -2)[-2] < 3e-3


@pytest.mark.slow
@BOTH
@RATIOS
def test_endless_wear_reaches_the_limiting_state(kind, ratio):
    problem, theory, limit = on_cells(kind, ratio)
    cycles = 60 if kind == "rings" else 1e4
    *_, last = evolve(problem, [cycles / (problem.wear_growth * theory.hertz.peak_pressure)])
    found, rel = Measures(problem, last), 3e-3 if kind == "rings" else 1e-3
    assert found.approach == near(limit.approach, rel=1e-4 if kind == "rings" else 1e-5)
    assert found.central_pressure == near(limit.central_pressure, rel=1e-3)
    assert last.wear.max() == near(limit.deepest_wear, rel=rel)
    assert found.wear_volume == near(limit.wear_volume, rel=rel)
    assert found.contact_half_width_x == near(limit.contact_radius, rel=rel)
    assert found.stick_half_width_x == near(limit.stick_radius, rel=1e-3)


def test_influence_is_symmetric_and_that_of_discs():
    edges = np.array([0.0, 0.3, 0.31, 0.7, 1.4, 1.9])
    influence = mean_influence(edges)
    np.testing.assert_allclose(influence, influence.T, rtol=1e-13)
    # Everything under one pressure is a disc: in the mean it sinks by 16 p a/3πE*.
    assert influence.sum() == near(16.0 / 3.0 * 1.9**3, rel=1e-13)

    def sunk(r):
        """Displacement × E* at r within a disc of radius 1.4 minus that within one of 0.7."""
        outer, inner = (4 / math.pi * b * ellipe((r / b) ** 2) for b in (1.4, 0.7))
        return 2 * math.pi * r * (outer - inner)

    expected = [quad(sunk, *edges[i : i + 2], epsabs=0)[0] for i in range(3)]
    np.testing.assert_allclose(influence[:3, 3], expected, rtol=1e-11)
    line = Strips((0.0, 1e-6, 3e-6, 8e-6, 1e-5), 6e-3)
    influence = line.areas * line.influence(1e11)
    np.testing.assert_allclose(influence, influence.T, rtol=1e-6)
    assert np.linalg.eigvalsh(0.5 * (influence + influence.T)).min() > 0


def test_influence_of_narrow_rings_adds_up_to_that_of_wide_ones():
    """They are differences of discs of nearly the same radius, which leave no digits by themselves.

    The exact difference is accurate to a millionth for rings a 10 000th of the radius wide.
    """
    ends = np.array([0.4, 0.9998, 0.9999, 1.0, 1.0001, 1.3])
    expected = mean_influence(np.insert(ends, 0, 0.0))[1:, 1:]
    edges = np.unique(np.concatenate([np.linspace(*ends[i : i + 2], 41) for i in range(1, 4)]))
    parts = mean_influence(np.concatenate([[0.0, 0.4], edges, [1.3]]))[1:, 1:]
    starts = [0, 1, 41, 81, 121]
    found = np.add.reduceat(np.add.reduceat(parts, starts, axis=0), starts, axis=1)
    np.testing.assert_allclose(found, expected, rtol=3e-6)
    # Small discs within large ones: 2b/E* in the middle.
    small = mean_influence(np.array([0.0, 1e-6, 1.1e-6, 1.0]))[:2].sum(axis=1)
    np.testing.assert_allclose(small, 2.0 * np.pi * np.diff([0.0, 1e-12, 1.21e-12]), rtol=1e-9)


@BOTH
@pytest.mark.parametrize("ratio", [1e-3, 1 - 1e-9])
def test_narrow_zones_of_slip_and_stick_are_those_of_cattaneo_and_mindlin(kind, ratio):
    problem, theory, _ = on_cells(kind, ratio)
    found = Measures(problem, first_loading(problem))
    # A stick zone of a cylinder is narrower than a strip, and none of a sphere.
    assert found.dissipated_energy == near(theory.dissipated_energy, rel=3e-3)
    if kind == "rings":
        assert found.stick_half_width_x == near(theory.stick_radius, rel=1e-4)


@pytest.mark.slow
@BOTH
def test_pressure_in_the_middle_is_continuous_where_the_contact_begins_to_slide(kind):
    """As little as sticks or is left open within a rounding of U_t, it is no cell of its own."""
    steps = 10.0 ** np.arange(-15.0, -3.1, 3.0)
    ratios, worn = [1.0, 1.0 - 1.2e-16, *(1.0 - steps), *(1.0 + steps)], {}
    for ratio in ratios:
        problem = at_onset(kind, ratio)
        state = first_loading(problem)
        peak = problem.hertz.peak_pressure
        assert state.pressure[0, 0] == near(peak, rel=1e-3), ratio
        if ratio in ratios[:6:2]:
            *_, last = evolve(problem, [1.0 / (problem.wear_growth * peak)])
            worn[ratio] = last.pressure[0, 0] / peak
    # It changes by less over a thousandth of U_t.
    np.testing.assert_allclose([*worn.values()], worn[1.0], rtol=5e-3)


def test_rings_cover_the_disc_are_finest_at_the_edge_and_move_fields_by_cubics():
    rings = graded_rings(Grading(A, 1.2 * A, A, 2e-4 * A), 2.0 * A)
    widths = np.diff(rings.edges)
    assert rings.edges[0] == 0.0
    assert rings.edges[-1] == near(2.0 * A)
    assert widths.min() > 0
    assert min(abs(each - A) for each in rings.edges) < 1e-12 * A
    at_edge = np.argmin(np.abs(np.asarray(rings.edges) - A))
    np.testing.assert_allclose(widths[at_edge - 1 : at_edge + 1], 2e-4 * A, rtol=0.15)
    assert widths.max() <= 0.016 * 1.2 * A * (1 + 1e-9)
    assert rings.integral(np.ones(rings.shape)) == near(4 * math.pi * A**2)
    # The mean of r² over a ring equals the mean of the squares of its radii.
    assert (rings.areas[:, 0] * rings.x**2).sum() == near(0.5 * math.pi * (2 * A) ** 4)
    # As scipy has them, to the last bit, which takes longer to import than a short run.
    random = np.random.default_rng(1)
    for signs in 20 * (0.0, 1.0):
        places = np.concatenate([[0.0], np.cumsum(random.random(80) ** 3 + 1e-6)])
        values = np.cumsum(random.standard_normal(81) + 2.0 * (1.0 - signs))
        others = np.sort(random.random(99)) * places[-1]
        expected = PchipInterpolator(places, values)(others)
        np.testing.assert_array_equal(interpolated(places, values, others), expected)


def test_bodies_that_sink_far_less_than_their_approach_meet_on_the_narrowest_rings():
    """As worn ones do at a tiny reduced load: rounding of heights is all that may be left."""
    rings = graded_rings(Grading(0.0, A, A, 3e-6 * A), 1.3 * A)
    bodies, unworn = rings.half_space(MODULUS), fretting().unworn(rings)
    for offset in (0.0, 10.0 * HERTZ.approach, 100.0 * HERTZ.approach):
        problem = ContactProblem(bodies, unworn + offset, LOAD)
        found = solve_contact(problem, tolerance=1e-8)
        assert found.approach - offset == near(HERTZ.approach, rel=1e-7)
        # Rounding of sums of some hundred terms.
        assert found.residual < 1e-13 * (1.0 + offset / HERTZ.approach)


def test_fields_on_a_plane_are_those_along_the_radius():
    problem = fretting(geometry=Rings)
    state = first_loading(problem)
    plane = state.geometry.plane(problem.spacing)
    assert plane.spacing == problem.spacing
    assert np.hypot(*plane.extent) <= state.geometry.edges[-1]
    assert plane.extent[0] > 1.1 * A
    r = np.hypot(plane.x[:, None], plane.y)
    sticks = state.reduced.stick
    found = state.geometry.written({"pressure": state.pressure, "sticks": sticks}, plane)
    np.testing.assert_allclose(found["pressure"], HERTZ.pressure(r), atol=0.05 * P0)
    inside, parts = r < 0.95 * A, (np.arange(8) - 3.5) / 8.0
    x, y = (
        centres[:, None] + parts * size
        for centres, size in zip((plane.x, plane.y), plane.spacing, strict=True)
    )
    within = HERTZ.pressure(np.hypot(x[:, None, :, None], y[None, :, None, :])).mean(axis=(2, 3))
    np.testing.assert_allclose(found["pressure"][inside], within[inside], rtol=2e-3)
    assert found["pressure"].max() <= state.pressure.max()
    area = 4.0 * np.prod(problem.spacing)
    assert area * found["pressure"].sum() == near(LOAD, rel=1e-10)
    edge = problem.hertz.with_load(problem.stick_load).contact_radius
    np.testing.assert_array_equal(found["sticks"], r < edge)


def test_a_zone_with_a_hole_covers_the_cells_of_a_plane_between_its_edges():
    rings = Rings(tuple(np.linspace(0.0, 1.2, 61) * A))
    cells = ((rings.x > 0.4 * A) & (rings.x < 0.8 * A))[:, None]
    region, plane = Region(cells, 0.8 * A), rings.plane((0.02 * A, 0.02 * A))
    covered = rings.covered(region, plane)
    assert plane.integral(covered) == near(rings.zone(region).area, rel=1e-9)
    assert rings.zone(region).area == near(np.pi * (0.64 - 0.16) * A**2, rel=0.01)
    radius = np.hypot(plane.x[:, None], plane.y) / A
    assert covered[(radius < 0.36) | (radius > 0.82)].max() == 0.0
    assert covered[(radius > 0.45) & (radius < 0.78)].min() == near(1.0)


def test_no_written_mean_lies_beyond_the_values_around_it():
    """Where a field rises more and more steeply, such as beside a singular edge."""
    strips = Strips(tuple(1e-6 * np.arange(9.0)), 6e-3)
    rising = np.array([0.0, 0.0, 0.01, 1.0, 1.0, 1.01, 3.0, 3.0])[:, None]
    plane = strips.plane((1e-7, 1e-7))
    means = strips.written({"pressure": rising}, plane)["pressure"]
    assert means.min() >= 0.0
    assert means.max() <= 3.0
    assert (np.diff(means[:, 0]) >= -1e-12).all()
    assert means.sum() * 1e-7 == near(rising.sum() * 1e-6)


def test_the_peak_of_rings_that_yield_is_the_limit_beyond_which_cubics_take_no_pressure():
    problem = fretting(limit=1.5, geometry=Rings)
    *_, state = evolve(problem, [1000])
    assert Measures(problem, state).peak_pressure == problem.plastic_limit
    others = graded_rings(Grading(0.4 * A, 1.1 * A, A, 2e-4 * A), state.geometry.edges[-1])
    assert state.geometry.resized(state.pressure, others).max() > problem.plastic_limit
    assert state.on(Workspace(problem), others).pressure.max() == problem.plastic_limit


def test_the_peak_at_the_edge_of_stick_is_the_mean_over_one_cell():
    problem, _, limit = on_cells("rings", 0.5)
    state = first_loading(problem)
    c, h = limit.stick_radius, min(problem.spacing)
    load, _ = quad(lambda r: 2.0 * np.pi * r * limit.pressure(r), c - h, c)
    fine = Rings(tuple(np.linspace(0.0, c, 2001)))
    worn = replace(state, geometry=fine, pressure=limit.pressure(fine.x)[:, None])
    peak = load / (np.pi * (2.0 * c - h) * h)
    # Of 2√h, the middle of the last ring, of a width d, misses 0.59 √d: 2.6 %.
    assert Measures(problem, worn).peak_pressure == near(peak, rel=0.03)


@pytest.mark.slow
def test_a_punch_with_rounded_edges():
    """Half-widths of contact and stick, pressures and approach; and many cycles later."""
    share = 0.8
    punch = FlatPunch(flat_half_width=1e-4, edge_radius=6e-3)
    unit = punch.hertz(NormalLoad(1.0), CYLINDER_BODIES.composite_modulus)
    load = unit.load_at(1e-4 / share)
    hertz = unit.with_load(load)
    problem = on_strips(
        load_ratio=0.5,
        indenter=punch,
        normal=NormalLoad(load),
        extent=(1.15 * hertz.contact_radius, 1.15 * hertz.contact_radius),
    )
    state = first_loading(problem)
    found = Measures(problem, state)
    assert found.contact_half_width_x == near(1e-4 / share, rel=1e-3)
    stick = hertz.with_load(0.5 * load)
    assert found.stick_half_width_x == near(stick.contact_radius, rel=1e-4)
    assert found.central_pressure == near(float(hertz.pressure(0.0)), rel=1e-4)
    assert found.peak_pressure == near(hertz.peak_pressure, rel=1e-3)
    assert found.approach == near(hertz.approach, rel=1e-5)
    *_, last = evolve(problem, [1e4 / (problem.wear_growth * hertz.peak_pressure)])
    found, limiting = Measures(problem, last), LineLimitingState(hertz, 0.5)
    assert found.central_pressure == near(limiting.central_pressure, rel=1e-3)
    assert found.approach == near(limiting.approach, rel=1e-4)


def driven(ratio, compliance):
    """A cylinder under a displacement, over that which slides it as a whole unworn."""
    loading = DisplacementRatio(displacement_ratio=ratio, tangential_compliance=compliance)
    return on_strips(loading=loading.plain(FRICTION, 1.0, LINE))


# Compliances of large bodies, and of bodies smaller than their radius.
@pytest.mark.parametrize(("ratio", "compliance"), [(0.2, 3e-11), (0.9, 5e-12), (1.5, 5e-12)])
def test_displacement_over_the_slope_of_the_loop(ratio, compliance):
    """U = C Q + (µP/πE*) [X + (1 − X) ln(1 − X)], whatever the approach counts from."""
    problem = driven(ratio, compliance)
    state = first_loading(problem)
    found = Measures(problem, state)
    sliding, force = FRICTION * PER_LENGTH, found.tangential_force
    stuck = 1.0 - force / sliding
    slip = sliding / (math.pi * CYLINDER_BODIES.composite_modulus)
    slip *= 1.0 - stuck + (stuck * math.log(stuck) if stuck > 0.0 else 0.0)
    displacement = problem.loading.displacement_amplitude
    if ratio < 1.0:
        assert compliance * force + slip == near(displacement, rel=1e-5)
        assert found.stick_half_width_x == near(EDGE * math.sqrt(stuck), rel=1e-4)
    else:
        assert (force, found.regime) == (near(sliding), 1.0)
        assert compliance * force + slip == near(displacement / ratio, rel=1e-9)
        slid = found.tangential_displacement
        energy = gross_slip_energy(LINE, FRICTION, 1.0, slid)
        assert found.dissipated_energy == near(energy, rel=1e-3)
    curve = loop(Workspace(problem), state)
    assert np.trapezoid(curve.force, curve.displacement) == near(found.dissipated_energy, rel=1e-3)
    assert curve.displacement.max() == near(displacement, rel=1e-5)


@pytest.mark.slow
def test_strips_widen_with_a_contact_that_slides_as_a_whole(monkeypatch):
    """Far fewer of them give the same scar as strips of the first width throughout."""
    problem = driven(20.0, 3e-11)
    cycles = 0.25 / (problem.wear_growth * LINE.peak_pressure)
    *_, last = evolve(problem, [0.01 * cycles, cycles])
    monkeypatch.setattr(grading, "_WIDEST_SLIDING", 0.0)
    *_, fine = evolve(problem, [0.01 * cycles, cycles])
    found, expected = Measures(problem, last), Measures(problem, fine)
    assert found.contact_half_width_x > 3.0 * EDGE
    assert last.pressure.size < 0.5 * fine.pressure.size
    for name in ("contact_half_width_x", "peak_pressure", "approach", "dissipated_energy"):
        assert getattr(found, name) == near(getattr(expected, name), rel=5e-4)
    integral = last.geometry.integral
    assert integral(last.wear) == near(fine.geometry.integral(fine.wear), rel=1e-4)
    assert last.wear.max() == near(fine.wear.max(), rel=1e-4)


@pytest.mark.slow
def test_wear_under_a_displacement_against_explicit_steps():
    """Euler's steps of the contacts under P and P*, the latter by bisection of the condition."""
    problem = driven(0.8, 5e-12)
    cycles = 2.0 / (problem.wear_growth * LINE.peak_pressure)
    *_, last = evolve(problem, [cycles])
    line = Strips(tuple(np.linspace(0.0, 1.5 * EDGE, 121)), LINE.radius)
    bodies, unworn = problem.half_space(line), problem.unworn(line)
    wear, steps, start = np.zeros(line.shape), 40, None
    for step in range(steps + 1):
        shape = unworn + wear
        contact = solve_contact(ContactProblem(bodies, shape, PER_LENGTH), start)
        start = contact.pressure

        def excess(load, shape=shape, contact=contact):
            found = solve_contact(ContactProblem(bodies, shape, load), contact.pressure)
            passed = contact.approach - found.approach + problem.flexibility * (PER_LENGTH - load)
            return FRICTION * passed - problem.loading.displacement_amplitude

        held = brentq(excess, 1e-3 * PER_LENGTH, PER_LENGTH, xtol=1e-6 * PER_LENGTH)
        stuck = solve_contact(ContactProblem(bodies, shape, held), start)
        if step < steps:
            wear += problem.wear_growth * cycles / steps * start * np.maximum(stuck.gap, 0.0)
    assert last.geometry.integral(last.wear) == near(line.integral(wear), rel=2e-3)
    assert last.reduced.load == near(held, rel=4e-3)
    assert last.reduced.load > 1.05 * problem.stick_load


def test_waves_across_the_line():
    """In full contact waves A cos kx add −(E*kA/2) cos kx to the pressure: Westergaard (1939)."""
    length = 0.25 * EDGE
    height = 0.2 * LINE.peak_pressure * length / (math.pi * CYLINDER_BODIES.composite_modulus)
    waves = WavyRoughness(height, math.atan(4.0 * height / length), 0.0)
    problem = on_strips(load_ratio=0.5, roughness=waves, spacing=(length / 32, length / 32))
    state = first_loading(problem)
    x, pressure = state.geometry.x, state.pressure[:, 0]
    inside = x < 2.0 * length
    ripple = (pressure - LINE.pressure(x))[inside] / LINE.peak_pressure
    expected = -0.2 * np.cos(2.0 * math.pi * x[inside] / length)
    assert ripple == pytest.approx(expected, abs=4e-3)
    assert state.geometry.integral(state.pressure) == near(PER_LENGTH)


@pytest.mark.slow
def test_edges_of_ridges_lie_anywhere_in_a_strip_without_bias():
    """A ridge on either side of the centre line, on strips and on ones an eighth as wide."""
    width, middle, errors = 3e-6, 150e-6, []

    def zone(strip, load):
        edges = np.arange(round(240e-6 / strip) + 1) * strip
        strips = Strips(tuple(edges.tolist()), LINE.reference)
        shape = ((strips.x - middle) ** 2 / (2.0 * RADIUS))[:, None]
        found = solve_contact(ContactProblem(strips.half_space(MODULUS), shape, load))
        closed = found.pressure > 0.0
        edge = half_width(strips.axis_cells(0), closed, found.gap, plane_strain=True)
        return strips.zone(Region(closed, edge))

    # Two ridges share the load.
    for half in (12.0 + np.arange(24) / 24.0) * width:
        load = 0.5 * math.pi * MODULUS * half**2 / RADIUS
        coarse, fine = zone(width, load), zone(width / 8, load)
        assert coarse.inside.size == 2
        errors.append(coarse.area - fine.area)
    assert abs(np.mean(errors)) < 0.03 * 2.0 * width
    # The outer edges are known to a tenth of a strip, the inner ones lie anywhere in it.
    stated = 2.0 * width * math.hypot(0.1, 1.0 / math.sqrt(12.0))
    assert 0.8 < np.sqrt(np.mean(np.square(errors))) / stated < 1.2
