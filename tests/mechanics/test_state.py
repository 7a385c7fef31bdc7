"""The first loading, a state on a larger window, and one implicit stage."""

from dataclasses import replace

import numpy as np
import pytest

from fretwear.mechanics import stages
from fretwear.mechanics.contact import ContactError, ContactProblem
from fretwear.mechanics.geometry import Workspace
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.integrator import evolve, first_loading
from fretwear.mechanics.slip import Jaeger, WearLayer
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.stages import StageSolver

from .problems import EVEN, HERTZ, LOAD, P0, ROUGH, SMOOTH, A, covered, fretting, uneven

KINDS = {
    "smooth": {},
    "rough": {"roughness": ROUGH},
    "smooth capped": {"limit": 0.8},
    "rough capped": {"roughness": ROUGH, "limit": 1.2},
}


@pytest.mark.parametrize("kind", ["smooth capped", "rough capped"])
def test_first_loading_yields_where_the_pressure_is_at_its_limit_and_sinks_for_good(kind):
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
def test_first_window_grows_until_it_holds_the_contact(kind):
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


@pytest.mark.parametrize("even", EVEN)
def test_a_larger_window_keeps_every_field_and_computes_the_gaps_outside(even):
    problem = fretting(12, roughness=uneven(ROUGH, even), limit=1.2)
    *_, state = evolve(problem, [200])
    nx, ny = state.geometry.shape
    window = Grid((nx + 14, ny + 28), state.geometry.spacing, even)
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


def stage_after(problem, cycles, exponent):
    """A state after some cycles and the stage after it, x = ``exponent`` (0.3 p₀ + 0.7 p₁)/p0."""
    *_, state = evolve(problem, [cycles], 1e-3)
    base = state
    solver = StageSolver(Workspace(problem), state.geometry, 1e-4)
    known = 0.3 * exponent * base.pressure / P0
    nothing = np.zeros(state.geometry.shape)
    return base, solver.solve(base, known, 0.7 * exponent / P0, base.pressure, nothing, 1e-6)


def exponent_of(base, stage, exponent):
    return exponent * (0.3 * base.pressure + 0.7 * stage.pressure) / P0


@pytest.mark.parametrize("surface", [SMOOTH, ROUGH], ids=["smooth", "rough"])
def test_cells_that_lose_their_pressure_stop_wearing_when_they_touch(surface):
    problem = fretting(16, roughness=surface)
    base, stage = stage_after(problem, 200, 10.0)
    window = replace(next(evolve(problem, [0])).geometry, shape=stage.pressure.shape)
    shape = problem.unworn(window) + stage.wear
    gap = problem.half_space(window).displacement(stage.pressure) + shape - stage.approach
    # So long a stage takes all pressure from cells that it wears: wear must not open a gap there.
    emptied = (stage.pressure == 0) & (stage.wear > base.wear)
    assert emptied.any()
    assert np.abs(gap[emptied]).max() <= 2e-6 * HERTZ.approach
    # What is not worn off adds nothing to g* either.
    np.testing.assert_allclose(stage.source_since(base), 0.0, atol=1e-12 * HERTZ.approach)
    np.testing.assert_allclose(stage.gap, gap, atol=2e-6 * HERTZ.approach)
    overshot = np.expm1(exponent_of(base, stage, 10.0)) * base.reduced.gap
    assert (overshot - (stage.wear - base.wear))[emptied].max() > 1e-3 * HERTZ.approach


@pytest.mark.parametrize("surface", [SMOOTH, ROUGH], ids=["smooth", "rough"])
def test_wear_of_a_yielding_stage_is_that_of_the_flow_it_ends_with(surface):
    problem = fretting(16, roughness=surface, limit=1.3)
    base, stage = stage_after(problem, 1200, 0.3)
    assert stage.yielded
    grew = stage.plastic > base.plastic
    assert (stage.pressure[grew] == problem.limit).all()
    shift = stage.source_since(base)
    nothing = np.zeros_like(shift)
    whole = WearLayer(base.wear, base.reduced.gap, shift, nothing, 1.0)
    expected = whole.displacement(exponent_of(base, stage, 0.3))
    loaded = stage.pressure > 0
    error = np.abs(stage.wear - expected)[loaded].sum()
    # Sweeps stop at 0.002 of the tolerance 1e-4 of the volume, and converge by halves at least.
    assert error <= 1e-6 * stage.wear.sum()
    assert np.abs(shift).max() > 1e-3 * HERTZ.approach


def test_flow_that_does_not_settle_is_an_error(monkeypatch):
    problem = fretting(16, limit=1.3)
    *_, state = evolve(problem, [1200])
    base = state
    monkeypatch.setattr(stages, "_LARGEST_SWEEPS", 1)
    solver = StageSolver(Workspace(problem), state.geometry, 1e-4)
    nothing = np.zeros(state.geometry.shape)
    with pytest.raises(ContactError):
        solver.solve(base, nothing, 0.3 / P0, base.pressure, nothing, 1e-6)
