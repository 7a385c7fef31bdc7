"""Normal contact against two other libraries."""

from dataclasses import dataclass, replace
from importlib import import_module
from importlib.metadata import version

import numpy as np
from benchmarks.pages import Check, Data, Section, scientific, table
from benchmarks.peers.contacts import PEERS, pressed_by
from benchmarks.verification.problems import STUDY_LIMIT
from tests.mechanics.problems import MODULUS, P0, SMOOTH, Waves, pressed, window

from fretwear.mechanics.contact.problem import ContactProblem, solve_contact

CELLS = (480, 96)
HALF_WIDTH = 175e-6
TOLERANCE = 1e-9
REQUIRED, REQUIRED_AREA = 1e-3, 1e-2
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
                    "cells": int((ours > 0).sum()),
                    "area": float((theirs > 0).sum() / (ours > 0).sum() - 1),
                    "peak": float(ours.max() / P0),
                }
            )
    return {"rows": rows, "versions": {name: version(name) for name in DRIVERS}}


def checks(data: Data) -> list[Check]:
    found = []
    for peer, number in data["versions"].items():
        rows = [row for row in data["rows"] if row["peer"] == peer]
        title = f"{peer} {number}"
        found.append(Check(f"{title}: pressure, L1", max(r["pressure"] for r in rows), REQUIRED))
        area = max((row["area"] for row in rows), key=abs)
        found.append(Check(f"{title}: contact area", area, REQUIRED_AREA))
    return found


def text(data: Data) -> str:
    rows = [
        [
            f"{row['job']}, {row['peer']}",
            scientific(row["pressure"], ".1e"),
            scientific(row["largest"], ".1e"),
        ]
        for row in data["rows"]
    ]
    versions = " and ".join(f"{name} {number}" for name, number in data["versions"].items())
    nx, ny = CELLS
    return f"""\
The first loading by {versions} on the same {nx} × {ny} cells. All load {"other" if any(row["area"] for row in data["rows"]) else "the same"} cells.

{table(["", "pressure, L1", "pressure, largest"], rows)}
"""


SECTION = Section("peers", "Normal contact against other libraries", run, text, checks)
