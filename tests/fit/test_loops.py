"""A recording of many loops with a time column is split into cycles."""

import numpy as np
import pytest
import yaml

from fretwear.study.case import Case
from fretwear_fit.loops import loop_history

from ..studies import base

LOAD, AMPLITUDE, STIFFNESS = 50.0, 40e-6, 2e6  # N, m, N/m of the rig in series


def friction_at(cycle):
    return 0.3 + 0.4 * cycle / 20.0


def recorded(file):
    """Twenty cycles of a contact that slides as a whole on a rig, from a part of one before."""
    turn = np.arange(-0.3, 20.4, 1 / 400)
    x = AMPLITUDE * np.sin(2 * np.pi * turn)
    limit = friction_at(np.maximum(np.floor(turn), 0.0)) * LOAD
    force = np.zeros(turn.size)
    for n in range(1, turn.size):
        trial = force[n - 1] + STIFFNESS * (x[n] - x[n - 1])
        force[n] = np.clip(trial, -limit[n], limit[n])
    rows = "\n".join(
        f"{t:.5f},{a * 1e6:.5f},{q:.6f}" for t, a, q in zip(turn, x, force, strict=True)
    )
    file.write_text(f"time (s),displacement (um),force (N)\n{rows}\n")


def test_each_cycle_has_its_friction_amplitude_and_energy(tmp_path):
    """E = 4 µP (δ − µP/k), of a parallelogram."""
    recorded(tmp_path / "loops.csv")
    table = loop_history(tmp_path / "loops.csv", LOAD)
    assert len(table) == 20
    expected = friction_at(table["cycle"].to_numpy())
    # A cycle begins in the middle of the rise, so its first readings have the friction before.
    assert table["friction"][3:].to_numpy() == pytest.approx(expected[3:], rel=0.01)
    assert table["displacement_amplitude"].to_numpy() == pytest.approx(AMPLITUDE, rel=1e-3)
    force = expected * LOAD
    energy = 4.0 * force * (AMPLITUDE - force / STIFFNESS)
    assert table["dissipated_energy"][3:].to_numpy() == pytest.approx(energy[3:], rel=0.03)


def test_the_command_prints_friction_that_a_study_takes(desk, tmp_path):
    recorded(tmp_path / "loops.csv")
    said = desk.call("loops", tmp_path / "loops.csv", "--load", "50 N", "-o", "table.csv").stdout
    written = yaml.safe_load(said.splitlines()[-1])
    case = Case(**base() | written)
    assert case.friction.at(10) == pytest.approx(friction_at(10), rel=0.02)
