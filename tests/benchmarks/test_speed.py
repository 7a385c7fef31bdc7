"""The table of speeds: its unit, its verdicts, its rows on grids too coarse to say anything."""

import json

import numpy as np
import pytest
import scipy.fft
from benchmarks.speed.__main__ import main as speed
from benchmarks.speed.table import Row, from_json, missing
from benchmarks.speed.units import bare_convolution

from fretwear.mechanics.geometry.grid import Grid, influence_coefficients

ROWS = [
    "cold_smooth", "cold_rough", "smooth_run", "smooth_steps", "smooth_volume", "smooth_share",
    "rough_run", "rough_share", "memory", "help", "plan", "cold_peers", "wear_peers",
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
