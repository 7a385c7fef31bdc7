"""Peers are driven rightly: what they are timed for is the contact that was asked."""

import numpy as np
import pytest
from benchmarks.peers import cold
from benchmarks.peers.solvers import PEERS, Pressed, residual, unfolded
from benchmarks.peers.wear_loop import CYCLES, estimated_step, own_loop, whole_run
from benchmarks.speed.cases import smooth_case

from fretwear.mechanics.contact import solve_contact
from fretwear.mechanics.geometry import Workspace
from fretwear.mechanics.integrator import evolve
from fretwear.running import simulate


@pytest.mark.parametrize("kind", PEERS, ids=[kind.name for kind in PEERS])
def test_a_peer_solves_from_nothing_and_from_a_start(kind):
    pytest.importorskip(kind.name, reason=f"{kind.name} is not installed (extra: bench)")
    problem = cold.sphere(64)
    bodies = problem.half_space
    modulus = simulate.wear_problem(smooth_case(16)).composite_modulus
    peer = kind(bodies.geometry, modulus, 1e-8)
    first = peer.solve(problem.shape, problem.load)
    warm = peer.solve(problem.shape, problem.load, first.pressure)
    for found in (first, warm):
        assert residual(problem, found.pressure) < 1e-6
        # tamaas leaves the displacement shifted by the approach: gaps are what can be compared.
        own = Pressed(found.pressure, bodies.displacement(found.pressure))
        np.testing.assert_allclose(
            found.gap(problem.shape), own.gap(problem.shape), atol=1e-6 * problem.shape.max()
        )


def test_the_residual_is_that_of_the_solver():
    problem = cold.sphere(32)
    contact = solve_contact(problem, tolerance=1e-4)
    assert residual(problem, contact.pressure) == pytest.approx(contact.residual, rel=0.5)
    assert residual(problem, 0.99 * contact.pressure) > 0.005


def test_the_quarter_unfolds_to_the_whole_contact():
    quarter = solve_contact(cold.sphere(32, quarter=True), tolerance=1e-9).pressure
    whole = solve_contact(cold.sphere(32), tolerance=1e-9).pressure
    np.testing.assert_allclose(unfolded(quarter), whole, atol=1e-6 * whole.max())


def test_the_explicit_loop_wears_as_the_run_does():
    problem = simulate.wear_problem(smooth_case(12))
    start, *_, end = evolve(problem, [600.0])
    loop = own_loop(problem, start.on(Workspace(problem), end.geometry))
    step = 0.25 * estimated_step(problem, start)
    count = round(600.0 / step)
    for _ in range(count):
        loop.step(600.0 / count)
    # Euler's steps are of first order, the run promises one per cent.
    assert loop.wear.sum() == pytest.approx(end.wear.sum(), rel=0.03)


def test_a_loop_of_equal_steps_is_summed_exactly():
    steps, seconds = whole_run([6.0] * len(CYCLES), [0.5] * len(CYCLES))
    assert steps == pytest.approx(30000 / 6)
    assert seconds == pytest.approx(0.5 * 30000 / 6)
