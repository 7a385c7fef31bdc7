"""Normal contacts that are hard to solve, and the fallbacks of their solvers alone."""

import numpy as np
import pytest

from fretwear.mechanics.contact import dense, solver
from fretwear.mechanics.contact.gradients import projected_gradients
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactError, ContactProblem, solve_contact
from fretwear.mechanics.surfaces.laws import Archard
from fretwear.mechanics.surfaces.loading import SlidingAmplitude
from fretwear.mechanics.surfaces.materials import Coulomb
from fretwear.mechanics.wear import rubbing, stroke
from fretwear.mechanics.wear.rubbing import Rubbing

from .hard_contacts import RATIOS, SEEDS, hard_family
from .problems import EDGE, LINE, P0, on_strips


@pytest.mark.parametrize("seed", SEEDS)
def test_normal_contacts_converge_at_every_load(seed):
    family = hard_family(seed)
    for place, ratio in enumerate(RATIOS):
        problem = family(ratio)
        found = solve_contact(problem, tolerance=1e-8)
        assert found.residual <= 1e-8
        assert np.all((found.pressure >= 0.0) & (found.pressure <= problem.limit))
        if place % 20 == 0:
            slow = projected_gradients(problem, problem.first_guess(), 1e-8)
            error = np.abs(slow.pressure - found.pressure).max()
            # The condition number stands between the residual and the error.
            assert error <= 1e-5 * found.pressure.max()


@pytest.mark.parametrize("seed", SEEDS[:12])
def test_projected_gradients_solve_normal_contacts_alone(seed, monkeypatch):
    for ratio in RATIOS[4::25]:
        problem = hard_family(seed)(ratio)
        expected = solve_contact(problem, tolerance=1e-8)
        with monkeypatch.context() as without:
            without.setattr(solver, "_ACTIVE_SET_STEPS", 0)
            without.setattr(dense, "_SOLUTIONS", 0)
            found = solve_contact(problem, tolerance=1e-8)
        assert found.residual <= 1e-8
        assert np.abs(found.pressure - expected.pressure).max() <= 1e-5 * found.pressure.max()
        assert found.approach == pytest.approx(expected.approach, rel=1e-7)
        assert (found.stiffness is None) == (expected.stiffness is None)
        if expected.stiffness is not None:
            change = np.abs(found.stiffness - expected.stiffness).max()
            assert change <= 1e-4 * np.abs(expected.stiffness).max()


def test_pressures_carry_the_load_from_any_guess_under_any_limits():
    random, grid = np.random.default_rng(1), Grid((10, 8), (0.1, 0.1), (False, False))
    shape, start = np.zeros(grid.shape), random.standard_normal(grid.shape)
    # Most cells bear half of the mean pressure at most.
    uneven = np.where(random.random(grid.shape) < 0.9, 0.5, 20.0)
    for limit in (np.inf, 1.1, uneven):
        problem = ContactProblem(grid.half_space(1.0), shape, grid.integral(shape + 1.0), limit)
        for guess in (0.0 * start, start, 1e-20 * start, 1e9 * start, -1.0 + 0.0 * start):
            for result in (problem.clip_to_load(guess), problem.projected(guess)[0]):
                rounding = 1e-16 * np.abs(guess).sum()
                assert result.sum() == pytest.approx(start.size, rel=1e-12, abs=rounding)
                assert np.all((result >= 0.0) & (result <= limit))


@pytest.mark.parametrize("limit", [np.inf, 0.7])
@pytest.mark.parametrize("worn", [0.0, 0.3])
def test_projected_gradients_solve_the_contacts_of_a_stroke_alone(limit, worn, monkeypatch):
    problem = on_strips(
        6,
        loading=SlidingAmplitude(0.3 * EDGE),
        wear_law=Archard((1.9e-14, 2.9e-14)),
        friction_law=Coulomb(0.9),
        limit=limit * LINE.peak_pressure / P0,
    )
    strokes = Rubbing(problem, (16, 1))
    inside = np.abs(strokes.x - strokes.places[:, None]) < EDGE
    opening = np.zeros((2, *strokes.geometry.shape))
    # Wear that lowers pressures by a good part.
    compliance = worn * float(strokes.influence[0, 0, 0]) * np.array([1.9, 2.9])[:, None, None]
    expected = strokes.solve(opening, compliance, inside[..., None].astype(float))
    monkeypatch.setattr(rubbing, "_LARGEST_SWEEPS", 0)
    found = strokes.solve(opening, compliance, inside[..., None].astype(float))
    for field, exact in zip(found, expected, strict=True):
        assert np.abs(field - exact).max() <= 1e-7 * max(np.abs(exact).max(), 1e-12)
    assert (found.flow.max() > 0.0) == (limit < 1.0)


def test_flow_of_a_stroke_that_does_not_settle_is_an_error(monkeypatch):
    problem = on_strips(
        6, loading=SlidingAmplitude(0.3 * EDGE), limit=0.7 * LINE.peak_pressure / P0
    )
    monkeypatch.setattr(stroke, "_LARGEST_PASSES", 1)
    with pytest.raises(ContactError, match="did not settle in 1"):
        next(stroke.slide(problem, (1.0,)))
