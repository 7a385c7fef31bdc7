"""Smooth contacts on rings: closed forms, the independent reference, output on a grid."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator
from scipy.special import ellipe

from fretwear.mechanics.contact import ContactProblem
from fretwear.mechanics.geometry.dense import interpolated
from fretwear.mechanics.geometry.rings import Grading, Rings, mean_influence
from fretwear.mechanics.integrator import evolve, first_loading
from fretwear.mechanics.measures import measure
from fretwear.mechanics.solver import solve_contact
from fretwear.theory import CattaneoMindlin, LimitingState

from .problems import COUPLING, FRICTION, HERTZ, LOAD, MODULUS, P0, RADIUS, ROUGH, A, fretting, near

TABLE = Path(__file__).parent / "reference" / "smooth_wear.csv"
DEPTH, VOLUME = A**2 / RADIUS, A**4 / RADIUS
STUDY_LIMIT = 4500e6 / P0


def contact_on(rings, **conditions):
    bodies = rings.half_space(MODULUS)
    problem = ContactProblem(bodies, fretting().unworn(rings), **conditions)
    return solve_contact(problem, tolerance=1e-9)


@pytest.fixture(scope="module")
def rings():
    return Rings.graded(Grading(A, 1.2 * A, A, 2e-4 * A), 2.0 * A)


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


def test_rings_cover_the_disc_are_finest_at_the_edge_and_move_fields_by_cubics(rings):
    widths = np.diff(rings.edges)
    assert rings.edges[0] == 0.0
    assert rings.edges[-1] == near(2.0 * A)
    assert widths.min() > 0
    assert min(abs(each - A) for each in rings.edges) < 1e-12 * A
    at_edge = np.argmin(np.abs(np.asarray(rings.edges) - A))
    np.testing.assert_allclose(widths[at_edge - 1 : at_edge + 1], 2e-4 * A, rtol=0.15)
    assert widths.max() <= 0.016 * 1.2 * A * (1 + 1e-9)
    assert rings.integral(np.ones(rings.shape)) == near(4 * math.pi * A**2)
    # The mean of r² over a ring is that of its radii.
    assert (rings.areas[:, 0] * rings.x**2).sum() == near(0.5 * math.pi * (2 * A) ** 4)
    # As scipy has them, to the last bit, which takes longer to import than a short run.
    random = np.random.default_rng(1)
    for signs in (0.0, 1.0):
        places = np.concatenate([[0.0], np.cumsum(random.random(80) ** 3 + 1e-6)])
        values = np.cumsum(random.standard_normal(81) + 2.0 * (1.0 - signs))
        others = np.sort(random.random(99)) * places[-1]
        expected = PchipInterpolator(places, values)(others)
        np.testing.assert_array_equal(interpolated(places, values, others), expected)


@pytest.mark.parametrize("condition", ["load", "approach"])
def test_hertz_under_a_load_and_at_an_approach(rings, condition):
    given = {"load": LOAD} if condition == "load" else {"load": None, "approach": HERTZ.approach}
    found = contact_on(rings, **given)
    assert found.approach == near(HERTZ.approach, rel=1e-5)
    assert rings.integral(found.pressure) == near(LOAD, rel=1e-5)
    np.testing.assert_allclose(found.pressure[:, 0], HERTZ.pressure(rings.x), atol=3e-3 * P0)
    outside = rings.x > A
    np.testing.assert_allclose(
        found.gap[outside, 0], HERTZ.gap(rings.x[outside]), atol=2e-5 * HERTZ.approach
    )


def test_a_capped_contact_meets_its_conditions(rings):
    limit = 0.7 * P0
    found = contact_on(rings, load=LOAD, limit=limit)
    moved = rings.half_space(MODULUS).displacement(found.pressure)
    gap = moved + fretting().unworn(rings) - found.approach
    # Factors solve it to rounding, not to the tolerance: yielding may be less deep than that.
    slack = 1e-12 * moved.max()
    assert rings.integral(found.pressure) == near(LOAD, rel=1e-12)
    free = (found.pressure > 0) & (found.pressure < limit)
    assert np.abs(gap[free]).max() < slack
    assert gap[found.pressure == 0].min() > -slack
    assert gap[found.pressure == limit].max() < slack
    assert found.saturated.sum() > 20
    with pytest.raises(ValueError, match="rotational symmetry"):
        first_loading(fretting(roughness=ROUGH, geometry=Rings))


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.9])
def test_unworn_contact_is_that_of_cattaneo_and_mindlin(ratio):
    problem = fretting(load_ratio=ratio, geometry=Rings)
    found = measure(problem, first_loading(problem))
    theory = CattaneoMindlin(HERTZ, FRICTION, ratio * FRICTION * LOAD, COUPLING)
    assert found.approach == near(HERTZ.approach, rel=1e-4)
    assert found.central_pressure == near(P0, rel=1e-4)
    assert found.contact_half_width_x == near(A, rel=2e-3)
    assert found.contact_half_width_y == found.contact_half_width_x
    assert found.stick_half_width_x == near(theory.stick_radius, rel=2e-4)
    assert found.tangential_displacement == near(theory.tangential_displacement, rel=2e-4)
    assert found.dissipated_energy == near(theory.dissipated_energy, rel=3e-3)


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.9])
def test_endless_wear_reaches_the_limiting_state(ratio):
    problem = fretting(load_ratio=ratio, geometry=Rings)
    *_, last = evolve(problem, [60 / (problem.growth_rate * P0)])
    found, limit = measure(problem, last), LimitingState(HERTZ, ratio)
    assert found.approach == near(limit.approach, rel=1e-4)
    assert found.central_pressure == near(limit.central_pressure, rel=1e-3)
    assert last.wear.max() == near(limit.deepest_wear, rel=3e-3)
    assert found.wear_volume == near(limit.wear_volume, rel=3e-3)
    assert found.contact_half_width_x == near(limit.contact_radius, rel=3e-3)
    assert found.stick_half_width_x == near(limit.stick_radius, rel=1e-3)


def reference(ratio, limit):
    """What the independent solver found at each τ."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    return {
        row["tau"]: row
        for row in rows
        if row["load_ratio"] == ratio
        and (row["limit_ratio"] == limit or math.isclose(row["limit_ratio"], limit, rel_tol=1e-6))
    }


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.8, 0.9])
@pytest.mark.parametrize("limit", [math.inf, STUDY_LIMIT], ids=["elastic", "capped"])
def test_wear_is_that_of_the_independent_reference(ratio, limit):
    known = reference(ratio, limit)
    problem = fretting(load_ratio=ratio, limit=limit, geometry=Rings)
    times = {tau / (problem.growth_rate * P0): tau for tau in (0.5, 1.0, 3.0, 5.0, 10.0)}
    # The tolerance of a step is 1 %, and errors of steps mend each other.
    bound = 5e-3
    for state in evolve(problem, sorted(times)):
        if state.cycle not in times:
            continue
        found, expected = measure(problem, state), known[times[state.cycle]]
        assert found.approach / DEPTH == near(expected["approach"], rel=0.2 * bound)
        assert found.central_pressure / P0 == near(expected["central_pressure"], rel=0.2 * bound)
        assert state.wear.max() / DEPTH == near(expected["deepest_wear"], rel=bound)
        assert found.wear_volume / VOLUME == near(expected["wear_volume"], rel=bound)
    if limit == STUDY_LIMIT:
        assert found.plastic_volume > 0
        assert found.plastic_volume / VOLUME == near(expected["plastic_volume"], rel=0.03)


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
        at[:, None] + parts * size
        for at, size in zip((plane.x, plane.y), plane.spacing, strict=True)
    )
    within = HERTZ.pressure(np.hypot(x[:, None, :, None], y[None, :, None, :])).mean(axis=(2, 3))
    np.testing.assert_allclose(found["pressure"][inside], within[inside], rtol=2e-3)
    assert found["pressure"].max() <= state.pressure.max()
    area = 4.0 * np.prod(problem.spacing)
    assert area * found["pressure"].sum() == near(LOAD, rel=1e-10)
    edge = problem.hertz.with_load(problem.stick_load).contact_radius
    np.testing.assert_array_equal(found["sticks"], r < edge)
