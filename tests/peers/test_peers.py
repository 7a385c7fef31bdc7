"""Other libraries find the same contact, each with its own kernel and its own solver.

Both are optional: install the extra ``bench``. Where one is missing, its tests are skipped.
"""

from collections.abc import Callable

import numpy as np
import pytest

from fretwear.mechanics.contact import ContactProblem, solve_contact
from fretwear.mechanics.geometry import Array

from ..mechanics.problems import MODULUS, SMOOTH, A, Waves, pressed, window
from .drivers import contact_mechanics_pressure, tamaas_pressure

pytestmark = pytest.mark.peers

# Waves of seven and twelve cells: asperities touch one by one.
ROUGH = Waves(0.2e-6, 2 * np.pi / (0.17 * A), 2 * np.pi / (0.43 * A))
CELLS = (96, 64)

Solver = Callable[[ContactProblem, float], Array]


@pytest.fixture(params=["tamaas", "ContactMechanics"])
def peer(request: pytest.FixtureRequest) -> Solver:
    pytest.importorskip(request.param, reason=f"{request.param} is not installed (extra: bench)")
    return {"tamaas": tamaas_pressure, "ContactMechanics": contact_mechanics_pressure}[
        request.param
    ]


def assert_same(problem: ContactProblem, theirs: Array) -> None:
    # Both solvers stop at 1e-8 of the gap or below, so what is left is ten times that at most.
    ours = solve_contact(problem, tolerance=1e-9).pressure
    assert np.abs(theirs - ours).sum() <= 1e-6 * ours.sum()
    differ = (theirs > 0) != (ours > 0)
    assert differ.sum() <= 1e-3 * (ours > 0).sum()


@pytest.mark.parametrize("surface", [SMOOTH, ROUGH], ids=["smooth", "rough"])
def test_a_peer_finds_the_same_elastic_contact(peer, surface):
    problem = pressed(window(CELLS, quarter=False), roughness=surface)
    assert_same(problem, peer(problem, MODULUS))


def test_a_peer_finds_the_same_contact_without_symmetry(peer):
    grid = window(CELLS, quarter=False)
    noise = 0.1e-6 * np.random.default_rng(11).standard_normal(CELLS)
    smooth = pressed(grid)
    problem = ContactProblem(smooth.half_space, smooth.shape + noise, smooth.load)
    assert_same(problem, peer(problem, MODULUS))


@pytest.mark.parametrize("limit", [0.8, 1.5])
def test_contact_mechanics_yields_alike(limit):
    pytest.importorskip("ContactMechanics", reason="not installed (extra: bench)")
    problem = pressed(window(CELLS, quarter=False), roughness=ROUGH, limit=limit)
    theirs = contact_mechanics_pressure(problem, MODULUS)
    assert theirs.max() == pytest.approx(problem.limit, rel=1e-9)
    assert_same(problem, theirs)


def test_the_influence_of_tamaas_is_ours():
    tamaas = pytest.importorskip("tamaas", reason="tamaas is not installed (extra: bench)")
    grid = window(CELLS, quarter=False)
    lengths = [2 * extent for extent in grid.extent]
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, lengths, grid.shape)
    model.E, model.nu = MODULUS, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "free")
    pressure = np.random.default_rng(5).uniform(0.0, 1e9, CELLS)
    theirs = np.zeros(CELLS)
    model.operators["free"](pressure, theirs)
    ours = pressed(grid).half_space.displacement(pressure)
    # Both transform with rounding errors only.
    np.testing.assert_allclose(theirs, ours, rtol=1e-12)
