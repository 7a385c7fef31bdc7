"""The laws of a contact hold in the results of any valid case, and in other units as well."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.invariants import ROUND, SPHERE, Draw, Laws, case_of, judged, swept

from benchmarks import invariants
from fretwear.mechanics.state import WearProblem
from fretwear.mechanics.surfaces import Sphere
from fretwear.running.simulate import steps

SEED, FIRST, COUNT = 2, 19, 30
SMALL = SPHERE | {"cycles": 30, "error_estimate": False, "cell": [15e-6, 15e-6]}


def broken(given, folder):
    return {law: times for law, times in judged(given, folder)[0].items() if times > 1.0}


@pytest.mark.slow
def test_no_drawn_case_breaks_a_law(tmp_path):
    drawn = {number: Draw(SEED, number, tmp_path).case() for number in range(FIRST, FIRST + COUNT)}
    # Each indenter and most of what can be imposed is among them.
    assert {case.indenter.kind for _, case in drawn.values()} == {*invariants.INDENTERS}
    assert len({case.loading.kind for _, case in drawn.values()}) >= 4
    found = {number: broken(given, tmp_path) for number, (given, _) in drawn.items()}
    assert not {number: wrong for number, wrong in found.items() if wrong}


@pytest.mark.parametrize(
    ("field", "change", "law"),
    [
        ("pressure", lambda p: 1.0001 * p, "the pressure carries P"),
        ("pressure", lambda p: p - 1e-9 * p.max(), "p >= 0"),
        ("gap", lambda g: g - 1e-12, "g >= 0"),
        ("gap", lambda g: g + 1e-9, "g p = 0"),
        ("wear", lambda w: (1.0 - 1e-9) * w, "bodies do not heal"),
    ],
)
def test_a_planted_defect_is_found(tmp_path, field, change, law):
    case = case_of(SMALL | {"indenter": ROUND["indenter"]}, tmp_path)
    laws, before = Laws(case), None
    for step in steps(case):
        laws(step)
        before = step
    assert max(laws.worst.values()) <= 1.0
    state = replace(before.state, **{field: change(getattr(before.state, field))})
    laws(replace(before, state=replace(state, cycle=state.cycle + 1)))
    assert laws.worst[law] > 1.0


def test_a_length_that_is_hidden_in_the_code_is_found(tmp_path, monkeypatch):
    gap = Sphere.gap
    monkeypatch.setattr(Sphere, "gap", lambda self, x, y: gap(self, x, y) + 1e-3 * np.tanh(x**2))
    worst, _ = judged(SMALL, tmp_path)
    assert worst["the same in other units"] > 1.0


def test_energy_that_does_not_belong_to_the_wear_by_one_percent_is_found(tmp_path, monkeypatch):
    given = SMALL | {"tolerance": 0.002}
    law = "V = integral of K/mu dE"
    assert judged(given, tmp_path, again=False)[0][law] < 0.5
    energy = WearProblem.dissipated_energy
    monkeypatch.setattr(WearProblem, "dissipated_energy", lambda *stage: 1.01 * energy(*stage))
    assert judged(given, tmp_path, again=False)[0][law] > 1.0


def test_a_jump_along_a_parameter_is_found(tmp_path, monkeypatch):
    given = SMALL | {"error_estimate": True}
    assert max(swept(given, "load", 49.5, 50.5, tmp_path).values()) < 1.0
    slip = WearProblem.slip
    monkeypatch.setattr(
        WearProblem,
        "slip",
        lambda self, reduced: slip(self, reduced) * (1.01 if self.hertz.load > 50.0 else 1.0),
    )
    assert swept(given, "load", 49.5, 50.5, tmp_path)["dissipated_energy"] > 1.0
