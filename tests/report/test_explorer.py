"""What the page's explorer holds is what the case files say, of as many cases as fit."""

import base64
import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fretwear.data.files import open_case, open_history
from fretwear.report.explorer import (
    MISSING,
    PROFILES,
    Packer,
    build_explorer,
    evenly,
    run_lengths,
    select_points,
    thinned_levels,
)
from fretwear.report.results import point_results


class Unpacked:
    """The header and the arrays, read as the page's script reads them."""

    def __init__(self, text: str) -> None:
        content = gzip.decompress(base64.b64decode(text))
        length = int.from_bytes(content[:4], "little")
        self.header: dict[str, Any] = json.loads(content[8 : 8 + length])
        self.arrays = content[8 + length :]

    def profile(self, case: dict[str, Any], name: str) -> np.ndarray:
        shape = (len(case["cycles"]), case["x"][2])
        packed = case["profiles"][name]
        whole = np.frombuffer(self.arrays, "<i2", shape[0] * shape[1], packed["at"])
        return whole.reshape(shape) * np.array(packed["scales"])[:, None]

    def steps(self, case: dict[str, Any], name: str) -> np.ndarray:
        steps = case["steps"]
        return np.frombuffer(self.arrays, "<f4", steps["number"], steps[name])


@pytest.fixture(scope="module")
def unpacked(finished) -> Unpacked:
    results = point_results(finished.plan, finished.summary, {})
    explorer = build_explorer(finished.plan, results, finished.cases)
    assert explorer is not None
    assert explorer.note == ""
    return Unpacked(explorer.data)


def test_profiles_are_those_of_the_files_to_a_32767th(finished, unpacked: Unpacked) -> None:
    assert len(unpacked.header["cases"]) == 11
    for case in unpacked.header["cases"]:
        with open_case(finished.cases / f"{case['id']}.nc") as stored:
            first, spacing, count = case["x"]
            x = stored["x"].values[:count]
            assert first + spacing * np.arange(count) == pytest.approx(1e6 * x, rel=1e-9)
            assert x[-1] > 1.1 * float(stored["contact_half_width_x"].max())
            for name in PROFILES:
                size = {"MPa": 1e6, "µm": 1e-6, "nm": 1e-9}[unpacked.header["words"][name]["unit"]]
                expected = stored[name].values[:, :count, 0] / size
                error = np.abs(unpacked.profile(case, name) - expected)
                assert (error <= 0.51 / 32767 * np.abs(expected).max(axis=1, keepdims=True)).all()


def test_zones_are_the_states_of_the_cells(finished, unpacked: Unpacked) -> None:
    for case in unpacked.header["cases"]:
        with open_case(finished.cases / f"{case['id']}.nc") as stored:
            for cycle, pairs in enumerate(case["states"]):
                states = np.repeat(pairs[::2], pairs[1::2])
                expected = stored["contact_state"].values[cycle, : case["x"][2], 0]
                assert states.tolist() == expected.tolist()


def test_histories_hold_every_step(finished, unpacked: Unpacked) -> None:
    case = unpacked.header["cases"][0]
    with open_history(finished.cases / f"{case['id']}.nc") as history:
        assert unpacked.steps(case, "cycle") == pytest.approx(history["cycle"].values, rel=1e-6)
        width = 1e6 * history["contact_half_width_x"].values
        assert unpacked.steps(case, "contact_half_width_x") == pytest.approx(width, rel=1e-6)


def test_points_without_results_keep_their_reasons(finished, unpacked: Unpacked) -> None:
    points = unpacked.header["points"]
    assert len(points) == len(finished.plan.points) == 16
    invalid = [point for point in points if point["status"] == "invalid"]
    assert len(invalid) == 4
    assert all(point["case"] == -1 and "Q must be less" in point["reason"] for point in invalid)


def test_the_case_that_has_worn_most_comes_first(unpacked: Unpacked) -> None:
    start = unpacked.header["points"][unpacked.header["start"]]
    volumes = [case["scalars"]["wear_volume"][-1] for case in unpacked.header["cases"]]
    assert start["case"] == int(np.argmax(volumes))


def test_of_many_points_a_grid_of_fewer_levels_is_held(finished) -> None:
    results = point_results(finished.plan, finished.summary, {})
    explorer = build_explorer(finished.plan, results, finished.cases, most=9)
    assert explorer is not None
    header = Unpacked(explorer.data).header
    assert explorer.note.startswith("This page holds 8 of the 16 points of the study,")
    assert [len(axis["levels"]) for axis in header["axes"]] == [1, 2, 2, 2]
    assert [point["number"] for point in header["points"]] == list(range(1, 9))


def test_levels_are_thinned_where_there_are_most_and_keep_their_ends() -> None:
    assert thinned_levels([10, 10, 10], 300) == [
        evenly(10, 6),
        evenly(10, 7),
        evenly(10, 7),
    ]
    assert thinned_levels([1000], 3) == [[0, 500, 999]]
    assert thinned_levels([2, 3], 6) == [[0, 1], [0, 1, 2]]


def test_if_no_chosen_point_is_done_those_that_are_done_are_held(finished) -> None:
    done = {5, 6, 9}
    assert select_points(finished.plan, done, 2) == [5, 9]
    assert set(select_points(finished.plan, {0}, 2)) & {0}


def test_one_place_of_many_is_the_first() -> None:
    assert evenly(7, 1) == [0]
    assert evenly(3, 7) == [0, 1, 2]


def test_runs_tell_states_and_how_long_they_last() -> None:
    assert run_lengths(np.array([2, 2, 1, 0, 0, 0], dtype=np.int8)) == [2, 2, 1, 1, 0, 3]
    assert run_lengths(np.array([1], dtype=np.int8)) == [1, 1]


def test_missing_values_and_rows_of_zeros_are_packed() -> None:
    packer = Packer()
    packed = packer.add_rounded([[np.nan, 2.0, -1.0], [0.0, 0.0, 0.0]])
    text = packer.text({"words": "µ </script>"})
    unpacked = Unpacked(text)
    assert unpacked.header == {"words": "µ </script>"}
    whole = np.frombuffer(unpacked.arrays, "<i2", 6, packed["at"]).reshape(2, 3)
    assert whole[0].tolist() == [MISSING, 32767, -16384]
    assert packed["scales"][0] == pytest.approx(2.0 / 32767)
    assert not whole[1].any()


def test_the_same_numbers_give_the_same_text_without_markup(finished) -> None:
    results = point_results(finished.plan, finished.summary, {})
    first, second = (build_explorer(finished.plan, results, finished.cases) for _ in range(2))
    assert first == second
    assert not set(first.data) & set("<>&\"'")


def test_a_case_without_a_file_is_named(finished, tmp_path: Path) -> None:
    from fretwear.data.safe import CaseFileError

    results = point_results(finished.plan, finished.summary, {})
    with pytest.raises(CaseFileError, match=next(iter(finished.plan.study.cases()))):
        build_explorer(finished.plan, results, tmp_path)
