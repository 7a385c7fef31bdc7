"""Slip from the reduced load against a tangential solve that knows nothing of it."""

import numpy as np
from benchmarks.pages import Data, Section, scientific
from tests.mechanics.oracles import influence_matrix, tangential_step
from tests.mechanics.problems import COUPLING, FRICTION, LOAD, MODULUS, ROUGH, fretting, uneven

from fretwear.arrays import Array
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactProblem, solve_contact
from fretwear.mechanics.slip.models import ReducedContact
from fretwear.mechanics.wear.integrator import evolve
from fretwear.mechanics.wear.state import WearProblem

CELLS, WORN_AFTER = 14, 300.0
RATIOS = (0.2, 0.5, 0.8, 0.95)
TOLERANCE = 1e-12


def shapes(problem: WearProblem) -> tuple[Grid, dict[str, Array]]:
    """Rough surfaces on one whole window: waves, the same with noise, the same worn."""
    *_, state = evolve(problem, [WORN_AFTER])
    window = state.geometry
    waves = problem.unworn(window)
    noise = 0.1e-6 * np.random.default_rng(7).standard_normal(window.shape)
    return window, {
        "wavy": waves,
        "wavy and random": waves + noise,
        "wavy, worn": waves + state.wear,
    }


def compare(window: Grid, shape: Array, ratio: float, problem: WearProblem) -> Data:
    """Largest differences over one cycle, relative to the largest slip or traction."""
    bodies = problem.half_space(window)
    contact = solve_contact(ContactProblem(bodies, shape, LOAD), tolerance=TOLERANCE)
    small = solve_contact(ContactProblem(bodies, shape, LOAD * (1 - ratio)), tolerance=TOLERANCE)
    gap = np.where(small.pressure > 0, 0.0, small.gap)
    reduced = ReducedContact(small.pressure, gap, small.approach, LOAD * (1 - ratio))
    influence = COUPLING * influence_matrix(window, MODULUS)
    bound = FRICTION * contact.pressure.ravel()
    force = ratio * FRICTION * LOAD

    def move(force: float, initial: Array) -> tuple[Array, Array, float]:
        step = tangential_step(influence, bound, initial, window.unit_area, force)
        return step.traction, step.slip.reshape(window.shape), step.displacement

    traction, slip, displacement = move(force, np.zeros_like(bound))
    reversed_traction, back, _ = move(-force, traction)
    _, again, _ = move(force, reversed_traction)
    loaded = contact.pressure > 0
    expected = problem.slip(reduced)[loaded]
    scale = expected.max()
    shear = problem.shear_traction(contact.pressure, reduced).ravel()
    shift = problem.tangential_displacement(contact.approach, reduced)
    return {
        "ratio": ratio,
        "slip": float(np.abs(slip[loaded] - expected).max() / scale),
        "traction": float(np.abs(traction - shear).max() / shear.max()),
        "displacement": abs(displacement / shift - 1),
        "reversal": float(np.abs(back[loaded] + 2 * expected).max() / scale),
        "return": float(np.abs(again[loaded] - 2 * expected).max() / scale),
        "loaded": int(loaded.sum()),
        "slipping": int((loaded & (reduced.pressure == 0)).sum()),
    }


def run() -> Data:
    problem = fretting(CELLS, roughness=uneven(ROUGH))
    window, surfaces = shapes(problem)
    return {
        "cells": list(window.shape),
        "surfaces": [
            {
                "name": name,
                "ratios": [compare(window, shape, ratio, problem) for ratio in RATIOS],
            }
            for name, shape in surfaces.items()
        ],
    }


def rows(data: Data) -> list[list[str]]:
    found = [ratio for surface in data["surfaces"] for ratio in surface["ratios"]]
    largest = max(
        each[name] for each in found for name in ("slip", "traction", "reversal", "return")
    )
    return [
        [
            "slip, traction of rough, random and worn surfaces",
            "dense solution along x",
            scientific(largest),
        ]
    ]


SECTION = Section("tangential", "Slip against an independent tangential solve", run)
