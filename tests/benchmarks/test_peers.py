"""Other libraries find the same contact, each with its own kernel and its own solver.

They are optional: install the extra ``bench``. Where one is missing, its tests are skipped.
"""

import numpy as np
import pytest
from benchmarks.peers import contacts
from benchmarks.peers.contacts import PEERS, pressed_by, residual

from fretwear.mechanics.contact.cells import ContactProblem
from fretwear.mechanics.contact.problem import solve_contact

from ..mechanics.problems import MODULUS, SMOOTH, A, Waves, pressed, window

# Waves of seven and twelve cells: asperities touch one by one.
ROUGH = Waves(0.2e-6, 2 * np.pi / (0.17 * A), 2 * np.pi / (0.43 * A))
CELLS = (96, 64)


@pytest.fixture(params=PEERS, ids=[kind.name for kind in PEERS])
def kind(request):
    pytest.importorskip(request.param.name, reason="not installed (extra: bench)")
    return request.param


def assert_same(problem, theirs):
    # Both solvers stop at 1e-8 of the gap or below, so what is left is ten times that at most.
    ours = solve_contact(problem, tolerance=1e-9).pressure
    assert np.abs(theirs - ours).sum() <= 1e-6 * ours.sum()
    differ = (theirs > 0) != (ours > 0)
    assert differ.sum() <= 1e-3 * (ours > 0).sum()


@pytest.mark.peers
@pytest.mark.parametrize("surface", ["smooth", "rough", "without symmetry"])
def test_a_peer_finds_the_same_elastic_contact(kind, surface):
    problem = pressed(
        window(CELLS, even=(False, False)), roughness=ROUGH if surface == "rough" else SMOOTH
    )
    if surface == "without symmetry":
        noise = 0.1e-6 * np.random.default_rng(11).standard_normal(CELLS)
        problem = ContactProblem(problem.half_space, problem.shape + noise, problem.load)
    assert_same(problem, pressed_by(kind, problem, MODULUS))


def test_the_residual_is_that_of_the_solver_and_a_quarter_unfolds_to_the_whole():
    problem = contacts.sphere(32)
    contact = solve_contact(problem, tolerance=1e-4)
    assert residual(problem, contact.pressure) == pytest.approx(contact.residual, rel=0.5)
    assert residual(problem, 0.99 * contact.pressure) > 0.005
    quarter = solve_contact(contacts.sphere(32, quarter=True), tolerance=1e-9).pressure
    whole = solve_contact(problem, tolerance=1e-9).pressure
    np.testing.assert_allclose(contacts.unfolded(quarter), whole, atol=1e-6 * whole.max())
