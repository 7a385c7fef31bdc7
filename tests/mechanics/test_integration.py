"""The integrator against explicit steps and smaller errors; steps that fail, and runs."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.integrator import WearError, evolve, first_loading
from fretwear.mechanics.slip import Jaeger
from fretwear.mechanics.state import State

from .explicit import Worn, explicit_wear
from .problems import P0, ROUGH, A, fretting, near

RUNS = {
    "smooth": ({}, 2000),
    "rough": ({"roughness": ROUGH}, 1500),
    "smooth capped": ({"limit": 1.5}, 2500),
    "rough capped": ({"roughness": ROUGH, "limit": 1.8}, 2500),
    "yielding from the first loading": ({"limit": 0.9}, 1200),
}


@dataclass(frozen=True)
class Reference:
    """A run, and what explicit steps make of it at 8 cells per Hertz radius."""

    name: str
    worn: Worn
    integrated: dict[float, State]


@pytest.fixture(scope="module", params=RUNS)
def reference(request):
    """Two explicit runs, one with half the steps, extrapolated; and the integrator's own."""
    changes, cycles = RUNS[request.param]
    problem = fretting(8, extent=(1.7 * A, 1.7 * A), **changes)
    integrated = {}
    for tolerance in (0.01, 0.001):
        *_, integrated[tolerance] = evolve(problem, [cycles], tolerance)
    window = integrated[0.01].geometry
    # 0.002 / (β p0) a step: a tenth of the stable one on this grid, and a twentieth.
    steps = round(problem.growth_rate * P0 * cycles / 0.02)
    coarse, fine = (explicit_wear(problem, window, cycles, n) for n in (steps, 2 * steps))
    extrapolated = Worn(
        *(2 * getattr(fine, f) - getattr(coarse, f) for f in ("wear", "plastic", "pressure")),
        reduced_gap=fine.reduced_gap,
    )
    return Reference(request.param, extrapolated, integrated)


def test_small_explicit_steps_are_met_within_the_tolerance(reference):
    for tolerance, state in reference.integrated.items():
        expected = reference.worn.wear
        assert np.abs(state.wear - expected).sum() <= tolerance * expected.sum()
    found, expected = reference.integrated[0.001], reference.worn
    error = np.abs(found.pressure - expected.pressure).sum()
    assert error <= 0.002 * expected.pressure.sum()
    # The extrapolation of a depth that starts and stops at cells of its own is worth 0.1 %.
    assert np.abs(found.plastic - expected.plastic).sum() <= 0.002 * expected.plastic.sum()
    assert expected.plastic.any() == (reference.name not in ("smooth", "rough"))
    np.testing.assert_array_equal(found.reduced.stick, expected.reduced_gap == 0)
    # Once the contact yields, the stick zone shrinks.
    start = next(evolve(fretting(8, extent=(1.7 * A, 1.7 * A), **RUNS[reference.name][0]), [0]))
    shrunk = found.reduced.stick.sum() < start.reduced.stick.sum()
    assert shrunk == ("capped" in reference.name)


@pytest.mark.parametrize(
    ("changes", "cycles"),
    [
        ({}, 7000),
        ({"roughness": ROUGH}, 7000),
        ({"limit": 2.0}, 5000),
        ({"roughness": ROUGH, "limit": 2.5}, 4000),
    ],
)
def test_a_halved_tolerance_changes_less_than_the_tolerance_promises(changes, cycles):
    problem = fretting(20, **changes)
    found = []
    for tolerance in (0.01, 0.005):
        *_, state = evolve(problem, [cycles], tolerance)
        fields = (state.wear, state.plastic, state.reduced.stick.astype(float))
        found.append([state.geometry.integral(field) for field in fields])
    # 1 % is promised for a step; the sum of the steps of a run keeps below it too.
    np.testing.assert_allclose(found[0], found[1], rtol=0.01)
    assert (found[0][1] > 0) == ("limit" in changes)


def test_the_error_estimate_of_each_step_is_within_the_tolerance():
    for tolerance in (0.01, 0.001):
        states = list(evolve(fretting(12, roughness=ROUGH, limit=2.0), [2000], tolerance))
        estimates = [state.error_estimate for state in states[1:]]
        # A step a little above is kept, not made again.
        assert max(estimates) <= 1.3 * tolerance
        assert max(estimates) > 0.2 * tolerance


@dataclass(frozen=True)
class TroubledSlip(Jaeger):
    """The slip model of the tests, except that long steps or deep wear break it.

    Parameters
    ----------
    longest
        Largest exponent that a stage may add at the Hertz pressure.
    deepest
        Largest wear depth at the start of a stage, m.
    """

    longest: float = math.inf
    deepest: float = math.inf

    def wear_layer(self, wear, gap, shift, exponent, rate):
        if rate * P0 > self.longest or wear.max() > self.deepest:
            raise ContactError("the slip model does not go that far: residual 1.0e+00")
        return super().wear_layer(wear, gap, shift, exponent, rate)


@dataclass(frozen=True)
class PoisonedSlip(Jaeger):
    """A slip model whose gap after long steps is not a number."""

    most: float = 1e-8

    def gap_after(self, gap, wear):
        after = super().gap_after(gap, wear)
        return np.where(wear > self.most, np.nan, after)


def test_a_step_that_fails_is_halved_until_it_succeeds():
    plain = list(evolve(fretting(12), [2000]))
    longest = max(after.cycle - before.cycle for before, after in pairwise(plain))
    rate = fretting(12).growth_rate * P0 * longest
    troubled = fretting(12, slip_model=TroubledSlip(longest=0.05 * rate))
    states = list(evolve(troubled, [2000]))
    steps = np.diff([state.cycle for state in states])
    assert steps.max() < 0.5 * longest
    assert states[-1].cycle == 2000
    volumes = [state.geometry.integral(state.wear) for state in (states[-1], plain[-1])]
    assert volumes[0] == near(volumes[1], rel=0.01)


def test_a_run_that_cannot_go_on_names_cycle_and_residuals_and_keeps_the_last_state():
    half_way = list(evolve(fretting(12), [1000]))[-1].wear.max()
    states = []
    with pytest.raises(WearError) as error:  # noqa: PT012 - the states before it count
        for state in evolve(fretting(12, slip_model=TroubledSlip(deepest=half_way)), [2000]):
            states.append(state)
    last = states[-1]
    assert 500 < last.cycle < 2000
    assert f"no step after cycle {last.cycle:.6g} is accurate" in str(error.value)
    assert "the slip model does not go that far: residual 1.0e+00" in str(error.value)
    assert f"has a residual of {last.residual:.1e}" in str(error.value)
    going_on = next(evolve(fretting(12), [2000], start=last))
    assert going_on.cycle > last.cycle, "the last state is sound"
    problem = fretting(12)
    with pytest.raises(WearError, match=r"the error is estimated as .*e-.* instead of 1.0e-15"):
        list(evolve(problem, [2000], 1e-15, start=first_loading(problem)))
    run = evolve(fretting(12, slip_model=PoisonedSlip(most=0.0)), [2000])
    assert next(run).cycle == 0.0
    with pytest.raises(WearError, match="not finite"):
        next(run)


def test_steps_to_values_that_are_not_finite_are_shortened_as_well():
    states = list(evolve(fretting(12, slip_model=PoisonedSlip()), [20_000]))
    assert states[-1].cycle == 20_000
    assert len(states) > len(list(evolve(fretting(12), [20_000])))
    for state in states:
        for name in ("pressure", "gap", "wear", "plastic"):
            assert np.isfinite(getattr(state, name)).all()
        assert np.isfinite(state.reduced.gap).all()
