"""Wear by friction in two directions: explicit steps, limits, and Coulomb's law in the output."""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import fretwear
from fretwear.mechanics.contact.problem import Accuracy
from fretwear.mechanics.slip.models import Coupled, Jaeger
from fretwear.mechanics.wear.integrator import evolve
from fretwear.run.simulate import run
from fretwear.theory import coupling_ratio

from ..studies import near
from .problems import (
    FRICTION,
    P0,
    RADIUS,
    ROUGH,
    WORN_BY_VECTOR_FRICTION,
    A,
    Elastic,
    fretting,
    uneven,
)

CASE = {
    "radius": "10 mm",
    "youngs_modulus": "208 GPa",
    "load": "50 N",
    "friction": 0.5,
    "wear_coefficient": "7e-13 / Pa",
    "poisson_ratio": 0.3,
    "cell": "7.5 um",
    "error_estimate": False,
}


# Solved this well, both models are the same where Poisson's ratio is zero; else they differ by less
# than the tolerance of the contact of a first stage.
EXACT = Accuracy(*[3e-12] * 6)


def worn(problem, times, accuracy=None):
    """States at some τ = β N p0."""
    cycles = [tau / (problem.wear_growth * P0) for tau in times]
    states = {state.cycle: state for state in evolve(problem, cycles, accuracy=accuracy)}
    return [states[cycle] for cycle in cycles]


@pytest.mark.slow
def test_wear_is_that_of_explicit_steps():
    """The depths are those beside both axes."""
    states = worn(fretting(30, slip_model=Coupled()), [*WORN_BY_VECTOR_FRICTION])
    for state, (volume, deepest, x, y) in zip(
        states, WORN_BY_VECTOR_FRICTION.values(), strict=True
    ):
        assert state.geometry.integral(state.wear) == near(volume * A**4 / RADIUS, rel=0.005)
        depths = (field.max() for field in (state.wear, state.wear[:, 0], state.wear[0]))
        for depth, expected in zip(depths, (deepest, x, y), strict=True):
            assert depth == near(expected * A**2 / RADIUS, rel=0.012)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [{}, {"roughness": ROUGH, "limit": 3.0}, {"debris_fraction": 0.5}],
    ids=["smooth", "rough and plastic", "debris"],
)
def test_without_poissons_ratio_slip_is_that_of_one_direction(changes):
    for accuracy, equal in ((EXACT, 1e-7), (None, 1e-4)):
        coupled, single = (
            worn(
                fretting(12, bodies=Elastic(coupling=1.0), slip_model=model, **changes),
                [0.5],
                accuracy,
            )[0]
            for model in (Coupled(), Jaeger())
        )
        volume = single.geometry.integral(single.wear)
        assert coupled.geometry.integral(coupled.wear) == near(volume, rel=equal)
        assert np.abs(coupled.wear - single.wear).max() <= equal * single.wear.max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ratio", "poisson", "changes"),
    [
        (0.5, 0.3, {}),
        (0.85, 0.4, {"limit": 1.3}),
        (0.7, 0.2, {"roughness": ROUGH}),
        (0.6, 0.45, {"roughness": uneven(ROUGH, (False, True)), "limit": 3.0}),
    ],
    ids=["smooth", "capped", "rough", "even along y only"],
)
def test_wear_volume_is_the_energy_dissipated_times_the_coefficient_over_friction(
    ratio, poisson, changes
):
    bodies = Elastic(coupling=coupling_ratio(1.0, poisson, 1.0, poisson))
    problem = fretting(12, load_ratio=ratio, bodies=bodies, slip_model=Coupled(), **changes)
    states = [*evolve(problem, [1.0 / (problem.wear_growth * P0)], 3e-4)]
    energies = [problem.dissipated_energy(state, state.geometry) for state in states]
    spent = PchipInterpolator([state.cycle for state in states], energies)
    energy = float(spent.integrate(0.0, states[-1].cycle))
    volume = states[-1].geometry.integral(states[-1].wear)
    assert volume == near(problem.combined_wear_coefficient / FRICTION * energy, rel=1e-3)


def test_a_window_that_grows_keeps_the_tractions():
    wide, narrow = (
        worn(fretting(12, slip_model=Coupled(), extent=(size * A, size * A)), [2.0])[0]
        for size in (1.6, 1.02)
    )
    assert narrow.geometry.shape < wide.geometry.shape
    volumes = [state.geometry.integral(state.wear) for state in (wide, narrow)]
    assert volumes[1] == near(volumes[0], rel=0.002)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("loading", "roughness"),
    [
        ({"tangential_ratio": 0.7}, None),
        ({"displacement_ratio": 0.6, "rig_stiffness": "20 N/um"}, None),
        ({"displacement_ratio": 1.4}, None),
        (
            {"tangential_ratio": 0.7},
            {
                "kind": "self_affine",
                "rms_height": "0.2 um",
                "rolloff_wavelength": "120 um",
                "shortest_wavelength": "60 um",
                "hurst": 0.8,
                "seed": 1,
            },
        ),
    ],
    ids=["force", "rig", "gross slip", "random surface"],
)
def test_results_obey_coulombs_law_and_loops_have_their_work(loading, roughness):
    case = fretwear.Case(slip_model="coupled", cycles=50, roughness=roughness, **CASE, **loading)
    result = run(case)
    last = result.dataset.isel(cycle=-1)
    pressure, slip = last.pressure.values, last.slip.values
    traction = np.hypot(last.shear_traction, last.shear_traction_y).values
    assert np.all(traction <= FRICTION * pressure + 1e-6 * FRICTION * pressure.max())
    assert np.allclose(np.hypot(last.slip_x, last.slip_y), slip, atol=1e-6 * slip.max())
    slips = (pressure > 0) & (slip > 0.01 * slip[pressure > 0].max()) & (last.stick_fraction == 0)
    slips = slips.values
    assert np.allclose(traction[slips], FRICTION * pressure[slips], rtol=1e-5)
    turned = last.slip_x * last.shear_traction_y - last.slip_y * last.shear_traction
    assert np.abs(turned.values[slips] / (slip * traction)[slips]).max() <= 1e-3
    assert np.abs(last.shear_traction_y.values).max() > 0.01 * traction.max()
    loop = result.loops.isel(cycle=-1)
    work = abs(np.trapezoid(loop.force, loop.displacement))
    assert work == near(float(last.dissipated_energy), rel=1e-3)
    assert loop.force.max() == near(float(last.tangential_force), rel=1e-12)


def test_mirrored_tractions_along_y_change_sign_from_quarter_to_quarter():
    case = fretwear.Case(slip_model="coupled", cycles=10, tangential_ratio=0.7, **CASE)
    last = fretwear.simulate(case).isel(cycle=-1)
    for name in ("slip_y", "shear_traction_y"):
        field = last[name].transpose("x", "y").values
        assert np.array_equal(field, -field[::-1])
        assert np.array_equal(field, -field[:, ::-1])
        assert field.any()
    for name in ("slip_x", "shear_traction", "slip"):
        field = last[name].transpose("x", "y").values
        assert np.array_equal(field, field[::-1])
    assert "slip_y" not in fretwear.simulate(fretwear.Case(cycles=10, tangential_ratio=0.7, **CASE))
