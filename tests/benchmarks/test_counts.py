"""How many steps and convolutions the jobs of the table of speeds take.

Counts do not depend on the machine but for rounding, which can move a few of them; a test fails
above `TOLERATED` times these. Lower them when the solver gets better.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
import pytest
from benchmarks.speed.cases import WAVES, first_contact, rough_case, smooth_case, study_case

from fretwear.mechanics.active_set import ActiveSet
from fretwear.mechanics.integrator import evolve, first_loading
from fretwear.mechanics.kernels import inner
from fretwear.mechanics.solver import solve_contact
from fretwear.running import simulate

TOLERATED = 1.15


@dataclass(frozen=True)
class Counts:
    """Accepted steps, 0 for a contact, and half-space convolutions."""

    steps: int
    convolutions: int

    def hold(self, steps: int, convolutions: int) -> bool:
        """Whether a job took no more than it may."""
        return steps <= TOLERATED * self.steps and convolutions <= TOLERATED * self.convolutions


COLD_SMOOTH = Counts(0, 28)
COLD_ROUGH_CAPPED = Counts(0, 51)
FIRST_LOADING = Counts(0, 106)
"""Of the rough run, on its own grid."""
SMOOTH_RUN = Counts(15, 315)
ROUGH_RUN_COARSE = Counts(9, 836)
"""On twice the spacing and for 438 cycles; the row itself took 61 steps, 4712 convolutions."""


def last_state(case):
    problem = simulate.wear_problem(case)
    return deque(evolve(problem, [float(case.cycles)], case.tolerance), maxlen=1)[0]


@pytest.mark.parametrize(
    ("rough", "expected"),
    [(False, COLD_SMOOTH), (True, COLD_ROUGH_CAPPED)],
    ids=["smooth", "rough, capped"],
)
def test_a_cold_contact_takes_few_convolutions(rough, expected):
    contact = solve_contact(first_contact(256, rough=rough), tolerance=1e-6)
    assert contact.residual <= 1e-6
    assert expected.hold(0, contact.convolutions), contact.convolutions


def test_the_first_loading_of_the_rough_capped_run_takes_few_convolutions():
    state = first_loading(simulate.wear_problem(rough_case()))
    assert FIRST_LOADING.hold(0, state.convolutions), state.convolutions


def test_no_step_of_the_solver_is_downhill_by_rounding_only(monkeypatch):
    # Along such a step, left by clipping, the energy hardly falls, and the next is the same again.
    search, descents = ActiveSet._search, []

    def watched(method, segment):
        along = inner(np.abs(method.gap), np.abs(segment.step))
        assert segment.slope == pytest.approx(inner(method.gap, segment.step), abs=1e-12 * along)
        descents.append(-segment.slope / along)
        search(method, segment)

    monkeypatch.setattr(ActiveSet, "_search", watched)
    cell = (0.75e-6, 3e-6)
    last_state(study_case(roughness=WAVES, plastic_limit="5500 MPa", cycles=438, cell=cell))
    assert len(descents) > 100
    assert min(descents) > 0.05


def test_a_smooth_run_of_30000_cycles_takes_few_steps():
    state = last_state(smooth_case(128))
    assert SMOOTH_RUN.hold(state.step, state.convolutions), (state.step, state.convolutions)


def test_a_rough_capped_run_takes_few_steps_on_a_coarse_grid():
    state = last_state(rough_case(2.0, cycles=438))
    assert ROUGH_RUN_COARSE.hold(state.step, state.convolutions), (
        state.step,
        state.convolutions,
    )
