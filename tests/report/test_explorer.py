"""What the page's explorer holds is what the case files say, of as many cases as fit."""

import base64
import gzip
import json
from collections import defaultdict
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fretwear.data.files import open_case, open_history, write_case
from fretwear.data.safe import CaseFileError, DataFileError
from fretwear.figures.bearing import bearing_heights
from fretwear.report.above import MAPS, Above, read_above
from fretwear.report.explorer import (
    PROFILES,
    build_explorer,
    differences,
    evenly,
    held_points,
    read_curves,
    thinned_levels,
)
from fretwear.report.results import point_results
from fretwear.running.simulate import run
from fretwear.units import MEGAPASCAL, MICROMETRE
from fretwear.vocabulary import PointStatus

from ..studies import steel


@pytest.fixture(scope="module")
def results(finished):
    return point_results(finished.plan, finished.summary, {})


@pytest.fixture(scope="module")
def curves(finished, results):
    done = [place for place, result in enumerate(results) if result.done]
    return read_curves(finished.folder / "summary.nc", finished.plan, done)


EVEN = defaultdict(Above)
"""What is shown of surfaces beside their profiles: nothing."""


@pytest.fixture(scope="module")
def data(finished, results, curves):
    explorer = build_explorer(finished.plan, results, range(16), curves, EVEN)
    assert explorer is not None
    assert explorer.note == ""
    return unpacked(explorer.data)


def unpacked(text):
    """Read what the page's script reads."""
    content: dict[str, Any] = json.loads(gzip.decompress(base64.b64decode(text)))
    return content


def profile(packed):
    known = [0 if step is None else step for step in packed["steps"]]
    values = packed["scale"] * np.cumsum(known)
    return np.where([step is None for step in packed["steps"]], np.nan, values)


def test_profiles_zones_and_histories_are_those_of_the_files_to_a_10000th(finished, data):
    assert len(data["cases"]) == 11
    for case in data["cases"]:
        with open_case(finished.cases / f"{case['id']}.nc") as stored:
            first, spacing, count = case["x"]
            x = stored["x"].values[:count]
            assert first + spacing * np.arange(count) == pytest.approx(1e6 * x, rel=1e-9)
            assert x[-1] > 1.1 * float(stored["contact_half_width_x"].max())
            for name in PROFILES:
                size = {"MPa": 1e6, "µm": 1e-6, "nm": 1e-9}[data["words"][name]["unit"]]
                expected = stored[name].values[:, :count, 0] / size
                found = np.array([profile(packed) for packed in case["profiles"][name]])
                largest = np.abs(expected).max(axis=1, keepdims=True)
                assert (np.abs(found - expected) <= 0.51e-4 * largest).all()
            for cycle, pairs in enumerate(case["states"]):
                states = np.repeat(pairs[::2], pairs[1::2])
                expected = stored["contact_state"].values[cycle, : case["x"][2], 0]
                assert states.tolist() == expected.tolist()
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
    packed = differences(np.array([np.nan, 2.0, np.nan, -1.0]))
    assert packed["steps"] == [None, 10_000, None, -15_000]
    assert profile(packed) == pytest.approx([np.nan, 2.0, np.nan, -1.0], nan_ok=True)
    assert differences(np.zeros(3)) == {"scale": 0.0, "steps": [0, 0, 0]}
    assert differences(np.full(2, np.nan)) == {"scale": 0.0, "steps": [None, None]}


def test_of_many_points_a_grid_of_fewer_levels_is_held(finished, results, curves):
    places = held_points(finished.plan, results, most=9)
    assert places == list(range(8))
    held = {results[place].id: curves[results[place].id] for place in places if results[place].done}
    explorer = build_explorer(finished.plan, results, places, held, EVEN)
    assert explorer is not None
    assert explorer.note.startswith("This page holds 8 of the 16 points of the study,")
    axes = unpacked(explorer.data)["axes"]
    assert [len(axis["levels"]) for axis in axes] == [1, 2, 2, 2]
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


def test_the_same_numbers_give_the_same_text_without_markup(finished, results, curves, tmp_path):
    first, second = (
        build_explorer(finished.plan, results, range(16), curves, EVEN) for _ in range(2)
    )
    assert first == second
    assert not set(first.data) & set("<>&\"'")
    with pytest.raises(DataFileError, match="there is no such file"):
        read_curves(tmp_path / "summary.nc", finished.plan, [0])


RANDOM = {
    "kind": "self_affine", "rms_height": "0.1 um", "hurst": 0.8, "rolloff_wavelength": "60 um",
    "shortest_wavelength": "30 um", "seed": 3,
}  # fmt: skip


@pytest.fixture(scope="module")
def case():
    return steel(roughness=RANDOM, error_estimate=False, cycles=30)


@pytest.fixture(scope="module")
def file(case, tmp_path_factory):
    path = tmp_path_factory.mktemp("above") / f"{case.case_id}.nc"
    result = run(case)
    write_case(result.dataset, result.history, path, result.loops)
    return path


@pytest.fixture(scope="module")
def above(case, file):
    return read_above(file, case, np.array([0.0, 30.0]))


def test_maps_keep_loads_and_volumes_within_a_255th(file, above):
    assert above.view is not None
    view = above.view
    area = (view.x[1] - view.x[0]) * (view.y[1] - view.y[0])
    assert max(view.x.size, view.y.size) <= 64
    with open_case(file) as stored:
        loads = view.fields["pressure"].sum(axis=(1, 2)) * area
        # Half a square at each end may be dropped, where hardly anything touches.
        assert loads == pytest.approx(stored["normal_force"].values, rel=1e-3)
        volume = view.fields["wear_depth"][-1].sum() * area
        assert volume == pytest.approx(float(stored["wear_volume"][-1]), rel=1e-3)
    units = {"pressure": MEGAPASCAL, "wear_depth": MICROMETRE}
    packed = view.packed(units)
    counts = packed["y"][2], packed["x"][2]
    assert packed["x"][0] + (counts[1] - 1) * packed["x"][1] == pytest.approx(1e6 * view.x[-1])
    for name in MAPS:
        for each, field in zip(packed["fields"][name], view.fields[name], strict=True):
            levels = np.frombuffer(base64.b64decode(each["levels"]), np.uint8).reshape(counts)
            found, wanted = each["scale"] * levels.T, units[name].of(field)
            assert np.abs(found - wanted).max() <= 0.501 / 255 * wanted.max()


def test_bearing_areas_are_those_of_the_figure(file, above):
    with open_case(file) as stored:
        before, after = bearing_heights(stored, [0, 30]).values()
    assert above.heights is not None
    for found, heights in zip(above.heights, (before, after), strict=True):
        share = (np.arange(heights.size) + 0.5) / heights.size
        expected = np.interp(np.linspace(0.0, 1.0, found.size), share, heights)
        assert found == pytest.approx(expected, abs=1e-3 * np.ptp(heights))
    with pytest.raises(CaseFileError, match="no such file"):
        read_above(file.with_name("elsewhere.nc"), steel(roughness=RANDOM), np.array([0.0]))


def test_a_contact_that_is_even_has_no_maps(finished):
    smooth, rough = (
        next(each for each in finished.plan.study.cases().values() if (each.rough is None) == one)
        for one in (True, False)
    )
    for each in (smooth, rough):
        cycles = np.array(each.output_cycles)
        found = read_above(finished.cases / f"{each.case_id}.nc", each, cycles)
        assert found.view is None
        assert (found.heights is None) == (each.rough is None)
