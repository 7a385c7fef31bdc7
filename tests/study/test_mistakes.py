"""Mistakes in study files: each is told with its line, key, value, rule and the nearest name."""

import math

import pytest
import yaml

from fretwear.run.resources import machine_warnings
from fretwear.study.plan import Plan
from fretwear.study.problems import StudyError
from fretwear.study.reading import load_study
from fretwear.study.yamlfile import MAX_BYTES

# What is written in a sound study, | what is taken out of it | parts of the message.
MISTAKES = """
base/lod: 50 N || base.lod = 50 N | is not a case parameter | did you mean 'load'
base/E: 208 GPa | base/youngs_modulus | did you mean 'youngs_modulus'
base/diameter: 20 mm | base/radius | did you mean 'radius'
base/foo: 3 || is not a case parameter | fretwear schema lists all keys
vary/frction: [1] || vary.frction | did you mean 'friction'
titel: x || is not a section | did you mean 'title'
load: 5 N || put it under base: base.load
output/cycle: [1] || output.cycle | did you mean 'cycles'
output/stress: {depth: 0.5} || output.stress.depth = 0.5 | needs a unit
output/stress: {deph: 0.5 mm} || output.stress.deph = 0.5 mm | is not known
output/stress: {fatigue_strength: 1 GPa} || without strength_exponent
output/stress: [0] || must be a mapping
base/load: ~ || base.load | has no value
|base/cycles| base.cycles | is missing | such as cycles: 30000
|base/tangential_ratio| is missing, and so are tangential_load, sliding_amplitude
base/tangential_load: 2 N || is redundant: tangential_ratio is given too
base/rig_stiffness: 28 N/um || has no meaning with tangential_ratio
base/indenter: {kind: sphere, radius: 1 mm} || base.radius | is redundant: indenter is given too
base/radius: 10 N || must be a length | is a force
base/radius: 10 parsec || an unknown unit | 'parsec'
base/radius: 11 m || must be at most 10 m
base/friction: 0.5 N || plain number
base/load: 50 || needs a unit | '50 N'
base/wear_coefficient: 7e-4 || needs a unit | mm^3/(N m) | dimensionless k
base/youngs_modulus: [1 GPa, 2 GPa, 3 GPa] || a list of 3
base/youngs_modulus: [1 GPa, 0 GPa] || base.youngs_modulus[1] = 0 GPa | larger than 0
base/youngs_modulus: 208 Gpa || 'Gpa' | did you mean 'GPa'
vary/load: [50 N, 50 N] || vary.load[1] = 50 N | same value
vary/load: [25 N, 50] || vary.load[1] = 50 | needs a unit
base/load: -50 N || larger than 0
base/poisson_ratio: 0.6 || larger than -1 and at most 0.5
base/cycles: many || whole number
base/cycles: 50 % || whole number
base/tolerance: 0.5 || at most 0.1
base/cell: [1 um, 2] || base.cell[1] = 2 | needs a unit
base/slip_model: jager || must be one of | did you mean 'jaeger'
base/friction: .nan || finite
base/friction: true || plain number
base/error_estimate: maybe || true or false
base/accuracy: 2 %, base/error_estimate: false || leaves out the error estimates
vary/roughness: {amplitude: [1 um]} || must be a list
base/tangential_ratio: 1.2 || gross sliding
base/tangential_load: 40 N | base/tangential_ratio | gross sliding: Q must be less than µP
base/plastic_limit: 0.1 MPa || too low to carry
base/load: 50 N/mm | vary/load | a force per length, but the load of this sphere is a force
vary/load: [] || must be a list of values
vary/load: {from: 1 N, to: 2 N} || is a range, which design: grid cannot take
design: {kind: sobol, points: 8}, vary/load: {from: 40 N, to: 10 N} || vary.load.to = 10 N | more
design: {kind: sobol, points: 8}, vary/load: {from: 4 N, to: 9 N, scale: l} || linear or log
design: {kind: sobol, points: 8} | vary | vary | is missing
design: {kind: sobol} || design.points | is missing
design: {kind: grid, points: 4} || design.points = 4 | not known
design: gird || must be one of grid
output/cycles: [0, 1001] || output.cycles = 1001 | beyond the last cycle, 1000
output/cycles: [0, 1.5] || output.cycles[1] = 1.5 | whole number
output/cycles: 100 || must be auto, or a list
output/cycles: [5, 5] || twice
output: [5] || output
base/roughness: rough || must be one of wavy
base/roughness: {kind: fractal} || base.roughness.kind = fractal
base/roughness: {kind: wavy, amplitude: 1 um, slope_x: 5.7, slope_y: 1 deg} || slope_x = 5.7 | unit
base/roughness: {kind: wavy, amplitude: 1 um} || base.roughness.slope_x | is missing
base/roughness: {kind: measured, file: no.x3p} || base.roughness.file = no.x3p | is no file:
vary/roughness.seed: [1] || base.roughness
base/cell: 40 um || too coarse for the contact
base/friction: {cycles: [0, 500], values: [0.2]} || has 2 cycles and 1 values
base/blocks: [{cycles: 9, radius: 9 mm}] | base/cycles | a key that a block cannot change
base/blocks: [{cycles: 9}] || each block gives its cycles
invalid: ignore || 'stop' or 'skip'
title: 7 || title
base/material: alumina || has no effect
base/material: titan | base/youngs_modulus, base/poisson_ratio | did you mean 'titanium'
vary: {load: [25 N, 50 N], friction: [0.3, 0.4, 0.5]}, design: zip | base/friction | load has 2
vary: {load: [25 N, 25 N]}, design: zip || point 2 the same as point 1
"""
CASES = [[part.strip() for part in line.split("|")] for line in MISTAKES.strip().splitlines()]


def change(content, key, value):
    """Set a dotted key of a study's content; None removes it."""
    *sections, last = key.split("/")
    for name in sections:
        content = content.setdefault(name, {})
    content[last] = value
    if value is None:
        content.pop(last)


@pytest.mark.parametrize(("written", "taken", "parts"), [(w, t, p) for w, t, *p in CASES])
def test_a_mistake_is_told_with_its_place_rule_and_the_nearest_name(
    studies, content, written, taken, parts
):
    for place in filter(None, taken.split(", ")):
        change(content, place, None)
    for place, new in yaml.safe_load(f"{{{written}}}").items():
        *sections, last = place.split("/")
        where = content
        for name in sections:
            where = where.setdefault(name, {})
        where[last] = new
    told = str(studies.error(content))
    assert [part for part in parts if part not in told] == [], told


def test_all_mistakes_are_told_at_once_each_with_its_line(tmp_path):
    file = tmp_path / "wrong.yaml"
    file.write_text(
        "title: Wrong\n"
        "base:\n"
        "  radius: 10\n"
        "  youngs_modulus: 208 GPa\n"
        "  poisson_ratio: 0.6\n"
        "  load: 50 N\n"
        "  tangential_ratio: 0.8\n"
        "  frction: 0.5\n"
        "  wear_coefficient: 7e-13 / Pa\n"
        "  cycles: 10\n"
        "  cycles: 20\n"
        "  roughness:\n"
        "    kind: wavy\n"
        "    amplitude: 1 N\n"
        "vary:\n"
        "  load: [1 N,\n"
        "    2 kg]\n"
    )
    with pytest.raises(StudyError) as caught:
        load_study(file, ["cell=1 N", "frict=3"])
    problems = {problem.key: problem.line for problem in caught.value.problems}
    expected = {
        "base.radius": 3,
        "base.poisson_ratio": 5,
        "base.frction": 8,
        "base.cycles": 11,
        "base.roughness.amplitude": 14,
        "base.roughness.slope_x": 12,
        "base.roughness.slope_y": 12,
        "vary.load[1]": 17,
        "--set cell": None,
        "--set frict": None,
    }
    assert problems == expected
    assert str(caught.value).startswith(f"{file}: 10 problems\n  base.radius = 10 (line 3): needs")


def test_a_mistake_of_points_is_told_once_with_a_point_at_which_it_is_made(studies, content):
    del content["base"]["tangential_ratio"]
    content["base"]["tangential_load"] = "12 N"
    content["vary"] = {"load": ["10 N", "20 N", "50 N"], "friction": [0.5, 0.6, 0.9]}
    (first, *others) = studies.error(content).problems
    assert first.key == "base.tangential_load"
    assert "gross sliding" in first.rule
    assert "(at load = 10 N, and at 4 more points)" in first.rule
    assert not [one for one in others if one.key != "base.tangential_load"]
    kept = studies.load(content | {"invalid": "skip"})
    assert [point.values["load"] for point in kept.points() if point.case] == [20.0, *[50.0] * 3]
    assert "gross sliding" in kept.points()[0].problem


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("", ["the file is empty"]),
        ("5", ["must hold keys such as base and vary"]),
        ("base: {radius: 1 mm", ["is not YAML", "(line 1)"]),
        ("base:\n\tradius: 1 mm", ["is not YAML", "(line 2)"]),
        ("a: &a [1]\nb: {<<: *a}", ["holds a merge"]),
        ("a: " + "[" * 30 + "]" * 30, ["nested more than 12 levels"]),
        (
            "a: &a [1, 1]\n"
            + "".join(
                f"{x}: &{x} [{5 * f'*{y}, '}]\n"
                for y, x in zip("abcdefgh", "bcdefghi", strict=True)
            ),
            ["more than"],
        ),
        ("# " + MAX_BYTES * "x", ["is larger than 1000 kB"]),
        ("title: \x9b", ["is not YAML"]),
    ],
)
def test_what_is_no_study_file_is_refused_in_a_sentence(tmp_path, text, parts):
    file = tmp_path / "study.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(StudyError) as caught:
        load_study(file)
    assert all(part in str(caught.value) for part in parts), str(caught.value)


def test_a_file_that_is_not_there_or_has_a_bad_name_is_told_with_what_is(studies, content):
    studies.write(content)
    with pytest.raises(StudyError, match=r"did you mean '.*study\.yaml'"):
        load_study(studies.folder / "stduy.yaml")
    with pytest.raises(StudyError, match="is a folder"):
        load_study(studies.folder)
    with pytest.raises(StudyError, match="rename the file"):
        load_study(studies.write(content, "a study.yaml"))


def test_values_beyond_any_material_and_an_uneven_sequence_are_warned_of(studies, content):
    content["base"] |= {"friction": 50, "wear_coefficient": "7e-4 mm3/(N mm)"}
    content["vary"] = {"load": {"from": "10 N", "to": "40 N"}}
    content["design"] = {"kind": "sobol", "points": 12}
    del content["base"]["load"]
    even, unlikely = machine_warnings(Plan(studies.load(content)))
    assert "design.points = 12 is not a power of two" in even
    assert "coefficient of friction 50, wear coefficient 7e-10 / Pa" in unlikely
    content["base"] |= {"friction": 0.5, "wear_coefficient": "7e-4 mm3/(N m)"}
    content["design"]["points"] = 8
    assert [*machine_warnings(Plan(studies.load(content)))] == []


def test_what_is_left_out_or_not_used_is_told(studies, content):
    content["base"] |= {"load": "50 N", "friction": "50 %"}
    del content["base"]["roughness"], content["base"]["plastic_limit"]
    study = studies.load(content)
    assert study.remarks == ["base.load = 50 N is not used, because load is varied"]
    words = "roughness (smooth), plastic_limit (elastic)"
    assert dict(Plan(study).derived())["not given"] == words
    (case, *_) = study.cases().values()
    assert (case.friction, case.roughness, case.plastic_limit) == (0.5, None, math.inf)
    del content["base"]["load"]
    content["base"] |= {"cell": "2 um", "accuracy": "5 %", "budget": 3}
    told = [f"base.{what} is not used, because " for what in ("accuracy = 5 %", "budget = 3")]
    assert studies.load(content).remarks == [f"{text}cell is given" for text in told]
