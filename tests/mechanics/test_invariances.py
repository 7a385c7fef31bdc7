"""What must not change the result, and what must change it in a known way."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fretwear.mechanics.integrator import evolve
from fretwear.mechanics.loading import NormalLoad, TangentialRatio
from fretwear.mechanics.materials import Coulomb
from fretwear.mechanics.slip import Jaeger
from fretwear.mechanics.solver import solve_contact
from fretwear.mechanics.state import WearProblem
from fretwear.mechanics.surfaces import Sphere
from fretwear.mechanics.wear_laws import Archard
from fretwear.theory import HertzContact

from .problems import (
    CONVERGED,
    COUPLING,
    EVEN,
    FRICTION,
    HERTZ,
    LOAD,
    MODULUS,
    P0,
    RADIUS,
    ROUGH,
    SMOOTH,
    WEAR,
    A,
    Elastic,
    Waves,
    fretting,
    near,
    pressed,
    uneven,
    window,
)

CYCLES = 400.0
few = settings(max_examples=12)


def final(
    problem,
    cycles=CYCLES,
    tolerance=0.01,
    accuracy=None,
):
    *_, state = evolve(problem, [cycles], tolerance, accuracy=accuracy)
    return state


def scaled(factor):
    """Factors from 1/factor to factor, evenly on a logarithmic scale."""
    return st.floats(-1, 1).map(lambda power: factor**power)


@few
@given(
    radius=scaled(1e4),
    modulus=scaled(1e3),
    load=scaled(1e4),
    friction=scaled(3),
    coupling=scaled(1.5),
    wear=scaled(100),
    surface=st.sampled_from([SMOOTH, ROUGH]),
    limit=st.sampled_from([np.inf, 1.4]),
    ratio=st.floats(0.3, 0.9),
)
def test_only_dimensionless_groups_matter(
    radius, modulus, load, friction, coupling, wear, surface, limit, ratio
):
    """Q/µP, τ = β p0 N, p_lim/p0, A/δ and k a: all else is a choice of units."""
    problem = fretting(8, load_ratio=ratio, roughness=surface, limit=limit)
    hertz = HertzContact(RADIUS * radius, LOAD * load, MODULUS * modulus)
    a, p0 = hertz.contact_radius, hertz.peak_pressure
    waves = surface and Waves(
        ROUGH.amplitude * hertz.approach / HERTZ.approach,
        ROUGH.wavenumber_x * A / a,
        ROUGH.wavenumber_y * A / a,
    )
    other = WearProblem(
        indenter=Sphere(hertz.radius),
        roughness=waves,
        bodies=Elastic(hertz.composite_modulus, COUPLING * coupling),
        normal=NormalLoad(hertz.load),
        loading=TangentialRatio(ratio),
        friction=Coulomb(FRICTION * friction),
        slip_model=Jaeger(),
        wear_law=Archard(WEAR * wear),
        limit=limit * p0,
        spacing=(a / 8, a / 8),
        extent=(1.15 * a, 1.15 * a),
    )
    cycles = CYCLES * problem.growth_rate * P0 / (other.growth_rate * p0)
    one, two = final(problem), final(other, cycles)
    assert one.step == two.step
    # The same numbers up to rounding, as long as it flips no decision of the contact solver;
    # where it does, contacts are equal to their tolerance of 1e-6.
    np.testing.assert_allclose(two.pressure / p0, one.pressure / P0, atol=1e-5)
    for field in ("wear", "plastic", "gap"):
        found, expected = getattr(two, field), getattr(one, field)
        np.testing.assert_allclose(found / hertz.approach, expected / HERTZ.approach, atol=1e-5)
    assert two.geometry.integral(two.wear) > 0


def test_more_tangential_load_wears_more_and_finer_cells_change_it_ever_less():
    volumes = []
    for ratio in (0.1, 0.3, 0.5, 0.7, 0.9):
        state = final(fretting(16, load_ratio=ratio))
        volumes.append(state.geometry.integral(state.wear))
    assert all(np.diff(volumes) > 0)
    for cells in (12, 24, 48):
        state = final(fretting(cells, load_ratio=0.9), 1500)
        volumes.append(state.geometry.integral(state.wear))
    changes = np.abs(np.diff(volumes)) / volumes[-1]
    # The stick zone, 0.46 a in radius, is made of whole cells: its rounding fades as they shrink.
    assert changes[0] < 0.05
    assert changes[1] < 0.02


@pytest.mark.parametrize("limit", [np.inf, 1.4])
@pytest.mark.parametrize("even", EVEN)
def test_turning_roughness_and_grid_turns_the_fields(limit, even):
    spacing = (A / 10, A / 14)
    surface = uneven(ROUGH, even)
    turned = Waves(ROUGH.amplitude, ROUGH.wavenumber_y, ROUGH.wavenumber_x, even[::-1])
    one, other = (
        final(fretting(roughness=waves, limit=limit, spacing=cell), accuracy=CONVERGED)
        for waves, cell in ((surface, spacing), (turned, spacing[::-1]))
    )
    assert one.pressure.shape == other.pressure.shape[::-1]
    np.testing.assert_allclose(one.pressure, other.pressure.T, atol=1e-9 * P0)
    np.testing.assert_allclose(one.wear, other.wear.T, atol=1e-9 * HERTZ.approach)
    # The waves are not alike along x and y, so something was turned.
    assert not np.allclose(one.wear[:9, :9], one.wear[:9, :9].T, atol=1e-3 * HERTZ.approach)


def test_raising_both_bodies_changes_the_approach_alone():
    problem = pressed(window((20, 20)), roughness=ROUGH)
    raised = replace(problem, shape=problem.shape + 5e-6)
    one, other = (solve_contact(p, tolerance=1e-9) for p in (problem, raised))
    np.testing.assert_allclose(one.pressure, other.pressure, atol=1e-7 * P0)
    assert other.approach - one.approach == near(5e-6, rel=1e-8)


@pytest.mark.parametrize("limit", [np.inf, 1.4])
def test_further_stops_change_the_wear_by_less_than_the_tolerance(limit):
    problem = fretting(12, roughness=ROUGH, limit=limit)
    *_, often = evolve(problem, [17, 60, 61, 200, 1000], 0.01)
    seldom = final(problem, 1000)
    difference = np.abs(often.wear - seldom.wear).sum() / seldom.wear.sum()
    assert 0 < difference < 0.01
