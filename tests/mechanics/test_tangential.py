"""Slip is µκ times the gap under the reduced load: proved by solving the tangential problem.

Earlier cycles leave tractions behind where the stick zone grows into worn ground.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from fretwear.arrays import Array
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.surfaces.loading import DisplacementAmplitude
from fretwear.mechanics.surfaces.materials import Coulomb
from fretwear.mechanics.values import OverCycles
from fretwear.mechanics.wear.integrator import evolve

from ..studies import near
from .oracles import influence_matrix, love, normal_contact, tangential_step, with_images
from .problems import CONVERGED, COUPLING, FRICTION, HERTZ, LOAD, MODULUS, A, fretting, unworn

WINDOW = Grid((36, 28), (0.4e-3 / 36, 0.4e-3 / 28), even=(False, False))
CELL = WINDOW.unit_area


@cache
def normal_influence():
    return influence_matrix(WINDOW, MODULUS)


@dataclass(frozen=True, eq=False)
class Case:
    """A rough contact under the load P."""

    shape: Array
    pressure: Array
    gap: Array
    approach: float

    def move(self, force, initial=None):
        start = np.zeros_like(self.shape) if initial is None else initial
        influence = COUPLING * normal_influence()
        return tangential_step(influence, FRICTION * self.pressure, start, CELL, force)


def waves(x, y):
    return 0.25e-6 * np.cos(2 * np.pi * y / 130e-6) * np.cos(2 * np.pi * x / 70e-6)


def ring_groove(x, y):
    # like wear: a groove about the middle, with a kink at its inner edge
    distance = np.hypot(x, y)
    return 0.5e-6 * np.clip((distance - 80e-6) / 20e-6, 0.0, None) * (distance < 130e-6)


@pytest.fixture(scope="module", params=[waves, ring_groove], ids=lambda f: f.__name__)
def case(request):
    roughness = request.param(WINDOW.x[:, None], WINDOW.y)
    shape = (unworn(WINDOW) + roughness).ravel()
    return Case(shape, *normal_contact(normal_influence(), shape, CELL, LOAD))


@pytest.mark.parametrize("ratio", [0.2, 0.95])
def test_slip_is_the_gap_under_the_reduced_load(case, ratio):
    loaded = case.move(ratio * FRICTION * LOAD)
    stick, gap, approach = normal_contact(normal_influence(), case.shape, CELL, LOAD * (1 - ratio))
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


def test_reversal_travels_twice_the_slip_and_a_cycle_four_times(case):
    force = 0.8 * FRICTION * LOAD
    loaded = case.move(force)
    reversed_ = case.move(-force, loaded.traction)
    returned = case.move(force, reversed_.traction)
    scale = np.max(loaded.slip)
    assert np.max(np.abs(reversed_.slip + 2 * loaded.slip)) <= 1e-10 * scale
    assert np.max(np.abs(returned.slip - 2 * loaded.slip)) <= 1e-10 * scale
    peak = np.max(np.abs(loaded.traction))
    assert np.max(np.abs(reversed_.traction + loaded.traction)) <= 1e-10 * peak
    assert np.max(np.abs(returned.traction - loaded.traction)) <= 1e-10 * peak


def test_half_way_back_more_sticks_and_friction_does_the_work_of_the_loop(case):
    # half-way back the last-slipped cells have begun to slip back, the others have not
    force = 0.8 * FRICTION * LOAD
    loaded = case.move(force)
    halfway = case.move(0.0, loaded.traction)
    _, gap, _ = normal_contact(normal_influence(), case.shape, CELL, LOAD * (1 - 0.4))
    expected = -2 * FRICTION * COUPLING * (gap - case.gap)
    assert np.max(np.abs(halfway.slip - expected)) <= 1e-10 * np.max(np.abs(expected))
    work = 4 * np.sum(FRICTION * case.pressure * np.abs(loaded.slip)) * CELL
    forces = force * np.cos(np.linspace(0.0, np.pi, 51))
    shifts = [case.move(f, loaded.traction).displacement for f in forces]
    # both branches: the way back is the way there turned about the origin
    area = 2 * np.trapezoid(np.array(shifts) - shifts[-1] / 2, -forces)
    assert abs(area) == near(work, rel=2e-3)


def quarter_influence(window):
    """Tangential displacement of each cell under unit traction on it and its images, m/Pa."""
    (nx, ny), (dx, dy) = window.shape, window.spacing
    x, y = np.arange(2 * nx)[:, None] * dx, np.arange(2 * ny) * dy
    kernel = COUPLING * love(x, y, window.spacing, MODULUS)
    return with_images(kernel, *np.divmod(np.arange(nx * ny), ny))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "cycles", "growth", "excess", "mean"),
    [
        (FRICTION, 400, 1.25, 1e-4, 1e-5),
        (OverCycles((0.0, 200.0), (FRICTION, 0.9)), 200, 2.5, 3e-3, 5e-4),
    ],
    ids=["wear", "friction that rises"],
)
def test_a_cycle_is_a_fresh_loading_whatever_came_before(friction, cycles, growth, excess, mean):
    # +U → −U → +U on the worn shape of every cycle, from the tractions that the last one left.
    # A cell comes with the amplitude s of the last cycle and goes by s + s', then by 2 s': the
    # energy exceeds that of 4 s' by a quarter of what s changed, to first order, and by nothing
    # in a second cycle on the same shape. What is locked in where the stick zone grew shifts the
    # loop, but neither traction nor force differ in amplitude.
    amplitude = 0.8 * FRICTION * COUPLING * HERTZ.approach
    problem = fretting(
        12,
        loading=DisplacementAmplitude(displacement_amplitude=amplitude),
        friction_law=Coulomb.unchecked(friction=friction),
        extent=(1.4 * A, 1.4 * A),
    )
    every = range(1, cycles + 1)
    states = [s for s in evolve(problem, every, accuracy=CONVERGED) if s.cycle in (0, *every)]
    window = states[-1].geometry
    influence, cell = quarter_influence(window), window.unit_area
    traction, last = np.zeros(window.shape).ravel(), None
    sticks, shifts = [], []
    for state in states:
        now, mu = problem.at(state.cycle), problem.at(state.cycle).friction_law.coefficient
        pressure, stick, gap = (
            state.geometry.resized(field, window).ravel()
            for field in (state.pressure, state.reduced.pressure, state.reduced.gap)
        )
        bound, slip = mu * pressure, np.where(pressure > 0, mu * COUPLING * gap, 0.0)
        energy = 4 * np.sum(bound * slip) * cell
        force = now.tangential_force(state.load, state.reduced)

        def move(shift, initial, bound=bound):
            return tangential_step(influence, bound, initial, cell, displacement=shift)

        if last is None:
            last, traction = slip, move(amplitude, traction).traction
        change = 4 * np.sum(bound * np.abs(slip - last)) * cell / energy
        high = move(0.0, traction)
        first, second = (min(0.26 * change, excess), excess), (0.0, 0.0)
        for of_energy, of_slip in (first, second)[: 1 if state.cycle % 20 else 2]:
            back = move(-2 * amplitude, high.traction)
            high = move(2 * amplitude, back.traction)
            dissipated = np.sum(bound * (np.abs(back.slip) + np.abs(high.slip))) * cell
            assert dissipated == near(energy, rel=of_energy + 1e-9)
            error = np.abs((high.slip - back.slip) / 4 - slip)[pressure > 0].max()
            assert error <= (of_slip + 1e-9) * slip.max()
            half = (high.traction - back.traction) / 2
            assert np.abs(half - mu * (pressure - stick)).max() <= 1e-9 * bound.max()
            assert half.sum() * cell == near(force, rel=1e-9)
        last, traction = slip, high.traction
        sticks.append(np.sum(stick > 0))
        shifts.append(abs((high.traction + back.traction).sum()) / 2 * cell / force)
    assert sticks[-1] >= growth * sticks[0]
    assert mean / 20 <= max(shifts) <= mean
