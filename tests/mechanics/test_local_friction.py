"""Friction that changes where the surfaces slip, and wear above a threshold of energy."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.slip.models import CattaneoMindlin, Cerruti, Coupled
from fretwear.mechanics.surfaces.laws import Archard, EnergyWear
from fretwear.mechanics.surfaces.loading import DisplacementAmplitude, TangentialRatio
from fretwear.mechanics.surfaces.materials import Coulomb, ElasticBodies, OverEnergy
from fretwear.mechanics.wear.integrator import evolve
from fretwear.mechanics.wear.loops import loop
from fretwear.mechanics.wear.measures import Measures
from fretwear.mechanics.wear.state import Workspace
from fretwear.run.simulate import simulate
from fretwear.study.case import Case, CaseError
from fretwear_cracks.inputs import loaded_case, surface_of

from ..studies import STEEL as STEEL_SPHERE
from ..studies import line_contact, near
from .oracles import explicit_wear, normal_contact
from .problems import (
    COUPLING,
    EDGE,
    FRICTION,
    HERTZ,
    LOAD,
    MODULUS,
    WEAR,
    A,
    fretting,
    on_strips,
    window,
)

pytestmark = pytest.mark.slow

RISING = OverEnergy(start=0.3, end=0.6, energy=1000.0)
FALLING = OverEnergy(start=0.6, end=0.3, energy=1000.0)
THRESHOLD = 30.0  # J/m², of 185 at most in the first cycle of the study's contact


def friction(problem, state):
    """Coefficient of friction of each place."""
    law = problem.of(state).friction_law
    return law.coefficient * law.ratio


def energy(problem, state):
    """Energy dissipated per area in a cycle, J/m²."""
    return 4.0 * friction(problem, state) * state.pressure * problem.slip(state.reduced)


@pytest.mark.parametrize(
    "changes",
    [
        {"geometry": Rings},
        {"slip_model": Cerruti(), "bodies": ElasticBodies(208e9, 0.3)},
        {"slip_model": CattaneoMindlin()},
        {"wear_law": EnergyWear(WEAR / FRICTION)},
        {"debris_fraction": 1.0},
        {"debris_fraction": 0.5, "limit": 1.0},
        {"friction_law": Coulomb(RISING), "geometry": Rings},
    ],
    ids=["rings", "cerruti", "cattaneo_mindlin", "energy", "debris", "yielding", "friction"],
)
def test_what_a_place_dissipates_beyond_the_threshold_wears(changes):
    problem = fretting(12, wear_threshold=THRESHOLD, **changes)
    steps = evolve(problem, [300, 310])
    first, last = [each for each in steps if each.cycle in (300, 310)]
    rates = [energy(problem, each) for each in (first, last)]
    # EnergyWear has the same K/µ.
    rate = sum(
        WEAR / friction(problem, each) * np.maximum(of_cycle - THRESHOLD, 0.0)
        for each, of_cycle in zip((first, last), rates, strict=True)
    )
    worn, integral = (last.wear - first.wear) / 10.0, first.geometry.integral
    assert integral(worn) == near(0.5 * integral(rate), rel=1e-3)
    assert integral(worn) < 0.95 * integral(WEAR / friction(problem, last) * rates[1])
    assert worn.any()
    largest = np.maximum(*rates)
    never = largest < 0.9 * THRESHOLD
    assert (largest[never] > 0.0).any()
    assert (worn[never] == 0.0).all()


@pytest.mark.parametrize("limit", [np.inf, 1.0])
def test_wear_above_a_threshold_is_that_of_short_explicit_steps(limit):
    problem, cycles = fretting(12, wear_threshold=THRESHOLD, limit=limit), 600.0
    *_, state = evolve(problem, [cycles])
    cells = window((16, 16), 16 / 12 * A)
    direct = explicit_wear(problem, cells, cycles, 60)
    worn = state.geometry.integral(state.wear)
    assert worn == near(cells.integral(direct.wear), rel=0.01)
    assert state.wear.max() == near(direct.wear.max(), rel=0.01)
    without = explicit_wear(replace(problem, wear_threshold=0.0), cells, cycles, 60)
    assert worn < 0.8 * cells.integral(without.wear)


@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        (fretting, {"slip_model": Coupled(), "bodies": ElasticBodies(208e9, 0.3)}),
        (fretting, {"friction_law": Coulomb(RISING), "geometry": Rings}),
        (on_strips, {"friction_law": Coulomb(RISING)}),
    ],
    ids=["coupled", "friction", "strips"],
)
def test_below_the_threshold_nothing_wears(kind, changes):
    problem = kind(12, wear_threshold=2000.0, **changes)
    *_, state = evolve(problem, [30])
    assert 0.0 < energy(problem, state).max() < 2000.0
    assert not state.wear.any()


# Friction that follows slip.


def following(law, load_ratio=0.8, **changes):
    """The study's contact on rings under Q over the first friction, with friction of a law."""
    fields = {"geometry": Rings, "load_ratio": load_ratio, **changes}
    return fretting(32, friction_law=Coulomb(law), **fields)


def of_discs(radii, edges):
    """Displacement at some radii, m/Pa, by rings of uniform pressure between edges, m.

    A disc moves its surface by 4b/(πE*) E(r/b), r ≤ b, and beyond by 4r/(πE*) times
    E(b/r) − (1 − b²/r²) K(b/r) (Johnson 1985, section 3.4).
    """
    r, b = radii[:, None], edges[None, 1:]
    inner, outer = np.minimum(r / b, 1.0) ** 2, np.minimum(b / r, 1.0) ** 2
    outside = r * (ellipe(outer) - (1.0 - outer) * ellipk(np.minimum(outer, 1.0 - 1e-15)))
    discs = np.where(r <= b, b * ellipe(inner), outside) * 4.0 / (np.pi * MODULUS)
    return np.diff(discs, axis=1, prepend=0.0)


def of_strips(places, edges, modulus):
    """Displacement at some places, m/Pa, by pairs of strips of uniform pressure (plane strain)."""

    def primitive(t):
        return t * np.log(np.abs(t) / EDGE) - t

    x, sides = places[:, None], (edges[None, :], -edges[None, ::-1])
    right, left = (np.diff(-primitive(x - side), axis=1) for side in sides)
    return -2.0 / (np.pi * modulus) * (right + left[:, ::-1])


def every_cycle(problem, law, influence, edges, areas, cycles):
    """Stick radius, m, volume, m³, and energy of a cycle, J, by a contact, its friction and wear.

    Each cycle solves the tangential contact in the spare friction of the cells that touch, then
    wears the surface and changes the friction of each cell.
    """
    places = 0.5 * (edges[1:] + edges[:-1])
    load, force = problem.hertz.load, problem.loading.load_ratio() * law.start * problem.hertz.load
    gap = problem.indenter.gap(places, 0.0)
    worn, dissipated = np.zeros_like(places), np.zeros_like(places)
    for _ in range(cycles + 1):
        pressure, *_ = normal_contact(influence, gap + worn, areas, load)
        friction = law.slipped(dissipated)
        touching = np.flatnonzero(pressure)
        along = problem.coupling * influence[np.ix_(touching, touching)]
        bound, area = (friction * pressure)[touching], areas[touching]
        spare, slip, _ = normal_contact(along, -along @ bound, area, area @ bound - force)
        assert (spare <= bound).all()
        energy = 4.0 * bound * slip
        volume = areas @ worn
        dissipated[touching] += energy
        worn[touching] += WEAR * 4.0 * pressure[touching] * slip
    last = np.flatnonzero(spare)[-1]
    falls = (spare[last - 1] ** 2 - spare[last] ** 2) / (places[last] - places[last - 1])
    return places[last] + spare[last] ** 2 / falls, volume, area @ energy


@pytest.mark.parametrize(
    ("kind", "load_ratio", "law"),
    [("rings", 0.5, RISING), ("rings", 0.8, FALLING), ("strips", 0.8, RISING)],
)
def test_friction_that_follows_slip_is_that_of_every_cycle(kind, load_ratio, law):
    load_ratio *= min(1.0, law.end / law.start)
    if kind == "rings":
        problem, edges = following(law, load_ratio), np.linspace(0.0, 1.25 * A, 161)
        influence = of_discs(0.5 * (edges[1:] + edges[:-1]), edges)
        areas = np.pi * np.diff(edges**2)
    else:
        problem, edges = (
            on_strips(load_ratio=load_ratio, friction_law=Coulomb(law)),
            np.linspace(0.0, 1.25 * EDGE, 161),
        )
        modulus = problem.composite_modulus
        influence = of_strips(0.5 * (edges[1:] + edges[:-1]), edges, modulus)
        areas = 2.0 * np.diff(edges)
    *_, state = evolve(problem, [300])
    found = Measures(problem.of(state), state)
    stick, volume, energy = every_cycle(problem, law, influence, edges, areas, 300)
    assert found.stick_half_width_x == near(stick, rel=0.01)
    assert found.wear_volume == near(volume, rel=0.01)
    assert found.dissipated_energy == near(energy, rel=0.01)


@pytest.mark.parametrize("load_ratio", [0.7, 0.15])
@pytest.mark.parametrize("wear_law", [Archard(WEAR), EnergyWear(WEAR)], ids=["archard", "energy"])
def test_a_step_errs_little_where_friction_follows_slip(load_ratio, wear_law):
    """Between the same few snapshots, at the tolerance of an accuracy of 2 %, and a hundredth."""
    start, end = (0.25, 0.85) if load_ratio > 0.5 else (0.85, 0.25)
    law = Coulomb(OverEnergy(start=start, end=end, energy=300.0))
    problem = on_strips(load_ratio=load_ratio, friction_law=law, wear_law=wear_law, coarseness=4.0)
    stops = [10.0, 100.0, 1000.0]

    def numbers(tolerance):
        states = [s for s in evolve(problem, stops, tolerance) if s.cycle in stops]
        found = [Measures(problem.of(state), state) for state in states]
        return np.array([(one.dissipated_energy, one.wear_volume) for one in found])

    np.testing.assert_allclose(numbers(0.03), numbers(3e-4), rtol=0.004)


# U at which the unworn contact with the last friction slides as a whole, m.
TRANSITION = 0.6 * COUPLING * HERTZ.approach
SLIPS_AT_ONCE = OverEnergy(start=0.3, end=0.6, energy=0.1)
STEEL = ElasticBodies(208e9, 0.3)


def scalars(problem, cycles=1000, **options):
    """The measures at the end of a run, with the problem and the state there."""
    *_, state = evolve(problem, [cycles], **options)
    now = problem.of(state)
    return Measures(now, state), now, state


def test_friction_of_one_value_is_a_number():
    assert Coulomb(OverEnergy(start=0.5, end=0.5, energy=1.0)) == Coulomb(0.5)


def test_friction_that_takes_forever_to_change_is_constant():
    slow, *_ = scalars(following(replace(RISING, energy=1e12)), 300)
    constant, *_ = scalars(replace(following(RISING), friction_law=Coulomb(RISING.start)), 300)
    for name, value in constant.scalars({}, of_steps=True).items():
        assert getattr(slow, name) == near(value, rel=2e-3), name


def test_stick_zone_of_friction_that_changes_at_once_balances_the_force():
    # µ = end in the annulus; inside, q = µ_end (p − p_c) moves all points alike, p_c the Hertz
    # pressure of the radius c.
    problem = following(SLIPS_AT_ONCE, wear_coefficient=1e-20)
    found, now, state = scalars(problem)
    force, end = 0.8 * SLIPS_AT_ONCE.start * LOAD, SLIPS_AT_ONCE.end

    def excess(c):
        def traction(r):
            inner = HERTZ.peak_pressure / A * np.sqrt(max(c**2 - r**2, 0.0))
            return 2.0 * np.pi * r * end * (HERTZ.pressure(r) - inner)

        return quad(traction, 0.0, A, points=[c], epsabs=0.0)[0] - force

    assert found.stick_radius == near(brentq(excess, 0.1 * A, 0.999 * A), rel=1e-3)
    assert found.tangential_force == near(force, rel=1e-9)
    assert Measures(now, state).mean_slip_friction == near(end, rel=1e-3)
    # What never slipped keeps its friction.
    assert now.friction_law.ratio[0, 0] == 1.0


ONCE = {
    "force": {},
    "cerruti": {"slip_model": Cerruti(), "bodies": STEEL, "geometry": Grid},
    "displacement": {"loading": DisplacementAmplitude(displacement_amplitude=0.8 * TRANSITION)},
    "gross": {"loading": DisplacementAmplitude(displacement_amplitude=1.5 * TRANSITION)},
    "rig": {"loading": DisplacementAmplitude(displacement_amplitude=TRANSITION, rig_stiffness=3e7)},
}


@pytest.mark.parametrize("changes", ONCE.values(), ids=ONCE)
def test_contact_whose_friction_changed_at_once_is_that_of_the_last_friction(changes):
    # Traction where it sticks follows from the traction beside alone.
    problem = following(SLIPS_AT_ONCE, wear_coefficient=1e-20, **changes)
    law = Coulomb(SLIPS_AT_ONCE.end)
    loading = problem.loading
    if loading.is_force:
        loading = TangentialRatio(0.8 * SLIPS_AT_ONCE.start / SLIPS_AT_ONCE.end)
    constant = replace(problem, friction_law=law, loading=loading)
    found, _, state = scalars(problem)
    expected, _, alike = scalars(constant, 1)
    names = "tangential_force", "tangential_displacement", "stick_area", "dissipated_energy"
    for name in names:
        assert getattr(found, name) == near(getattr(expected, name), rel=3e-3), name
    curve, same = (
        loop(Workspace(each), end) for each, end in ((problem, state), (constant, alike))
    )
    assert curve.opening == near(same.opening, rel=5e-3)
    area = -np.trapezoid(curve.displacement, curve.force)
    assert area == near(found.dissipated_energy, rel=5e-3)


@pytest.mark.parametrize("law", [Archard(WEAR), EnergyWear(2.0 * WEAR)], ids=["archard", "energy"])
def test_wear_of_a_place_follows_from_the_energy_that_it_has_dissipated(law):
    _, _, state = scalars(following(RISING, wear_law=law), 600, tolerance=0.003)
    energy, start, end, scale = state.friction_energy, 0.3, 0.6, RISING.energy
    worn = 2.0 * WEAR * energy
    if law.kind == "archard":
        # ∫ de / µ(e)
        part = (end * np.exp(energy / scale) - (end - start)) / start
        worn = WEAR * scale / end * np.log(part)
    integral = state.geometry.integral
    assert integral(state.wear) == near(integral(worn), rel=3e-3)
    # Beyond, cells touch for the first time within a step.
    within = state.geometry.x < A
    np.testing.assert_allclose(state.wear[within], worn[within], atol=0.01 * worn.max())


BLOCKS = [{"cycles": 9, "friction": 0.5}, {"cycles": 9}]
LAW = {"start": 0.2, "end": 0.8, "energy": "0.05 mJ/mm^2"}


@pytest.fixture(scope="module")
def rubbed():
    """The dataset of a cylinder whose friction follows slip."""
    return simulate(line_case(tangential_load="2.96 N/mm", error_estimate=False))


def line_case(**changes):
    """A steel cylinder whose friction follows slip."""
    usual = {"tangential_ratio": None, "friction": LAW, "cycles": 30}
    return Case(**STEEL_SPHERE | line_contact("6 mm", "18.5 N/mm") | usual | changes)


@pytest.mark.parametrize(
    ("law", "cycles"),
    [
        ({"wear_coefficient": "7e-13 / Pa"}, 100),
        ({"energy_wear_coefficient": "2e-6 mm^3/J", "wear_coefficient": None}, 300),
    ],
    ids=["archard", "energy"],
)
def test_errors_of_lines_hold_against_half_cells_and_a_tenth_of_the_tolerance(law, cycles):
    """Run and twin take the same steps, and the edge of stick moves to cells between theirs."""
    case = line_case(
        **line_contact("10 mm", "342 N/mm"),
        tangential_load="72.86 N/mm",
        friction={"start": 0.303, "end": 0.614, "energy": "12.7 mJ/mm^2"},
        cycles=cycles,
        output_cycles=[0, *{30, 100, cycles}],
        accuracy="none",
        **law,
    )
    found, (spacing, _) = simulate(case), case.grid_spacing
    fine = case.replace(cell=spacing / 2.0, tolerance=case.tolerance / 10.0, error_estimate=False)
    truth = simulate(fine)
    for name in ("dissipated_energy", "wear_volume", "mean_slip_friction"):
        off, error = abs(found[name] - truth[name]), found[f"{name}_error"]
        assert (off <= error).all(), name


def test_traction_of_a_dataset_obeys_the_friction_of_each_cell(rubbed):
    now = rubbed.sel(cycle=30)
    bound = now["friction_coefficient"] * now["pressure"]
    assert (now["shear_traction"] <= bound * (1.0 + 1e-6)).all()
    slips = (now["stick_fraction"] == 0.0) & (now["pressure"] > 0.0)
    np.testing.assert_allclose(now["shear_traction"].values[slips], bound.values[slips], rtol=1e-5)
    np.testing.assert_allclose(rubbed["tangential_force"], 2960.0)
    mean = float((bound * slips).sum() / (now["pressure"] * slips).sum())
    assert float(now["mean_slip_friction"]) == near(mean, rel=0.02)
    assert 0.22 < mean < 0.78


def test_stresses_reverse_with_the_friction_of_each_cell(rubbed):
    surface, _ = surface_of(rubbed.sel(cycle=30), loaded_case(rubbed), 30)
    full = surface.ratio * surface.pressure
    reversed_to = surface.reduced(1.0, full).pressure
    opposite = surface.shear - 2.0 * surface.friction * (full - reversed_to)
    np.testing.assert_allclose(opposite, -surface.shear, atol=0.02 * surface.shear.max())


def test_friction_under_a_load_ratio_is_that_under_its_force():
    ratio = line_case(tangential_ratio=0.8)
    force = line_case(tangential_load="2.96 N/mm")
    assert ratio.case_id == force.case_id
    assert Case(**ratio.canonical_parameters()).case_id == ratio.case_id


@pytest.mark.parametrize(
    "changes",
    [
        {"sliding_amplitude": "20 um"},
        {"tangential_ratio": 0.8, "slip_model": "cattaneo_mindlin"},
        {"tangential_ratio": 0.8, "junction_growth": 9},
        {"tangential_ratio": 0.5, "friction": LAW | {"end": 0.1}},
        {"cycles": None, "blocks": BLOCKS, "tangential_ratio": 0.5},
    ],
)
def test_what_cannot_follow_the_energy_is_refused(changes):
    with pytest.raises(CaseError, match=r"friction"):
        line_case(**changes)
