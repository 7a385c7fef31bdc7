"""Wear of a smooth sphere on rings: limits, an explicit scheme, invariants and stored values."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from benchmarks.verification.reference_rings import (
    UNIT_HERTZ,
    Resolution,
    Rings,
    SmoothWear,
    WearState,
    dimensionless_history,
    graded_rings,
    solve_contact,
    wear_history,
)

from fretwear.theory import CattaneoMindlin, HertzContact, LimitingState

P0 = UNIT_HERTZ.peak_pressure
LIMIT = 4.162242
APPROACH, CENTRAL, DEEPEST, VOLUME, PLASTIC, CONTACT, STICK = range(7)
REFERENCE = Path(__file__).parents[1] / "mechanics" / "reference" / "smooth_wear.csv"


def coarse_rings(load_ratio: float, widest: float = 0.02) -> Rings:
    edge = math.cbrt(1 - load_ratio)
    return graded_rings(edge, 0.3, 4.0, narrowest=0.0125, narrow=0.0125, widest=widest)


def march(problem: SmoothWear, time: float, steps: int) -> WearState:
    state = problem.unworn()
    for _ in range(steps):
        state = problem.advance(state, time / steps)
    return state


def explicit(problem: SmoothWear, time: float, steps: int) -> np.ndarray:
    """Wear and plastic depth by forward steps: the wear of a step from its first pressure."""
    sphere = 0.5 * problem.rings.radii**2
    rigid = np.zeros_like(sphere)
    state = problem.unworn()
    wear, plastic, full, reduced = state.wear, state.plastic, state.full, state.reduced
    for _ in range(steps):
        wear = wear + time / steps * full.pressure / P0 * np.maximum(reduced.gap, 0.0)
        shape = sphere + wear + plastic
        layer = lambda _, shape=shape: (shape, rigid)  # noqa: E731
        full = solve_contact(problem.rings, layer, UNIT_HERTZ.load, problem.limit, full)
        sunk = np.where(full.yielding, -full.gap, 0.0)
        plastic = plastic + sunk
        shape = shape + sunk
        layer = lambda _, shape=shape: (shape, rigid)  # noqa: E731
        reduced = solve_contact(problem.rings, layer, problem.reduced_load, math.inf, reduced)
        reduced = type(reduced)(
            reduced.pressure,
            np.where(reduced.loaded, 0.0, reduced.gap),
            reduced.approach,
            reduced.loaded,
            reduced.yielding,
        )
    return problem.measure(WearState(wear, plastic, full, reduced))


@pytest.mark.parametrize("load_ratio", [0.2, 0.5, 0.9])
def test_endless_wear_reaches_the_limiting_state(load_ratio):
    # at τ = 40 the worn volume lacks less than a thousandth of its limit
    resolution = Resolution(swept_width=0.02, edge_width=1e-4, widest=0.01, step=0.4)
    values, _ = dimensionless_history(load_ratio, math.inf, [40.0], resolution)
    limit = LimitingState(UNIT_HERTZ, load_ratio)
    expected = [
        limit.approach,
        limit.central_pressure,
        limit.deepest_wear,
        limit.wear_volume,
        0.0,
        limit.contact_radius,
        limit.stick_radius,
    ]
    tolerance = [1e-4, 1e-4, 1e-3, 2e-3, 0.0, 1e-3, 1e-3]
    assert np.all(np.abs(values[:, 0] - expected) <= np.multiply(tolerance, expected))


@pytest.mark.parametrize(
    ("limit_ratio", "time"), [(math.inf, 3.0), (LIMIT, 8.0)], ids=["elastic", "capped"]
)
def test_forward_and_backward_steps_meet(limit_ratio, time):
    # both are first order from opposite sides; on the same rings their extrapolations agree
    problem = SmoothWear(coarse_rings(0.8, widest=0.04), 0.8, limit_ratio)
    backward = [problem.measure(march(problem, time, n)) for n in (320, 640)]
    forward = [explicit(problem, time, n) for n in (1600, 3200)]
    integrals = [APPROACH, CENTRAL, DEEPEST, VOLUME]
    found, expected = (2 * pair[1] - pair[0] for pair in (backward, forward))
    np.testing.assert_allclose(found[integrals], expected[integrals], rtol=2e-4)
    # plastic flow goes ring by ring, which the extrapolations cannot see
    np.testing.assert_allclose(found[PLASTIC], expected[PLASTIC], rtol=5e-3, atol=1e-12)


@pytest.mark.parametrize("limit_ratio", [math.inf, LIMIT], ids=["elastic", "capped"])
def test_steps_are_first_order(limit_ratio):
    problem = SmoothWear(coarse_rings(0.8), 0.8, limit_ratio)
    volumes = [problem.measure(march(problem, 8.0, n))[VOLUME] for n in (40, 80, 160)]
    ratio = (volumes[1] - volumes[0]) / (volumes[2] - volumes[1])
    # rings that yield or open one by one make the capped ratio uneven
    assert ratio == pytest.approx(2.0, abs=0.15 if limit_ratio == math.inf else 0.6)


def test_elastic_wear_never_changes_the_stick_zone():
    problem = SmoothWear(coarse_rings(0.5), 0.5, math.inf)
    first, last = problem.unworn(), march(problem, 20.0, 50)
    np.testing.assert_array_equal(first.reduced.loaded, last.reduced.loaded)
    np.testing.assert_array_equal(first.reduced.pressure, last.reduced.pressure)
    assert np.all(last.wear[last.reduced.loaded] == 0.0)
    shape = 0.5 * problem.rings.radii**2 + last.wear
    rigid = np.zeros_like(shape)
    solved = solve_contact(
        problem.rings, lambda _: (shape, rigid), problem.reduced_load, math.inf, first.reduced
    )
    np.testing.assert_allclose(solved.gap, last.reduced.gap, atol=1e-10)


def test_capped_states_obey_the_contact_laws():
    problem = SmoothWear(coarse_rings(0.8), 0.8, LIMIT)
    state, wear, plastic = problem.unworn(), 0.0, 0.0
    for _ in range(60):
        state = problem.advance(state, 0.5)
        shape = 0.5 * problem.rings.radii**2 + state.wear + state.plastic
        full, reduced = state.full, state.reduced
        gap = shape + problem.rings.influence @ full.pressure - full.approach
        assert problem.rings.areas @ full.pressure == pytest.approx(
            UNIT_HERTZ.load, rel=1e-10, abs=0
        )
        assert np.all((full.pressure >= 0.0) & (full.pressure <= problem.limit))
        assert np.all(np.abs(gap[full.loaded]) < 1e-9)
        assert np.all(gap > -1e-9)
        # the reduced load is an earlier stage of loading the same shape elastically
        assert np.all(reduced.pressure <= full.pressure + 1e-9)
        assert np.all(state.wear >= wear)
        assert np.all(state.plastic >= plastic)
        wear, plastic = state.wear, state.plastic
    assert plastic.max() > 0.5
    assert full.pressure[0] == problem.limit


def test_a_limit_that_is_not_reached_changes_nothing():
    rings = coarse_rings(0.5)
    elastic, capped = (march(SmoothWear(rings, 0.5, limit), 3.0, 10) for limit in (math.inf, 9.0))
    np.testing.assert_array_equal(elastic.wear, capped.wear)


def test_a_limit_below_the_hertzian_peak_sinks_before_any_wear():
    problem = SmoothWear(coarse_rings(0.5), 0.5, 0.5)
    state = problem.unworn()
    carried = problem.rings.areas @ state.full.pressure
    assert carried == pytest.approx(UNIT_HERTZ.load, rel=1e-12, abs=0)
    assert np.max(state.full.pressure) == problem.limit
    assert problem.measure(state)[PLASTIC] > 0.1
    assert not state.wear.any()
    assert np.all(state.reduced.pressure <= state.full.pressure + 1e-9)


def test_a_contact_that_outgrows_the_rings_is_refused():
    rings = graded_rings(0.6, 0.6, 1.05, narrowest=0.02, narrow=0.02, widest=0.02)
    problem = SmoothWear(rings, 0.8, math.inf)
    with pytest.raises(RuntimeError, match="outermost ring"):
        problem.measure(march(problem, 3.0, 10))


def partial_slip(load: float = 50.0, radius: float = 10e-3) -> CattaneoMindlin:
    return CattaneoMindlin(HertzContact(radius, load, 114e9), 0.5, 0.4 * load, 1.2143)


def test_history_in_si_units_scales_like_the_contact():
    # equal Q/µP, p_lim/p0 and τ: eight times the load doubles a and p0
    resolution = Resolution(swept_width=0.02, edge_width=0.01, widest=0.03, step=0.5)
    light, _ = wear_history(partial_slip(), 7e-13, 2e9, [0, 1000, 3000], resolution)
    heavy, _ = wear_history(partial_slip(400.0), 3.5e-13, 4e9, [0, 1000, 3000], resolution)
    for name, factor in (
        ("approach", 4),
        ("central_pressure", 2),
        ("deepest_wear", 4),
        ("wear_volume", 16),
        ("plastic_volume", 16),
        ("contact_radius", 2),
        ("stick_radius", 2),
    ):
        expected = factor * getattr(light, name)
        np.testing.assert_allclose(getattr(heavy, name), expected, rtol=1e-7, atol=0.0)
    hertz = partial_slip().hertz
    assert light.central_pressure[0] == pytest.approx(hertz.peak_pressure, rel=1e-3, abs=0)
    assert light.approach[0] == pytest.approx(hertz.approach, rel=1e-3, abs=0)
    assert light.wear_volume[0] == 0.0
    assert light.plastic_volume[-1] > 0.0


@pytest.mark.parametrize(
    ("coefficient", "limit", "cycles", "named"),
    [
        (0.0, math.inf, [1.0], "wear_coefficient"),
        (1e-13, 0.0, [1.0], "plastic_limit"),
        (1e-13, math.nan, [1.0], "plastic_limit"),
        (1e-13, math.inf, [], "cycles"),
        (1e-13, math.inf, [-1.0], "cycles"),
        (1e-13, math.inf, [3.0, 3.0], "cycles"),
    ],
)
def test_impossible_histories_are_named(coefficient, limit, cycles, named):
    with pytest.raises(ValueError, match=named):
        wear_history(partial_slip(), coefficient, limit, cycles)


def stored(load_ratio: float, limit_ratio: float) -> np.ndarray:
    """Rows of the reference table: τ, the seven values, their uncertainties."""
    with REFERENCE.open(newline="") as file:
        rows = [[float(value) for value in row] for row in list(csv.reader(file))[1:]]
    found = [row[2:] for row in rows if row[0] == load_ratio and row[1] == limit_ratio]
    assert found, "the table lacks these ratios"
    return np.array(found)


STORED_LIMIT = 4.1622421
SLOW_CASES = [(x, limit) for x in (0.2, 0.5, 0.8, 0.9) for limit in (math.inf, STORED_LIMIT)]


def assert_stored(rows: np.ndarray, values: np.ndarray, tolerance: float) -> None:
    expected, uncertainty = rows[:, 1:8].T, rows[:, 8:].T
    values[CENTRAL] /= P0
    smooth = [APPROACH, CENTRAL, DEEPEST, VOLUME]
    allowed = tolerance * np.abs(expected) + uncertainty + 1e-12
    assert np.all(np.abs(values - expected)[smooth] <= allowed[smooth])
    # edges are found to a ring; what yields lies within a few rings of the stick edge
    assert np.all(np.abs(values - expected)[[CONTACT, STICK]] <= 0.02)
    plastic = np.abs(values - expected)[PLASTIC] <= 10 * allowed[PLASTIC] + 1e-5
    assert np.all(plastic)


@pytest.mark.parametrize(
    ("load_ratio", "limit_ratio"), [(0.5, math.inf), (0.8, STORED_LIMIT)], ids=["elastic", "capped"]
)
def test_coarse_rings_come_near_the_stored_values(load_ratio, limit_ratio):
    rows = stored(load_ratio, limit_ratio)
    rows = rows[rows[:, 0] < 8.0]
    resolution = Resolution(swept_width=1 / 80, edge_width=1e-3, widest=0.015, step=0.2)
    values, _ = dimensionless_history(load_ratio, limit_ratio, list(rows[:, 0]), resolution)
    assert_stored(rows, values, 0.005)


def test_history_of_the_study_is_the_stored_one():
    # 50 N, 20 N, µ = 0.5, R = 10 mm, E = 208 GPa, ν = 0.3: its cycles are rows of the table
    hertz = HertzContact(10e-3, 50.0, 208e9 / (2 * (1 - 0.3**2)))
    slip = CattaneoMindlin(hertz, 0.5, 20.0, 1.7 / 1.4)
    resolution = Resolution(swept_width=1 / 80, edge_width=1e-3, widest=0.015, step=0.2)
    history, error = wear_history(slip, 7e-13, 4500e6, [1000, 3000], resolution)
    rows = stored(0.8, STORED_LIMIT)
    times = np.array([1000, 3000]) * 0.00183795172
    rows = np.array([rows[np.argmin(np.abs(rows[:, 0] - time))] for time in times])
    np.testing.assert_allclose(rows[:, 0], times, rtol=1e-7)
    volume = hertz.contact_radius**4 / hertz.radius
    np.testing.assert_allclose(history.wear_volume / volume, rows[:, 1 + VOLUME], rtol=2e-3)
    central = history.central_pressure / hertz.peak_pressure
    np.testing.assert_allclose(central, rows[:, 1 + CENTRAL], rtol=1e-3)
    deepest = history.deepest_wear / hertz.approach
    np.testing.assert_allclose(deepest, rows[:, 1 + DEEPEST], rtol=2e-3)
    assert np.all(error.wear_volume < 2e-3 * history.wear_volume)


@pytest.mark.slow
@pytest.mark.parametrize(("load_ratio", "limit_ratio"), SLOW_CASES)
def test_stored_values_are_those_of_the_solver(load_ratio, limit_ratio):
    rows = stored(load_ratio, limit_ratio)
    rows = rows[rows[:, 0] <= 20.0]
    resolution = Resolution(swept_width=1 / 160, edge_width=1e-4, widest=0.015, step=0.4)
    values, _ = dimensionless_history(load_ratio, limit_ratio, list(rows[:, 0]), resolution)
    assert_stored(rows, values, 0.01)
