"""Slip is µκ times the gap under the reduced load: proved by solving the tangential problem."""

from dataclasses import dataclass

import numpy as np
import pytest

from fretwear.mechanics.geometry import Array
from fretwear.mechanics.geometry.grid import Grid

from .oracles import influence_matrix
from .problems import COUPLING, FRICTION, LOAD, MODULUS, near, unworn
from .tangential import TangentialStep, normal_contact, tangential_step

WINDOW = Grid((36, 28), (0.4e-3 / 36, 0.4e-3 / 28), even=(False, False))
NORMAL = influence_matrix(WINDOW, MODULUS)
TANGENTIAL = COUPLING * NORMAL
CELL = WINDOW.unit_area


@dataclass(frozen=True, eq=False)
class Case:
    """A rough contact under the load P."""

    shape: Array
    pressure: Array
    gap: Array
    approach: float

    def move(self, force: float, before: Array | None = None) -> TangentialStep:
        start = np.zeros_like(self.shape) if before is None else before
        return tangential_step(TANGENTIAL, FRICTION * self.pressure, start, CELL, force)


def waves(x: Array, y: Array) -> Array:
    return 0.25e-6 * np.cos(2 * np.pi * y / 130e-6) * np.cos(2 * np.pi * x / 70e-6)


def noise(x: Array, y: Array) -> Array:
    return 0.15e-6 * np.random.default_rng(7).standard_normal(np.broadcast_shapes(x.shape, y.shape))


def ring_groove(x: Array, y: Array) -> Array:
    # like wear: a groove about the middle, with a kink at its inner edge
    distance = np.hypot(x, y)
    return 0.5e-6 * np.clip((distance - 80e-6) / 20e-6, 0.0, None) * (distance < 130e-6)


@pytest.fixture(scope="module", params=[waves, noise, ring_groove], ids=lambda f: f.__name__)
def case(request: pytest.FixtureRequest) -> Case:
    roughness = request.param(WINDOW.x[:, None], WINDOW.y)
    shape = (unworn(WINDOW) + roughness).ravel()
    return Case(shape, *normal_contact(NORMAL, shape, CELL, LOAD))


def test_contact_is_rough_and_carries_the_load(case):
    assert case.pressure.sum() * CELL == near(LOAD, rel=1e-12)
    gap = case.shape + NORMAL @ case.pressure - case.approach
    assert np.all(case.pressure >= 0.0)
    assert np.all(gap >= -1e-15)
    assert np.all(np.abs(gap[case.pressure > 0]) < 1e-15)
    border = np.zeros(WINDOW.shape, dtype=bool)
    border[[0, -1]] = border[:, [0, -1]] = True
    assert not np.any(case.pressure[border.ravel()])


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.8, 0.95])
def test_slip_is_the_gap_under_the_reduced_load(case, ratio):
    loaded = case.move(ratio * FRICTION * LOAD)
    stick, gap, approach = normal_contact(NORMAL, case.shape, CELL, LOAD * (1 - ratio))
    slip = FRICTION * COUPLING * gap
    traction = FRICTION * (case.pressure - stick)
    touching = case.pressure > 0
    assert np.max(np.abs(loaded.slip - slip)[touching]) <= 1e-10 * np.max(slip[touching])
    assert np.max(np.abs(loaded.traction - traction)) <= 1e-10 * np.max(traction)
    # beyond the contact, where nothing slips, surfaces pass each other by what the gap closes
    passed = FRICTION * COUPLING * (gap - case.gap)
    assert np.max(np.abs(loaded.slip - passed)) <= 1e-10 * np.max(passed)
    displacement = FRICTION * COUPLING * (case.approach - approach)
    assert loaded.displacement == near(displacement, rel=1e-10)
    assert 0 < np.sum(touching & (stick == 0)) < touching.sum()


@pytest.mark.parametrize("ratio", [0.2, 0.8])
def test_reversal_travels_twice_the_slip_and_a_cycle_four_times(case, ratio):
    force = ratio * FRICTION * LOAD
    loaded = case.move(force)
    reversed_ = case.move(-force, loaded.traction)
    returned = case.move(force, reversed_.traction)
    scale = np.max(loaded.slip)
    assert np.max(np.abs(reversed_.slip + 2 * loaded.slip)) <= 1e-10 * scale
    assert np.max(np.abs(returned.slip - 2 * loaded.slip)) <= 1e-10 * scale
    peak = np.max(np.abs(loaded.traction))
    assert np.max(np.abs(reversed_.traction + loaded.traction)) <= 1e-10 * peak
    assert np.max(np.abs(returned.traction - loaded.traction)) <= 1e-10 * peak


def test_reversal_passes_through_states_that_stick_more(case):
    # half-way back the last-slipped cells have begun to slip back, the others have not
    force = 0.8 * FRICTION * LOAD
    loaded = case.move(force)
    halfway = case.move(0.0, loaded.traction)
    _, gap, _ = normal_contact(NORMAL, case.shape, CELL, LOAD * (1 - 0.4))
    expected = -2 * FRICTION * COUPLING * (gap - case.gap)
    assert np.max(np.abs(halfway.slip - expected)) <= 1e-10 * np.max(np.abs(expected))


def test_friction_does_the_work_of_the_force_loop(case):
    # the area of the loop of force and displacement is the work on the slipping cells
    force = 0.8 * FRICTION * LOAD
    loaded = case.move(force)
    work = 4 * np.sum(FRICTION * case.pressure * np.abs(loaded.slip)) * CELL
    forces = force * np.cos(np.linspace(0.0, np.pi, 51))
    shifts = [case.move(f, loaded.traction).displacement for f in forces]
    # both branches: the way back is the way there turned about the origin
    area = 2 * np.trapezoid(np.array(shifts) - shifts[-1] / 2, -forces)
    assert abs(area) == near(work, rel=2e-3)
