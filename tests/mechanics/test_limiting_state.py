"""Smooth elastic runs of 30000 cycles on fine grids, against the closed form of endless wear."""

from dataclasses import dataclass

import numpy as np
import pytest

from fretwear.mechanics.geometry import Array
from fretwear.mechanics.integrator import evolve
from fretwear.mechanics.measures import Measures, measure
from fretwear.mechanics.state import State, WearProblem
from fretwear.theory import LimitingState

from .problems import HERTZ, A, fretting, near

pytestmark = pytest.mark.slow

STOPS = (100, 1000, 7000, 30000)


@dataclass(frozen=True)
class Run:
    """All states of a run and where it tends to."""

    problem: WearProblem
    states: list[State]
    limit: LimitingState

    @property
    def last(self) -> State:
        return self.states[-1]

    @property
    def measures(self) -> Measures:
        return measure(self.problem, self.last)

    @property
    def distance(self) -> Array:
        window = self.last.geometry
        return np.hypot(*np.meshgrid(window.x, window.y, indexing="ij"))


@pytest.fixture(scope="module", params=[0.2, 0.5, 0.9])
def run(request) -> Run:
    """30000 cycles at 110 cells per Hertz radius."""
    problem = fretting(110, load_ratio=request.param)
    return Run(problem, list(evolve(problem, STOPS)), LimitingState(HERTZ, request.param))


def narrow(run: Run) -> bool:
    """Whether the slip annulus is only eight cells wide: errors of its edges count double."""
    return run.limit.load_ratio < 0.3


def test_central_pressure_wear_and_contact_radius_are_those_of_endless_wear(run: Run):
    found, limit, last = run.measures, run.limit, run.states[-1]
    annulus = 0.02 if narrow(run) else 0.01
    assert found.central_pressure == near(limit.central_pressure, rel=5e-3)
    assert found.wear_volume == near(limit.wear_volume, rel=annulus)
    for width in (found.contact_half_width_x, found.contact_half_width_y):
        assert width == near(limit.contact_radius, rel=0.01)
    # Around the contact: the mean of rings one cell wide.
    ring = (run.distance / last.geometry.spacing[0]).astype(int).ravel()
    count = np.bincount(ring)
    rings = np.bincount(ring, last.wear.ravel())[count > 0] / count[count > 0]
    assert rings.max() == near(limit.deepest_wear, rel=annulus)
    # The stick zone is made of whole cells. Where its edge runs along the grid, on the axes, it
    # lies up to half a cell off over some thirty cells, and wear beside it follows: by 11 % of the
    # depth per cell in the narrow annulus. No integration error is in this.
    assert last.wear.max() == near(limit.deepest_wear, rel=0.055 if narrow(run) else 0.01)


def test_pressure_in_the_stick_zone(run: Run):
    inside = run.distance < 0.8 * run.limit.stick_radius
    expected = run.limit.pressure(run.distance)[inside]
    # Close to the edge the limit is singular and no grid follows it.
    np.testing.assert_allclose(run.last.pressure[inside], expected, rtol=0.01)


def test_worn_surfaces_conform_without_pressure(run: Run):
    r = run.distance
    worn = (r > run.limit.stick_radius + A / 55) & (r < run.limit.contact_radius - A / 55)
    assert run.last.pressure[worn].max() < 1e-3 * HERTZ.peak_pressure
    assert run.last.gap[worn].max() < 1e-3 * HERTZ.approach
    error = np.abs(run.last.wear - run.limit.wear_depth(r)).sum() / run.last.wear.sum()
    # The staircase of the stick edge again, without its sign.
    assert error < (0.03 if narrow(run) else 0.01)
