"""The default grid spacing: what a contact needs, up to what it may cost."""

import math

import numpy as np
import pytest

from fretwear.mechanics.integrator import first_loading
from fretwear.mechanics.measures import measure
from fretwear.running.simulate import wear_problem
from fretwear.study.spacing import MOST_CELLS, needed_spacing, zones_of_tip

from ..studies import WAVES, steel

GENTLE = {"amplitude": 2e-7, "slope_x": 0.05, "slope_y": 0.02}
CAPPED = {"plastic_limit": "4500 MPa", "roughness": {**WAVES, "slope_x": "3 deg"}}


def loaded(case):
    problem = wear_problem(case)
    state = first_loading(problem)
    return state, measure(problem, state)


@pytest.mark.parametrize("limit", [math.inf, 4.5e9])
@pytest.mark.parametrize("slopes", [(0.1, 0.02), (0.05, 0.05)])
def test_the_tip_in_the_middle_touches_as_wide_as_hertz_says_of_its_share(slopes, limit):
    """The middle is a valley; the tip nearest to it carries nearly as much."""
    waves = {"amplitude": 2e-7, "slope_x": slopes[0], "slope_y": slopes[1]}
    case = steel(roughness=waves, plastic_limit=limit)
    state, _ = loaded(case)
    window, rough = state.geometry, case.roughness
    row = int(np.argmin(abs(window.y)))
    on_tip = abs(window.x - rough.wavelength_x / 2) < rough.wavelength_x / 4
    width = np.count_nonzero(state.pressure[on_tip, row]) * window.spacing[0]
    expected = zones_of_tip(case)["contact of a tip"][0][0]
    assert width == pytest.approx(expected, rel=0.15)


def test_tips_get_their_cells_as_long_as_these_can_be_afforded():
    cheap, dear = steel(load=10, roughness=GENTLE), steel(load=200, roughness=GENTLE)
    for given, needed in zip(cheap.grid_spacing, needed_spacing(cheap), strict=True):
        assert 0.9 * needed < given <= needed
    assert dear.grid_spacing > needed_spacing(dear)
    cells = dear.hertz_radius**2 / math.prod(dear.grid_spacing)
    assert MOST_CELLS <= cells < 1.25 * MOST_CELLS


def test_waves_without_tips_of_known_shape_are_resolved_as_they_were():
    random = {"kind": "self_affine", "rms_height": 1e-7, "hurst": 0.8, "seed": 1}
    random |= {"rolloff_wavelength": 8e-5, "shortest_wavelength": 8e-6}
    assert steel(roughness=random).grid_spacing == (1e-6, 1e-6)


def test_plastic_volume_of_tips_that_hardly_yield_is_that_of_narrow_cells():
    """With heights of the centres for means over cells it would differ by 12 %."""
    coarse = steel(**CAPPED, load="40 N", cell=["0.4 um", "1.4 um"])
    fine = coarse.replace(cell=["0.2 um", "0.7 um"])
    volumes = [loaded(case)[1].plastic_volume for case in (coarse, fine)]
    assert volumes[0] == pytest.approx(volumes[1], rel=0.02)
