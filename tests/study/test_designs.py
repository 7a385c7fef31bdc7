import copy
import math

import numpy as np
import pytest

from fretwear.study.designs import Grid, LatinHypercube, Range, Sobol


def test_a_grid_takes_every_combination_the_last_axis_fastest():
    assert list(Grid().indices([2, 2])) == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert list(Grid().indices([])) == [()]


def test_zip_pairs_the_lists(studies, content):
    content["design"] = "zip"
    content["vary"] = {"load": ["25 N", "50 N"], "friction": [0.3, 0.4]}
    study = studies.load(content)
    pairs = [(point.case.load, point.case.friction) for point in study.points()]
    assert pairs == [(25.0, 0.3), (50.0, 0.4)]
    assert study.shape == (2,)


RANDOM = {
    "kind": "self_affine",
    "rms_height": "0.1 um",
    "hurst": 0.8,
    "rolloff_wavelength": "60 um",
    "shortest_wavelength": "16 um",
}


def test_seeds_are_short_for_varying_that_of_the_roughness(studies, content):
    content["base"]["roughness"], content["vary"] = RANDOM, {"load": ["25 N", "50 N"]}
    content["base"].pop("cell", None)
    short, long = copy.deepcopy(content), copy.deepcopy(content)
    short["seeds"], long["vary"]["roughness.seed"] = [1, 2, 3], [1, 2, 3]
    ids = [list(studies.load(each).cases()) for each in (short, long)]
    assert ids[0] == ids[1]
    assert len(ids[0]) == 6
    assert studies.load(short, ["roughness.seed=5"]).size == 2
    short["seeds"] = [1, 1, 0.5]
    assert [each.key for each in studies.error(short).problems] == ["seeds[1]", "seeds[2]"]
    long["seeds"] = [4]
    assert [each.key for each in studies.error(long).problems] == ["seeds"]


def test_a_latin_hypercube_has_one_point_in_every_slice():
    design = LatinHypercube(points=50, seed=3)
    linear, logarithmic = design.sample([Range(1.0, 2.0), Range(1.0, 100.0, True)])
    assert sorted(int((value - 1.0) * 50) for value in linear) == list(range(50))
    slices = sorted(int(math.log(value) / math.log(100.0) * 50) for value in logarithmic)
    assert slices == list(range(50))


def test_a_sobol_sequence_fills_every_quarter_evenly():
    x, y = Sobol(points=64, seed=1).sample([Range(0.0, 1.0), Range(0.0, 1.0)])
    counts, _, _ = np.histogram2d(x, y, bins=2, range=[[0, 1], [0, 1]])
    assert counts.tolist() == [[16, 16], [16, 16]]


def test_lists_are_drawn_equally_often():
    (drawn,) = LatinHypercube(points=30).sample([["a", "b", "c"]])
    assert sorted(drawn) == ["a"] * 10 + ["b"] * 10 + ["c"] * 10


@pytest.mark.parametrize("kind", [LatinHypercube, Sobol])
def test_the_seed_decides_the_points(kind):
    ranges = [Range(1.0, 2.0)]
    assert kind(9, 1).sample(ranges) == kind(9, 1).sample(ranges)
    assert kind(9, 1).sample(ranges) != kind(9, 2).sample(ranges)


def sampled(content, kind="sobol", points=16):
    content["design"] = {"kind": kind, "points": points, "seed": 1}
    content["vary"] = {
        "load": {"from": "10 N", "to": "100 N", "scale": "log"},
        "plastic_limit": ["none", "4500 MPa"],
    }
    return content


@pytest.mark.parametrize("kind", ["latin_hypercube", "sobol"])
def test_a_sampled_study_draws_ranges_and_lists(studies, content, kind):
    study = studies.load(sampled(content, kind))
    assert len(study.cases()) == 16
    assert all(10.0 <= case.load <= 100.0 for case in study.cases().values())
    assert sum(math.isinf(case.plastic_limit) for case in study.cases().values()) == 8
    assert study.shape == (16,)


def test_whole_numbers_are_not_drawn_from_a_range(studies, content):
    content = sampled(content)
    content["vary"]["cycles"] = {"from": 100, "to": 1000}
    (problem,) = studies.error(content).problems
    assert problem.key == "vary.cycles"


@pytest.mark.parametrize(
    ("interval", "key", "part"),
    [
        ({"from": "10 N"}, "vary.load.to", "missing"),
        ({"from": "10 N", "to": "5 N"}, "vary.load.to", "more than"),
        ({"from": "10 N", "to": 50}, "vary.load.to", "needs a unit"),
        ({"from": "10 N", "to": "50 N", "scale": "lin"}, "vary.load.scale", "linear or log"),
        ({"from": "10 N", "to": "50 N", "step": 3}, "vary.load.step", "not known"),
    ],
)
def test_a_wrong_range_is_refused(studies, content, interval, key, part):
    content = sampled(content)
    content["vary"]["load"] = interval
    (problem,) = studies.error(content).problems
    assert problem.key == key
    assert part in problem.rule


def test_a_wrong_design_makes_no_other_key_wrong(studies, content):
    content = sampled(content)
    content["design"] = {"kind": "sobol", "points": "many"}
    content["base"]["friction"] = "much"
    assert [each.key for each in studies.error(content).problems] == [
        "base.friction",
        "design.points",
    ]


def sliding(content):
    del content["base"]["tangential_ratio"]
    content["base"]["tangential_load"] = "10 N"
    content["base"]["friction"] = 0.5
    content["invalid"] = "skip"
    return sampled(content)


def test_invalid_points_can_be_skipped(studies, content):
    study = studies.load(sliding(content))
    for point in study.points():
        slides = point.values["load"] * 0.5 <= 10.0
        assert (point.case is None) == slides
        assert bool(point.id) != slides
        assert ("gross sliding" in point.problem) == slides
    assert 0 < len(study.cases()) < len(study.points())


def test_a_study_of_which_nothing_is_left_is_refused(studies, content):
    content = sliding(content)
    content["base"]["friction"] = 0.01
    assert "leaves no point" in str(studies.error(content))


def test_what_no_varied_value_can_mend_is_never_skipped(studies, content):
    content["invalid"] = "skip"
    content["output"] = {"cycles": [5000]}
    assert "beyond the last cycle" in str(studies.error(content))
