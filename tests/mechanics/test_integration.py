"""The integrator against explicit steps, endless wear and invariances; steps that fail."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.integrator import WearError, evolve, first_loading
from fretwear.mechanics.loading import NormalLoad
from fretwear.mechanics.materials import Archard, Coulomb
from fretwear.mechanics.measures import measure
from fretwear.mechanics.slip import Jaeger
from fretwear.mechanics.state import State
from fretwear.mechanics.surfaces import Sphere
from fretwear.theory import HertzContact, LimitingState

from .explicit import Worn, explicit_wear
from .problems import (
    CONVERGED,
    COUPLING,
    EVEN,
    FRICTION,
    HERTZ,
    LOAD,
    MODULUS,
    P0,
    RADIUS,
    ROUGH,
    SMOOTH,
    WEAR,
    A,
    Elastic,
    Waves,
    fretting,
    near,
    uneven,
)

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


def test_the_error_estimate_of_each_step_is_within_the_tolerance():
    for tolerance in (0.01, 0.001):
        states = list(evolve(fretting(12, roughness=ROUGH, limit=2.0), [2000], tolerance))
        estimates = [state.error_estimate for state in states[1:]]
        # A step a little above is kept, not made again.
        assert max(estimates) <= 1.3 * tolerance
        assert max(estimates) > 0.2 * tolerance


@dataclass(frozen=True)
class TroubledSlip(Jaeger):
    """The slip model of the tests; long stages (x at p0) and deep wear at their start break it."""

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


@pytest.mark.slow
def test_endless_wear_is_the_limiting_state():
    """30000 cycles at 110 cells per Hertz radius."""
    problem, limit = fretting(110, load_ratio=0.5), LimitingState(HERTZ, 0.5)
    *_, last = evolve(problem, (100, 1000, 7000, 30000))
    found, grid = measure(problem, last), last.geometry
    assert found.central_pressure == near(limit.central_pressure, rel=5e-3)
    assert found.wear_volume == near(limit.wear_volume, rel=0.01)
    assert last.wear.max() == near(limit.deepest_wear, rel=0.01)
    for width in (found.contact_half_width_x, found.contact_half_width_y):
        assert width == near(limit.contact_radius, rel=0.01)
    r = np.hypot(*np.meshgrid(grid.x, grid.y, indexing="ij"))
    # Close to the edge of stick the limit is singular and no grid follows it.
    inside = r < 0.8 * limit.stick_radius
    np.testing.assert_allclose(last.pressure[inside], limit.pressure(r)[inside], rtol=0.01)
    # Worn surfaces conform without pressure.
    worn = (r > limit.stick_radius + A / 55) & (r < limit.contact_radius - A / 55)
    assert last.pressure[worn].max() < 1e-3 * HERTZ.peak_pressure
    assert last.gap[worn].max() < 1e-3 * HERTZ.approach
    # The stick zone is made of whole cells.
    assert np.abs(last.wear - limit.wear_depth(r)).sum() / last.wear.sum() < 0.01


CYCLES = 400.0
few = settings(max_examples=12)


def final(problem, cycles=CYCLES, accuracy=None):
    *_, state = evolve(problem, [cycles], accuracy=accuracy)
    return state


def scaled(factor):
    """Factors from 1/factor to factor, evenly on a logarithmic scale."""
    return st.floats(-1, 1).map(lambda power: factor**power)


@few
@given(
    factors=st.tuples(*map(scaled, (1e4, 1e3, 1e4, 3, 1.5, 100))),
    surface=st.sampled_from([SMOOTH, ROUGH]),
    limit=st.sampled_from([np.inf, 1.4]),
    ratio=st.floats(0.3, 0.9),
)
def test_only_dimensionless_groups_matter(factors, surface, limit, ratio):
    """Q/µP, τ = β p0 N, p_lim/p0, A/δ and k a: all else is a choice of units."""
    radius, modulus, load, friction, coupling, wear = factors
    problem = fretting(8, load_ratio=ratio, roughness=surface, limit=limit)
    hertz = HertzContact(RADIUS * radius, LOAD * load, MODULUS * modulus)
    a, p0 = hertz.contact_radius, hertz.peak_pressure
    waves = surface and Waves(
        ROUGH.amplitude * hertz.approach / HERTZ.approach,
        ROUGH.wavenumber_x * A / a,
        ROUGH.wavenumber_y * A / a,
    )
    other = replace(
        problem,
        indenter=Sphere(hertz.radius),
        roughness=waves,
        bodies=Elastic(hertz.composite_modulus, COUPLING * coupling),
        normal=NormalLoad(hertz.load),
        friction=Coulomb(FRICTION * friction),
        wear_law=Archard(WEAR * wear),
        limit=limit * p0,
        spacing=(a / 8, a / 8),
        extent=(1.15 * a, 1.15 * a),
    )
    cycles = CYCLES * problem.growth_rate * P0 / (other.growth_rate * p0)
    one, two = final(problem), final(other, cycles)
    assert one.step == two.step
    # The same numbers up to rounding, as long as it flips no decision of the contact solver;
    # where it does, contacts are equal to their tolerance of 1e-6.
    np.testing.assert_allclose(two.pressure / p0, one.pressure / P0, atol=1e-5)
    for field in ("wear", "plastic", "gap"):
        found, expected = getattr(two, field), getattr(one, field)
        np.testing.assert_allclose(found / hertz.approach, expected / HERTZ.approach, atol=1e-5)
    assert two.geometry.integral(two.wear) > 0


@pytest.mark.parametrize("limit", [np.inf, 1.4])
@pytest.mark.parametrize("even", EVEN)
def test_turning_roughness_and_grid_turns_the_fields(limit, even):
    spacing = (A / 10, A / 14)
    surface = uneven(ROUGH, even)
    turned = Waves(ROUGH.amplitude, ROUGH.wavenumber_y, ROUGH.wavenumber_x, even[::-1])
    one, other = (
        final(fretting(roughness=waves, limit=limit, spacing=cell), accuracy=CONVERGED)
        for waves, cell in ((surface, spacing), (turned, spacing[::-1]))
    )
    assert one.pressure.shape == other.pressure.shape[::-1]
    np.testing.assert_allclose(one.pressure, other.pressure.T, atol=1e-9 * P0)
    np.testing.assert_allclose(one.wear, other.wear.T, atol=1e-9 * HERTZ.approach)
    # The waves are not alike along x and y, so something was turned.
    assert not np.allclose(one.wear[:9, :9], one.wear[:9, :9].T, atol=1e-3 * HERTZ.approach)


@pytest.mark.parametrize("limit", [np.inf, 1.4])
def test_further_stops_change_the_wear_by_less_than_the_tolerance(limit):
    problem = fretting(12, roughness=ROUGH, limit=limit)
    *_, often = evolve(problem, [17, 60, 61, 200, 1000], 0.01)
    seldom = final(problem, 1000)
    difference = np.abs(often.wear - seldom.wear).sum() / seldom.wear.sum()
    assert 0 < difference < 0.01
