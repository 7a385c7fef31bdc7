import math

import numpy as np
import pytest

from fretwear.study.designs import Grid, LatinHypercube, Range, Sobol

from ..studies import SELF_AFFINE


def test_a_grid_takes_every_combination_and_zip_pairs_the_lists(studies, content):
    assert list(Grid().indices([2, 2])) == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert list(Grid().indices([])) == [()]
    vary = {"load": ["25 N", "50 N"], "friction": [0.3, 0.4]}
    study = studies.load(content | {"design": "zip", "vary": vary})
    pairs = [(point.case.load, point.case.friction) for point in study.points()]
    assert (pairs, study.shape) == ([(25.0, 0.3), (50.0, 0.4)], (2,))


def test_seeds_are_short_for_varying_that_of_the_roughness(studies, content):
    content["base"]["roughness"] = SELF_AFFINE
    short = content | {"seeds": [1, 2, 3]}
    long = content | {"vary": {**content["vary"], "roughness.seed": [1, 2, 3]}}
    ids = [list(studies.load(each).cases()) for each in (short, long)]
    assert ids[0] == ids[1]
    assert len(ids[0]) == 6
    assert studies.load(short, ["roughness.seed=5"]).size == 2
    for wrong, keys in ((content | {"seeds": [1, 1, 0.5]}, [1, 2]), (long | {"seeds": [4]}, [""])):
        told = [each.key for each in studies.error(wrong).problems]
        assert told == [f"seeds[{key}]" if key else "seeds" for key in keys]


def test_samples_spread_evenly_and_their_seed_decides_them():
    design = LatinHypercube(points=50, seed=3)
    linear, logarithmic = design.sample([Range(1.0, 2.0), Range(1.0, 100.0, True)])
    assert sorted(int((value - 1.0) * 50) for value in linear) == list(range(50))
    slices = sorted(int(math.log(value) / math.log(100.0) * 50) for value in logarithmic)
    assert slices == list(range(50))
    x, y = Sobol(points=64, seed=1).sample([Range(0.0, 1.0), Range(0.0, 1.0)])
    counts, _, _ = np.histogram2d(x, y, bins=2, range=[[0, 1], [0, 1]])
    assert counts.tolist() == [[16, 16], [16, 16]]
    (drawn,) = LatinHypercube(points=30).sample([["a", "b", "c"]])
    assert sorted(drawn) == ["a"] * 10 + ["b"] * 10 + ["c"] * 10
    for kind in (LatinHypercube, Sobol):
        one, same, other = (kind(9, seed).sample([Range(1.0, 2.0)]) for seed in (1, 1, 2))
        assert one == same != other


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


def test_invalid_points_can_be_skipped_unless_nothing_is_left_or_none_would_do(studies, content):
    base = {**content["base"], "tangential_load": "10 N", "friction": 0.5}
    del base["tangential_ratio"]
    sliding = sampled({**content, "base": base, "invalid": "skip"})
    study = studies.load(sliding)
    for point in study.points():
        slides = point.values["load"] * 0.5 <= 10.0
        assert (point.case is None) == slides
        assert bool(point.id) != slides
        assert ("gross sliding" in point.problem) == slides
    assert 0 < len(study.cases()) < len(study.points())
    base["friction"] = 0.01
    assert "leaves no point" in str(studies.error(sliding))
    late = content | {"invalid": "skip", "output": {"cycles": [5000]}}
    assert "beyond the last cycle" in str(studies.error(late))
