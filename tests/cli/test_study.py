import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fretwear.data.files import open_summary
from fretwear.study.study import load_study

from ..studies import WAVES

HEAVY = ("scipy.fft", "xarray", "netCDF4", "matplotlib")


def test_a_plan_lists_every_point_the_total_and_what_will_go_wrong(desk, content):
    result = desk.call("plan", "tiny.yaml")
    assert result.exit_code == 0
    header, *points, empty, wear, total = result.stdout.splitlines()
    assert header.split() == ["id", "load", "cells", "time", "memory"]
    assert [line.split()[0][:4] for line in points] == ["P25N", "P50N"]
    assert points[0].split()[1:3] == ["25", "N"]
    assert empty == ""
    assert wear == "Wear coefficient per load and path: 0.0007 mm³/(N m)."
    assert total.startswith("2 points, 2 cases in 2 jobs: about ")
    assert desk.files() == ["tiny.yaml"]
    del content["base"]["cell"]
    content["base"]["plastic_limit"] = "500 MPa"
    desk.write(content)
    result = desk.call("plan", "tiny.yaml")
    assert "fretwear: warning: in 2 cases the contact yields all over" in result.stderr
    assert "warning" not in result.stdout


def test_a_wide_plan_is_not_cut_and_a_huge_one_shows_both_ends_unless_all_is_asked_for(
    desk, content
):
    content["base"]["roughness"] = {**WAVES, "slope_x": "0.2 deg", "slope_y": "0.2 deg"}
    content["vary"] |= {"roughness.amplitude": ["0.1 um"], "plastic_limit": ["4500 MPa"]}
    content["vary"] |= {"friction": [0.3], "tolerance": [0.01]}
    content["vary"]["load"] = [f"{load} N" for load in range(20, 321)]
    content["base"]["cell"] = "2 um"
    desk.write(content)
    header, *lines, empty, _, total = desk.call("plan", "tiny.yaml").stdout.splitlines()
    ids = [point.id for point in load_study(desk.folder / "tiny.yaml").points()]
    shown = [line.split()[0] for line in lines]
    assert shown == [*ids[:20], "...", *ids[-20:]]
    assert lines[20] == "... 261 more points, which --all prints ..."
    assert all(line.endswith("MB") for line in lines[:20])
    assert (header.split()[0], empty) == ("id", "")
    assert total.startswith("301 points, 301 cases in ")
    every = desk.call("plan", "tiny.yaml", "--all").stdout.splitlines()
    assert [line.split()[0] for line in every[1:-3]] == ids


@pytest.mark.parametrize(
    ("arguments", "heavy"),
    # The library of units looks for numpy by itself.
    [
        (["--help"], ("numpy", "pint", "pydantic", *HEAVY)),
        (["plan", "tiny.yaml"], HEAVY),
        (
            ["run", "tiny.yaml", "--case", "P25N", "-o", "a.nc"],
            ("scipy", "xarray", "pandas", "dask", "matplotlib"),
        ),
    ],
)
def test_what_should_begin_at_once_imports_nothing_heavy(desk, arguments, heavy):
    program = (
        "import sys\n"
        "from fretwear.cli import app\n"
        f"app({arguments!r}, standalone_mode=False)\n"
        f"print([name for name in {heavy!r} if name in sys.modules])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=desk.folder, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_merge_keeps_what_is_done_and_marks_what_failed(desk):
    assert desk.call("batch", "tiny.yaml", "--points", "1-1").exit_code == 0
    result = desk.call("merge", "tiny.yaml")
    assert result.exit_code == 0
    assert "1 points done, 1 failed, 0 invalid" in result.stdout
    with open_summary("results/tiny/summary.nc") as summary:
        assert list(summary["status"].values) == [0, 1]
        volume = summary["wear_volume"].isel(cycle=-1).values
    assert volume[0] > 0
    assert np.isnan(volume[1])
    with Path("results/tiny/points.csv").open(newline="", encoding="utf-8") as stream:
        assert [float(row["load"]) for row in csv.DictReader(stream)] == [25.0, 50.0]


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
    result = desk.call(command, "tiny.yaml", "--results", "tiny.yaml/results")
    assert result.exit_code == 2
    assert "tiny.yaml is not a folder" in result.stderr
