"""The first loading, and a state put on a larger window."""

from dataclasses import replace

import numpy as np
import pytest

from fretwear.mechanics.contact import ContactProblem
from fretwear.mechanics.geometry import Even, Workspace
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.integrator import evolve, first_loading
from fretwear.mechanics.slip import Jaeger
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.state import State

from .problems import (
    EVEN,
    HERTZ,
    LOAD,
    P0,
    ROUGH,
    A,
    covered,
    fretting,
    uneven,
)

KINDS = {
    "smooth": {},
    "rough": {"roughness": ROUGH},
    "smooth capped": {"limit": 0.8},
    "rough capped": {"roughness": ROUGH, "limit": 1.2},
}


@pytest.mark.parametrize("kind", ["smooth capped", "rough capped"])
def test_first_loading_yields_where_the_pressure_is_at_its_limit_and_sinks_for_good(kind: str):
    problem = fretting(20, **KINDS[kind])
    state = first_loading(problem)
    assert (state.plastic > 0).any()
    assert (state.pressure[state.plastic > 0] == problem.limit).all()
    # Once sunk, the shape carries the load without a limit, at the same pressure.
    bodies = problem.half_space(state.geometry)
    shape = problem.unworn(state.geometry) + state.plastic
    again = solve_contact(ContactProblem(bodies, shape, LOAD), tolerance=1e-8)
    np.testing.assert_allclose(again.pressure, state.pressure, atol=1e-4 * P0)
    reduced = Jaeger().reduced(problem, bodies, shape)
    np.testing.assert_allclose(state.reduced.gap, reduced.gap, atol=3e-8 * HERTZ.approach)
    assert not np.allclose(
        reduced.gap,
        Jaeger().reduced(problem, bodies, shape - state.plastic).gap,
        atol=1e-4 * HERTZ.approach,
    )


@pytest.mark.parametrize("kind", KINDS)
def test_first_window_grows_until_it_holds_the_contact(kind: str):
    problem = fretting(20, **KINDS[kind])
    # Large enough to carry the load at the limit, too small for the contact.
    reach = 0.5 if problem.limit == np.inf else 0.95
    small = first_loading(replace(problem, extent=(reach * A, 0.95 * A)))
    large = first_loading(replace(problem, extent=(2 * A, 2 * A)))
    assert not any(small.geometry.touched(small.pressure))
    assert small.geometry.extent[0] < large.geometry.extent[0]
    moved = small.on(Workspace(problem), large.geometry)
    # Two windows, two solutions to 1e-6 of the displacement: that much of K⁻¹ apart.
    np.testing.assert_allclose(moved.pressure, large.pressure, atol=1e-4 * P0)
    np.testing.assert_allclose(moved.gap, large.gap, atol=3e-6 * HERTZ.approach)
    np.testing.assert_allclose(moved.reduced.gap, large.reduced.gap, atol=3e-6 * HERTZ.approach)


def grown(state: State, cells: int) -> Grid:
    nx, ny = state.geometry.shape
    return Grid((nx + 2 * cells, ny + 4 * cells), state.geometry.spacing, state.geometry.even)


@pytest.mark.parametrize("even", EVEN)
def test_a_larger_window_keeps_every_field_and_computes_the_gaps_outside(even: Even):
    problem = fretting(12, roughness=uneven(ROUGH, even), limit=1.2)
    *_, state = evolve(problem, [200])
    window = grown(state, 7)
    moved = state.on(Workspace(problem), window)
    inside = covered(window, state.geometry)
    for name in ("pressure", "gap", "wear", "plastic", "pressure_rate", "source_rate"):
        field, before = getattr(moved, name), getattr(state, name)
        np.testing.assert_array_equal(field[inside], before.ravel(), err_msg=name)
        assert name == "gap" or not field[~inside].any()
    np.testing.assert_array_equal(moved.reduced.gap[inside], state.reduced.gap.ravel())
    np.testing.assert_array_equal(moved.reduced.pressure[inside], state.reduced.pressure.ravel())
    # Where nothing touches, both gaps are those of the deformed surfaces and never negative.
    bodies, unworn = problem.half_space(window), problem.unworn(window)
    for gap, pressure, approach in (
        (moved.gap, moved.pressure, moved.approach),
        (moved.reduced.gap, moved.reduced.pressure, moved.reduced.approach),
    ):
        expected = bodies.displacement(pressure) + unworn - approach
        np.testing.assert_allclose(gap[~inside], expected[~inside], rtol=1e-12)
        assert gap[~inside].min() > 0


def test_a_window_of_the_same_shape_changes_nothing():
    problem = fretting(12)
    state = first_loading(problem)
    assert state.on(Workspace(problem), Grid(state.geometry.shape, state.geometry.spacing)) is state
