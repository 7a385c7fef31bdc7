"""Wear through a coating: coefficients above and below its interface, the first cycle, the area."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.slip.models import WearLayer
from fretwear.mechanics.surfaces.coating import Coating, Interface
from fretwear.mechanics.surfaces.laws import Archard
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.values import OfBodies
from fretwear.mechanics.wear.integrator import evolve
from fretwear.mechanics.wear.measures import Measures, deeper_fraction

from ..studies import near
from .problems import (
    CONVERGED,
    EDGE,
    FRICTION,
    PER_LENGTH,
    WEAR,
    ElasticBodies,
    fretting,
    on_strips,
)

STOP = 2500.0
STEEL = ElasticBodies(208e9, 0.3)
KINDS = {
    "strips": (on_strips, {}),
    "grid": (fretting, {"cells": 8, "bodies": STEEL}),
    # Slip is alike in all directions, as rings need it.
    "rings": (fretting, {"cells": 32, "bodies": ElasticBodies(208e9, 0.0), "geometry": Rings}),
}
SLOW = [pytest.param(kind, marks=pytest.mark.slow) for kind in ("strips", "rings")]


def contact(kind, thickness=None, coefficient=None, *, stiffer=1.0, **changes):
    """A contact whose flat may have a coating, by default as stiff as the substrate."""
    make, usual = KINDS[kind]
    problem = make(**{**usual, **changes})
    if thickness is None:
        return problem
    bodies = problem.bodies
    elastic = stiffer * bodies.youngs_modulus, bodies.poisson_ratio
    return replace(problem, coating=Coating(thickness, *elastic, coefficient))


@cache
def run(kind, thickness=None, coefficient=None, tolerance=0.01, accuracy=None, **changes):
    """The problem and its states up to the last cycle."""
    problem = contact(kind, thickness, coefficient, **changes)
    return problem, [*evolve(problem, [STOP], tolerance, accuracy=accuracy)]


def deepest(kind):
    return float(run(kind)[1][-1].wear.max())


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("times", [0.1, 3.0])
def test_wear_of_both_materials_adds_up_to_the_energy(kind, times):
    thickness = 0.3 * min(times, 1.0) * deepest(kind)
    problem, states = run(kind, thickness, times * WEAR, tolerance=2e-4)
    last, depth = states[-1], problem.interface.depth
    integral = last.geometry.integral
    above = integral(np.minimum(last.wear, depth)) / (times * WEAR)
    below = integral(np.maximum(last.wear - depth, 0.0)) / WEAR
    rates = [problem.dissipated_energy(state, state.geometry) for state in states]
    energy = np.trapezoid(rates, [state.cycle for state in states])
    assert below > 0.1 * above
    # By the trapezoidal rule over the steps.
    assert above + below == near(energy / FRICTION, rel=1e-3)


def run_as_uncoated(kind, thickness, coefficient, part):
    """Run a coating which must take the steps and have the wear, to a part, of the bare flat."""
    _, uncoated = run(kind, accuracy=CONVERGED)
    problem, coated = run(kind, thickness, coefficient, accuracy=CONVERGED)
    assert len(coated) == len(uncoated)
    scale = uncoated[-1].wear.max()
    np.testing.assert_allclose(coated[-1].wear, uncoated[-1].wear, atol=part * scale)
    return problem, coated[-1]


@pytest.mark.parametrize("kind", ["grid", *SLOW])
def test_equal_materials_are_the_uncoated_contact(kind):
    problem, last = run_as_uncoated(kind, 0.3 * deepest(kind), WEAR, 1e-9)
    assert last.worn_through < STOP
    assert Measures(problem, last).coating_left == 0.0


@pytest.mark.parametrize("kind", ["grid", *SLOW])
def test_a_substrate_that_does_not_wear_stops_the_scar_at_the_thickness(kind):
    thickness = 0.3 * deepest(kind)
    problem, states = run(kind, thickness, WEAR, wear_coefficient=0.0, stiffer=1.5)
    last = states[-1]
    assert float(last.wear.max()) == near(thickness, rel=1e-9)
    assert Measures(problem, last).exposed_area > 0.0


@pytest.mark.parametrize("kind", ["grid", *SLOW])
@pytest.mark.parametrize("times", [0.1, 10.0])
def test_a_vanishing_coating_is_the_substrate(kind, times):
    run_as_uncoated(kind, 1e-16, times * WEAR, 1e-6)


def capped(kind, coating, substrate, thickness=None, coefficient=WEAR, **changes):
    """The problem with plastic limits over the peak pressure of elastic bodies, and its states."""
    problem = contact(kind, thickness, coefficient)
    limits = [limit * problem.hertz.peak_pressure for limit in (coating, substrate)]
    if thickness is not None:
        problem = replace(problem, coating=replace(problem.coating, plastic_limit=limits[0]))
    problem = replace(problem, plastic_limit=limits[1])
    return problem, [*evolve(problem, [STOP], **changes)]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_the_limit_of_a_substrate_that_is_never_bare_does_not_matter(kind):
    ends = [capped(kind, 0.9, substrate, 1.0)[1][-1] for substrate in (0.9, np.inf)]
    assert ends[0].plastic.max() > 0.01 * ends[0].wear.max()
    for name in ("wear", "plastic"):
        found, expected = (getattr(end, name) for end in ends)
        np.testing.assert_allclose(found, expected, atol=1e-9 * expected.max())


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["strips", "rings"])
@pytest.mark.parametrize(("coating", "substrate"), [(0.9, 0.7), (1.0, 2.0), (1.3, 0.7)])
def test_each_material_keeps_its_plastic_limit(kind, coating, substrate):
    volumes = []
    for tolerance in (0.01, 0.001):
        problem, states = capped(
            kind, coating, substrate, 0.3 * deepest(kind), 0.5 * WEAR, tolerance=tolerance
        )
        last, peak = states[-1], problem.hertz.peak_pressure
        # Cells that the last step wears through bear what either material does.
        through = problem.interface.reached(last.wear)
        bare = problem.interface.reached(states[-2].wear)
        assert 0 < bare.sum() < through.size
        assert last.pressure[bare].max() <= (1.0 + 1e-9) * substrate * peak
        assert last.pressure[~through].max() <= (1.0 + 1e-9) * coating * peak
        volumes.append(last.geometry.integral(last.wear))
    assert volumes[0] == near(volumes[1], rel=0.01)
    if coating > substrate:
        assert last.pressure[~through].max() > 1.2 * last.pressure[bare].max()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["strips", "rings"])
@pytest.mark.parametrize(("times", "part"), [(0.1, 0.4), (0.3, 0.3), (1.0, 0.4), (10.0, 0.1)])
def test_the_cycle_of_wear_through_is_that_of_much_shorter_steps(kind, times, part):
    thickness = part * min(times, 1.0) * deepest(kind)
    usual, fine = (
        run(kind, thickness, times * WEAR, tolerance=tolerance, cells=cells, stiffer=1.5)[1]
        for tolerance, cells in ((0.01, 32), (0.001, 64))
    )
    found = usual[-1].worn_through
    assert 0.0 < found < STOP
    assert found == near(fine[-1].worn_through, rel=0.01)
    # NaN before, and the same ever after.
    for state in usual:
        assert np.isnan(state.worn_through) == (state.cycle < found)


@pytest.mark.slow
def test_a_thicker_coating_or_one_that_wears_less_or_bears_less_lasts_longer():
    depth = 0.2 * deepest("strips")
    lives = [
        run("strips", thickness, coefficient, load_ratio=ratio, normal=NormalLoad(load))[1][
            -1
        ].worn_through
        for thickness, coefficient, ratio, load in (
            (depth, WEAR, 0.9, 1.2 * PER_LENGTH),
            (depth, WEAR, 0.9, PER_LENGTH),
            (depth, WEAR, 0.8, PER_LENGTH),
            (depth, 0.7 * WEAR, 0.8, PER_LENGTH),
            (1.5 * depth, 0.7 * WEAR, 0.8, PER_LENGTH),
        )
    ]
    assert lives == sorted(lives)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("times", [0.1, 0.5, 3.0])
def test_wearing_through_takes_hardly_more_steps(kind, times):
    """Than an uncoated flat that wears like the faster of both materials."""
    _, uncoated = run(kind, wear_coefficient=max(times, 1.0) * WEAR)
    _, coated = run(kind, 0.3 * min(times, 1.0) * deepest(kind), times * WEAR)
    assert not np.isnan(coated[-1].worn_through)
    assert len(coated) <= 1.1 * len(uncoated)


@pytest.mark.slow
def test_only_the_wear_of_the_flat_counts_where_each_body_wears():
    pair = OfBodies((0.5 * WEAR, 0.5 * WEAR))
    depth = 0.3 * deepest("strips")
    problem = contact("strips", 0.5 * depth, 0.5 * WEAR, wear_law=Archard(pair))
    assert problem.interface.depth == near(depth)
    *_, last = evolve(problem, [STOP])
    assert last.worn_through == near(run("strips", depth, WEAR)[1][-1].worn_through, rel=1e-6)
    fast = contact("strips", 0.5 * depth, 2.0 * WEAR, wear_law=Archard(pair))
    *_, last = evolve(fast, [STOP])
    both = last.wear_of_each(fast)
    above = np.minimum(last.wear, fast.interface.depth)
    np.testing.assert_allclose(both["flat"], 0.8 * above + 0.5 * (last.wear - above))
    np.testing.assert_allclose(both["flat"] + both["indenter"], last.wear)


def test_the_exposed_area_ends_within_a_cell():
    x = (np.arange(40) + 0.5) * EDGE / 40
    for edge in (0.313, 0.5, 0.72):
        depth = (1.0 - (x / EDGE) ** 2)[:, None]
        fractions = deeper_fraction(depth, 1.0 - edge**2)
        assert fractions.mean() == near(edge, rel=2e-3)
    stopped = np.minimum(depth, 0.5)
    assert deeper_fraction(stopped, 0.5)[:20].min() == 1.0


def test_a_cell_crosses_the_interface_at_its_depth():
    """In the last two cells slip ends, in the last one within an exponent that never passes."""
    gap, shift = np.array([[1e-6, 0.0], [1e-6, 2e-6], [1e-6, -5e-7], [1.77e-11, -6.4e-10]]).T
    interface, zeros = Interface(2e-7, 3.0, (0.0, 1.0)), np.zeros(4)
    layer = WearLayer(zeros, gap, shift, zeros, 1.0, interface=interface)
    found = layer.crossing
    assert layer.displacement(found)[:3] == near(np.full(3, 2e-7), rel=1e-9)
    assert found[3] > 36.0
