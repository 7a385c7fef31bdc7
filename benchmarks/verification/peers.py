"""Normal contact against two other libraries."""

from dataclasses import dataclass, replace
from importlib import import_module
from importlib.metadata import version

import numpy as np
from benchmarks.pages import Data, Section, scientific
from benchmarks.peers.contacts import PEERS, pressed_by
from benchmarks.verification.problems import STUDY_LIMIT
from tests.mechanics.problems import MODULUS, SMOOTH, Waves, pressed, window

from fretwear.mechanics.contact.problem import ContactProblem, solve_contact

CELLS = (480, 96)
HALF_WIDTH = 175e-6
TOLERANCE = 1e-9
DRIVERS = {kind.name: kind for kind in PEERS}

AMPLITUDE, SLOPE_X, SLOPE_Y = 0.2e-6, np.tan(np.deg2rad(5.7)), np.tan(np.deg2rad(1.0))
STUDY_WAVES = Waves(AMPLITUDE, np.pi / 2 * SLOPE_X / AMPLITUDE, np.pi / 2 * SLOPE_Y / AMPLITUDE)


@dataclass(frozen=True)
class Job:
    """A contact and the peers that can solve it."""

    name: str
    surface: Waves | None
    limit: float
    peers: tuple[str, ...]
    noise: float = 0.0

    def problem(self) -> ContactProblem:
        grid = window(CELLS, HALF_WIDTH, even=(False, False))
        problem = pressed(grid, roughness=self.surface, limit=self.limit)
        random = self.noise * np.random.default_rng(3).standard_normal(CELLS)
        return replace(problem, shape=problem.shape + random)


BOTH = tuple(DRIVERS)
ROUGH = STUDY_WAVES
JOBS = (
    Job("smooth", SMOOTH, np.inf, BOTH),
    Job("rough (the study's waves)", ROUGH, np.inf, BOTH),
    Job("random, no symmetry", SMOOTH, np.inf, BOTH, noise=50e-9),
    Job("rough, p ≤ 4500 MPa", ROUGH, STUDY_LIMIT, ("ContactMechanics",)),
)


def run() -> Data:
    for name in DRIVERS:
        import_module(name)
    rows = []
    for job in JOBS:
        problem = job.problem()
        ours = solve_contact(problem, tolerance=TOLERANCE).pressure
        for peer in job.peers:
            theirs = pressed_by(DRIVERS[peer], problem, MODULUS)
            rows.append(
                {
                    "job": job.name,
                    "peer": peer,
                    "pressure": float(np.abs(theirs - ours).sum() / ours.sum()),
                    "largest": float(np.abs(theirs - ours).max() / ours.max()),
                }
            )
    return {"rows": rows, "versions": {name: version(name) for name in DRIVERS}}


def rows(data: Data) -> list[list[str]]:
    versions = " and ".join(f"{name} {number}" for name, number in data["versions"].items())
    mean, largest = (max(row[name] for row in data["rows"]) for name in ("pressure", "largest"))
    found = f"mean {scientific(mean, '.1e')}, largest {scientific(largest, '.1e')}"
    return [["pressure of smooth, rough, random, yielding contacts", versions, found]]


SECTION = Section("peers", "Normal contact against other libraries", run)
