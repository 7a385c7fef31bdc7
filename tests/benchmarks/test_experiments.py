"""Studies of published experiments agree with their measurements, and the page with both."""

import json

import numpy as np
import pytest
from benchmarks.experiments.__main__ import PAGE
from benchmarks.experiments.measurements import (
    STUDIES,
    column,
    rows,
)
from benchmarks.pages import ROOT

import fretwear

TESTS = {
    "fouvry2017": [r for r in rows("fouvry2017") if r["test"] not in ("P_1", "f_8")],
    "vanpeteghem2011": [
        r for r in rows("vanpeteghem2011") if r["condition"] == "constant" and r["test"] != "7"
    ],
    "pulsating": rows("pulsating"),
}


@pytest.mark.parametrize("name", TESTS)
def test_a_study_has_the_conditions_and_the_energy_of_its_tests(name):
    tests = TESTS[name]
    cases = [point.case for point in fretwear.load_study(STUDIES / f"{name}.yaml").points()]
    assert len(cases) == len(tests)
    length = column(tests, "L_mm") * 1e-3 if name == "fouvry2017" else 8e-3
    energies = [
        4 * case.friction * case.load_at(0.0) * case.sliding_amplitude * case.cycles
        for case in cases
    ]
    np.testing.assert_allclose(np.array(energies) * length, column(tests, "SigmaEd_J"), rtol=1e-3)
    assert [case.frequency for case in cases] == column(tests, "f_Hz").tolist()
    assert [case.cycles for case in cases] == column(tests, "N_cycles").tolist()


def test_the_page_of_experiments_is_what_its_data_say_and_these_what_was_measured():
    assert PAGE.check(ROOT / "docs") == 0
    stored = json.loads((ROOT / "docs" / "experiments.json").read_text(encoding="utf-8"))
    points = stored["fouvry2017"]["data"]["points"]
    assert [each["measured"] for each in points] == column(TESTS["fouvry2017"], "V_mm3").tolist()
    every = stored["together"]["data"]
    assert set(every) == {name for name in stored if name not in ("laws", "together", "proposed")}
