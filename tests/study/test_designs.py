"""Designs of studies, what --set changes, and the table of points."""

import csv
import math

import numpy as np
import pytest

from fretwear.study.mistakes import StudyError
from fretwear.study.plan import Plan, write_points
from fretwear.study.reading import override, select_point

from ..studies import WAVES


def test_zip_pairs_the_lists(studies, content):
    vary = {"load": ["25 N", "50 N"], "friction": [0.3, 0.4]}
    study = studies.load(content | {"design": "zip", "vary": vary})
    pairs = [(point.case.load, point.case.friction) for point in study.points()]
    assert (pairs, study.sizes) == ([(25.0, 0.3), (50.0, 0.4)], {"point": 2})


def test_samples_spread_evenly_and_their_seed_decides_them(studies, content):
    def drawn(points, seed=1, **vary):
        design = {"kind": "sobol", "points": points, "seed": seed}
        study = studies.load(content | {"design": design, "vary": vary})
        return [axis.values for axis in study.axes]

    decades = {"from": "1 N", "to": "100 N", "scale": "log"}
    quarter = {"from": 0.25, "to": 0.5}
    friction, load = drawn(64, friction=quarter, load=decades)
    assert sorted(int((value - 0.25) * 256) for value in friction) == list(range(64))
    assert sorted(int(math.log(value, 100.0) * 64) for value in load) == list(range(64))
    x, y = drawn(64, friction=quarter, tangential_ratio=quarter)
    counts, _, _ = np.histogram2d(x, y, bins=2, range=[[0.25, 0.5], [0.25, 0.5]])
    assert counts.tolist() == [[16, 16], [16, 16]]
    listed, _ = drawn(32, cycles=[100, 200], friction=quarter)
    assert sorted(listed) == [100] * 16 + [200] * 16
    # To six digits, so that no id depends on the last bit of a logarithm.
    assert all(value == float(f"{value:.6g}") for value in (*friction, *load, *x))
    one, same, two = (drawn(9, seed, friction=quarter) for seed in (1, 1, 2))
    assert one == same != two


def sampled(content, kind="sobol", points=16):
    content["design"] = {"kind": kind, "points": points, "seed": 1}
    content["vary"] = {
        "load": {"from": "10 N", "to": "100 N", "scale": "log"},
        "plastic_limit": ["none", "4500 MPa"],
    }
    return content


def test_invalid_points_can_be_skipped_unless_nothing_is_left_or_none_would_do(studies, content):
    base = {**content["base"], "tangential_load": "10 N", "friction": 0.5}
    del base["tangential_ratio"]
    sliding = sampled({**content, "base": base, "invalid": "skip"})
    study = studies.load(sliding)
    for point in study.points():
        slides = point.values["load"] * 0.5 <= 10.0
        assert (point.case is None) == slides
        assert bool(point.id) != slides
        assert ("gross sliding" in point.mistake) == slides
    assert 0 < len(study.cases()) < len(study.points())
    base["friction"] = 0.01
    assert "leaves no point" in str(studies.error(sliding))
    late = content | {"invalid": "skip", "output": {"cycles": [5000]}}
    assert "beyond the last cycle" in str(studies.error(late))


def test_a_set_value_replaces_base_and_ends_the_variation(studies, content):
    (case,) = studies.load(content, ["load=30 N"]).cases().values()
    assert case.load == 30.0
    content["base"]["roughness"] = WAVES
    changes = ["roughness.amplitude=0.1 um", "tangential_load=5 N", "output.cycles=[0, 7]"]
    study = studies.load(content, [*changes, "title=Seven"])
    assert study.title == "Seven"
    for case in study.cases().values():
        assert (case.roughness.amplitude, case.tangential_load) == (1e-7, 5.0)
        assert case.output_cycles == (0, 7, 1000)


def test_a_set_key_drops_those_it_stands_for_and_no_others(content):
    del content["base"]["tangential_ratio"]
    content["base"] |= {"displacement_amplitude": "1 um", "rig_stiffness": "28 N/um"}
    written = repr(content)
    for assignment, gone in {
        "displacement_amplitude=2 um": [],
        "displacement_ratio=0.5": ["displacement_amplitude"],
        "rig_stiffness=30 N/um": [],
        "tangential_ratio=0.5": ["displacement_amplitude", "rig_stiffness"],
        "indenter={kind: cylinder, radius: 6 mm}": ["radius"],
        "indenter.radius=6 mm": ["radius"],
        "blocks=[{cycles: 10}, {cycles: 5, friction: 0.6}]": ["cycles"],
    }.items():
        changed, mistakes = override(content, [assignment])
        assert not mistakes
        assert content["base"].keys() - changed["base"].keys() == {*gone}, assignment
        assert changed["vary"] == content["vary"]
        assert repr(content) == written, "the content given stays as it is"


def test_a_wrong_assignment_is_refused_in_its_own_words(studies, content):
    for assignment, key, words in (
        ("lod=30 N", "--set lod", "did you mean 'load'"),
        ("load", "--set", "name=value"),
        ("load=30", "--set load", "needs a unit"),
        ("load=30 kg", "--set load", "must be a force"),
        ("load=[", "--set load", "YAML"),
        ("tangential_ratio=1.5", "--set tangential_ratio", "gross sliding"),
        ("output.cycles=[0, 1.5]", "--set output.cycles[1]", "whole number"),
    ):
        (mistake,) = studies.error(content, [assignment]).mistakes
        assert mistake.key == key
        assert words in str(mistake)
    amplitude = ["roughness.amplitude=1 um"]
    keys = [mistake.key for mistake in studies.error(content, amplitude).mistakes]
    assert keys == ["base.roughness.slope_x", "base.roughness.slope_y"]
    content["vary"] = {"roughness": ["none", WAVES]}
    assert studies.error(content, amplitude).mistakes[0].key == "--set roughness.amplitude"


def test_a_case_is_chosen_by_its_id_which_the_only_one_does_not_need(studies, content):
    study = studies.load(content)
    cases = study.cases()
    with pytest.raises(StudyError) as caught:
        select_point(study)
    for case_id, case in cases.items():
        assert case_id in str(caught.value)
        assert select_point(study, case_id).case == case
        with pytest.raises(StudyError, match=f"did you mean '{case_id}'"):
            select_point(study, f"{case_id[:-2]}00")
    assert select_point(studies.load(content, ["load=30 N"])).case.load == 30.0


def test_a_chosen_case_can_be_changed_without_losing_a_bit_of_the_rest(studies, content):
    content["base"]["roughness"] = WAVES
    content["vary"] = {"roughness.amplitude": ["0.1 um", "0.2 um"], "load": ["25 N", "50 N"]}
    study = studies.load(content)
    chosen = study.points()[1]
    changed = select_point(study, chosen.id, ["friction=0.7"]).case
    assert (changed.friction, changed.load, changed.roughness.amplitude) == (0.7, 50.0, 1e-7)
    assert changed.case_id != chosen.id
    content["design"] = {"kind": "sobol", "points": 4}
    content["vary"] = {"load": {"from": "10 N", "to": "20 N"}}
    study = studies.load(content)
    chosen = study.points()[2]
    assert select_point(study, chosen.id, ["friction=0.7"]).case.load == chosen.case.load
    # Setting all that is sampled leaves one case.
    assert len(studies.load(content, ["load=30 N"]).cases()) == 1


def table(study):
    file = study.file.with_name("points.csv")
    write_points(study, file)
    with file.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_the_table_of_points_is_in_si_units_to_the_last_bit(studies, content):
    content["vary"]["plastic_limit"] = ["none", "4500 MPa"]
    study = studies.load(content)
    rows = table(study)
    assert [float(row["load"]) for row in rows] == [25.0, 25.0, 50.0, 50.0]
    assert [float(row["plastic_limit"]) for row in rows] == [4.5e9, float("inf")] * 2
    for row, point in zip(rows, study.points(), strict=True):
        assert float(row["hertz_radius"]) == point.case.hertz_radius
        assert float(row["cell_x"]) == point.case.grid_spacing[0]
        assert float(row["estimated_seconds"]) > 0
        assert int(row["cells"]) > 0
        assert row["mistake"] == ""
    # What is varied as a whole has a column in the words of the file.
    content["vary"] = {"roughness": ["none", WAVES], "youngs_modulus": [["208 GPa", "70 GPa"]]}
    smooth, rough = table(studies.load(content))
    words = "{kind: wavy, amplitude: 0.2 um, slope_x: 5.7 deg, slope_y: 1 deg}"
    assert (smooth["roughness"], rough["roughness"]) == ("none", words)
    assert float(rough["roughness_amplitude"]) == 2e-7
    assert rough["youngs_modulus"] == "[208 GPa, 70 GPa]"
    assert float(rough["youngs_modulus_2"]) == 70e9


def test_invalid_points_are_in_the_table_with_the_reason_and_warnings_once_each(studies, content):
    content["invalid"] = "skip"
    content["vary"] = {"tangential_ratio": [0.8, 1.5]}
    good, bad = table(studies.load(content))
    assert (bad["case_id"], bad["cells"], bad["tangential_ratio"]) == ("", "", "1.5")
    assert "gross sliding" in bad["mistake"]
    assert good["case_id"]
    assert list(Plan(studies.load(content)).rows())[1][0] == "(invalid)"
    content["vary"] = {"plastic_limit": ["500 MPa", "4500 MPa"]}
    plan = Plan(studies.load(content))
    ((what, cases),) = plan.warnings.items()
    assert what.startswith("yields all over")
    assert list(cases) == [plan.points[0].id]
