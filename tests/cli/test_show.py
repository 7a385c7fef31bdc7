"""What a finished case shows: numbers, comparisons, pictures, films."""

import json
import re
import shutil
import struct
from pathlib import Path

import pytest

import fretwear
from fretwear.study.study import load_study, select_case


def test_show_tells_parameters_and_results_beside_the_closed_forms(desk, case_file):
    *lines, mark, explanation = desk.call("show", case_file).stdout.splitlines()
    case = select_case("tiny.yaml", None, ["load=50 N"])
    rows = {line[2:].split("  ")[0]: line.split("  ") for line in lines}
    assert case.case_id in lines[0]
    assert rows["normal load"][-1].strip() == "50 N"
    assert rows["plastic limit"][-1].strip() == "elastic"
    width = [cell.strip() for cell in rows["contact half-width along x"] if cell.strip()]
    first, last, hertz = (float(cell.split()[0]) for cell in width[1:-1])
    assert hertz == pytest.approx(case.hertz_radius * 1e6, rel=1e-3)
    assert first == pytest.approx(hertz, rel=0.02)
    assert last > first
    assert " ± " in width[2]
    pressure = [cell.strip() for cell in rows["central pressure †"] if cell]
    assert [*map(str.strip, pressure[-2:])] == [f"{case.hertz_pressure * 1e-9:.4g}", "GPa"]
    assert mark.startswith("† Of a single cell")
    assert explanation.startswith("Unworn: ")
    assert max(map(len, lines)) <= 80
    results = lines[lines.index("Results") + 2 : -1]
    assert len(results) == 15
    units = {line.split()[-1] for line in results}
    assert units <= {"µm", "nm", "µm²", "µm³", "MPa", "GPa", "µJ", "%"}


def test_a_script_gets_the_case_as_json_in_si_units(desk, case_file):
    seen = json.loads(desk.call("show", case_file, "--json").stdout)
    told = {"value": 50.0, "units": "N", "long_name": "normal load"}
    assert seen["parameters"]["load"] == told
    assert seen["parameters"]["plastic_limit"]["value"] is None
    with fretwear.open_case(case_file) as case:
        assert seen["case_id"] == case.attrs["case_id"]
        assert seen["cycle"] == case["cycle"].values.tolist()
        for name in ("contact_half_width_x", "peak_pressure", "wear_volume"):
            assert seen["results"][name]["values"] == case[name].values.tolist()
            assert seen["results"][name]["units"] == case[name].attrs["units"]
        deepest = float(case["maximum_wear_depth"][-1])
        assert seen["results"]["maximum_wear_depth"]["values"][-1] == pytest.approx(deepest)
        assert seen["unworn"]["contact_half_width_x"] == float(case["hertz_radius"])


def test_show_tells_the_forces_that_come_out_of_a_rig(desk, content):
    content["base"] |= {
        "displacement_ratio": 0.7,
        "rig_stiffness": "28 N/um",
        "friction": {"cycles": [0, 50], "values": [0.4, 0.6]},
    }
    del content["base"]["tangential_ratio"]
    desk.write(content)
    assert desk.call("run", "tiny.yaml", "--set", "load=50 N", "-o", "rig.nc").exit_code == 0
    seen = json.loads(desk.call("show", "rig.nc", "--json").stdout)
    first, last = (seen["results"]["tangential_force"]["values"][row] for row in (0, -1))
    assert 0.0 < first < 0.4 * 50.0
    assert first < last < 0.6 * 50.0
    assert 0.0 < seen["results"]["sliding_ratio"]["values"][0] < 0.2
    # The closed forms are those of the friction of cycle 0.
    closed = seen["unworn"]["tangential_displacement"]
    assert seen["results"]["tangential_displacement"]["values"][0] == pytest.approx(
        closed, rel=0.01
    )


def test_show_lists_the_points_of_a_merged_study_for_people_and_scripts(desk, content):
    content["vary"]["cycles"] = [100, 200]
    desk.write(content)
    assert desk.call("batch", "tiny.yaml", "--points", "1-3").exit_code == 0
    assert desk.call("merge", "tiny.yaml").exit_code == 0
    merged = "results/tiny/summary.nc"
    lines = desk.call("show", merged).stdout.splitlines()
    assert lines[2] == "4 points: 3 done, 1 failed, 0 invalid"
    header, *rows = lines[lines.index("") + 2 :]
    assert header.split()[:3] == ["id", "load", "cycles"]
    assert [row.split()[0] for row in rows] == list(load_study("tiny.yaml").cases())
    assert "failed" in rows[-1]
    assert "wear volume (µm³)" in header  # one unit for all
    volumes = [float(re.findall(r" ([\d.]+) ± ", row)[0]) for row in rows[:-1]]
    assert 0 < volumes[0] < volumes[1]
    *done, missing = json.loads(desk.call("show", merged, "--json").stdout)["points"]
    assert [point["status"] for point in (*done, missing)] == ["done", "done", "done", "failed"]
    assert missing["wear_volume"] is None
    for point in done:
        with fretwear.open_case(f"results/tiny/cases/{point['case_id']}.nc") as case:
            assert point["load"] == float(case["load"])
            assert point["wear_volume"] == float(case["wear_volume"][-1])


def test_compare_tells_what_differs_by_which_factor_and_draws_both(desk, case_file):
    call = ("run", "tiny.yaml", "--set", "load=25 N", "-o", "other.nc")
    assert desk.call(*call).exit_code == 0
    result = desk.call("compare", "other.nc", case_file)
    assert result.exit_code == 0
    cells = [re.split(r"\s{2,}", line.strip()) for line in result.stdout.splitlines()]
    rows = {row[0]: row[1:] for row in cells}
    assert rows["normal load"] == ["25 N", "50 N"]
    assert "coefficient of friction" not in " ".join(rows)
    first, second, unit, ratio = rows["wear volume"]
    assert unit == "10³ µm³"
    volumes = [float(text.split()[0]) for text in (first, second)]
    assert float(ratio) == pytest.approx(volumes[1] / volumes[0], rel=0.01)
    # Hertz: the radius goes with the cube root of the load.
    assert float(rows["contact half-width along x"][-1]) == pytest.approx(2 ** (1 / 3), rel=0.03)
    assert desk.files() == ["other.nc", "tiny.yaml"]
    result = desk.call("compare", case_file, case_file, "-o", "both.svg")
    assert "All parameters are the same." in result.stdout
    assert result.stdout.splitlines()[-1] == "both.svg"
    assert (desk.folder / "both.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_plot_draws_the_case_beside_it_or_where_it_is_told_to(desk, case_file):
    shutil.copy(case_file, "mine.nc")
    assert desk.call("plot", "mine.nc").exit_code == 0
    assert desk.call("plot", case_file, "-o", "a.svg").exit_code == 0
    assert desk.files() == ["a.svg", "mine.nc", "mine.png", "tiny.yaml"]
    assert (desk.folder / "a.svg").read_text(encoding="utf-8").startswith("<?xml")
    content = (desk.folder / "mine.png").read_bytes()
    assert content.startswith(b"\x89PNG")
    assert struct.unpack(">II", content[16:24]) > (1000, 600)


def test_animate_writes_a_gif_beside_the_case_and_advises_more_snapshots(
    desk, case_file, monkeypatch
):
    shutil.copy(case_file, "mine.nc")
    result = desk.call("animate", "mine.nc", "--dpi", "50")
    assert result.exit_code == 0
    assert (desk.folder / "mine.gif").read_bytes().startswith(b"GIF89a")
    assert result.stdout.startswith("mine.gif: 3 pictures, ")
    advice = result.stderr.partition("output: {cycles: [")[2].partition("]")[0]
    cycles = [int(cycle) for cycle in advice.split(", ")]
    assert (cycles[0], cycles[-1]) == (0, 200)
    monkeypatch.setenv("PATH", str(desk.folder))
    result = desk.call("animate", case_file, "-o", "a.mp4")
    assert result.exit_code == 2
    assert "a.gif instead" in result.stderr
    assert not Path("a.mp4").exists()
