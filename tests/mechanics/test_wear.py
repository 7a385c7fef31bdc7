"""Wear over cycles: every step, explicit steps, endless wear, invariances; steps that fail."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fretwear.mechanics.contact.problem import ContactError
from fretwear.mechanics.slip.models import Jaeger, Pressed, WearLayer
from fretwear.mechanics.surfaces.indenters import Sphere
from fretwear.mechanics.surfaces.laws import Archard
from fretwear.mechanics.surfaces.loading import DisplacementRatio, SlidingAmplitude
from fretwear.mechanics.surfaces.materials import Coulomb
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.wear import stage as stages
from fretwear.mechanics.wear.integrator import Evolution, WearError, evolve
from fretwear.mechanics.wear.rubbing import Rubbing
from fretwear.mechanics.wear.stage import Exposure
from fretwear.mechanics.wear.state import Workspace
from fretwear.mechanics.wear.window import first_cells
from fretwear.theory import HertzContact

from ..studies import near
from .oracles import extrapolated_wear, worst_violation
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
    covered,
    fretting,
    on_strips,
    uneven,
)

STOPS = (100, 1000, 2500)
RUNS = {
    "smooth": {},
    "rough": {"roughness": ROUGH},
    "rough capped": {"roughness": ROUGH, "limit": 2.0},
    "capped under friction": {"roughness": ROUGH, "limit": 3.2, "junction_growth": 9.0},
    "yielding from the first loading": {"limit": 0.9},
    "nearly sliding": {"load_ratio": 0.95, "limit": 2.0},
}
# Where explicit steps are compared with.
CYCLES = {"rough": 1500, "rough capped": 2500}
CYCLES |= {"yielding from the first loading": 1200, "capped under friction": 1700}
ELASTIC = [name for name, changes in RUNS.items() if "limit" not in changes]
CAPPED = [name for name in RUNS if name not in ELASTIC]


@pytest.fixture(scope="module")
def runs():
    """Every state of each run, at 16 cells per Hertz radius."""
    problems = {name: fretting(16, **changes) for name, changes in RUNS.items()}
    return {name: (problem, list(evolve(problem, STOPS))) for name, problem in problems.items()}


@pytest.mark.parametrize("name", RUNS)
def test_every_step_meets_the_conditions_of_contact_and_wears_on(runs, name):
    problem, states = runs[name]
    # In the time 1/(β p_lim) wear frees a cell at the limit: longer steps would miss its flow.
    freed = 1.0 / (problem.wear_growth * problem.slip_limit)
    for earlier, later in pairwise(states):
        assert later.cycle - earlier.cycle <= 1.2 * freed or not later.yielded
    for state in states:
        assert worst_violation(problem, state) <= 1e-5, state.cycle
        assert state.residual <= 1e-6
        assert state.pressure.min() >= 0
        assert state.pressure.max() <= problem.plastic_limit
        # A worn cell touches to rounding; nothing overlaps.
        assert state.gap.min() >= -1e-15 * A
        assert state.reduced.gap.min() >= 0
        assert not any(state.geometry.touched(state.pressure)), "the window holds the contact"
    extents = [state.geometry.extent for state in states]
    assert all(b >= a for a, b in pairwise(extents))
    moved = [state.on(Workspace(problem), states[-1].geometry) for state in states]
    for field in ("wear", "plastic"):
        depths = [getattr(state, field) for state in moved]
        for earlier, later in pairwise(depths):
            assert (later >= earlier).all()
        assert not depths[0].any() or field == "plastic"
    assert depths[-1].any() == (name in CAPPED)
    # Wear makes surfaces conform; cells that have touched once touch for ever.
    if name in ELASTIC:
        for earlier, later in pairwise([state.in_contact for state in moved]):
            assert not (earlier & ~later).any()


@pytest.mark.parametrize("name", ELASTIC)
def test_stick_cells_of_an_elastic_run_are_the_same_to_the_last_bit(runs, name):
    problem, states = runs[name]
    first = states[0].on(Workspace(problem), states[-1].geometry)
    stick = first.reduced.stick
    assert stick.any()
    for state in states:
        moved = state.on(Workspace(problem), states[-1].geometry)
        np.testing.assert_array_equal(moved.reduced.stick, stick)
        np.testing.assert_array_equal(moved.reduced.pressure, first.reduced.pressure)
        assert not moved.reduced.gap[stick].any()
        assert not moved.wear[stick].any()
        # What wears off adds to the gap of the reduced contact, and nothing else changes it.
        grown = moved.reduced.gap - first.reduced.gap
        np.testing.assert_allclose(grown, moved.wear, atol=1e-12 * HERTZ.approach)


@pytest.mark.parametrize("name", CAPPED)
def test_slip_of_a_yielding_run_is_that_of_its_current_shape(runs, name):
    problem, states = runs[name]
    for state in states:
        shape = problem.unworn(state.geometry) + state.wear + state.plastic
        bodies = problem.half_space(state.geometry)
        pressed = Pressed(
            bodies, shape, state.pressure, state.gap, state.approach, problem.unworn_sliding
        )
        own = problem.slip_model.reduced(problem, pressed)
        np.testing.assert_array_equal(state.reduced.stick, own.stick)
        # Steps without flow add wear to the gap; the contacts behind it were solved to 1e-8.
        np.testing.assert_allclose(state.reduced.gap, own.gap, atol=1e-6 * HERTZ.approach)
    areas = [state.geometry.integral(state.reduced.stick.astype(float)) for state in states]
    assert areas[-1] <= areas[0]
    # Where yielding starts with the first loading, the stick zone holds out longest.
    assert areas[-1] < areas[0] or "first loading" in name


def test_a_growing_window_gives_what_a_large_one_gives(runs):
    problem, states = runs["rough capped"]
    roomy = replace(problem, extent=(1.9 * A, 1.9 * A))
    *_, large = evolve(roomy, STOPS)
    small = states[-1].on(Workspace(problem), large.geometry)
    assert states[0].geometry.extent < states[-1].geometry.extent < large.geometry.extent
    # Contacts solved to 1e-6 of the displacement; the wear of one step enters the next.
    np.testing.assert_allclose(small.pressure, large.pressure, atol=1e-3 * P0)
    np.testing.assert_allclose(small.wear, large.wear, atol=1e-5 * HERTZ.approach)
    np.testing.assert_allclose(small.gap, large.gap, atol=1e-5 * HERTZ.approach)


def test_a_stop_does_not_slow_down_the_next_step(runs):
    problem, states = runs["smooth"]
    earlier = states[len(states) // 2]
    stop = earlier.cycle + 0.01 * earlier.next_step
    (stopped,) = evolve(problem, [stop], start=earlier)
    assert stopped.next_step >= earlier.next_step


@pytest.mark.parametrize("even", [EVEN[0], EVEN[2]])
def test_a_larger_window_keeps_every_field_and_computes_the_gaps_outside(even):
    problem = fretting(12, roughness=uneven(ROUGH, even), limit=1.2)
    *_, state = evolve(problem, [200])
    x, y = state.geometry.extent
    window = state.geometry.covering((1.3 * x, 1.6 * y))
    moved = state.on(Workspace(problem), window)
    inside = covered(window, state.geometry)
    for name in ("pressure", "gap", "wear", "plastic", "pressure_rate", "source_rate"):
        field, kept = getattr(moved, name), getattr(state, name)
        np.testing.assert_array_equal(field[inside], kept.ravel(), err_msg=name)
        assert name == "gap" or not field[~inside].any()
    np.testing.assert_array_equal(moved.reduced.gap[inside], state.reduced.gap.ravel())
    np.testing.assert_array_equal(moved.reduced.pressure[inside], state.reduced.pressure.ravel())
    # Off contact, both gaps follow from the deformed surfaces and are never negative.
    bodies, unworn = problem.half_space(window), problem.unworn(window)
    for gap, pressure, approach in (
        (moved.gap, moved.pressure, moved.approach),
        (moved.reduced.gap, moved.reduced.pressure, moved.reduced.approach),
    ):
        expected = bodies.displacement(pressure) + unworn - approach
        np.testing.assert_allclose(gap[~inside], expected[~inside], rtol=1e-12)
        assert gap[~inside].min() > 0


def test_cells_that_lose_their_pressure_stop_wearing_when_they_touch():
    problem = fretting(8, roughness=ROUGH)
    # A stage of x = 3 p₀/p0 + 7 p₁/p0.
    *_, base = evolve(problem, [200], 1e-3)
    window, known, nothing = base.geometry, 3.0 * base.pressure / P0, np.zeros_like(base.pressure)
    steps = Evolution(problem, base, tolerance=1e-4)
    stage = steps.stage(base, problem, Exposure(known, 7.0 / P0), base.pressure, nothing, 1e-6)
    shape = problem.unworn(window) + stage.wear
    gap = problem.half_space(window).displacement(stage.pressure) + shape - stage.approach
    # So long a stage takes all pressure from cells that it wears: wear must not open a gap there.
    emptied = (stage.pressure == 0) & (stage.wear > base.wear)
    assert emptied.any()
    assert np.abs(gap[emptied]).max() <= 2e-6 * HERTZ.approach
    # What is not worn off adds nothing to g* either.
    np.testing.assert_allclose(
        stage.source_since(base, problem.slip_model), 0.0, atol=1e-12 * HERTZ.approach
    )
    np.testing.assert_allclose(stage.gap, gap, atol=2e-6 * HERTZ.approach)
    overshot = np.expm1(known + 7.0 * stage.pressure / P0) * base.reduced.gap
    assert (overshot - (stage.wear - base.wear))[emptied].max() > 1e-3 * HERTZ.approach


@pytest.mark.parametrize("withheld", [0.0, 0.2])
def test_keeping_all_debris_is_the_limit_of_keeping_nearly_all(withheld):
    gap, change, exponent, opens = *np.array([[[1.0, 0.0]], [[-0.9, 2.0]], [[0.7, 3.0]]]), 1e-7
    layer = WearLayer(0.0 * gap, gap, change, opens * exponent, 0.0, withheld=opens * withheld)
    opened = layer.displacement(0.0 * gap)
    nearly, every = (
        stages.all_worn(kept, opened, gap, gap + change, exponent, withheld)
        for kept in (1.0 - opens, 1.0)
    )
    np.testing.assert_allclose(every, nearly, rtol=1e-6)


def test_wear_of_a_yielding_stage_is_that_of_the_flow_it_ends_with(monkeypatch):
    problem = fretting(16, roughness=ROUGH, limit=1.3)
    *_, base = evolve(problem, [1200], 1e-3)
    known, nothing = 0.3 * base.pressure / P0, np.zeros(base.geometry.shape)
    steps = Evolution(problem, base, tolerance=1e-4)
    stage = steps.stage(base, problem, Exposure(known, 0.3 / P0), base.pressure, nothing, 1e-6)
    assert stage.yielded
    grew = stage.plastic > base.plastic
    assert (stage.pressure[grew] == problem.plastic_limit).all()
    shift = stage.source_since(base, problem.slip_model)
    assert np.abs(shift).max() > 1e-3 * HERTZ.approach
    whole = WearLayer(base.wear, base.reduced.gap, shift, nothing, 1.0)
    expected = whole.displacement(known + 0.3 * stage.pressure / P0)
    error = np.abs(stage.wear - expected)[stage.pressure > 0].sum()
    # Sweeps stop at 0.002 of the tolerance 1e-4 of the volume, and converge by halves at least.
    assert error <= 1e-6 * stage.wear.sum()
    # Flow that does not settle is an error.
    monkeypatch.setattr(stages, "_LARGEST_SWEEPS", 1)
    with pytest.raises(ContactError):
        steps.stage(base, problem, Exposure(nothing, 0.3 / P0), base.pressure, nothing, 1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "cycles"), CYCLES.items())
def test_small_explicit_steps_are_met_within_the_tolerance(name, cycles):
    problem = fretting(8, extent=(1.7 * A, 1.7 * A), **RUNS[name])
    window = first_cells(problem)
    # 0.002 / (β p0) a step: a tenth of the stable one on this grid, and a twentieth.
    steps = round(problem.wear_growth * P0 * cycles / 0.02)
    expected = extrapolated_wear(problem, window, cycles, steps)
    wear, plastic, pressure = expected.wear, expected.plastic, expected.pressure
    for tolerance in (0.01, 0.001):
        start, *_, found = evolve(problem, [cycles], tolerance)
        assert found.geometry == window
        assert np.abs(found.wear - wear).sum() <= tolerance * wear.sum()
    assert np.abs(found.pressure - pressure).sum() <= 0.002 * pressure.sum()
    # The extrapolation of a depth that starts and stops at cells of its own is worth 0.1 %.
    assert np.abs(found.plastic - plastic).sum() <= 0.002 * plastic.sum()
    assert plastic.any() == (name != "rough")
    np.testing.assert_array_equal(found.reduced.stick, expected.reduced_gap == 0)
    # Once the contact yields, the stick zone shrinks.
    assert (found.reduced.stick.sum() < start.reduced.stick.sum()) == ("capped" in name)


@pytest.mark.slow
def test_the_error_estimate_of_each_step_is_within_the_tolerance():
    """Within a quarter of it where all slides, as the pressure then errs more than the wear."""
    slides = DisplacementRatio(displacement_ratio=1.3).plain(FRICTION, COUPLING, HERTZ)
    for part, changes in ((1.0, {"roughness": ROUGH, "limit": 2.0}), (0.25, {"loading": slides})):
        for tolerance in (0.01, 0.001):
            states = list(evolve(fretting(12, **changes), [2000], tolerance))
            estimates = [state.error_estimate for state in states[1:]]
            # A step a little above is kept, not made again.
            assert max(estimates) <= 1.3 * part * tolerance
            assert max(estimates) > 0.2 * part * tolerance


@dataclass(frozen=True)
class TroubledSlip(Jaeger):
    """The slip model of the tests; long stages (x at p0) and deep wear at their start break it."""

    longest: float = math.inf
    deepest: float = math.inf

    def wear_layer(self, wear, gap, shift, exponent, rate, withheld=0.0):
        if rate * P0 > self.longest or wear.max() > self.deepest:
            raise ContactError("the slip model does not go that far: residual 1.0e+00")
        return super().wear_layer(wear, gap, shift, exponent, rate, withheld)


@dataclass(frozen=True)
class PoisonedSlip(Jaeger):
    """A slip model whose gap after any wear is not a number."""

    def gap_after(self, gap, wear):
        return np.where(wear > 0.0, np.nan, super().gap_after(gap, wear))


def test_a_step_that_fails_is_halved_until_it_succeeds():
    plain = list(evolve(fretting(12), [2000]))
    longest = max(later.cycle - earlier.cycle for earlier, later in pairwise(plain))
    rate = fretting(12).wear_growth * P0 * longest
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
    assert f"no step after cycle {last.cycle:.6g} is accurate" in str(error.value)
    assert "the slip model does not go that far: residual 1.0e+00" in str(error.value)
    going_on = next(evolve(fretting(12), [2000], start=last))
    assert going_on.cycle > last.cycle > 500, "the last state is sound"
    with pytest.raises(WearError, match=r"the error is estimated as .*e-.* instead of 1.0e-15"):
        list(evolve(fretting(12), [2000], 1e-15))
    run = evolve(fretting(12, slip_model=PoisonedSlip()), [2000])
    assert next(run).cycle == 0.0
    with pytest.raises(WearError, match="not finite"):
        next(run)


few = settings(max_examples=12)


def final(problem, cycles=400.0, accuracy=None):
    *_, state = evolve(problem, [cycles], accuracy=accuracy)
    return state


def scaled(factor):
    """Factors from 1/factor to factor, evenly on a logarithmic scale."""
    return st.floats(-1, 1).map(lambda power: factor**power)


@pytest.mark.slow
@few
@given(
    factors=st.tuples(*map(scaled, (1e3, 1e3, 1e4, 3, 1.5, 100))),
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
    similar = replace(
        problem,
        indenter=Sphere(hertz.radius),
        roughness=waves,
        bodies=Elastic(hertz.composite_modulus, COUPLING * coupling),
        normal=NormalLoad(hertz.load),
        friction_law=Coulomb(FRICTION * friction),
        wear_law=Archard(WEAR * wear),
        plastic_limit=limit * p0,
        spacing=(a / 8, a / 8),
        extent=(1.15 * a, 1.15 * a),
    )
    cycles = 400.0 * problem.wear_growth * P0 / (similar.wear_growth * p0)
    one, two = final(problem), final(similar, cycles)
    assert one.step == two.step
    # The same numbers up to rounding, as long as it flips no decision of the contact solver;
    # where it does, contacts are equal to their tolerance of 1e-6.
    np.testing.assert_allclose(two.pressure / p0, one.pressure / P0, atol=1e-5)
    for field in ("wear", "plastic", "gap"):
        found, expected = getattr(two, field), getattr(one, field)
        np.testing.assert_allclose(found / hertz.approach, expected / HERTZ.approach, atol=1e-5)
    assert two.geometry.integral(two.wear) > 0


def volume(state):
    return state.geometry.integral(state.wear)


def test_more_tangential_load_wears_more_and_finer_cells_change_it_ever_less():
    ratios = (0.1, 0.3, 0.5, 0.7, 0.9)
    assert all(np.diff([volume(final(fretting(16, load_ratio=ratio))) for ratio in ratios]) > 0)
    volumes = [volume(final(fretting(cells, load_ratio=0.9), 1500)) for cells in (12, 24, 48)]
    changes = np.abs(np.diff(volumes)) / volumes[-1]
    # The stick zone, 0.46 a in radius, is made of whole cells: its rounding fades as they shrink.
    assert changes[0] < 0.05
    assert changes[1] < 0.02


@pytest.mark.parametrize("even", EVEN[:2])
def test_turning_roughness_and_grid_turns_the_fields(even):
    spacing = (A / 10, A / 14)
    surface = uneven(ROUGH, even)
    turned = Waves(ROUGH.amplitude, ROUGH.wavenumber_y, ROUGH.wavenumber_x, even[::-1])
    one, two = (
        final(fretting(roughness=waves, limit=1.4, spacing=cell), accuracy=CONVERGED)
        for waves, cell in ((surface, spacing), (turned, spacing[::-1]))
    )
    assert one.pressure.shape == two.pressure.shape[::-1]
    np.testing.assert_allclose(one.pressure, two.pressure.T, atol=1e-9 * P0)
    np.testing.assert_allclose(one.wear, two.wear.T, atol=1e-9 * HERTZ.approach)
    # The waves are not alike along x and y, so something was turned.
    assert not np.allclose(one.wear[:9, :9], one.wear[:9, :9].T, atol=1e-3 * HERTZ.approach)


def test_cells_of_a_stroke_take_the_wear_of_the_indenter_above_them():
    changes = {"loading": SlidingAmplitude(24e-6), "wear_law": Archard((1e-14, 1e-14))}
    rubbing = Rubbing(on_strips(6, friction_law=Coulomb(0.9), **changes), (9, 1))
    assert rubbing.places[0] == 0.0
    depth = np.random.default_rng(1).random(9)
    # In the middle of the stroke each cell is under its own.
    above = rubbing.worn[: rubbing.cells] @ np.append(np.zeros(9), depth)
    np.testing.assert_allclose(above, np.append(depth[::-1], depth), rtol=1e-12)
