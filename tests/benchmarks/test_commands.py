"""The benchmark commands run, here on grids far too coarse to say anything."""

import json
import math

import pytest
from benchmarks.speed.__main__ import main as speed
from benchmarks.speed.table import Row, from_json, missing

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


def test_an_unknown_group_is_refused(capsys):
    with pytest.raises(SystemExit):
        speed(["contacts"])
    assert "there are contact, smooth" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("measured", "at_least", "verdict"),
    [
        (40.0, False, "holds"),
        (30.0, False, "reaches the aim"),
        (51.0, False, "falls short"),
        (51.0, True, "reaches the aim"),
        (29.0, True, "falls short"),
    ],
)
def test_a_row_is_judged_by_both_bounds(measured, at_least, verdict):
    asked, aim = (30.0, 50.0) if at_least else (50.0, 30.0)
    assert Row("row", "job", measured, "CE", asked, aim, at_least).verdict == verdict


def test_what_was_not_measured_is_no_success_and_survives_json():
    row = missing("row", "job", "×", 10.0, 20.0, "no library")
    assert row.verdict == "not measured"
    again = from_json(json.loads(json.dumps(row.as_json())))
    assert math.isnan(again.measured)
    assert again.note == "no library"
