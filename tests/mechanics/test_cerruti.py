"""Friction along x with the true influence of tractions, against friction as a vector."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from fretwear.mechanics.contact.cells import Workspace
from fretwear.mechanics.contact.grid import influence_coefficients
from fretwear.mechanics.contact.strips import Strips
from fretwear.mechanics.slip.loading import DisplacementAmplitude
from fretwear.mechanics.slip.models import Cerruti, Coupled, Jaeger
from fretwear.mechanics.slip.shear import shear_influence
from fretwear.mechanics.surfaces.indenters import Cylinder
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.wear.integrator import evolve
from fretwear.mechanics.wear.loops import loop
from fretwear.theory import coupling_ratio

from ..studies import near
from .oracles import normal_contact
from .problems import (
    COUPLING,
    FRICTION,
    LOAD,
    MODULUS,
    P0,
    RADIUS,
    ROUGH,
    WORN_BY_VECTOR_FRICTION,
    A,
    Elastic,
    fretting,
)
from .test_coupled import worn

TILTING = DisplacementAmplitude(displacement_amplitude=0.3 * FRICTION * A**2 / RADIUS)
ON_A_RIG = DisplacementAmplitude(
    displacement_amplitude=0.45 * FRICTION * A**2 / RADIUS, rig_stiffness=2e7
)


LINE = {
    "geometry": Strips,
    "indenter": Cylinder(6e-3),
    "normal": NormalLoad(4e5),
    "spacing": (2e-6, 2e-6),
    "extent": (2e-4, 2e-4),
}


def of_poisson(ratio):
    return Elastic(coupling=coupling_ratio(1.0, ratio, 1.0, ratio))


def test_the_kernel_is_that_of_displacements_along_x_by_tractions_along_x():
    shape, spacing = (7, 5), (0.3 * A, 0.2 * A)
    along, _, _ = shear_influence(shape, spacing, MODULUS, COUPLING)
    weights = (1.0, 2.0 * COUPLING - 1.0)
    found = influence_coefficients(shape, spacing, MODULUS, weights=weights)
    np.testing.assert_allclose(found, along, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("poisson", "changes"),
    [
        (0.2, {"load_ratio": 0.5}),
        (0.3, {"roughness": ROUGH}),
        (0.3, {"roughness": ROUGH, "limit": 3.5}),
        (0.3, {"limit": 1.4, "load_ratio": 0.9}),
        (0.3, {"loading": TILTING}),
        (0.3, {"loading": ON_A_RIG, "roughness": ROUGH}),
    ],
    ids=["smooth", "rough", "rough, capped", "capped", "displacement", "rig"],
)
def test_slip_and_wear_are_those_of_friction_as_a_vector(poisson, changes):
    """Friction along one direction alike in all leaves out 10 % of the slip here."""
    times, runs = [0.0, 0.5, 2.0], {}
    for model in (Jaeger(), Cerruti(), Coupled()):
        problem = fretting(20, slip_model=model, bodies=of_poisson(poisson), **changes)
        runs[model.kind] = worn(problem, times)
    off = {"jaeger": 0.0, "cerruti": 0.0}
    for kind, worst in off.items():
        for state, exact in zip(runs[kind], runs["coupled"], strict=True):
            touches, slip = exact.pressure > 0.0, problem.slip(exact.reduced)
            missed = np.abs(problem.slip(state.reduced) - slip)[touches].max()
            off[kind] = worst = max(worst, missed / slip[touches].max())
            if kind == "jaeger":
                continue
            integral, bound = state.geometry.integral, FRICTION * state.pressure
            traction = problem.shear_traction(state.pressure, state.reduced)
            assert np.abs(traction).max() <= (1.0 + 1e-6) * bound.max()
            assert (FRICTION * state.reduced.pressure - 2.0 * bound).max() <= 1e-6 * bound.max()
            energy, expected = (
                problem.dissipated_energy(each, each.geometry) for each in (state, exact)
            )
            assert energy == near(expected, rel=0.01)
            if state.cycle:
                assert integral(np.abs(state.wear - exact.wear)) < 0.01 * integral(exact.wear)
                assert integral(state.wear) == near(integral(exact.wear), rel=0.006)
                assert state.wear.max() == near(exact.wear.max(), rel=0.007)
    assert off["cerruti"] < 0.015
    assert off["jaeger"] > 4.0 * off["cerruti"]


@pytest.mark.slow
def test_wear_is_that_of_explicit_steps():
    """The depths are those beside both axes."""
    states = worn(fretting(30, slip_model=Cerruti()), [*WORN_BY_VECTOR_FRICTION])
    for state, (volume, deepest, x, y) in zip(
        states, WORN_BY_VECTOR_FRICTION.values(), strict=True
    ):
        assert state.geometry.integral(state.wear) == near(volume * A**4 / RADIUS, rel=0.005)
        depths = (field.max() for field in (state.wear, state.wear[:, 0], state.wear[0]))
        for depth, expected in zip(depths, (deepest, x, y), strict=True):
            assert depth == near(expected * A**2 / RADIUS, rel=0.015)


@pytest.mark.parametrize(
    "changes",
    [
        {"bodies": Elastic(coupling=1.0), "roughness": ROUGH, "limit": 3.0},
        {"bodies": Elastic(coupling=1.0), "loading": TILTING},
        LINE,
    ],
    ids=["without Poisson's ratio", "the same under a displacement", "a single direction"],
)
def test_it_equals_that_of_a_normal_contact_to_the_bit_where_directions_do_not_differ(changes):
    single, found = (
        worn(fretting(10, slip_model=model, **changes), [1.0])[0] for model in (Jaeger(), Cerruti())
    )
    for name in ("pressure", "wear", "gap"):
        np.testing.assert_array_equal(getattr(found, name), getattr(single, name))
    np.testing.assert_array_equal(found.reduced.gap, single.reduced.gap)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes", [{}, {"roughness": ROUGH}, {"limit": 1.4}, {"loading": TILTING}]
)
def test_the_loop_has_the_energy_of_slip_and_wear_the_energy_of_all_cycles(changes):
    problem = fretting(14, slip_model=Cerruti(), **changes)
    states = [*evolve(problem, [1.0 / (problem.wear_growth * P0)], 3e-4)]
    energies = [problem.dissipated_energy(state, state.geometry) for state in states]
    for state, energy in zip(states[:: len(states) - 1], energies[:: len(states) - 1], strict=True):
        curve = loop(Workspace(problem), state)
        assert abs(np.trapezoid(curve.force, curve.displacement)) == near(energy, rel=1e-3)
    spent = PchipInterpolator([state.cycle for state in states], energies)
    energy = float(spent.integrate(0.0, states[-1].cycle))
    volume = states[-1].geometry.integral(states[-1].wear)
    assert volume == near(problem.combined_wear_coefficient / FRICTION * energy, rel=1e-3)


@pytest.mark.slow
def test_late_wear_is_that_of_short_explicit_steps_with_dense_matrices():
    """The stick zone recedes, which raises volume and energy above those of `Jaeger`."""
    cells, tau, step = 8, 8.0, 0.02
    size, count = A / cells, int(1.5 * cells)
    weights = (1.0 / COUPLING, (2.0 * COUPLING - 1.0) / COUPLING)
    normal, along_x = (_dense(count, size, each) for each in ((1.0, 1.0), weights))
    x, y = np.meshgrid(*[(np.arange(count) + 0.5) * size] * 2, indexing="ij")
    unworn, area = ((x**2 + y**2) / (2.0 * RADIUS)).ravel(), 4.0 * size**2
    wear, loaded, stuck = np.zeros_like(unworn), None, None
    for last in (False,) * round(tau / step) + (True,):
        pressure, _, _ = normal_contact(normal, unworn + wear, area, LOAD, loaded)
        turned = unworn + wear + (normal - along_x) @ pressure
        reduced, gap, _ = normal_contact(along_x, turned, area, 0.2 * LOAD, stuck)
        loaded, stuck = pressure > 0.0, reduced > 0.0
        if not last:
            wear += np.expm1(step * pressure / P0) * gap
    problem = fretting(cells, slip_model=Cerruti(), extent=(1.5 * A, 1.5 * A))
    found, single = (worn(replace(problem, slip_model=m), [tau])[0] for m in (Cerruti(), Jaeger()))
    volume = found.geometry.integral(found.wear)
    assert volume == near(wear.sum() * area, rel=0.005)
    assert found.wear.max() == near(wear.max(), rel=0.005)
    energy = 4.0 * FRICTION**2 * COUPLING * area * (pressure * gap).sum()
    assert problem.dissipated_energy(found, found.geometry) == near(energy, rel=0.03)
    assert volume > 1.03 * single.geometry.integral(single.wear)


def _dense(count, size, weights):
    """Influence of the cells of a quarter and their images."""
    kernel = influence_coefficients((2 * count + 1,) * 2, (size, size), MODULUS, weights)
    i = np.arange(count)
    near_by, image = np.abs(i[:, None] - i), i[:, None] + i + 1
    both = itertools.product((near_by, image), repeat=2)
    matrix = sum(kernel[dx[:, None, :, None], dy[None, :, None, :]] for dx, dy in both)
    return matrix.reshape(count**2, count**2)


@pytest.mark.slow
@pytest.mark.parametrize("changes", [{"roughness": ROUGH}, {}], ids=["rough", "smooth"])
def test_shorter_steps_lead_to_the_same_wear_when_the_stick_zone_recedes(changes):
    problem = fretting(16, slip_model=Cerruti(), **changes)
    end = [10.0 / (problem.wear_growth * P0)]
    usual, fine = ([*evolve(problem, end, tolerance)][-1] for tolerance in (0.01, 0.001))
    assert usual.geometry.integral(usual.wear) == near(fine.geometry.integral(fine.wear), rel=0.01)
    assert usual.wear.max() == near(fine.wear.max(), rel=0.01)
    if not changes:
        *_, single = evolve(fretting(16, slip_model=Jaeger()), end)
        assert fine.reduced.stick.sum() < single.reduced.stick.sum()
