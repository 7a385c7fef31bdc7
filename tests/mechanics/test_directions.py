"""Slip by the true influence of tractions: friction as a vector, along x alone, bulk stress."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import fretwear
from fretwear.mechanics.contact.grid import influence_coefficients
from fretwear.mechanics.contact.problem import ContactError
from fretwear.mechanics.contact.strips import Row
from fretwear.mechanics.slip.models import Cerruti, Coupled, Jaeger
from fretwear.mechanics.slip.shear import bodies_under_shear, shear_influence
from fretwear.mechanics.surfaces.loading import DisplacementAmplitude
from fretwear.mechanics.surfaces.materials import Coulomb, ElasticBodies
from fretwear.mechanics.wear.integrator import evolve, first_loading
from fretwear.mechanics.wear.loops import loop
from fretwear.mechanics.wear.state import Workspace
from fretwear.run.simulate import run
from fretwear.run.states import wear_problem
from fretwear.study.case import CaseError
from fretwear.theory import coupling_ratio

from ..studies import line_contact, near, steel
from .oracles import normal_contact, with_images
from .problems import (
    COUPLING,
    EDGE,
    FRICTION,
    LINE,
    LOAD,
    MODULUS,
    P0,
    RADIUS,
    ROUGH,
    WORN_BY_VECTOR_FRICTION,
    A,
    Elastic,
    fretting,
    on_strips,
    uneven,
)


def worn(problem, times):
    """States at some τ = β N p0."""
    cycles = [tau / (problem.wear_growth * P0) for tau in times]
    states = {state.cycle: state for state in evolve(problem, cycles)}
    return [states[cycle] for cycle in cycles]


@pytest.mark.slow
@pytest.mark.parametrize(("model", "rel"), [(Coupled(), 0.012), (Cerruti(), 0.015)])
def test_wear_is_that_of_explicit_steps(model, rel):
    """The depths are those beside both axes."""
    states = worn(fretting(30, slip_model=model), [*WORN_BY_VECTOR_FRICTION])
    for state, (volume, deepest, x, y) in zip(
        states, WORN_BY_VECTOR_FRICTION.values(), strict=True
    ):
        assert state.geometry.integral(state.wear) == near(volume * A**4 / RADIUS, rel=0.005)
        depths = (field.max() for field in (state.wear, state.wear[:, 0], state.wear[0]))
        for depth, expected in zip(depths, (deepest, x, y), strict=True):
            assert depth == near(expected * A**2 / RADIUS, rel=rel)


@pytest.mark.slow
def test_a_window_that_grows_keeps_the_tractions():
    wide, narrow = (
        worn(fretting(12, slip_model=Coupled(), extent=(size * A, size * A)), [2.0])[0]
        for size in (1.6, 1.02)
    )
    assert narrow.geometry.shape < wide.geometry.shape
    volumes = [state.geometry.integral(state.wear) for state in (wide, narrow)]
    assert volumes[1] == near(volumes[0], rel=0.002)


@pytest.mark.slow
def test_results_obey_coulombs_law_and_loops_have_their_work():
    case = steel(
        **{"slip_model": "coupled", "cycles": 50, "cell": "7.5 um", "error_estimate": False},
        **{"tangential_ratio": None, "displacement_ratio": 1.4},
    )
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


@pytest.mark.slow
def test_mirrored_tractions_along_y_change_sign_from_quarter_to_quarter():
    last = fretwear.simulate(steel(slip_model="coupled", cycles=10, cell="7.5 um")).isel(cycle=-1)
    for name in ("slip_y", "shear_traction_y"):
        field = last[name].transpose("x", "y").values
        assert np.array_equal(field, -field[::-1])
        assert np.array_equal(field, -field[:, ::-1])
        assert field.any()
    for name in ("slip_x", "shear_traction", "slip"):
        field = last[name].transpose("x", "y").values
        assert np.array_equal(field, field[::-1])
    assert "slip_y" not in fretwear.simulate(steel(cycles=10, cell="7.5 um"))


TILTING = DisplacementAmplitude(displacement_amplitude=0.3 * FRICTION * A**2 / RADIUS)
ON_A_RIG = DisplacementAmplitude(
    displacement_amplitude=0.45 * FRICTION * A**2 / RADIUS, rig_stiffness=2e7
)


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
        (0.3, {"roughness": ROUGH, "limit": 3.5}),
        (0.3, {"loading": ON_A_RIG, "roughness": ROUGH}),
    ],
    ids=["smooth", "rough, capped", "rig"],
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
@pytest.mark.parametrize(
    "problem",
    [
        fretting(10, bodies=Elastic(coupling=1.0), roughness=ROUGH, loading=TILTING),
        on_strips(32),
    ],
    ids=["without Poisson's ratio", "a single direction"],
)
def test_it_equals_that_of_a_normal_contact_to_the_bit_where_directions_do_not_differ(problem):
    single, found = (
        worn(replace(problem, slip_model=model), [0.3])[0] for model in (Jaeger(), Cerruti())
    )
    for name in ("pressure", "wear", "gap"):
        np.testing.assert_array_equal(getattr(found, name), getattr(single, name))
    np.testing.assert_array_equal(found.reduced.gap, single.reduced.gap)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "changes"),
    [
        (Coupled(), {"load_ratio": 0.85, "bodies": of_poisson(0.4), "limit": 1.3}),
        (Coupled(), {"roughness": uneven(ROUGH, (False, True)), "limit": 3.0}),
        (Cerruti(), {"roughness": ROUGH, "limit": 3.5}),
        (Cerruti(), {"loading": TILTING}),
    ],
)
def test_the_loop_has_the_energy_of_slip_and_wear_the_energy_of_all_cycles(model, changes):
    problem = fretting(14, slip_model=model, **changes)
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
    return with_images(kernel, *np.divmod(np.arange(count**2), count))


RATIO, LINE_CONTACT = 0.4, line_contact("10 mm", "200 N/mm")
NARROW = [(0.4, 0.6, 0.286), (0.55, 0.45, 0.25), (0.3, 0.5, 0.2)]  # Q/µP, µ, σ/p0


def cylinder(stress, cells=80):
    """A cylinder on strips of both sides; the stress over its peak pressure."""
    fields = {"friction_law": Coulomb(0.6), "bulk_stress": stress * LINE.peak_pressure}
    return on_strips(cells, load_ratio=RATIO, geometry=Row, **fields)


def worn_once(problem):
    """Energy of the first cycle, and the deepest wear in it on either side."""
    state = first_loading(problem)
    rate = state.pressure * problem.slip(state.reduced)
    x, energy = state.geometry.x, problem.dissipated_energy(state, state.geometry)
    return np.array([energy, rate[x < 0.0].max(), rate[x > 0.0].max()]), state


@pytest.mark.parametrize(
    ("stress", "expected"),
    [(0.143, (1.21, 0.54, 1.61)), (0.43, (2.91, 0.04, 3.3))],
)
def test_energy_and_wear_are_those_of_a_direct_solution_in_increments(stress, expected):
    (alone, _), (found, state) = worn_once(cylinder(0.0)), worn_once(cylinder(stress))
    energy, low, high = found / alone
    assert energy == near(expected[0], rel=0.01)
    assert (low, high) == pytest.approx(expected[1:], rel=0.015, abs=0.005)
    # The stick zone is as wide as without it, and moved by e = aσ/(4µp0).
    stuck = state.geometry.x[state.reduced.stick[:, 0]]
    assert stuck.mean() == pytest.approx(-stress / (4.0 * 0.6) * EDGE, abs=EDGE / 80)
    assert np.ptp(stuck) == near(2.0 * EDGE * np.sqrt(1.0 - RATIO), rel=0.02)


@pytest.mark.parametrize(
    ("ratio", "friction", "stress", "expected"),
    [(*each, part) for each, part in zip(NARROW, (0.2201, 0.3299, None), strict=True)],
)
def test_cells_resolve_the_narrow_side_of_slip(ratio, friction, stress, expected):
    """The closed form is the slip of a stick zone moved by e = aσ/(4µp0) (Hills and Nowell)."""
    stick, moved = np.sqrt(1.0 - ratio), stress / (4.0 * friction)

    def deepest(moved):
        x = np.linspace(-1.0, -stick - moved, 4001)
        t = np.maximum(-(x + moved) / stick, 1.0)
        return (np.sqrt(1.0 - x**2) * (t * np.sqrt(t**2 - 1.0) - np.arccosh(t))).max()

    part = deepest(moved) / deepest(0.0)
    assert expected is None or part == near(expected, rel=1e-3)
    case = steel(**LINE_CONTACT, friction=friction, tangential_ratio=ratio, cycles=10)
    problem = wear_problem(case.replace(bulk_stress=stress * case.hertz_pressure))
    (_, low, _), _ = worn_once(problem)
    (_, usual, _), _ = worn_once(replace(problem, bulk_stress=0.0))
    assert low / usual == near(part, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "friction", "stress"), NARROW)
def test_cells_resolve_the_narrow_side_while_it_wears(ratio, friction, stress):
    """At every cycle to 1 % of quarter cells, and the wide side to a fifth of that."""
    case = steel(
        **LINE_CONTACT,
        friction=friction,
        tangential_ratio=ratio,
        output_cycles=[10, 100],
        error_estimate=False,
    )
    case = case.replace(bulk_stress=stress * case.hertz_pressure)
    depths = []
    for each in (case, case.replace(cell=case.grid_spacing[0] / 4.0)):
        wear = run(each).dataset.wear_depth.sel(cycle=[10, 100, 1000])
        depths.append([wear.where(side).max("x") for side in (wear.x < 0.0, wear.x > 0.0)])
    narrow, wide = np.array(depths[0]) / np.array(depths[1]) - 1.0
    assert np.abs(narrow).max() < 0.01
    assert np.abs(wide).max() < 0.002
    assert (np.array(depths[1][0]) < 0.4 * np.array(depths[1][1])).all()


def test_the_scar_of_a_cylinder_is_deeper_on_one_side():
    problem = cylinder(0.286, cells=40)
    *_, state = evolve(problem, [2.0 / (problem.wear_growth * LINE.peak_pressure)])
    x, wear = state.geometry.x, state.wear[:, 0]
    assert wear[x > 0.0].max() > 2.0 * wear[x < 0.0].max()


def test_friction_as_a_vector_gives_the_same_for_a_sphere():
    (found, state), (exact, vector) = (
        worn_once(fretting(12, slip_model=model, load_ratio=0.6, bulk_stress=0.1 * P0))
        for model in (Cerruti(), Coupled())
    )
    np.testing.assert_allclose(found, exact, rtol=0.02)
    assert state.reduced.stick.sum() == near(vector.reduced.stick.sum(), rel=0.03)
    x = state.geometry.x[:, None] * state.reduced.stick
    assert x.sum() / state.reduced.stick.sum() < -0.02 * A


@pytest.mark.parametrize("even", [True, False])
def test_where_a_sphere_sticks_friction_strains_it_like_the_flat(even):
    stress, waves = 0.1 * P0, uneven(None, (False, even))
    problem = fretting(
        16,
        slip_model=Coupled(),
        load_ratio=0.3,
        bulk_stress=stress,
        bodies=ElasticBodies(208e9, 0.3),
        roughness=waves,
    )
    state = first_loading(problem)
    bodies = bodies_under_shear(state.geometry.half_space(MODULUS), problem.bodies.coupling)
    moved = bodies.displacement(state.reduced.sheared.traction)
    x, y = np.meshgrid(state.geometry.x, state.geometry.y, indexing="ij")
    inside = np.hypot(x, y) < 0.6 * A
    assert state.reduced.stick[inside].all()
    along, across = np.polyfit(x[inside], moved[0][inside], 1), moved[1][inside] / y[inside]
    assert along[0] == near(stress / 208e9, rel=1e-3)
    np.testing.assert_allclose(across, -0.3 * stress / 208e9, rtol=0.01)


def test_a_stress_that_reverses_slip_is_refused():
    with pytest.raises(ContactError, match="beyond the contact"):
        first_loading(cylinder(0.6))
    ratios = {"friction": 0.6, "tangential_ratio": RATIO}
    case = steel(**line_contact("6 mm", "400 N/mm"), **ratios, cycles=10)
    case.replace(bulk_stress=0.5 * case.hertz_pressure)
    with pytest.raises(CaseError, match="beyond the contact, where slip reverses"):
        case.replace(bulk_stress=0.6 * case.hertz_pressure)
