"""How many steps and convolutions the jobs of the table of speeds take.

Counts do not depend on the machine but for rounding, which can move a few of them; a test fails
above `TOLERATED` times these. Lower them when the solver gets better.
"""

from collections import deque

import numpy as np
import pytest
from benchmarks.speed.cases import WAVES, first_contact, rough_case, smooth_case, study_case

from fretwear.mechanics.active_set import ActiveSet
from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.integrator import evolve, first_loading
from fretwear.mechanics.kernels import inner
from fretwear.mechanics.solver import solve_contact
from fretwear.running import simulate

TOLERATED = 1.15


def last_state(case):
    problem = simulate.wear_problem(case, Grid)
    return deque(evolve(problem, [float(case.cycles)], case.tolerance), maxlen=1)[0]


@pytest.mark.parametrize(("rough", "expected"), [(False, 28), (True, 51)], ids=["smooth", "rough"])
def test_a_cold_contact_takes_few_convolutions(rough, expected):
    contact = solve_contact(first_contact(256, rough=rough), tolerance=1e-6)
    assert contact.residual <= 1e-6
    assert contact.convolutions <= TOLERATED * expected


def test_the_first_loading_of_the_rough_capped_run_takes_few_convolutions():
    state = first_loading(simulate.wear_problem(rough_case()))
    assert state.convolutions <= TOLERATED * 126


RUNS = {
    "smooth": (smooth_case(128), 15, 315),
    "smooth, capped": (smooth_case(24, plastic_limit="2160 MPa", cycles=7000), 28, 1880),
    # On twice the spacing and for 438 cycles; the row itself took 61 steps, 4712 convolutions.
    "rough, capped": (rough_case(2.0, cycles=438), 9, 836),
}


@pytest.mark.parametrize("run", RUNS)
def test_a_run_takes_few_steps_and_convolutions(run):
    case, steps, convolutions = RUNS[run]
    last = last_state(case)
    assert last.step <= TOLERATED * steps
    assert last.convolutions <= TOLERATED * convolutions


def test_no_step_of_the_solver_is_downhill_by_rounding_only(monkeypatch):
    # Along such a step, left by clipping, the energy hardly falls, and the next is the same again.
    search, descents = ActiveSet._search, []

    def watched(method, segment):
        along = inner(method._team, np.abs(method.gap), np.abs(segment.step))
        descent = inner(method._team, method.gap, segment.step)
        assert segment.slope == pytest.approx(descent, abs=1e-12 * along)
        descents.append(-segment.slope / along)
        search(method, segment)

    monkeypatch.setattr(ActiveSet, "_search", watched)
    cell = (0.75e-6, 3e-6)
    last_state(study_case(roughness=WAVES, plastic_limit="5500 MPa", cycles=438, cell=cell))
    assert len(descents) > 100
    assert min(descents) > 0.05
