"""Layers against the differential equation of wear, against numerical derivatives and limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fretwear.mechanics import kernels
from fretwear.mechanics.geometry import Array
from fretwear.mechanics.slip import WearLayer, WinklerLayer
from fretwear.mechanics.solver import solve_contact

from .problems import P0, pressed, window


def integrated(
    wear: float, gap: float, shift: float, known: float, rate: float, pressure: float
) -> tuple[float, float]:
    """Wear and g* at the end of a stage in which x grows to known + τp and G by ``shift``."""
    end = known + rate * pressure

    def slope(_: float, state: Array) -> list[float]:
        # dW/dx = g*, dg*/dx = g* + dG/dx
        return [state[1], state[1] + shift / end]

    solution = solve_ivp(slope, (0, end), [wear, gap], rtol=1e-11, atol=1e-14)
    return float(solution.y[0, -1]), float(solution.y[1, -1])


def layer(wear: float, gap: float, shift: float | None, known: float, rate: float) -> WearLayer:
    given_shift = None if shift is None else np.array([[shift]])
    return WearLayer(np.array([[wear]]), np.array([[gap]]), given_shift, np.array([[known]]), rate)


def tangent(stage: WearLayer, pressure: Array) -> Array:
    """Derivative of the wear depth in double precision, by NumPy, which has any."""
    result, slope = np.empty_like(pressure), kernels.wear_slope.in_numpy
    slope(pressure, stage.rate, stage.exponent, stage.reduced_gap, stage.shift, stage.rate, result)
    return result


stages = {
    "wear": st.floats(0, 3),
    "gap": st.floats(0, 2),
    "known": st.floats(0, 2),
    "rate": st.floats(0.01, 3),
    "pressure": st.floats(0, 3),
}


@given(**stages, shift=st.floats(0, 1) | st.none())
def test_wear_of_a_stage_solves_its_differential_equation(wear, gap, shift, known, rate, pressure):
    pressure = max(pressure, 1e-3)
    expected, reduced = integrated(wear, gap, shift or 0.0, known, rate, pressure)
    found = layer(wear, gap, shift, known, rate).displacement(np.array([[pressure]]))[0, 0]
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-12)
    if shift is None:
        # What wears off adds to g*.
        assert found - wear == pytest.approx(reduced - gap, rel=1e-7, abs=1e-9)


@given(**stages, shift=st.floats(-3, 3) | st.none())
@example(wear=1.0, gap=0.0, shift=-1.0, known=0.0, rate=1.0, pressure=1.0)
def test_wear_never_decreases_with_pressure_nor_below_its_start(
    wear, gap, shift, known, rate, pressure
):
    stage = layer(wear, gap, shift, known, rate)
    low, high = (stage.displacement(np.array([[p]]))[0, 0] for p in (pressure, 1.1 * pressure))
    assert wear <= low <= high * (1 + 1e-15)
    assert tangent(stage, np.array([[pressure]]))[0, 0] >= 0


@given(**stages, shift=st.floats(0, 1) | st.none())
def test_tangent_is_the_derivative_of_the_displacement(wear, gap, shift, known, rate, pressure):
    # Below x = 0.01 the difference of two close numbers says nothing about (eˣ - 1)/x.
    pressure = max(pressure, 0.01 / rate)
    stage = layer(0.0 * wear, gap, shift, known, rate)
    step = 1e-5 * pressure
    up, down = (stage.displacement(np.array([[pressure + s]]))[0, 0] for s in (step, -step))
    slope = tangent(stage, np.array([[pressure]]))[0, 0]
    # Truncation is (step·τ)²; rounding 1e-16 of the displacement over a step of 1e-5.
    assert slope == pytest.approx((up - down) / (2 * step), rel=1e-6, abs=1e-9)
    if shift is not None:
        # Slip that falls with the approach: the wear depth is linear in it.
        at = np.array([[pressure]])
        follows = replace(stage, shift=stage.shift + 1.0, response=np.array([[-0.4]]), level=2.0)
        apart = follows.at(3.0).displacement(at) - follows.displacement(at)
        assert follows.per_approach(at) == pytest.approx(apart, rel=1e-9, abs=1e-12)


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
    np.testing.assert_allclose(tangent(stage, exponents), derivative, rtol=1e-9)


@pytest.mark.parametrize("shift", [True, False])
def test_the_solver_is_told_the_same_wear_in_its_own_units(shift: bool):
    wear, gap, flow, known, pressure = np.random.default_rng(3).random((5, 6, 7))
    stage = WearLayer(wear, gap, flow if shift else None, known, 1.7)
    above = np.full((6, 7), 0.25)
    stage.add_displacement(pressure, above)
    np.testing.assert_allclose(above, 0.25 + stage.displacement(pressure), rtol=1e-15)
    relative = stage.tangent_in(3e-4, pressure)
    assert relative.dtype == np.float32
    np.testing.assert_allclose(relative, tangent(stage, pressure) / 3e-4, rtol=1e-7)


def test_endless_stages_stay_finite():
    stage = layer(0.0, 1e-9, 1e-9, 0.0, 1.0)
    for value in (stage.displacement(np.array([[1e9]])), tangent(stage, np.array([[1e9]]))):
        assert np.isfinite(value).all()


def test_winkler_layer_is_a_line():
    compliance, offset = np.array([[2.0, 0.0]]), np.array([[0.5, 0.1]])
    spring = WinklerLayer(compliance, offset)
    pressure = np.array([[3.0, 7.0]])
    np.testing.assert_allclose(spring.displacement(pressure), [[6.5, 0.1]])
    above = np.ones_like(pressure)
    spring.add_displacement(pressure, above)
    np.testing.assert_allclose(above, [[7.5, 1.1]])
    np.testing.assert_allclose(spring.tangent_in(0.5, pressure), 2.0 * compliance)


def test_a_contact_with_a_wear_layer_is_the_contact_of_the_worn_shape():
    cells = window((24, 24))
    random = np.random.default_rng(1)
    gap = random.uniform(0, 0.2, cells.shape) * 2e-6
    nothing = np.zeros(cells.shape)
    stage = WearLayer(nothing, gap, None, nothing, 1.0 / P0)
    problem = pressed(cells, layer=stage)
    found = solve_contact(problem, tolerance=1e-9)
    worn = replace(problem, shape=problem.shape + stage.displacement(found.pressure), layer=None)
    # A fixed point: the shape that this pressure wears carries just this pressure.
    np.testing.assert_allclose(
        solve_contact(worn, tolerance=1e-9).pressure, found.pressure, atol=1e-6 * P0
    )
