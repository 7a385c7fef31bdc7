"""Steps that fail are shortened; a run that cannot go on says where and why."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.integrator import WearError, evolve, first_loading
from fretwear.mechanics.slip import Jaeger

from .problems import P0, fretting, near


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


def states_and_error(problem, cycles):
    """What a run yields until it ends with an error."""
    states = []

    def collect():
        for state in evolve(problem, [cycles]):
            states.append(state)

    with pytest.raises(WearError) as error:
        collect()
    return states, error.value


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
    states, error = states_and_error(fretting(12, slip_model=TroubledSlip(deepest=half_way)), 2000)
    last = states[-1]
    assert 500 < last.cycle < 2000
    assert f"no step after cycle {last.cycle:.6g} is accurate" in str(error)
    assert "the slip model does not go that far: residual 1.0e+00" in str(error)
    assert f"has a residual of {last.residual:.1e}" in str(error)
    going_on = next(evolve(fretting(12), [2000], start=last))
    assert going_on.cycle > last.cycle, "the last state is sound"


def test_an_accuracy_that_cannot_be_met_is_told_with_the_estimate():
    problem = fretting(12)
    with pytest.raises(WearError, match=r"the error is estimated as .*e-.* instead of 1.0e-15"):
        list(evolve(problem, [2000], 1e-15, start=first_loading(problem)))


def test_steps_to_values_that_are_not_finite_are_shortened_as_well():
    states = list(evolve(fretting(12, slip_model=PoisonedSlip()), [20_000]))
    assert states[-1].cycle == 20_000
    assert len(states) > len(list(evolve(fretting(12), [20_000])))
    for state in states:
        for name in ("pressure", "gap", "wear", "plastic"):
            assert np.isfinite(getattr(state, name)).all()
        assert np.isfinite(state.reduced.gap).all()


def test_a_run_to_values_that_are_not_finite_ends_before_them():
    states, error = states_and_error(fretting(12, slip_model=PoisonedSlip(most=0.0)), 2000)
    assert [state.cycle for state in states] == [0.0]
    assert "not finite" in str(error)
