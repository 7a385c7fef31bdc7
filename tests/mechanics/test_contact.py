"""Normal contact and the wear of a stage, against closed forms, dense matrices and conditions."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fretwear.mechanics.contact import gradients, solver
from fretwear.mechanics.contact.gradients import projected_gradients
from fretwear.mechanics.contact.problem import ContactError, ContactProblem, solve_contact
from fretwear.mechanics.slip.models import (
    CattaneoMindlin,
    Pressed,
    WearLayer,
    WinklerLayer,
    lowered,
)

from ..studies import near
from . import oracles
from .problems import (
    EVEN,
    HERTZ,
    LOAD,
    MODULUS,
    P0,
    RADIUS,
    ROUGH,
    SMOOTH,
    A,
    fretting,
    pressed,
    reduced,
    window,
)
from .problems import unworn as shape_of

# Elastic; the top of the pressure cut off; nearly all of the contact at its limit.
LIMITS = (np.inf, 0.9, 0.55)


def test_hertz_pressure_converges_with_the_grid():
    errors = []
    for n in (16, 32, 64):
        cells = window((n, n))
        r = np.hypot(*np.meshgrid(cells.x, cells.y, indexing="ij"))
        error = solve_contact(pressed(cells)).pressure - HERTZ.pressure(r)
        errors.append(cells.integral(np.abs(error)) / LOAD)
    # The square-root edge limits the order to 3/2: a factor of 2.8 each time the cells halve.
    assert errors[1] < errors[0] / 2
    assert errors[2] < errors[1] / 2
    assert errors[2] < 2e-3


def test_a_pressure_is_refined_up_to_its_edge():
    fine, coarse = (window((n, n)) for n in (128, 64))
    wider = solve_contact(pressed(coarse), tolerance=1e-10)
    self_influence = coarse.half_space(MODULUS).self_influence
    refined = solver.refined(wider.pressure, wider.gap, self_influence)
    np.testing.assert_allclose(solver.halved(refined), wider.pressure, atol=1e-6 * P0)
    exact = solve_contact(pressed(fine), tolerance=1e-10).pressure
    repeated = wider.pressure.repeat(2, axis=0).repeat(2, axis=1)
    # Repeated values err by half of a step between cells; the square root, nearly linear in p², by
    # what the discrete solution differs from it in the cells at the edge.
    assert np.abs(refined - exact).sum() < 0.15 * np.abs(repeated - exact).sum()


@pytest.mark.parametrize("waves", [0.0, 5.0])
def test_wider_cells_replace_a_start_only_if_they_know_more(waves):
    short = replace(
        ROUGH, wavenumber_x=waves * ROUGH.wavenumber_x, wavenumber_y=waves * ROUGH.wavenumber_y
    )
    problem = pressed(window((192, 192)), roughness=short)
    first = solve_contact(problem)
    worn = problem.shape + 0.01 * first.approach * first.pressure / first.pressure.max()
    problem = replace(problem, shape=worn)
    method = solver.ActiveSet(problem, problem.half_space, first.pressure)
    assert method.is_far(1e-6) == (waves == 0.0)
    from_start, anew = (solve_contact(problem, start) for start in (first.pressure, None))
    # The start costs a convolution before it is judged.
    assert from_start.convolutions <= anew.convolutions + 1


@pytest.mark.parametrize(("rough", "limit"), [(False, np.inf), (True, 0.8)])
def test_a_given_approach_carries_the_load_that_leads_to_it(limit, rough):
    problem = pressed(window((48, 48)), roughness=ROUGH if rough else SMOOTH, limit=limit)
    loaded = solve_contact(problem, tolerance=1e-10)
    at_approach = replace(problem, load=None, approach=loaded.approach)
    held = solve_contact(at_approach, tolerance=1e-10)
    assert held.approach == loaded.approach
    np.testing.assert_allclose(held.pressure, loaded.pressure, atol=1e-7 * P0)
    np.testing.assert_array_equal(held.saturated, loaded.saturated)
    if not rough:
        smooth = solve_contact(replace(at_approach, approach=HERTZ.approach))
        assert problem.half_space.geometry.integral(smooth.pressure) == near(LOAD, rel=2e-3)
    for wrong in ({"load": None}, {"approach": HERTZ.approach}):
        with pytest.raises(ValueError, match="either a load or an approach"):
            replace(problem, **wrong)


def test_soft_layer_alone_is_a_winkler_foundation():
    cells = window((64, 64), 1.2 * A)
    # So soft a layer that the half-space adds 1e-6 of its displacement.
    compliance = 1e6 * A / MODULUS
    layer = WinklerLayer(np.full(cells.shape, compliance), np.zeros(cells.shape))
    load = np.pi * RADIUS * HERTZ.approach**2 / 4 / compliance
    found = solve_contact(replace(pressed(cells, layer=layer), load=load))
    r2 = np.add.outer(cells.x**2, cells.y**2)
    # p = (δ - r²/2R)/c, so P = πRδ²/c; cells cut the rim, which carries nothing.
    expected = HERTZ.approach / 2
    assert found.approach == near(expected, rel=1e-3)
    pressure = np.maximum(found.approach - r2 / (2 * RADIUS), 0.0) / compliance
    np.testing.assert_allclose(found.pressure, pressure, atol=1e-4 * pressure.max())


@pytest.mark.parametrize(("layered", "limit"), [(False, 0.9), (True, 0.55), (True, np.inf)])
def test_small_contacts_equal_a_dense_solution(limit, layered):
    cells = window((10, 8), even=(False, False))
    matrix = oracles.influence_matrix(cells, MODULUS)
    random = np.random.default_rng(7)
    compliance = random.uniform(0.0, 3.0, cells.shape) * matrix[0, 0] * layered
    offset = random.uniform(0.0, 0.05, cells.shape) * HERTZ.approach * layered
    layer = WinklerLayer(compliance, offset) if layered else None
    problem = pressed(cells, roughness=ROUGH, limit=limit, layer=layer)
    found = solve_contact(problem, tolerance=1e-11)
    pressure, _, approach = oracles.normal_contact(
        matrix + np.diag(compliance.ravel()),
        (problem.shape + offset).ravel(),
        cells.unit_area,
        LOAD,
        limit=limit * P0,
    )
    # The solver stops at a residual near 1e-11; the condition number of some tens adds to it.
    np.testing.assert_allclose(found.pressure.ravel(), pressure, atol=1e-8 * P0)
    assert found.approach == near(approach, rel=1e-9)


@pytest.mark.parametrize(("limit", "tolerance"), [(0.55, 1e-7), (0.9, 1e-4), (np.inf, 1e-12)])
def test_solution_meets_the_conditions_of_contact_by_an_independent_convolution(limit, tolerance):
    cells = window((48, 40), even=(False, False))
    problem = pressed(cells, roughness=ROUGH, limit=limit)
    found = solve_contact(problem, tolerance=tolerance)
    displaced = oracles.displacement(found.pressure, cells.spacing, MODULUS)
    gap = displaced + problem.shape - found.approach
    # The transforms of both round at some 1e-15.
    rounding = 4e-15 * displaced.max()
    slack = 1.01 * tolerance * displaced.max() + rounding
    assert found.pressure.min() >= 0
    assert found.pressure.max() <= limit * P0
    assert found.pressure.sum() * cells.unit_area == near(LOAD, rel=1e-12)
    at_limit = found.pressure == limit * P0
    loaded = (found.pressure > 0) & ~at_limit
    assert np.abs(gap[loaded]).max() < slack
    assert gap[found.pressure == 0].min() > -slack
    assert gap[at_limit].max(initial=-1.0) < slack
    np.testing.assert_array_equal(found.saturated, at_limit)
    np.testing.assert_allclose(found.penetration, np.maximum(-gap, 0) * at_limit, atol=slack)
    np.testing.assert_allclose(found.gap, gap, atol=1e-3 * slack + rounding)
    assert at_limit.any() == np.isfinite(limit)


def test_more_load_closes_more_and_never_relieves_a_cell():
    cells = window((32, 32))
    loads = [solve_contact(pressed(cells, load=part * LOAD), tolerance=1e-10) for part in (0.5, 1)]
    # The maximum principle of the half-space; the slack is the accuracy of both solutions.
    assert (loads[1].pressure - loads[0].pressure).min() > -1e-8 * P0
    assert loads[1].approach > loads[0].approach


NOTHING = np.zeros((12, 11))


def scattered(seed, loaded, power):
    """Pressure of any size on some of 12 × 11 cells."""
    random = np.random.default_rng(seed)
    start = 10**power * P0 * random.random((12, 11)) * (random.random((12, 11)) < loaded)
    start[random.integers(12), random.integers(11)] += P0
    return start


@pytest.mark.slow
@given(
    start=st.builds(
        scattered, st.integers(0, 2**32 - 1), st.floats(0.01, 1.0), st.floats(-3.0, 3.0)
    ),
    limit=st.sampled_from(LIMITS) | st.floats(0.45, 3.0),
    rough=st.booleans(),
)
@example(start=scattered(0, 0.01, 3.0), limit=0.45, rough=True)
@example(start=np.outer(np.eye(12)[-1], np.eye(11)[-1]), limit=0.55, rough=True)
@example(start=np.outer(np.eye(12)[0], np.eye(11)[0]), limit=np.inf, rough=True)
@example(start=NOTHING, limit=np.inf, rough=False)
@example(start=NOTHING - P0, limit=0.9, rough=True)
@example(start=NOTHING + 1e3 * P0, limit=0.55, rough=True)
def test_any_start_leads_to_the_same_solution_and_is_left_as_it_is(start, limit, rough):
    problem = pressed(window((12, 11)), roughness=ROUGH if rough else SMOOTH, limit=limit)
    expected = solve_contact(problem, tolerance=1e-10)
    given_shape, given_start = problem.shape.copy(), start.copy()
    for guess, tolerance in ((start, 1e-10), (expected.pressure, 1e-3)):
        found = solve_contact(problem, guess, tolerance=tolerance)
        np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-7 * P0)
        for result in (found.pressure, found.gap, found.saturated):
            assert not np.shares_memory(result, guess)
            assert not np.shares_memory(result, problem.shape)
    np.testing.assert_array_equal(problem.shape, given_shape)
    np.testing.assert_array_equal(start, given_start)


def test_a_flat_punch_as_wide_as_the_window_loads_every_cell():
    cells = window((16, 16))
    flat = ContactProblem(cells.half_space(MODULUS), np.zeros(cells.shape), LOAD)
    found = solve_contact(flat)
    assert found.pressure.min() > 0
    assert cells.integral(found.pressure) == near(LOAD, rel=1e-12)
    cells = window((20, 20))
    mean = LOAD / cells.integral(np.ones(cells.shape)) / P0
    with pytest.raises(ContactError, match=r"cannot carry 50 N on a window"):
        solve_contact(pressed(cells, limit=0.999 * mean))
    found = solve_contact(pressed(cells, limit=1.01 * mean))
    assert found.pressure.max() <= 1.01 * mean * P0
    assert cells.integral(found.pressure) == near(LOAD, rel=1e-12)


def test_a_contact_that_does_not_converge_is_brought_by_the_projected_gradient_or_an_error(
    monkeypatch,
):
    problem = pressed(window((16, 16)), roughness=ROUGH, limit=1.2)
    expected = solve_contact(problem, tolerance=1e-9)
    calls = []

    def counted(*args):
        calls.append(args)
        return projected_gradients(*args)

    monkeypatch.setattr(solver, "projected_gradients", counted)
    monkeypatch.setattr(solver, "_ACTIVE_SET_STEPS", 2)
    found = solve_contact(problem, np.ones(problem.shape.shape), tolerance=1e-5)
    assert len(calls) == 1
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-3 * P0)
    monkeypatch.setattr(gradients, "_LARGEST_STEPS", 1)
    with pytest.raises(ContactError, match=r"did not converge: residual .* instead of 1e-06"):
        solve_contact(problem)


def layers(cells):
    random = np.random.default_rng(3)
    compliance = random.uniform(0, 2, cells.shape) * A / 16 / MODULUS
    gap = random.uniform(0, 0.1, cells.shape) * HERTZ.approach
    zero = np.zeros(cells.shape)
    return {
        "bare": None,
        "Winkler": WinklerLayer(compliance, zero),
        "wear": WearLayer(zero, gap, None, zero, 0.5 / P0),
        "wear and flow": WearLayer(zero, gap, 0.3 * gap[::-1], zero, 0.5 / P0),
    }


@pytest.mark.parametrize(
    ("limit", "kind"),
    [(np.inf, "bare"), (0.55, "bare"), (1.1, "Winkler"), (1.1, "wear"), (1.1, "wear and flow")],
)
def test_projected_gradient_and_active_set_agree(limit, kind):
    cells = window((18, 16))
    problem = pressed(cells, roughness=ROUGH, limit=limit, layer=layers(cells)[kind])
    found = projected_gradients(problem, np.ones(cells.shape), 1e-8).pressure
    expected = solve_contact(problem, tolerance=1e-10)
    # The condition number, near 40 here, stands between the change of a step and the error.
    np.testing.assert_allclose(found, expected.pressure, atol=1e-6 * P0)
    bare = solve_contact(replace(problem, layer=None))
    assert (np.abs(found - bare.pressure).max() > 0.02 * P0) == (kind != "bare")


@pytest.mark.parametrize("even", [EVEN[0], EVEN[1]])
def test_reduced_contact_does_not_depend_on_the_window_it_was_solved_on(even):
    cells = window(tuple(36 if one else 72 for one in even), even=even)
    shape, load = shape_of(cells, ROUGH), 0.5 * LOAD
    whole = ContactProblem(cells.half_space(MODULUS), shape, load)
    expected = solve_contact(whole, tolerance=1e-9)
    one_cell = np.zeros(cells.shape)
    # Its neighborhood does not even hold the highest wave.
    one_cell[tuple(0 if one else n // 2 for n, one in zip(cells.shape, even, strict=True))] = 1.0
    for guess in (None, one_cell, np.full(cells.shape, P0)):
        found = reduced(load, cells.half_space(MODULUS), shape, guess)
        np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-5 * P0)
        np.testing.assert_array_equal(found.stick, expected.pressure > 0)
        gap = np.where(found.stick, 0.0, np.maximum(expected.gap, 0.0))
        np.testing.assert_allclose(found.gap, gap, atol=2e-8 * HERTZ.approach)
        assert found.approach == near(expected.approach, rel=2e-8)


def test_wear_under_a_slip_that_stays_is_linear_in_the_pressure():
    problem, cells = fretting(load_ratio=0.6), window((40, 40))
    model = CattaneoMindlin()
    shape = shape_of(cells, ROUGH)
    bodies, sliding = cells.half_space(MODULUS), problem.unworn_sliding
    gap = model.reduced(problem, Pressed(bodies, shape, shape, shape, 0.0, sliding)).gap
    worn = np.ones(cells.shape)
    np.testing.assert_array_equal(model.gap_after(gap, worn), gap)
    layer = model.wear_layer(worn, gap, None, 0.2 * worn, 0.5)
    np.testing.assert_allclose(layer.scaled_tangent(0.5, worn), 2.0 * layer.compliance, rtol=1e-6)
    # W + g* ∫βp dN
    np.testing.assert_allclose(layer.displacement(3 * worn), 1 + 1.7 * gap, rtol=1e-14)


def integrated(wear, gap, shift, known, rate, pressure):
    """Wear and g* at the end of a stage in which x grows to known + τp and G by ``shift``."""
    end = known + rate * pressure

    def slope(_, state):
        # dW/dx = g*, dg*/dx = g* + dG/dx
        return [state[1], state[1] + shift / end]

    # Errors of a small gap grow by e^x as it does: they have to be small beside the gap itself.
    close = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-22}
    return solve_ivp(slope, (0, end), [wear, gap], **close).y[:, -1]


@given(
    wear=st.floats(0, 3),
    gap=st.floats(0, 2),
    known=st.floats(0, 2),
    rate=st.floats(0.01, 3),
    pressure=st.floats(1e-3, 3),
    shift=st.floats(-3, 3) | st.none(),
)
@example(wear=1.0, gap=0.0, shift=-1.0, known=0.0, rate=1.0, pressure=1.0)
@example(wear=0.0, gap=2.0**-24, shift=None, known=0.0, rate=3.0, pressure=3.0)
def test_wear_of_a_stage_solves_its_equation_and_its_tangent_is_the_derivative(
    wear, gap, known, rate, pressure, shift
):
    def at(*values):
        return [np.array([[each]]) for each in values]

    changed = None if shift is None else np.array([[shift]])
    stage = WearLayer(*at(wear, gap), changed, *at(known), rate)
    # Below x = 0.01 the difference of two close numbers says nothing about (eˣ - 1)/x.
    middle = max(pressure, 0.01 / rate)
    places = pressure, 1.1 * pressure, (1 - 1e-5) * middle, (1 + 1e-5) * middle
    low, high, down, up = (stage.displacement(place)[0, 0] for place in at(*places))
    tangent = stage.scaled_tangent(1.0, *at(pressure))[0, 0]
    # Wear never decreases with pressure nor below its start.
    assert wear <= low <= high * (1 + 1e-15)
    assert tangent >= 0
    if shift is not None and shift < 0:
        return
    expected, reduced = integrated(wear, gap, shift or 0.0, known, rate, pressure)
    assert low == pytest.approx(expected, rel=1e-8, abs=1e-12)
    # What wears off adds to g*.
    assert shift is not None or low - wear == pytest.approx(reduced - gap, rel=1e-7, abs=1e-9)
    # Truncation is (step·τ)²; rounding 1e-16 of the displacement over a step of 1e-5.
    slope = stage.scaled_tangent(1.0, *at(middle))[0, 0]
    assert slope == pytest.approx((up - down) / (places[3] - places[2]), rel=1e-6, abs=3e-8)
    if shift is not None:
        # Slip that falls with the approach: the wear depth is linear in it.
        follows = replace(stage, shift=stage.shift + 1.0, response=np.array([[-0.4]]), level=2.0)
        apart = follows.at(3.0).displacement(*at(pressure)) - follows.displacement(*at(pressure))
        assert follows.per_approach(*at(pressure)) == pytest.approx(apart, rel=1e-9, abs=1e-12)


def test_short_stages_keep_their_accuracy():
    exponents = np.array([[1e-15, 1e-9, 9e-8, 1.1e-7, 9e-4, 1.1e-3, 0.1]])
    one, nothing = np.ones_like(exponents), np.zeros_like(exponents)
    stage = WearLayer(nothing, nothing, one, nothing, 1.0)
    # φ(x) - 1 = x/2 + x²/6 + x³/24 + …; below 1e-7 the layer stops at x/2 ± x²/6, and close above
    # a few roundings of φ ≈ 1 remain.
    series = sum(exponents**n / np.prod(np.arange(2, n + 2)) for n in range(1, 9))
    error = np.abs(stage.displacement(exponents) - series)
    assert (error <= 1e-13 * series + 2e-15).all()
    derivative = sum(n * exponents ** (n - 1) / np.prod(np.arange(2, n + 2)) for n in range(1, 9))
    # As the solver is told it, in single precision and in its own units.
    np.testing.assert_allclose(stage.scaled_tangent(3e-4, exponents), derivative / 3e-4, rtol=1e-6)
    # Less wear than a threshold withholds is none, whatever a little more pressure adds.
    resting = replace(stage, reduced_gap=one, shift=None, withheld=0.5)
    assert not resting.displacement(exponents).any()
    assert not resting.scaled_tangent(1.0, exponents).any()
    endless = np.full_like(exponents, 1e9)
    for value in (stage.displacement(endless), stage.scaled_tangent(1.0, endless)):
        assert np.isfinite(value).all()


def test_active_sets_take_a_few_convolutions_where_projected_gradients_take_hundreds():
    for roughness in (SMOOTH, ROUGH):
        contact = solve_contact(pressed(window((24, 24)), roughness=roughness), tolerance=1e-8)
        assert contact.convolutions <= 60


@pytest.mark.parametrize("part", [0.2, 0.7, 1.0, 1.3])
def test_a_guess_under_less_load_is_that_of_a_sphere_and_under_more_presses_no_open_cell(part):
    def under(load):
        return np.sqrt(np.maximum(load ** (2.0 / 3.0) - radii**2, 0.0))

    places = (np.arange(60) + 0.5) / 54
    radii = np.hypot(places[:, None], places)
    expected = under(min(part, 1.0))
    # Cells at the edge count as a whole or not at all.
    np.testing.assert_allclose(lowered(under(1.0), part), expected, atol=0.1)
    assert np.count_nonzero(lowered(under(1.0), part)) == near(np.count_nonzero(expected), rel=0.05)
