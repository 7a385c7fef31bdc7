"""A study file: what is read, what is refused with line, key, value and rule."""

import copy
import os
import re
from pathlib import Path

import pytest
import yaml

from fretwear.study.problems import in_words
from fretwear.study.case import Case
from fretwear.study.problems import StudyError
from fretwear.study.reading import load_study
from fretwear.study.yamlfile import MAX_BYTES, read_document

from ..studies import WAVES, steel

STUDIES = Path(__file__).parents[2] / "studies"


def change(content, key, value):
    """Set a dotted key of a study's content; None removes it."""
    *sections, last = key.split("/")
    for name in sections:
        content = content.setdefault(name, {})
    content[last] = value
    if value is None:
        del content[last]


# Changes | @key = value, where those told are not those changed | parts of the rule or the hint;
# with a star those that the JSON Schema does not know.
BAD_VALUES = """
base/lod: 50 N | not a case parameter | did you mean 'load'
vary/frction: [1] | did you mean 'friction'
titel: x | did you mean 'title'
load: 5 N | base.load
output/cycle: [1] | did you mean 'cycles'
output/stress: {depth: 0.5} | @output.stress.depth = 0.5 | needs a unit
output/stress: {deph: 0.5 mm} | @output.stress.deph = 0.5 mm | did you mean 'depth'
output/stress: {cycle: 3} | @output.stress.cycle = 3 | did you mean 'cycles'
output/stress: {cycles: [-1]} | @output.stress.cycles[0] = -1 | 0
* output/stress: {fatigue_strength: 1 GPa} | without strength_exponent
output/stress: [0] | must be a mapping
base/radius: ~ | is missing | such as radius: 10 mm
base/cycles: ~ | is missing | cycles: 30000
base/tangential_load: 2 N | is redundant | exactly one
vary/tangential_load: [2 N] | @vary.tangential_load = | exactly one
base/tangential_ratio: ~ | is missing, and so are tangential_load, sliding_amplitude | exactly one
* base/radius: 10 N | must be a length | is a force
base/friction: 0.5 N | plain number
base/load: 50 | needs a unit | '50 N'
base/load: '50' | needs a unit
base/youngs_modulus: [1 GPa, 2 GPa, 3 GPa] | a list of 3
base/roughness: {amplitude: 0.2 um, slope_x: 1 deg, slope_y: 1} | @base.roughness.slope_y = 1 | unit
vary/load: [50 N, 50 N] | @vary.load[1] = 50 N | same value
vary/load: [25 N, 50] | @vary.load[1] = 50 | needs a unit
base/load: -50 N | larger than 0
* base/radius: 0 mm | larger than 0
* base/youngs_modulus: [1 GPa, 0 GPa] | @base.youngs_modulus[1] = 0 GPa | larger than 0
* base/wear_coefficient: 0 / Pa | larger than 0
* base/plastic_limit: 0 MPa | larger than 0
base/tangential_ratio: 0 | larger than 0
base/cycles: 0 | at least 1
base/cycles: many | whole number
base/tolerance: 0.5 | at most 0.1
* base/cell: 0 um | larger than 0
base/cell: [1 um, 2] | @base.cell[1] = 2 | needs a unit
base/slip_model: jager | did you mean 'jaeger'
base/poisson_ratio: -1 | larger than -1
base/poisson_ratio: 0.6 | at most 0.5
base/friction: 0 | larger than 0
base/friction: true | plain number
* base/friction: .nan | finite
* base/friction: HUGE | @base.friction = 1000 | finite
base/cycles: HUGE | @base.cycles = 1000 | whole number
base/plastic_limit: .inf | write none
base/plastic_limit: None | a pressure | or none
vary/roughness: {amplitude: [1 um]} | roughness.amplitude: [
* base/tangential_ratio: 1 | gross sliding
* base/plastic_limit: 0.1 MPa | @base.plastic_limit = 100 kPa | too low to carry
vary/load: [] | empty list
vary/load: 50 N | must be a list | [50 N]
* vary/load: [50 N, 25 N, 0.05 kN] | @vary.load[2] = 0.05 kN | vary.load[0]
* vary/friction: [0.3, '0.30'] | @vary.friction[1] = 0.30 | same value
* vary/friction: [COURSE1, COURSE2] | @vary.friction[1] = COURSE2 | same value
* vary/load: {from: 1 N, to: 2 N} | range
* output/cycles: [0, 1001] | @output.cycles = 1001 | beyond the last cycle, 1000
output/cycles: [0, 1.5] | @output.cycles[1] = 1.5 | whole number
output/cycles: [0, -1] | @output.cycles[1] = -1 | at least 0
output/cycles: 100 | must be auto, or a list
* output/cycles: [5, 5] | @output.cycles[1] = 5 | given twice
output: [5] | must hold keys
base/roughness: rough | none or a roughness
* base/roughness: {kind: measured, file: no.x3p} | @base.roughness.file = no.x3p | is no file:
base/roughness: {kind: wavy, WAVES, slope_x: 5.7} | @base.roughness.slope_x = 5.7 | '5.7 deg'
base/roughness: {kind: wavy, WAVES, slop: 1} | @base.roughness.slop = 1 | mean 'slope_
base/roughness: {kind: fractal, WAVES} | @base.roughness.kind = fractal | must be wavy
* base/roughness: {kind: wavy, WAVES}, base/cell: [2 um, 2 um] | @base.cell = [2 um, 2 um]
   | too coarse for the roughness | [1 um, 2 um] or finer would be fine
* base/cell: 40 um | @base.cell = [40 um, 40 um] | too coarse for the contact
design: gird | did you mean 'grid'
design: {kind: sobol} | @design.points = | is missing
design: {kind: grid, points: 4} | @design.points = 4 | not known
invalid: ignore | stop or skip
title: 7 | must be text
title: LONG | @title = xxx | 200 characters
* vary: {load: [25 N, 50 N], friction: [0.3, 0.4, 0.5]}, design: zip | @vary = | load has 2
   | friction has 3
vary: {load: [50 N, 50 N], friction: [0.5, 0.5]}, design: zip | @vary = load 50 N, friction 0.5
   | point 2 the same as point 1
* base/tangential_ratio: ~, base/tangential_load: 10 N, vary/friction: [0.3, 1]
   | @base.tangential_load = 10 N | gross sliding | load = 25 N, friction = 0.3
* vary/tangential_ratio: [0.5, 1.0] | @vary.tangential_ratio[1] = 1 | gross sliding
base/roughness: {kind: wavy, WAVES}, vary/roughness.amplitude: 0.2 um
   | @vary.roughness.amplitude = 0.2 um | write [0.2 um]
* vary: {roughness: [none, {kind: wavy, WAVES}], roughness.amplitude: [0.1 um]}
   | @vary.roughness = | roughness.amplitude varies a part
* vary/roughness.amplitude: [1 um] | @base.roughness = none | the other parts
* base/roughness: {kind: wavy, WAVES}, vary/roughness.rms_height: [1 um]
   | @vary.roughness.rms_height = [1 um] | is not a parameter of wavy | amplitude, slope_x, slope_y
DRAWN, vary/load: {from: 10 N} | @vary.load.to = | missing
* DRAWN, vary/load: {from: 10 N, to: 5 N} | @vary.load.to = 5 N | more than
DRAWN, vary/load: {from: 1 N, to: 50} | @vary.load.to = 50 | needs a unit
DRAWN, vary/load: {from: 1 N, to: 9 N, scale: lin} | @vary.load.scale = lin | linear or log
DRAWN, vary/load: {from: 1 N, to: 9 N, step: 3} | @vary.load.step = 3 | not known
DRAWN, vary/cycles: {from: 100, to: 1000} | @vary.cycles = {from: 100, to: 1000} | cannot be drawn
* vary: {load: LOADS, cycles: COUNTS} | @vary = | 360000 points
"""
WORDS = {
    "HUGE": f"{10**400}",
    "LONG": 201 * "x",
    "COURSE1": "{cycles: [0, 9], values: [0.2, 0.6]}",
    "COURSE2": f"{{cycles: [0, 9], values: [0.2, {0.6 + 1e-14}]}}",
    "WAVES": "amplitude: 0.2 um, slope_x: 5.7 deg, slope_y: 1 deg",
    "DRAWN": "design: {kind: sobol, points: 16, seed: 1}",
    "LOADS": f"[{', '.join(f'{n} N' for n in range(1, 601))}]",
    "COUNTS": f"{[*range(1, 601)]}",
}


@pytest.mark.parametrize("row", re.sub(r"\n +", " ", BAD_VALUES.strip()).splitlines())
def test_one_mistake_is_refused_once_with_file_key_value_and_rule(studies, validator, content, row):
    for word, text in WORDS.items():
        row = row.replace(word, text)
    beyond_schema = row.startswith("* ")
    written, *parts = row.removeprefix("* ").split(" | ")
    changes = yaml.safe_load(f"{{{written}}}")
    if parts[0].startswith("@"):
        key, value = parts.pop(0)[1:].split(" =")
    else:
        ((place, given),) = changes.items()
        key, value = place.replace("/", "."), in_words(given)
    value = value.strip()[:57]
    if not any(place.startswith(("vary", "design")) for place in changes):
        del content["vary"]
    for place, new in changes.items():
        change(content, place, new)
    error = studies.error(content)
    (problem,) = error.problems
    assert validator.is_valid(content) == beyond_schema
    assert problem.key == key
    assert problem.value.startswith(value)
    assert bool(problem.value) == bool(value)
    for part in (str(studies.folder / "study.yaml"), key, value):
        assert part in str(error)
    for part in parts:
        assert part in f"{problem.rule} {problem.hint}"


def test_the_same_rule_broken_all_over_is_not_said_a_hundred_times(studies, content):
    del content["base"]["tangential_ratio"]
    content["vary"] = {
        "load": [f"{10 + number} N" for number in range(20)],
        "tangential_load": [f"{100 + number} N" for number in range(20)],
    }
    problems = studies.error(content).problems
    assert len(problems) < 12
    assert "(at load = 10 N, and at 19 more combinations)" in problems[0].rule
    assert "wrong in the same way for 12 more" in problems[-1].rule


def test_all_problems_of_a_file_are_said_at_once_in_the_order_of_its_lines(studies):
    error = studies.error(
        """\
titel: x
base:
  radius: 10 N
  youngs_modulus: 208
  poisson_ratio: 0.7
  laod: 50 N
  tangential_load: 20 N
  tangential_ratio: 0.4
  friction: 0.5
  wear_coefficient: 7e-13 / Pa
  plastic_limit: none
  roughness: {kind: wavy, amplitude: 0.2 um, slope_x: 5.7, slope_y: 1 deg}
vary:
  plastic_limit: [none, 0 MPa]
output:
  cycles: [0, 1.5]
"""
    )
    keys = ["titel", "base.radius", "base.youngs_modulus", "base.poisson_ratio", "base.laod"]
    keys += ["base.tangential_load", "base.roughness.slope_x", "vary.plastic_limit[1]"]
    lines = dict(zip(keys, (1, 3, 4, 5, 6, 7, 12, 14), strict=True))
    lines |= {"output.cycles[1]": 16, "base.cycles": None}
    assert [(problem.key, problem.line) for problem in error.problems] == [*lines.items()]
    again = copy.deepcopy(error)
    assert (str(again), again.problems) == (str(error), error.problems)
    assert "10 problems" in str(again)


def test_one_mistake_hides_no_other_and_makes_none(studies, content):
    content["base"].update({"wear_coefficient": "1 N", "tangential_ratio": 2})
    content["output"] = {"cycles": [5000]}
    wrong = ["base.tangential_ratio", "base.wear_coefficient", "output.cycles"]
    assert [problem.key for problem in studies.error(content).problems] == wrong
    content["design"] = {"kind": "sobol", "points": "many"}
    content["vary"] = {"load": {"from": "10 N", "to": "100 N"}}
    assert [each.key for each in studies.error(content).problems] == [*wrong, "design.points"]


def test_a_file_without_keys_and_a_key_without_a_value_are_refused(studies, content):
    for text in ("just text\n", "[1, 2]\n", "42\n"):
        assert "must hold keys" in str(studies.error(text))
    for key in ("load", "plastic_limit", "roughness", "cycles", "slip_model"):
        text = studies.write({**content, "base": content["base"] | {key: "VALUE"}}).read_text()
        problems = studies.error(text.replace("VALUE", "")).problems
        assert "no value" in next(p.rule for p in problems if p.key == f"base.{key}")


@pytest.mark.parametrize(
    "name", ["a b", "-x", "", "a;b", "ä", "$(touch harm)", "it's", "..", "a\nb", "{x}"]
)
def test_a_name_that_could_hurt_in_a_path_is_refused(studies, content, name):
    with pytest.raises(StudyError, match=r"names the folder of its results(.|\n)*rename the file"):
        load_study(studies.write(content, f"{name}.yaml"))


def test_a_study_says_its_points_in_order(studies, content):
    small = studies.load(content).cases()
    content["vary"] = {"plastic_limit": ["none", "4500 MPa"], "load": ["25 N", "50 N"]}
    study = studies.load(content)
    assert (study.name, study.title, study.shape) == ("study", "Two loads", (2, 2))
    assert [axis.coordinate for axis in study.axes] == ["plastic_limit", "load"]
    assert [point.index for point in study.points()] == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert [point.case.load for point in study.points()] == [25.0, 50.0, 25.0, 50.0]
    assert study.points()[2].values == {"plastic_limit": 4.5e9, "load": 25.0}
    assert study.points()[2].labels == {"plastic_limit": "4500 MPa", "load": "25 N"}
    assert set(small) < set(study.cases()), "ids do not depend on what else is varied"
    content["vary"] = {"roughness": [{**WAVES, "slope_y": f"{slope} deg"} for slope in (1, 2)]}
    labels = [point.labels["roughness"] for point in studies.load(content).points()]
    assert [label.partition("slope_y: ")[2] for label in labels] == ["1 deg}", "2 deg}"]
    del content["vary"], content["title"]
    study = studies.load(content)
    assert (len(study.cases()), study.sizes, study.title) == (1, {}, "study")


def test_points_are_the_cases_that_python_would_make(studies, content):
    content["base"]["roughness"] = WAVES
    content["vary"] = {
        "roughness.amplitude": ["0 um", "0.2 um"],
        "plastic_limit": ["none", "4500 MPa"],
        "youngs_modulus": ["208 GPa", ["208 GPa", "70 GPa"]],
    }
    for point in studies.load(content).points():
        assert point.case.replace() == point.case
    rough = steel(roughness=WAVES, output_cycles=(0, 100))
    assert studies.load(content).points()[4].case == rough


def test_blocks_of_loading_can_be_varied(studies, content):
    del content["base"]["cycles"]
    two, one = [{"cycles": 200, "friction": 0.6}, {"cycles": 300}], [{"cycles": 400}]
    content["vary"] = {"blocks": [two, one]}
    cases = studies.load(content).cases().values()
    assert [(case.cycles, len(case.blocks)) for case in cases] == [(500, 2), (400, 0)]
    content["output"] = {"cycles": [450]}
    (problem,) = studies.error(content).problems
    assert problem.rule.startswith("is beyond the last cycle, 400 (at blocks = [{cycles: 400}])")


TANGENTIAL = ("tangential_ratio", "tangential_load")
RIG = {"displacement_amplitude": "0.4 um"}
ALL_GIVE = {
    "a ratio": ({}, [{"tangential_ratio": 0.5}, {"tangential_ratio": 0.9}]),
    "another way": ({}, [{"tangential_load": "10 N"}, {"displacement_ratio": 0.5}]),
    # What only the first block has is not that of the second.
    "a rig of one": ({}, [{**RIG, "rig_stiffness": "9 N/um"}, RIG]),
    "one rig": ({"rig_stiffness": "9 N/um"}, [RIG, {"displacement_amplitude": "0.5 um"}]),
    "loads": ({"tangential_ratio": 0.5}, [{"load": "50 N"}, {"load": "60 N"}]),
    "friction": ({"tangential_ratio": 0.5}, [{"friction": 0.5}, {"friction": 0.7}]),
}


@pytest.mark.parametrize(("given", "blocks"), ALL_GIVE.values(), ids=ALL_GIVE)
def test_what_all_blocks_give_need_not_be_given_once_more(
    studies, content, validator, given, blocks
):
    """The case is that with the first block's values in base, and so is each point of a study."""
    first = {name: each for name, each in blocks[0].items() if name != "rig_stiffness"}
    blocks = [{"cycles": 100 * number, **block} for number, block in enumerate(blocks, start=1)]
    base = {**content["base"], "load": "50 N", **given}
    for name in ("cycles", *first, *(() if given.get("tangential_ratio") else TANGENTIAL)):
        base.pop(name, None)
    content |= {"base": {**base, "blocks": blocks}, "vary": {}}
    (short,) = studies.load(content).cases().values()
    assert validator.is_valid(content)
    content["base"] |= first
    (full,) = studies.load(content).cases().values()
    assert (short, short.case_id) == (full, full.case_id)
    assert short.scalar_coordinates() == full.scalar_coordinates()
    assert [*short.in_blocks()] == [*full.in_blocks()]
    assert Case(**base, blocks=blocks).case_id == full.case_id
    # Blocks that vary have a first block each.
    content |= {"base": base, "vary": {"blocks": [blocks, blocks[::-1]]}}
    assert validator.is_valid(content)
    there, back = studies.load(content).cases().values()
    assert there == full
    forth = [block.loading for _, block in full.in_blocks()]
    assert [block.loading for _, block in back.in_blocks()] == forth[::-1]
    # One block without it would have nothing to fall back on.
    content |= {"base": {**base, "blocks": [*blocks, {"cycles": 5}]}, "vary": {}}
    (problem,) = studies.error(content).problems
    assert "is missing" in problem.rule
    assert not validator.is_valid(content)


def test_what_is_wrong_with_the_first_block_is_told_in_its_place(studies, content):
    for name in ("cycles", *TANGENTIAL):
        content["base"].pop(name, None)
    blocks = [{"cycles": 200, "tangential_ratio": 1.5}, {"cycles": 300, "tangential_ratio": 0.5}]
    content["base"]["blocks"] = blocks
    (problem,) = studies.error(content).problems
    assert problem.key == "base.blocks[0].tangential_ratio"
    assert "gross sliding" in problem.rule
    content["vary"]["blocks"] = [blocks[1:], blocks]
    del content["base"]["blocks"]
    (problem,) = studies.error(content).problems
    assert problem.key == "vary.blocks[1][0].tangential_ratio"
    # A block that cannot be read may give what seems to be missing.
    content["vary"]["blocks"] = [[{"cycles": 20, "tangential_ratio": "much"}]]
    (problem,) = studies.error(content).problems
    assert problem.key == "vary.blocks[0][0].tangential_ratio"


def test_a_mistake_in_a_block_is_told_with_its_line(studies, content):
    del content["base"]["cycles"]
    content["base"]["blocks"] = [{"cycles": 200, "radius": "1 mm"}, {"friction": "0.5 N"}]
    problems = studies.error(content).problems
    keys = ("base.blocks[0].radius", "base.blocks[1].cycles", "base.blocks[1].friction")
    assert {problem.key for problem in problems} == {*keys}
    text = (studies.folder / "study.yaml").read_text().splitlines()
    for problem in (problem for problem in problems if problem.line):
        assert problem.value in text[problem.line - 1]


def read(folder, text):
    file = folder / "study.yaml"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_document(file)


def refusal(folder, text):
    with pytest.raises(StudyError) as caught:
        read(folder, text)
    assert str(folder / "study.yaml") in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("texts", "words"),
    [
        (["base:\n  load: 1 N\n  load: 2 N\n"], "first in line 2"),
        # YAML 1.2 makes a key of a word that ends in a colon, the library that reads it a text.
        (["a: [1, 010:, 3]\n", "a: {b: c:}\n"], "key without a value"),
        (["1: a\n", "{[1, 2]: a}\n", "? {a: b}\n: c\n", "true: a\n"], "not text"),
        (["a: !x y\n", "a: !!python/name:os.system x\n"], "cannot be read"),
        (["a: &x {b: 1}\nc:\n  <<: *x\n"], "merge"),
    ],
)
def test_keys_and_tags_that_no_study_has_are_problems(tmp_path, texts, words):
    for text in texts:
        (problem,) = read(tmp_path, text).problems
        assert words in problem.rule
        if "load" in text:
            assert (problem.key, problem.value, problem.line) == ("base.load", "2 N", 3)


@pytest.mark.parametrize(
    ("texts", "part"),
    [
        (["a: [1, 2\n", "a: b: c\n", "a:\n\t- b\n"], "not YAML"),
        (["a: 1\n---\nb: 2\n"], "more than one document (line 2)\n    leave out the line ---"),
        (["a:\tb\n", "a: \tb\n"], "use spaces instead of tabs"),
        (["a:\n  b: 1\n   c: 2\n"], "keys of a section begin in the same column"),
        (["a: %50\n"], "a percent sign follows its number: 2 %"),
        (["a: @b\n"], "(line 1)\n    put a value that begins with this character in quotes"),
        (["a: *b\n", "a: \x00\n"], "not YAML"),
        (["a: 3\u20284\n"], "U+2028 in line 1"),
        (["a: 1\nb: [\x851]\n"], "U+0085 in line 2"),
        (["", "# only a comment\n"], "empty"),
        ([b"a: \xff\xfe\n"], "not UTF-8"),
        (["[" * 1000, "{a: " * 1000], "levels deep"),
        (["a: " + "x" * MAX_BYTES], "larger than 1000 kB"),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_reason(tmp_path, texts, part):
    assert all(part in refusal(tmp_path, text) for text in texts)


def test_aliases_are_followed_but_cannot_explode(tmp_path):
    assert read(tmp_path, "a: &x [1]\nb: *x\n").data == {"a": [1], "b": [1]}
    levels = [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}' if n else 'x'] * 10)}]" for n in range(9)]
    assert "more than" in refusal(tmp_path, "\n".join(levels))
    assert "levels deep" in refusal(tmp_path, "a: &x [*x]\n")


def test_a_pipe_is_refused_without_waiting_and_a_byte_order_mark_is_no_text(tmp_path):
    os.mkfifo(tmp_path / "pipe.yaml")
    with pytest.raises(StudyError, match="not a regular file"):
        read_document(tmp_path / "pipe.yaml")
    assert read(tmp_path, b"\xef\xbb\xbfa: 1\n").data == {"a": 1}


@pytest.mark.parametrize("file", sorted(STUDIES.glob("*.yaml")), ids=lambda file: file.stem)
def test_the_studies_of_the_repository_pass_schema_and_checks(validator, file):
    validator.validate(yaml.safe_load(file.read_text()))
    if "kind: measured" in file.read_text():
        pytest.importorskip("SurfaceTopography", reason="needs the extra surfaces")
    assert load_study(file).cases()
