"""One implicit stage: consistent in itself, elastic and yielding."""

from dataclasses import replace

import numpy as np
import pytest

from fretwear.mechanics import stages
from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.geometry import Workspace
from fretwear.mechanics.integrator import evolve
from fretwear.mechanics.slip import WearLayer
from fretwear.mechanics.stages import StageSolver
from fretwear.mechanics.state import Stage, WearProblem

from .problems import HERTZ, P0, ROUGH, SMOOTH, fretting

SURFACES = {"smooth": SMOOTH, "rough": ROUGH}


def stage_after(problem: WearProblem, cycles: float, exponent: float) -> tuple[Stage, Stage]:
    """A state after some cycles and the stage after it, x = ``exponent`` (0.3 p₀ + 0.7 p₁)/p0."""
    *_, state = evolve(problem, [cycles], 1e-3)
    base = state
    solver = StageSolver(Workspace(problem), state.geometry, 1e-4)
    known = 0.3 * exponent * base.pressure / P0
    nothing = np.zeros(state.geometry.shape)
    return base, solver.solve(base, known, 0.7 * exponent / P0, base.pressure, nothing, 1e-6)


def exponent_of(base: Stage, stage: Stage, exponent: float) -> np.ndarray:
    return exponent * (0.3 * base.pressure + 0.7 * stage.pressure) / P0


@pytest.mark.parametrize("name", SURFACES)
def test_an_elastic_stage_wears_by_its_own_pressure_and_leaves_the_stick_zone(name: str):
    base, stage = stage_after(fretting(16, roughness=SURFACES[name]), 200, 0.5)
    growth = np.expm1(exponent_of(base, stage, 0.5))
    loaded = stage.pressure > 0
    expected = base.wear + growth * base.reduced.gap
    np.testing.assert_allclose(stage.wear[loaded], expected[loaded], rtol=1e-12)
    np.testing.assert_array_equal(stage.reduced.stick, base.reduced.stick)
    assert not stage.reduced.gap[stage.reduced.stick].any()
    assert not stage.wear[stage.reduced.stick].any()
    assert not stage.yielded
    np.testing.assert_allclose(stage.source_since(base), 0.0, atol=1e-12 * HERTZ.approach)


@pytest.mark.parametrize("name", SURFACES)
def test_cells_that_lose_their_pressure_stop_wearing_when_they_touch(name: str):
    problem = fretting(16, roughness=SURFACES[name])
    base, stage = stage_after(problem, 200, 10.0)
    window = problem_window(problem, stage)
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


def problem_window(problem: WearProblem, stage: Stage):
    *_, state = evolve(problem, [0])
    return replace(state.geometry, shape=stage.pressure.shape)


@pytest.mark.parametrize("name", SURFACES)
def test_wear_of_a_yielding_stage_is_that_of_the_flow_it_ends_with(name: str):
    problem = fretting(16, roughness=SURFACES[name], limit=1.3)
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
