"""A limit of pressure that friction lowers: p² + αq² ≤ p_lim²."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactProblem, solve_contact
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.slip.models import CattaneoMindlin, Coupled, Jaeger
from fretwear.mechanics.surfaces.laws import Archard
from fretwear.mechanics.surfaces.loading import DisplacementRatio, SlidingAmplitude
from fretwear.mechanics.surfaces.materials import Coulomb
from fretwear.mechanics.values import OverCycles
from fretwear.mechanics.wear.integrator import evolve, first_loading
from fretwear.mechanics.wear.measures import Measures
from fretwear.mechanics.wear.stroke import slide
from fretwear.mechanics.wear.window import first_cells

from ..studies import near
from .problems import (
    COUPLING,
    DEPTH,
    EDGE,
    FRICTION,
    HERTZ,
    LINE,
    LOAD,
    P0,
    ROUGH,
    STUDY_LIMIT,
    VOLUME,
    A,
    fretting,
    independent,
    on_strips,
)

ALPHA = 9.0
GROWTH = ALPHA * FRICTION**2


def cycles_of(problem, tau):
    return tau / (problem.wear_growth * problem.hertz.peak_pressure)


def excess(problem, state):
    """How far √(p² + αq²) is beyond the limit in each cell, relative to it."""
    now = problem.of(state)
    sheared = state.reduced.sheared
    one_way = now.shear_traction(state.pressure, state.reduced)
    shear = one_way if sheared is None else np.hypot(*sheared.traction)
    equivalent = np.sqrt(state.pressure**2 + now.junction_growth * shear**2)
    return equivalent / problem.plastic_limit - 1.0


@pytest.mark.parametrize("geometry", [Rings, Grid])
def test_where_bodies_first_yield_by_the_closed_forms_of_pressure_and_traction(geometry):
    r = np.linspace(0.0, 1.0, 100_001) * A
    stuck = HERTZ.with_load(0.2 * LOAD).pressure(r)
    equivalent = np.sqrt(HERTZ.pressure(r) ** 2 + GROWTH * (HERTZ.pressure(r) - stuck) ** 2)
    onset = r[np.argmax(equivalent)]
    assert 0.0 < onset < A
    fields = {"junction_growth": ALPHA, "geometry": geometry}
    below, above = (
        first_loading(fretting(48, limit=part * equivalent.max() / P0, **fields))
        for part in (1.01, 0.99)
    )
    assert not below.plastic.any()
    radius = np.hypot(*np.meshgrid(above.geometry.x, above.geometry.y, indexing="ij"))
    depth = above.plastic
    assert float((radius * depth).sum() / depth.sum()) == near(onset, rel=0.05)
    assert excess(fretting(limit=0.99 * equivalent.max() / P0, **fields), above).max() < 1e-5


@pytest.mark.parametrize("geometry", [Grid, Rings])
def test_a_limit_of_each_cell_is_kept_like_one_of_all(geometry):
    problem = fretting(24, geometry=geometry)
    cells = first_cells(problem)
    bodies, shape = problem.half_space(cells), problem.unworn(cells)

    def pressed(limit):
        return solve_contact(ContactProblem(bodies, shape, LOAD, limit), tolerance=1e-9)

    one, each = pressed(0.8 * P0), pressed(np.full(cells.shape, 0.8 * P0))
    np.testing.assert_allclose(each.pressure, one.pressure, atol=1e-9 * P0)
    np.testing.assert_allclose(each.penetration, one.penetration, atol=1e-8 * HERTZ.approach)
    radius = np.hypot(*np.meshgrid(cells.x, cells.y, indexing="ij"))
    limit = P0 * (0.7 + 0.3 * (radius / A) ** 2)
    found = pressed(limit)
    gap = bodies.displacement(found.pressure) + shape - found.approach
    slack, free = 1e-8 * HERTZ.approach, (found.pressure > 0) & (found.pressure < limit)
    assert (found.pressure <= limit).all()
    assert found.saturated.sum() > 10 < free.sum()
    assert np.abs(gap[free]).max() < slack
    assert gap[found.saturated].max() < slack
    assert cells.integral(found.pressure) == near(LOAD)


SLIDES = DisplacementRatio(displacement_ratio=1.3).plain(FRICTION, COUPLING, HERTZ)


@pytest.mark.slow
@pytest.mark.parametrize(
    "contact", [{"geometry": Rings}, {"roughness": ROUGH, "slip_model": Coupled()}]
)
def test_gross_slip_is_that_under_the_limit_over_the_root_of_one_and_alpha_squared_friction(
    contact,
):
    limit = 1.6
    grown = fretting(16, loading=SLIDES, limit=limit, junction_growth=ALPHA, **contact)
    capped = fretting(16, loading=SLIDES, limit=limit / math.sqrt(1.0 + GROWTH), **contact)
    cycles = [cycles_of(grown, 2.0)]
    *_, found = evolve(grown, cycles)
    *_, expected = evolve(capped, cycles)
    assert found.plastic.any()
    for name in ("wear", "plastic", "pressure"):
        one, right = (each.geometry.integral(getattr(each, name)) for each in (found, expected))
        assert one == near(right, rel=1e-6), name


@pytest.mark.slow
def test_strokes_yield_at_the_limit_of_the_friction_of_the_moment():
    limit = 2.6
    fields = {"loading": SlidingAmplitude(0.15 * EDGE), "wear_law": Archard((2e-14, 1e-14))}

    def slid(limit, friction, alpha=0.0):
        fields.update(junction_growth=alpha, friction_law=Coulomb(friction))
        return list(slide(on_strips(12, limit=limit * LINE.peak_pressure / P0, **fields), [9]))

    lowered = limit / math.sqrt(1.0 + ALPHA * 0.9**2)
    steady, expected = slid(limit, 0.9, ALPHA)[-1], slid(lowered, 0.9)[-1]
    np.testing.assert_array_equal(steady.pressures, expected.pressures)
    np.testing.assert_array_equal(steady.worn, expected.worn)
    first, *_, last = slid(limit, OverCycles(cycles=(0, 5), values=(0.3, 0.9)), ALPHA)
    assert not first.plastic.any()
    assert last.plastic.any()
    for state in (steady, last):
        assert state.pressures.max() == near(lowered * LINE.peak_pressure, rel=1e-9)


CONTACTS = {
    "rings under a displacement": fretting(
        limit=1.7,
        geometry=Rings,
        loading=DisplacementRatio(displacement_ratio=0.8).plain(FRICTION, COUPLING, HERTZ),
    ),
    "strips": on_strips(load_ratio=0.6, limit=1.2 * LINE.peak_pressure / P0),
    "two directions": fretting(16, limit=2.0, slip_model=Coupled()),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTACTS)
def test_no_cell_exceeds_the_limit_and_less_pressure_yields_than_without_friction(name):
    problem = replace(CONTACTS[name], junction_growth=ALPHA)
    cycles = cycles_of(problem, 3.0)
    *_, without = evolve(CONTACTS[name], [cycles])
    for state in evolve(problem, [cycles]):
        over_limit, load = excess(problem, state), problem.hertz.load
        # A cell at the edge of stick, between two sweeps.
        assert over_limit.max() < 0.03
        assert state.geometry.integral(np.maximum(over_limit, 0.0) * state.pressure) < 3e-4 * load
    sunk = state.plastic > 0.0
    assert sunk.any()
    assert state.geometry.integral(state.plastic) > without.geometry.integral(without.plastic)
    stuck = state.reduced.stick & (state.pressure > problem.slip_limit)
    assert stuck.any(), "cells that stick bear more than those that slip"


def test_models_differ_in_what_flow_leaves_in_the_stick_zone():
    """The traction if the reduced contact follows the shape, else the reduced pressure."""
    limit, r = STUDY_LIMIT * P0, np.linspace(0.0, 0.5, 7)[:, None] * A
    reduced = replace(first_loading(fretting(8)).reduced, pressure=HERTZ.pressure(r))
    for model in (Jaeger(), CattaneoMindlin()):
        stuck = reduced.pressure
        pressure = model.limit(limit, GROWTH, stuck + 0.3 * limit, reduced)
        traction = 0.3 * limit if model.follows_shape else pressure - stuck
        np.testing.assert_allclose(np.hypot(pressure, math.sqrt(GROWTH) * traction), limit)


# The tolerance of a step is 1 %, and errors of steps mend each other.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("ratio", "limit", "alpha", "taus"),
    [
        (0.5, math.inf, 0.0, (1.0, 10.0)),
        (0.9, STUDY_LIMIT, 0.0, (1.0, 5.0, 10.0)),
        (0.5, STUDY_LIMIT, ALPHA, (5.0, 10.0)),
        (0.8, STUDY_LIMIT, ALPHA, (3.0, 5.0)),
    ],
)
def test_wear_is_that_of_the_independent_reference(ratio, limit, alpha, taus):
    known = independent(ratio, limit, alpha * FRICTION**2)
    problem = fretting(load_ratio=ratio, limit=limit, junction_growth=alpha, geometry=Rings)
    times = {cycles_of(problem, tau): tau for tau in taus}
    for state in evolve(problem, sorted(times)):
        if state.cycle in times:
            found, expected = Measures(problem, state), known[times[state.cycle]]
            assert found.approach / DEPTH == near(expected["approach"], rel=1e-3)
            assert found.central_pressure / P0 == near(expected["central_pressure"], rel=1e-3)
            assert found.wear_volume / VOLUME == near(expected["wear_volume"], rel=5e-3)
            assert state.wear.max() / DEPTH == near(expected["deepest_wear"], rel=5e-3)
            assert found.stick_half_width_x / A == near(expected["stick_radius"], rel=5e-3)
    within = 0.02 if alpha else 0.03
    assert found.plastic_volume / VOLUME == near(expected["plastic_volume"], rel=within)
