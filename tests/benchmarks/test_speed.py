"""The table of speeds, the counts of its jobs, and the pages that their data make."""

import json
from collections import deque
from pathlib import Path

import numpy as np
import pytest
import scipy.fft
from benchmarks.speed.__main__ import main as speed
from benchmarks.speed.cases import WAVES, first_contact, rough_case, smooth_case, study_case
from benchmarks.speed.table import Row, from_json, missing
from benchmarks.speed.units import bare_convolution
from benchmarks.verification.__main__ import PAGE as VERIFICATION
from fretwear.mechanics.kernels import inner

from benchmarks import performance
from fretwear.mechanics.contact import solve_contact
from fretwear.mechanics.geometry.grid import Grid, influence_coefficients
from fretwear.mechanics.integrator import evolve, first_loading
from fretwear.mechanics.solver import ActiveSet
from fretwear.running import simulate

ROWS = [
    "cold_smooth", "cold_rough", "smooth_run", "smooth_steps", "smooth_volume", "smooth_share",
    "rough_run", "rough_asked", "rough_share", "memory", "help", "plan", "cold_peers", "wear_peers",
]  # fmt: skip


@pytest.mark.slow
def test_the_table_has_every_row(tmp_path, capsys):
    output = tmp_path / "speed.json"
    speed(["--coarser", "8", "--repeats", "1", "--output", str(output)])
    rows = [from_json(entry) for entry in json.loads(output.read_text("utf-8"))["rows"]]
    assert [row.name for row in rows] == ROWS
    assert all(row.measured > 0 for row in rows if not row.name.endswith("_peers"))
    printed = capsys.readouterr().out
    assert all(row.job in printed for row in rows)


@pytest.mark.parametrize(
    ("row", "verdict"),
    [
        (Row("row", "job", 40.0, "CE", 50.0, 30.0), "holds"),
        (Row("row", "job", 30.0, "CE", 50.0, 30.0), "reaches the aim"),
        (Row("row", "job", 51.0, "CE", 50.0, 30.0), "falls short"),
        (Row("row", "job", 51.0, "CE", 30.0, 50.0, True), "reaches the aim"),
        (Row("row", "job", 29.0, "CE", 30.0, 50.0, True), "falls short"),
        (missing("row", "job", "×", 10.0, 20.0, "no library"), "not measured"),
    ],
)
def test_a_row_is_judged_by_both_bounds_also_after_it_was_stored(row, verdict):
    again = from_json(json.loads(json.dumps(row.as_json())))
    assert row.verdict == again.verdict == verdict


def test_the_unit_is_the_convolution_of_the_solver():
    window = Grid((12, 20), (1e-6, 2e-6))
    kernel = influence_coefficients((25, 41), window.spacing, 1e11)
    spectrum = scipy.fft.dctn(kernel, type=1)[:-1, :-1]
    pressure = np.random.default_rng(2).random(window.shape)
    expected = window.half_space(1e11).displacement(pressure)
    np.testing.assert_allclose(bare_convolution(pressure, spectrum), expected, rtol=1e-12)


TOLERATED = 1.15


def last_state(case):
    problem = simulate.wear_problem(case, Grid)
    return deque(evolve(problem, [float(case.cycles)], case.tolerance), maxlen=1)[0]


@pytest.mark.parametrize(("rough", "expected"), [(False, 28), (True, 51)], ids=["smooth", "rough"])
def test_a_cold_contact_takes_few_convolutions(rough, expected):
    contact = solve_contact(first_contact(256, rough=rough), tolerance=1e-6)
    assert contact.residual <= 1e-6
    assert contact.convolutions <= TOLERATED * expected


def test_the_first_loading_of_the_rough_capped_run_takes_few_convolutions():
    state = first_loading(simulate.wear_problem(rough_case()))
    assert state.convolutions <= TOLERATED * 126


@pytest.mark.parametrize(
    ("case", "steps", "convolutions"),
    [
        (smooth_case(128), 19, 315),
        (smooth_case(24, plastic_limit="2160 MPa", cycles=7000), 28, 1880),
        # On twice the spacing and for 438 cycles; the row itself took 61 steps, 4712 convolutions.
        (rough_case(2.0, cycles=438), 11, 836),
    ],
    ids=["smooth", "smooth, capped", "rough, capped"],
)
def test_a_run_takes_few_steps_and_convolutions(case, steps, convolutions):
    last = last_state(case)
    assert last.step <= TOLERATED * steps
    assert last.convolutions <= TOLERATED * convolutions


def test_no_step_of_the_solver_is_downhill_by_rounding_only(monkeypatch):
    # Along such a step, left by clipping, the energy hardly falls, and the next is the same again.
    search, descents = ActiveSet._search, []

    def watched(method, step, slope, *moved):
        along = inner(method._team, np.abs(method.gap), np.abs(step))
        descent = inner(method._team, method.gap, step)
        assert slope == pytest.approx(descent, abs=1e-12 * along)
        descents.append(-slope / along)
        search(method, step, slope, *moved)

    monkeypatch.setattr(ActiveSet, "_search", watched)
    cell = (0.75e-6, 3e-6)
    last_state(study_case(roughness=WAVES, plastic_limit="5500 MPa", cycles=438, cell=cell))
    assert len(descents) > 100
    assert min(descents) > 0.05


DOCS = Path(__file__).resolve().parents[2] / "docs"


def stored(page, docs=DOCS):
    return json.loads((docs / f"{page.name}.json").read_text(encoding="utf-8"))


def keep(page, docs, entries):
    (docs / f"{page.name}.json").write_text(json.dumps(entries), encoding="utf-8")


@pytest.mark.parametrize("page", [VERIFICATION, performance.PAGE], ids=lambda page: page.name)
def test_the_page_is_what_its_data_say(page):
    assert page.main(["--check"]) == 0


def test_a_worse_measurement_falls_short_on_the_page(tmp_path):
    entry, docs = stored(VERIFICATION)["tangential"], ["--docs", str(tmp_path)]
    entry["data"]["surfaces"][0]["ratios"][0]["slip"] = 3e-8
    keep(VERIFICATION, tmp_path, {"tangential": entry})
    assert VERIFICATION.main(["--check", *docs]) == 1
    assert VERIFICATION.main(["--render", *docs]) == 0
    page = (tmp_path / "checks.md").read_text(encoding="utf-8")
    (line,) = (line for line in page.splitlines() if "s = µκg*" in line and line.startswith("| ["))
    assert "falls short" in line
    assert "+3.0e-8" in line
    assert VERIFICATION.main(["--check", *docs]) == 0
    row = Row("help", "fretwear --help", 0.5, "s", 0.4, 0.2, note="shortest of 9")
    entry = {"cores": 2, "processor": "one", "load_average": 0.1, "versions": {}, "seconds": 1}
    keep(performance.PAGE, tmp_path, {"table": {**entry, "data": {"rows": [row.as_json()]}}})
    assert performance.PAGE.main(["--render", *docs]) == 0
    text = (tmp_path / "performance.md").read_text("utf-8")
    assert "| fretwear --help | ≤ 0.4 | ≤ 0.2 | 0.5 | s | falls short |" in text


@pytest.mark.slow
def test_a_section_is_measured_drawn_and_kept(tmp_path):
    assert VERIFICATION.main(["closed_forms", "--docs", str(tmp_path)]) == 0
    peak, kept = (
        [row["peak_pressure"] for row in data["closed_forms"]["data"]["spacings"]]
        for data in (stored(VERIFICATION, tmp_path), stored(VERIFICATION))
    )
    # deviations of 1e-6 on other processors differ in the digits of the contact's tolerance
    assert peak == pytest.approx(kept, abs=1e-6)
    assert (tmp_path / "images" / "verification" / "closed_forms_orders.svg").exists()
    assert "## Closed forms" in (tmp_path / "checks.md").read_text(encoding="utf-8")
