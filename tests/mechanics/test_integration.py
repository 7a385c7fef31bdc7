"""The implicit integrator against small explicit steps, and against itself with smaller errors."""

from dataclasses import dataclass

import numpy as np
import pytest

from fretwear.mechanics.integrator import evolve
from fretwear.mechanics.state import State

from .explicit import Worn, explicit_wear
from .problems import P0, ROUGH, A, fretting

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
def reference(request) -> Reference:
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


@pytest.mark.parametrize("tolerance", [0.01, 0.001])
def test_wear_of_small_explicit_steps_is_met_within_the_tolerance(
    reference: Reference, tolerance: float
):
    found, expected = reference.integrated[tolerance], reference.worn.wear
    assert np.abs(found.wear - expected).sum() <= tolerance * expected.sum()


def test_pressure_and_plastic_depth_of_small_explicit_steps_are_met(reference: Reference):
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


LONG = {
    "smooth": ({}, 7000),
    "rough": ({"roughness": ROUGH}, 7000),
    "smooth capped": ({"limit": 2.0}, 5000),
    "rough capped": ({"roughness": ROUGH, "limit": 2.5}, 4000),
}


@pytest.mark.parametrize("name", LONG)
def test_a_halved_tolerance_changes_less_than_the_tolerance_promises(name: str):
    changes, cycles = LONG[name]
    problem = fretting(20, **changes)
    found = []
    for tolerance in (0.01, 0.005):
        *_, state = evolve(problem, [cycles], tolerance)
        window = state.geometry
        found.append(
            (
                window.integral(state.wear),
                window.integral(state.plastic),
                window.integral(state.reduced.stick.astype(float)),
            )
        )
    # 1 % is promised for a step; the sum of the steps of a run keeps below it too.
    np.testing.assert_allclose(found[0], found[1], rtol=0.01)
    assert (found[0][1] > 0) == ("capped" in name)


@pytest.mark.parametrize("name", ["smooth", "rough capped"])
def test_smaller_tolerances_converge_to_one_result(name: str):
    changes, cycles = LONG[name]
    problem = fretting(10, **changes)
    volumes = []
    for tolerance in (0.02, 0.002, 0.0002):
        *_, state = evolve(problem, [cycles / 4], tolerance)
        volumes.append(state.geometry.integral(state.wear))
    errors = np.abs(np.diff(volumes)) / volumes[-1]
    assert errors[0] < 0.01
    assert errors[1] < 0.0005


def test_the_error_estimate_of_each_step_is_within_the_tolerance():
    for tolerance in (0.01, 0.001):
        states = list(evolve(fretting(12, roughness=ROUGH, limit=2.0), [2000], tolerance))
        estimates = [state.error_estimate for state in states[1:]]
        # A step a little above is kept, not made again.
        assert max(estimates) <= 1.3 * tolerance
        assert max(estimates) > 0.2 * tolerance
