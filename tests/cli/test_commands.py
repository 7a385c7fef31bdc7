"""What the commands do: run, plan, merge, show, compare, plot; how they are stopped."""

import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import fretwear
from fretwear.cli.show import comparison_lines
from fretwear.study.reading import load_study, select_point


@pytest.mark.parametrize("beginning", [4, None])
def test_a_case_chosen_by_its_id_or_its_beginning_is_simulated_and_written(desk, beginning):
    case_id = select_point(load_study("tiny.yaml", ["load=25 N"])).id
    Path("out").mkdir()
    result = desk.call("run", "tiny.yaml", "--case", case_id[:beginning], "-o", "out/one.nc")
    assert result.stdout.startswith("out/one.nc: ")
    with fretwear.open_case("out/one.nc") as case:
        assert case.attrs["case_id"] == case_id
        assert list(case["cycle"].values) == [0, 20, 200]


@pytest.mark.slow
def test_a_changed_case_has_the_numbers_of_python_and_tells_its_call(desk):
    desk.call("run", "tiny.yaml", "--set", "load=30 N", "--set", "cycles=50")
    case = select_point(load_study(desk.folder / "tiny.yaml", ["load=30 N", "cycles=50"])).case
    computed = fretwear.simulate(case, quarter=True)
    with fretwear.open_case(f"{case.case_id}.nc") as stored:
        command = "fretwear run tiny.yaml --set 'load=30 N' --set cycles=50"
        assert stored.attrs["history"].endswith(command)
        for name in computed.data_vars:
            np.testing.assert_array_equal(stored[name], computed[name])


@pytest.mark.slow
def test_the_program_writes_its_file_after_xarray_was_imported_and_leaves_dask_alone(desk):
    """As a notebook or another program has it, which calls `main` itself."""
    program = (
        "import sys, xarray, fretwear.cli\n"
        "sys.argv = ['fretwear', 'run', 'tiny.yaml', '--set', 'load=50 N', '-o', 'one.nc']\n"
        "try:\n    fretwear.cli.main()\nexcept SystemExit as end:\n    assert not end.code\n"
        "import dask.array\n"
        "assert xarray.open_dataset('one.nc', chunks={}).wear_volume.chunks\n"
    )
    subprocess.run([sys.executable, "-c", program], cwd=desk.folder, check=True)


@pytest.mark.slow
@pytest.mark.parametrize("load", ["50 N", "0.05 kilonewton"])
def test_a_command_imports_neither_dask_nor_h5py_and_pint_only_for_rare_units(desk, load):
    program = [sys.executable, "-X", "importtime", "-m", "fretwear"]
    run = [*program, "run", "tiny.yaml", "--set", f"load={load}", "-o", "one.nc"]
    imported = set[str]()
    for command in (run, [*program, "show", "one.nc"]):
        ended = subprocess.run(command, capture_output=True, text=True, check=True)
        imported |= {*ended.stderr.split()}
    assert "xarray" in imported
    assert {"dask", "h5py", "pint"} & imported == ({"pint"} if "kilo" in load else set())


def test_a_plan_lists_every_point_the_total_and_what_will_go_wrong(desk, content):
    result = desk.call("plan", "tiny.yaml")
    header, *points, empty, total = result.stdout.splitlines()
    assert header.split() == ["id", "load", "cells", "time", "memory"]
    assert [line.split()[0][:4] for line in points] == ["P25N", "P50N"]
    assert points[0].split()[1:3] == ["25", "N"]
    assert empty == ""
    assert total.startswith("2 points, 2 cases in 1 job: about ")
    assert desk.files() == ["tiny.yaml"]
    del content["base"]["cell"]
    content["base"]["plastic_limit"] = "500 MPa"
    desk.write(content)
    result = desk.call("plan", "tiny.yaml")
    assert "fretwear: warning: in 2 cases the contact yields all over" in result.stderr
    assert "warning" not in result.stdout


@pytest.mark.parametrize(
    ("command", "needed"), [("merge", "cases"), ("figures", "summary.nc"), ("report", "summary.nc")]
)
def test_a_step_without_what_it_needs_fails_with_a_message(desk, command, needed):
    result = desk.call(command, "tiny.yaml", status=1)
    assert "fretwear: error: results/tiny/summary.nc: " in result.stderr
    assert needed in result.stderr
    assert not (desk.folder / "results/tiny/report.html").exists()
    result = desk.call(command, "tiny.yaml", "--results", "tiny.yaml/results", status=2)
    assert "tiny.yaml/results: cannot be written to" in result.stderr


def test_show_tells_parameters_and_results_beside_the_closed_forms(desk, case_file):
    *lines, mark, explanation = desk.call("show", case_file).stdout.splitlines()
    case = select_point(load_study("tiny.yaml", ["load=50 N"])).case
    rows = {line[2:].split("  ")[0]: line.split("  ") for line in lines}
    assert case.case_id in lines[0]
    assert rows["normal load"][-1].strip() == "50 N"
    assert rows["plastic limit"][-1].strip() == "elastic"
    width = [cell.strip() for cell in rows["contact outline radius"] if cell.strip()]
    first, last, hertz = (float(cell.split()[0]) for cell in width[1:-1])
    assert hertz == pytest.approx(case.hertz_radius * 1e6, rel=1e-3)
    assert first == pytest.approx(hertz, rel=0.02)
    assert last > first
    assert " ± " in width[2]
    pressure = [cell.strip() for cell in rows["central pressure †"] if cell]
    assert [*map(str.strip, pressure[-2:])] == [f"{case.hertz_pressure * 1e-9:.4g}", "GPa"]
    assert mark.startswith("† In one cell or on one line")
    assert explanation.startswith("Unworn: ")
    first = lines.index("Results") + 2
    results = lines[first : lines.index("", first)]
    assert len(results) == 16
    units = {line.split()[-1] for line in results}
    assert units <= {"µm", "nm", "µm²", "µm³", "MPa", "GPa", "µJ", "%"}


@pytest.mark.slow
def test_compare_tells_what_differs_by_which_factor(desk, case_file):
    desk.call("run", "tiny.yaml", "--set", "load=25 N", "-o", "other.nc")
    result = desk.call("compare", "other.nc", case_file)
    cells = [re.split(r"\s{2,}", line.strip()) for line in result.stdout.splitlines()]
    rows = {row[0]: row[1:] for row in cells}
    assert rows["normal load"] == ["25 N", "50 N"]
    assert "coefficient of friction" not in " ".join(rows)
    first, second, unit, ratio = rows["wear volume"]
    assert unit == "10³ µm³"
    volumes = [float(text.split()[0]) for text in (first, second)]
    assert float(ratio) == pytest.approx(volumes[1] / volumes[0], rel=0.01)
    # Hertz: the radius goes with the cube root of the load.
    assert float(rows["contact outline radius"][-1]) == pytest.approx(2 ** (1 / 3), rel=0.03)
    result = desk.call("compare", case_file, case_file)
    assert "All parameters are the same." in result.stdout


def _case(cycles, **parameters):
    growth = np.arange(1.0, len(cycles) + 1.0)
    results = dict.fromkeys(("wear_volume", "peak_pressure"), ("cycle", growth))
    results["plastic_volume"] = ("cycle", 0.0 * growth)
    return xr.Dataset(results, {"cycle": np.array(cycles, float), **parameters})


@pytest.mark.parametrize(
    ("first", "second", "cycles", "ratio"),
    [
        ([0, 10, 100], [0, 5, 10, 50], (10, 10), "1.5"),
        ([0, 100], [0, 10, 50], (100, 50), "1.5"),
        ([0, 7], [0, 7], (7, 7), "1"),
    ],
)
def test_parameters_differ_beyond_rounding_and_results_are_those_of_a_common_snapshot(
    first, second, cycles, ratio
):
    """Or of the last ones; a ratio to zero is none."""
    a = _case(first, normal_load=40.0, friction=0.3, slip_model="jaeger", plastic_limit=np.inf)
    b = _case(second, normal_load=40.0 + 1e-13, friction=0.6, slip_model="jaeger", radius=1.0)
    lines = [re.split(r"\s{2,}", line.strip()) for line in comparison_lines(a, b)]
    rows = {row[0]: row[1:] for row in lines}
    differing = [row[0] for row in lines[2 : lines.index([""])]]
    assert differing == ["friction", "plastic_limit", "radius"]
    assert lines[lines.index(["Results"]) + 1][:2] == [
        f"{n}, cycle {cycles[n > 'A']}" for n in "AB"
    ]
    assert rows["wear volume"][-1] == ratio
    assert rows["plastic volume"][-1] == "–"


@pytest.mark.slow
def test_plot_draws_the_case_beside_it_or_where_it_is_told_to(desk, case_file):
    shutil.copy(case_file, "mine.nc")
    desk.call("plot", "mine.nc")
    assert desk.files() == ["mine.nc", "mine.png", "tiny.yaml"]
    content = (desk.folder / "mine.png").read_bytes()
    assert content.startswith(b"\x89PNG")
    assert struct.unpack(">II", content[16:24]) > (1000, 600)
    desk.call("plot", case_file, "-o", "a.svg", "--cycle", 0)
    text = (desk.folder / "a.svg").read_text(encoding="utf-8")
    assert text.startswith("<?xml")
    assert "cycle 0" in text
    assert "has snapshots at" in desk.call("plot", case_file, "--cycle", 7, status=2).stderr
