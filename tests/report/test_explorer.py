"""What the page's explorer holds is what the case files say, of as many cases as fit."""

import base64
import gzip
import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from fretwear.data.atomic import DataFileError
from fretwear.data.files import open_case, open_history
from fretwear.figures.profiles import bearing_heights
from fretwear.report.explorer import (
    EXPLORED_PROFILES,
    MAPS,
    build_explorer,
    delta_coded,
    evenly,
    held_points,
    thinned_levels,
)
from fretwear.report.results import point_results
from fretwear.study.plan import Plan
from fretwear.study.reading import load_study
from fretwear.vocabulary import PointStatus

from ..studies import base, run_study, write_study

SIZES = {"MPa": 1e6, "µm": 1e-6, "nm": 1e-9}


@pytest.fixture(scope="module")
def results(finished):
    return point_results(finished.plan, finished.summary, {})


@pytest.fixture(scope="module")
def explorer(finished, results):
    return build_explorer(finished.plan, results, finished.folder)


def unpacked(explorer):
    """Read what the page's script reads."""
    return json.loads(gzip.decompress(base64.b64decode(explorer.data)))


@pytest.fixture(scope="module")
def data(explorer):
    return unpacked(explorer)


def summed(packed):
    known = [0 if step is None else step for step in packed["steps"]]
    values = packed["scale"] * np.cumsum(known)
    return np.where([step is None for step in packed["steps"]], np.nan, values)


def test_profiles_zones_and_histories_are_those_of_the_files_to_a_10000th(finished, data):
    assert len(data["cases"]) == 11
    for case in data["cases"]:
        # A contact that is even has no maps, and a smooth one no heights.
        assert case["view"] is None
        assert (case["heights"] is None) == (finished.plan.study.cases()[case["id"]].rough is None)
        with open_case(finished.cases / f"{case['id']}.nc") as stored:
            first, spacing, count = case["x"]
            x = stored["x"].values[:count]
            assert first + spacing * np.arange(count) == pytest.approx(1e6 * x, rel=1e-9)
            assert x[-1] > 1.1 * float(stored["contact_half_width_x"].max())
            for name in EXPLORED_PROFILES:
                expected = stored[name].values[:, :count, 0] / SIZES[data["words"][name]["unit"]]
                found = np.array([summed(packed) for packed in case["profiles"][name]])
                largest = np.abs(expected).max(axis=1, keepdims=True)
                assert (np.abs(found - expected) <= 0.51e-4 * largest).all()
            across = case["across"]
            first, spacing, count_y = across["x"]
            y = 1e6 * stored["y"].values[:count_y]
            assert first + spacing * np.arange(count_y) == pytest.approx(y, rel=1e-9)
            for name, packed in across["profiles"].items():
                expected = stored[name].values[:, 0, :count_y] / SIZES[data["words"][name]["unit"]]
                found = np.array([summed(row) for row in packed])
                largest = np.abs(expected).max(axis=1, keepdims=True)
                assert (np.abs(found - expected) <= 0.51e-4 * largest).all()
            for name, widths in across["numbers"].items():
                assert widths == pytest.approx(1e6 * stored[name].values, rel=1e-6)
            for cycle, zones in enumerate(case["zones"]):
                for state, number in (("slip", 1), ("stick", 2)):
                    inside = np.zeros(count, bool)
                    for start, end in zones[state]:
                        inside |= (1e6 * x > start) & (1e6 * x < end)
                    expected = stored["contact_state"].values[cycle, :count, 0] == number
                    assert (inside == expected).all()
    case = data["cases"][0]
    with open_history(finished.cases / f"{case['id']}.nc") as history:
        assert case["history"]["cycle"] == pytest.approx(history["cycle"].values, rel=1e-6)
        width = 1e6 * history["contact_half_width_x"].values
        assert case["history"]["contact_half_width_x"] == pytest.approx(width, rel=1e-6)


def test_points_without_results_keep_their_reasons_and_the_case_most_worn_comes_first(data):
    assert len(data["points"]) == 16
    invalid = [point for point in data["points"] if point["status"] == "invalid"]
    assert len(invalid) == 4
    assert all(point["case"] == -1 and "Q must be less" in point["reason"] for point in invalid)
    volumes = [case["numbers"]["wear_volume"][-1] for case in data["cases"]]
    assert data["points"][data["start"]]["case"] == int(np.argmax(volumes))
    packed = delta_coded(np.array([np.nan, 2.0, np.nan, -1.0]))
    assert packed["steps"] == [None, 10_000, None, -15_000]
    assert summed(packed) == pytest.approx([np.nan, 2.0, np.nan, -1.0], nan_ok=True)
    assert delta_coded(np.zeros(3)) == {"scale": 0.0, "steps": [0, 0, 0]}
    assert delta_coded(np.full(2, np.nan)) == {"scale": 0.0, "steps": [None, None]}


def test_of_many_points_a_grid_of_fewer_levels_is_held(finished, results, explorer):
    assert explorer.note == ""
    assert explorer.numbers == {result.number for result in results if result.done}
    fewer = build_explorer(finished.plan, results, finished.folder, most=9)
    assert fewer.note.startswith("This page holds 8 of the 16 points of the study,")
    assert [point["number"] for point in unpacked(fewer)["points"]] == list(range(1, 9))
    assert [len(axis["levels"]) for axis in fewer.axes] == [1, 2, 2, 2]
    assert thinned_levels([10, 10, 10], 300) == [evenly(10, 6), evenly(10, 7), evenly(10, 7)]
    assert thinned_levels([1000], 3) == [[0, 500, 999]]
    assert thinned_levels([2, 3], 6) == [[0, 1], [0, 1, 2]]
    assert evenly(7, 1) == [0]
    assert evenly(3, 7) == [0, 1, 2]


@pytest.mark.parametrize(("done", "held"), [({5, 6, 9}, {5, 9}), ({0}, {0})])
def test_at_least_one_point_that_is_done_is_held(finished, results, done, held):
    status = [PointStatus.DONE if place in done else PointStatus.FAILED for place in range(16)]
    told = [replace(result, status=one) for result, one in zip(results, status, strict=True)]
    assert held <= set(held_points(finished.plan, told, most=2))


def test_the_same_numbers_give_the_same_text_without_markup(finished, results, explorer, tmp_path):
    assert build_explorer(finished.plan, results, finished.folder) == explorer
    assert not set(explorer.data) & set("<>&\"'")
    with pytest.raises(DataFileError, match="there is no such file"):
        build_explorer(finished.plan, results, tmp_path)


@pytest.fixture(scope="module")
def random(tmp_path_factory):
    """A random surface: its file, and what the explorer has of it."""
    folder = tmp_path_factory.mktemp("random")
    rough = {"kind": "self_affine", "rms_height": "0.1 um", "hurst": 0.8, "seed": 3}
    rough |= {"rolloff_wavelength": "60 um", "shortest_wavelength": "30 um"}
    given = base(roughness=rough, error_estimate=False, cycles=30)
    study = load_study(write_study(folder / "random.yaml", {"title": "Random", "base": given}))
    run_study(study, folder)
    with xr.open_dataset(folder / "summary.nc") as summary:
        results = point_results(Plan(study), summary, {})
    data = unpacked(build_explorer(Plan(study), results, folder))
    (file,) = (folder / "cases").glob("*.nc")
    sizes = {
        name: SIZES[words["unit"]]
        for name, words in data["words"].items()
        if words["unit"] in SIZES
    }
    yield file, data["cases"][0], sizes
    file.unlink()
    with pytest.raises(DataFileError, match="no such file"):
        build_explorer(Plan(study), results, folder)


def test_maps_keep_loads_and_volumes(random):
    file, case, sizes = random
    view = case["view"]
    (_, dx, nx), (_, dy, ny) = view["x"], view["y"]
    assert max(nx, ny) <= 64
    fields = {
        name: sizes[name]
        * np.array([[summed(row) for row in field] for field in view["fields"][name]])
        for name in MAPS
    }
    with open_case(file) as stored:
        loads = fields["pressure"].sum(axis=(1, 2)) * dx * dy * 1e-12
        # Half a square at each end may be dropped, where hardly anything touches.
        assert loads == pytest.approx(stored["normal_force"].values, rel=1e-3)
        volume = fields["wear_depth"][-1].sum() * dx * dy * 1e-12
        assert volume == pytest.approx(float(stored["wear_volume"][-1]), rel=1e-3)
    assert view["x"][0] + 0.5 * (nx - 1) * dx == pytest.approx(0.0, abs=2 * dx)
    assert fields["pressure"].shape == (len(case["cycles"]), ny, nx)


def test_bearing_areas_are_those_of_the_figure(random):
    file, case, sizes = random
    with open_case(file) as stored:
        before, after = bearing_heights(stored, [0, 30]).values()
    for shown, heights in zip(case["heights"], (before, after), strict=True):
        share = (np.arange(heights.size) + 0.5) / heights.size
        expected = np.interp(np.linspace(0.0, 1.0, len(shown)), share, heights)
        found = sizes["height"] * np.array(shown)
        assert found == pytest.approx(expected, abs=1e-3 * np.ptp(heights))


def test_profiles_of_a_stroke_reach_to_the_end_of_the_scar(tmp_path):
    stroke = {"indenter": {"kind": "cylinder", "radius": "6 mm"}, "sliding_amplitude": "25 um"}
    stroke |= {"load": "18.5 N/mm", "wear_coefficient": ["1e-13 / Pa", "1e-13 / Pa"]}
    stroke |= {"youngs_modulus": "200 GPa", "poisson_ratio": 0.3, "friction": 0.9, "cycles": 300}
    content = {"base": stroke | {"cell": "3 um", "error_estimate": False}}
    study = load_study(write_study(tmp_path / "stroke.yaml", content))
    summary = xr.load_dataset(run_study(study, tmp_path) / "summary.nc")
    plan = Plan(study)
    (case,) = unpacked(build_explorer(plan, point_results(plan, summary, {}), tmp_path))["cases"]
    first, spacing, count = case["x"]
    depth = summed(case["profiles"]["wear_depth"][-1])
    assert depth.max() > 100.0 * depth[-1]
    # The contact in the middle of the stroke is far narrower.
    assert first + spacing * (count - 1) > 1.3 * case["numbers"]["contact_half_width_x"][-1] + 5.0
