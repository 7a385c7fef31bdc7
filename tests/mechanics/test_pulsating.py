"""Partial slip under a load in phase with the tangential force."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.linalg import toeplitz

from fretwear import simulate
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import influence_of_cell
from fretwear.mechanics.surfaces.laws import Archard
from fretwear.mechanics.surfaces.loading import TangentialRatio
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.wear.integrator import evolve, first_loading
from fretwear.mechanics.wear.loops import loop
from fretwear.mechanics.wear.measures import Measures
from fretwear.mechanics.wear.pulsating import evolve_pulsating, load_cycle
from fretwear.mechanics.wear.state import Workspace

from ..studies import near, steel
from . import oracles
from .problems import CYLINDER, EDGE, FRICTION, LOAD, PER_LENGTH, A, fretting, on_strips

WEAR = 1e-13


def line(least, ratio, **changes):
    """A cylinder whose load falls to a part of the largest, with Q/µP of the latter."""
    return on_strips(
        40,
        half_width=1.3,
        normal=NormalLoad(PER_LENGTH, least),
        loading=TangentialRatio(ratio),
        wear_law=Archard(WEAR),
        **changes,
    )


def sphere(least, ratio, **changes):
    return fretting(
        geometry=Rings,
        normal=NormalLoad(LOAD, least),
        loading=TangentialRatio(ratio),
        **changes,
    )


class Reference:
    """Equal strips, on which load and force are taken round a cycle in small steps.

    Each solves Coulomb friction directly, |q| ≤ µp and no slip below, without reduced loads.
    """

    def __init__(self, problem, half, count, parts):
        self.width = 2 * half / count
        self.x = (np.arange(count) - 0.5 * (count - 1)) * self.width
        modulus = problem.composite_modulus
        self.influence = toeplitz(influence_of_cell(count, self.width, CYLINDER.radius, modulus))
        self.phases = np.linspace(-1, 1, parts + 1)
        self.forces = self.phases * problem.loading.tangential_ratio * FRICTION * PER_LENGTH
        least = problem.normal.pulsating_load
        self.loads = PER_LENGTH * (1 - 0.5 * (1 - least) * (1 - self.phases))
        self.loaded = [None] * (parts + 1)
        self.traction = np.zeros(count)

    def cycle(self, wear):
        """Wear depth of the third cycle from the middle, or of the second from the last end."""
        shape, pressures = self.x**2 / (2 * CYLINDER.radius) + wear, []
        for phase, load in enumerate(self.loads):
            pressure, _, _ = oracles.normal_contact(
                self.influence, shape, self.width, load, self.loaded[phase]
            )
            pressures.append(pressure)
            self.loaded[phase] = pressure > 0
        last = len(self.loads) - 1
        back = [*range(last - 1, -1, -1)]
        begin = [] if self.traction.any() else [*range(last // 2, last + 1), *back]
        for path in (begin, [*range(last + 1), *back], [*range(last + 1), *back]):
            worn = np.zeros_like(self.x)
            for earlier, now in pairwise(path):
                bound = FRICTION * pressures[earlier]
                step = oracles.tangential_step(
                    self.influence,
                    FRICTION * pressures[now],
                    np.clip(self.traction, -bound, bound),
                    self.width,
                    force=self.forces[now],
                )
                mean = 0.5 * (pressures[earlier] + pressures[now]) * (pressures[now] > 0)
                worn += WEAR * mean * abs(step.slip)
                self.traction = step.traction
        return worn


def test_a_cycle_wears_what_coulombs_law_says_step_by_step():
    least = 0.4
    problem = line(least, 0.35)
    state = first_loading(problem)
    bodies = Workspace(problem).on(state.geometry)
    pulse = load_cycle(problem, bodies.half_space, bodies.unworn, state, 1e-8)
    reference = Reference(problem, 1.3 * EDGE, 120, 40)
    worn = reference.cycle(0.0)
    rate = WEAR * pulse.path[:, 0]
    assert state.geometry.integral(rate[:, None]) == near(worn.sum() * reference.width, rel=0.01)
    rates = np.interp(abs(reference.x), state.geometry.x, rate, right=0.0)
    assert np.abs(rates - worn).sum() < 0.015 * worn.sum()
    assert pulse.least_load == least * PER_LENGTH
    assert state.geometry.integral(pulse.least) == near(pulse.least_load, rel=2e-3)


@pytest.mark.slow
def test_wear_over_many_cycles_is_that_of_small_explicit_steps():
    """Each with contacts and friction of their own; the deepest wear is a tenth of the approach."""
    problem, cycles, steps = line(0.7, 0.45, coarseness=2.0), 68500.0, 30
    *_, last = evolve_pulsating(problem, (cycles,))
    reference = Reference(problem, 1.6 * EDGE, 80, 20)
    wear = np.zeros_like(reference.x)
    for _ in range(steps):
        wear = wear + reference.cycle(wear) * cycles / steps
    assert last.geometry.integral(last.wear) == near(wear.sum() * reference.width, rel=0.01)
    depth = np.interp(abs(reference.x), last.geometry.x, last.wear[:, 0], right=0.0)
    assert np.abs(depth - wear).sum() < 0.01 * wear.sum()


def test_a_load_that_hardly_pulsates_under_a_force_is_constant():
    (*_, plain), (*_, pulsating) = (
        march(sphere(least, 0.4), (500.0,))
        for march, least in ((evolve, 1.0), (evolve_pulsating, 0.9999))
    )
    usual, found = (Measures(sphere(1.0, 0.4), state) for state in (plain, pulsating))
    for name in ("wear_volume", "maximum_wear_depth", "dissipated_energy", "approach"):
        assert getattr(found, name) == near(getattr(usual, name), rel=5e-3)


@pytest.mark.slow
def test_the_stick_zone_the_loop_and_the_energy_of_a_sphere():
    """The contact of (1 + r)/2 P − Q/µ sticks; the loop has Q as it is, and the area of D."""
    problem = sphere(0.7, 0.4)
    stops = (500.0, 2000.0)
    states = [state for state in evolve_pulsating(problem, stops) if state.cycle in (0.0, *stops)]
    for state in states:
        found, curve = Measures(problem, state), loop(Workspace(problem), state)
        assert found.stick_half_width_x == near(A * 0.45 ** (1 / 3), rel=2e-3)
        assert found.tangential_force == near(0.4 * problem.hertz.load * 0.5)
        assert curve.force.max() == near(found.tangential_force)
        assert curve.displacement.max() == near(found.tangential_displacement)
        assert curve.displacement.min() == near(-found.tangential_displacement)
        area = abs(trapezoid(curve.force, curve.displacement))
        assert area == near(found.dissipated_energy, rel=0.01)
        assert 0.0 < curve.opening < 0.2 * found.tangential_displacement
    *_, resumed = evolve_pulsating(problem, stops, start=states[1])
    np.testing.assert_array_equal(resumed.wear, states[-1].wear)
    *_, kept = evolve_pulsating(replace(problem, debris_fraction=0.5), (500.0,))
    np.testing.assert_allclose(kept.opening, 0.5 * kept.wear, rtol=1e-9, atol=1e-18)


def test_a_dataset_has_shear_of_the_amplitude_and_wear_of_a_cycle():
    keys = {"pulsating_load": 0.7, "tangential_ratio": 0.4, "cycles": 200}
    case = steel(cell="6 um", error_estimate=False, **keys)
    ds = simulate(case)
    for last in (ds.isel(cycle=0), ds.isel(cycle=-1)):
        area = last.cell_x * last.cell_y
        assert float(last.shear_traction.sum() * area) == near(0.4 * 0.5 * 50.0, rel=1e-5)
        worn = float(last.wear_rate.sum() * area)
        energy = float(last.dissipated_energy)
        assert worn == near(energy * case.wear_coefficient / case.friction, rel=1e-5)
    assert float(ds.pulsating_load) == near(0.7)
