import pytest

from fretwear.study.problems import StudyError
from fretwear.study.study import override, select_case

from ..studies import WAVES


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


@pytest.mark.parametrize(
    ("assignment", "there", "gone"),
    [
        ("displacement_amplitude=2 um", ["rig_stiffness"], []),
        ("displacement_ratio=0.5", ["rig_stiffness"], ["displacement_amplitude"]),
        ("rig_stiffness=30 N/um", ["displacement_amplitude"], []),
        ("tangential_ratio=0.5", [], ["displacement_amplitude", "rig_stiffness"]),
        ("indenter={kind: cylinder, radius: 6 mm}", [], ["radius"]),
        ("indenter.radius=6 mm", [], ["radius"]),
        ("blocks=[{cycles: 10}, {cycles: 5, friction: 0.6}]", [], ["cycles"]),
    ],
)
def test_a_set_key_drops_those_it_stands_for_and_no_others(content, assignment, there, gone):
    del content["base"]["tangential_ratio"]
    content["base"] |= {"displacement_amplitude": "1 um", "rig_stiffness": "28 N/um"}
    before = repr(content)
    changed, problems = override(content, [assignment])
    assert not problems
    assert {*there} <= changed["base"].keys()
    assert {*gone}.isdisjoint(changed["base"])
    assert changed["vary"] == content["vary"]
    assert repr(content) == before, "the content given stays as it is"


@pytest.mark.parametrize(
    ("assignment", "key", "words"),
    [
        ("lod=30 N", "--set lod", "did you mean 'load'"),
        ("load", "--set", "name=value"),
        ("load=30", "--set load", "needs a unit"),
        ("load=30 kg", "--set load", "must be a force"),
        ("load=[", "--set load", "YAML"),
        ("tangential_ratio=1.5", "--set tangential_ratio", "gross sliding"),
        ("output.cycles=[0, 1.5]", "--set output.cycles[1]", "whole number"),
    ],
)
def test_a_wrong_assignment_is_refused_in_its_own_words(studies, content, assignment, key, words):
    error = studies.error(content, [assignment])
    assert [problem.key for problem in error.problems] == [key]
    assert words in str(error)
    amplitude = ["roughness.amplitude=1 um"]
    keys = [problem.key for problem in studies.error(content, amplitude).problems]
    assert keys == ["base.roughness.slope_x", "base.roughness.slope_y"]
    content["vary"] = {"roughness": ["none", WAVES]}
    assert studies.error(content, amplitude).problems[0].key == "--set roughness.amplitude"


def test_a_case_is_chosen_by_its_id_which_the_only_one_does_not_need(studies, content):
    file = studies.write(content)
    cases = studies.load(content).cases()
    with pytest.raises(StudyError) as caught:
        select_case(file)
    for case_id, case in cases.items():
        assert case_id in str(caught.value)
        assert select_case(file, case_id) == case
        with pytest.raises(StudyError, match=f"did you mean '{case_id}'"):
            select_case(file, f"{case_id[:-2]}00")
    assert select_case(file, None, ["load=30 N"]).load == 30.0


def test_a_chosen_case_can_be_changed_without_losing_a_bit_of_the_rest(studies, content):
    content["base"]["roughness"] = WAVES
    content["vary"] = {"roughness.amplitude": ["0.1 um", "0.2 um"], "load": ["25 N", "50 N"]}
    file, chosen = studies.write(content), studies.load(content).points()[1]
    changed = select_case(file, chosen.id, ["friction=0.7"])
    assert (changed.friction, changed.load, changed.roughness.amplitude) == (0.7, 50.0, 1e-7)
    assert changed.case_id != chosen.id
    content["design"] = {"kind": "sobol", "points": 4}
    content["vary"] = {"load": {"from": "10 N", "to": "20 N"}}
    file, chosen = studies.write(content), studies.load(content).points()[2]
    assert select_case(file, chosen.id, ["friction=0.7"]).load == chosen.case.load
    # Setting all that is sampled leaves one case.
    assert len(studies.load(content, ["load=30 N"]).cases()) == 1
