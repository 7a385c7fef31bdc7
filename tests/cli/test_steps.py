import csv
from pathlib import Path

import numpy as np
import pytest

from fretwear.data.files import open_summary
from fretwear.study.study import load_study


@pytest.fixture
def done(desk):
    """The study with its first case simulated, the second not."""
    first, _ = load_study("tiny.yaml").cases()
    path = f"results/tiny/cases/{first}.nc"
    assert desk.call("run", "tiny.yaml", "--case", first, "-o", path).exit_code == 0
    return desk


def test_merge_keeps_what_is_done_and_marks_what_failed(done):
    result = done.call("merge", "tiny.yaml")
    assert result.exit_code == 0
    assert "1 points done, 1 failed, 0 invalid" in result.stdout
    with open_summary("results/tiny/summary.nc") as summary:
        assert list(summary["status"].values) == [0, 1]
        volume = summary["wear_volume"].isel(cycle=-1).values
    assert volume[0] > 0
    assert np.isnan(volume[1])
    with Path("results/tiny/points.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["load"]) for row in rows] == [25.0, 50.0]


def test_figures_and_report_follow_the_merged_study(done):
    assert done.call("merge", "tiny.yaml").exit_code == 0
    assert done.call("figures", "tiny.yaml").exit_code == 0
    assert done.call("report", "tiny.yaml").exit_code == 0
    figures = done.folder / "results/tiny/figures"
    names = {path.stem for path in figures.glob("*.svg")}
    assert {"contact_half_width", "wear_volume", "dissipated_energy"} <= names
    assert names == {path.stem for path in figures.glob("*.png")}
    page = (done.folder / "results/tiny/report.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert "Tiny" in page


@pytest.mark.parametrize(
    ("command", "needed"), [("merge", "cases"), ("figures", "summary.nc"), ("report", "summary.nc")]
)
def test_a_step_without_what_it_needs_fails_with_a_message(desk, command, needed):
    result = desk.call(command, "tiny.yaml")
    assert result.exit_code == 1
    assert "fretwear: error: results/tiny/summary.nc: " in result.stderr
    assert needed in result.stderr
    assert "Traceback" not in result.stderr
    assert not (desk.folder / "results/tiny/report.html").exists()


def test_a_report_without_figures_says_what_is_missing(done):
    assert done.call("merge", "tiny.yaml").exit_code == 0
    result = done.call("report", "tiny.yaml")
    assert result.exit_code == 1
    assert "results/tiny/figures/index.json" in result.stderr


@pytest.mark.parametrize("command", ["merge", "figures", "report"])
def test_results_in_an_impossible_place_are_refused(desk, command):
    result = desk.call(command, "tiny.yaml", "--results", "tiny.yaml/results")
    assert result.exit_code == 2
    assert "tiny.yaml is not a folder" in result.stderr
