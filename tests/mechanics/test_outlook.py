"""The window holds every asperity tip that touches, also those a wavelength away."""

from dataclasses import replace

import numpy as np
import pytest

from fretwear import Case
from fretwear.mechanics.loading import first_loading
from fretwear.mechanics.outlook import Outlook, larger_window
from fretwear.mechanics.surfaces import Surface
from fretwear.mechanics.wear import evolve
from fretwear.mechanics.window import Window
from fretwear.running.simulate import wear_problem

CONTACT_GAP = 1e-5


@pytest.fixture
def problem():
    case = Case(
        radius="10 mm",
        youngs_modulus="208 GPa",
        poisson_ratio=0.3,
        load="20 N",
        tangential_ratio=0.8,
        friction=0.6,
        wear_coefficient="7e-13 / Pa",
        roughness={"amplitude": "0.2 um", "slope_x": "3 deg", "slope_y": "1 deg"},
        cell=("1.5 um", "3 um"),
        cycles=1000,
    )
    return wear_problem(case)


def wider(window: Window, factor: float) -> Window:
    nx, ny = (int(factor * n) for n in window.shape)
    return Window((nx, ny), window.spacing, window.quarter)


def test_nothing_penetrates_beyond_the_window_at_any_step(problem):
    for state in evolve(problem, [10, 100, 1000]):
        wide = state.on(problem, wider(state.window, 1.6))
        assert wide.gap.min() >= -CONTACT_GAP * state.approach


def test_a_tip_beyond_the_window_is_noticed(problem):
    state = list(evolve(problem, [100]))[-1]
    window = state.window
    columns = np.flatnonzero(state.pressure.any(axis=1))
    # Cut the window in the valley before the outermost row of tips that touch.
    gaps = np.flatnonzero(np.diff(columns) > 1)
    cut = int(columns[gaps[-1]]) + 3
    small = Window((cut, window.shape[1]), window.spacing, window.quarter)
    inner = window.resized(state.pressure, small.shape)
    assert not inner[-2:].any()
    assert Outlook(problem, small).touched(inner, state.approach)[0]
    grown = larger_window(problem, small, inner, state.approach)
    assert grown.shape[0] > columns[-1]


def test_tips_that_the_displacement_keeps_open_are_not_touched(problem):
    state = first_loading(problem)
    wide = wider(state.window, 1.6)
    outside = ~state.window.covered(wide.shape)
    # Rigid bodies would touch there.
    assert (problem.surface.shape(wide)[outside] < state.approach).any()
    outlook = Outlook(problem, state.window)
    assert outlook.touched(state.pressure, state.approach) == (False, False)


def test_a_smooth_contact_looks_at_its_border_alone(problem):
    smooth = replace(problem, surface=Surface(problem.surface.radius))
    state = first_loading(smooth)
    assert Outlook(smooth, state.window).touched(state.pressure, state.approach) == (False, False)
    full = np.ones(state.window.shape)
    assert Outlook(smooth, state.window).touched(full, state.approach) == (True, True)


def test_a_window_grows_before_the_contact_is_at_its_border(problem):
    state = first_loading(replace(problem, surface=Surface(problem.surface.radius)))
    outlook = Outlook(problem, state.window)
    reach = np.flatnonzero(state.pressure.any(axis=1))[-1] + 1
    near, far = (np.zeros(state.window.shape) for _ in range(2))
    near[: state.window.shape[0] - 1, 0] = 1.0
    far[:reach, 0] = 1.0
    assert outlook.approached(near) == (True, False)
    assert outlook.approached(far) == (False, False)
