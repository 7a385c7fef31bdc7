"""Mistakes in study files: each is told with its line, key, value, rule and the nearest name."""

import re

import pytest
import yaml

from fretwear.study.mistakes import StudyError
from fretwear.study.reading import load_study

# What is written in a sound study, | what is taken out of it | parts of the message.
MISTAKES = """
base/lod: 50 N || base.lod = 50 N: is not known | did you mean 'load'
vary/frction: [1] || vary.frction | did you mean 'friction'
titel: x || titel = x: is not known | did you mean 'title'
output/cycle: [1] || output.cycle | did you mean 'cycles'
output/stress: {depth: 0.5} || output.stress.depth = 0.5: needs a unit
output/stress: {deph: 0.5 mm} || output.stress.deph = 0.5 mm: is not known
|base/cycles| base.cycles: is missing | such as cycles: 30000
|base/tangential_ratio| base.tangential_ratio: is missing | or sliding_amplitude: 25 um
base/tangential_load: 2 N || base.tangential_load: is redundant: tangential_ratio is given
base/rig_stiffness: 28 N/um || rig_stiffness: is redundant: tangential_ratio is given
base/indenter: {kind: sphere, radius: 1 mm} || base.radius: is redundant: indenter is given too
base/wear_coefficient: 7e-4 || needs a unit | mm^3/(N m) | dimensionless k
base/youngs_modulus: [1 GPa, 0 GPa] || base.youngs_modulus[1] = 0 GPa: must be larger than 0
vary/load: [50 N, 50 N] || vary.load[1] = 50 N: is the same value
base/slip_model: jager || must be one of | did you mean 'jaeger'
base/accuracy: 2 %, base/error_estimate: false || leaves out the error estimates
base/tangential_ratio: 1.2 || gross sliding
base/load: 50 N/mm | vary/load | a force per length, but the load of this sphere is a force
vary/load: {from: 1 N, to: 2 N} || is a range, which design: grid cannot take
design: {kind: sobol, points: 8}, vary/load: {from: 40 N, to: 10 N} || must lead from a
design: {kind: sobol, points: 8}, vary/load: {from: 4 N, to: 9 N, scale: l} || must be 'linear'
design: {kind: sobol, points: 8} | vary | vary | is missing
design: {kind: grid, points: 4} || design.points = 4: is not known
output/cycles: [0, 1001] || output.cycles = 1001: is beyond the last cycle, 1000
base/roughness: {kind: fractal} || base.roughness.kind = fractal | did you mean 'self_affine'?
base/roughness: map.txt || write {kind: measured, file: map.txt}
base/indenter: {kind: ball, radius: 1 mm} | base/radius | did you mean 'sphere'?
base/friction: 50 || base.friction = 50: must be larger than 0 and at most 10 | did you mean '50 %'
base/friction: {cycles: [0, 9], values: [0.2, 60]} || friction[1] = 60 | did you mean '60 %'?
base/friction: {start: 20, end: 0.6, energy: 1 J/m^2} || start = 20 | did you mean '20 %'?
base/cell: 1 mm || base.cell = 1 mm: is too coarse for the contact | or leave cell out
base/indenter: {kind: crossed_cylinders, radii: 1 mm, angle: 1e-4 deg} | base/radius | a cylinder
base/sliding_distance: 1e7 m | base/tangential_ratio, base/cycles | sliding_distance = 1e
base/debris_fraction: 85 || at most 1 | did you mean '85 %'?
base/roughness: {kind: wavy, amplitude: 1 um} || base.roughness.slope_x: is missing
base/roughness: {kind: measured, file: no.x3p} || base.roughness.file = no.x3p: is no file that
base/roughness: {kind: wavy}, vary/roughness.seed: [1] || vary.roughness.seed = 1: is not known
base/friction: {cycles: [0, 500], values: [0.2]} || has 2 cycles and 1 values
base/blocks: [{cycles: 9, radius: 9 mm}] | base/cycles | base.blocks[0].radius = 9 mm: is not known
base/diameter: 10 mm || base.diameter = 10 mm: is not known | the radius, half of it
base/E: 208 GPa || base.E = 208 GPa: is not known | did you mean 'youngs_modulus'
base/hardness: 3 GPa || base.hardness = 3 GPa: is not known | give plastic_limit
vary/friction: {start: 0.1, stop: 0.5, num: 5} || be a list | a sample takes {from: …, to: …}
design: {kind: sobol, points: 8}, vary/load: {from: 4 N, to: 9 N, num: 3} || are from, to, scale
output/cycles: all || output.cycles = all: must be a list of values
output: [0, 9] || output = [0, 9]: must be a mapping | its keys are cycles
base/coating: 3 um || its keys are thickness, youngs_modulus
base/coating: {thickness: 3 um, material: TiN} || coating.material = TiN | only base takes it
base/coating: {thickness: 3 um, body: flat} || coating.body = flat: is not known | its keys are
base/coating: none, vary/coating_thickness: [1 um] || study.yaml: vary.coating_thickness
base/coating: none, vary/coating.K: [1] || did you mean 'coating.wear_coefficient'?
base/coating.thickness: 1 um || write coating: {thickness: …}; vary and --set take coating.thickness
base/load: 2 kg | vary/load | did you mean '2 kgf', 19.61 N?
base/frequency: 300 rpm || did you mean '300 / min', 5 Hz?
base/plastic_limit: 60 HRC || convert it to HV
base/plastic_limit: 2e9 || did you mean '2000000000 Pa'?
base/roughness: {kind: wavy, amplitude: 1 um, slope_x: 0.02} || did you mean '0.02 rad'?
base/radius: "10,5 mm" || numbers have a decimal point and no other separators
base/cycles: 30 000 || must be a whole number such as 30000 | no other separators
base/youngs_modulus: {ball: 2 GPa, flat: 1 GPa} || two values are a list: [body I, body II]
base/amplitude: 1 um || it is a key of roughness; vary and --set take roughness.amplitude
base/roughness: {rms_height: 1 um} || rms_height = 1 um: | it is a key of kind: self_affine
base/hertz_pressure: 1 GPa || it is a result
base/normal_load: 5 N || did you mean 'load'?
fit: {free: {K: [1e-14 / Pa, 1e-12 / Pa]}, data: []} || did you mean 'wear_coefficient'?
base/roughness: {kind: measured, path: a.x3p} || did you mean 'file'?
base/slip_model: Coulomb || must be one of jaeger
design: lhs || must be one of grid, zip, sobol | write {kind: sobol, …}
base/material: steel | base/youngs_modulus, base/poisson_ratio | 'mild steel' or 'tool steel'?
base/displacement: 1 um || base.displacement = 1 um: is not known | give displacement_amplitude
base/roughness: {kind: wavy, wavelength: 9 um} || roughness.wavelength = 9 um | give the slopes
base/roughness: {kind: wavy, Sa: 1 um} || self_affine roughness takes rms_height
base/load: [50 N, 60 N] | vary/load | belong into vary
vary/material: [52100, copper] || vary.material | only base takes it: give youngs_modulus
base/roughness: 0.1 um || must be one of wavy | write {kind: wavy, …}
base/blocks: [{cycles: 9}] || each block gives its cycles
invalid: ignore || 'stop' or 'skip'
base/blocks: [{cycles: 5, tangential_ratio: 2}] | base/cycles | in block 1 is gross sliding
base/friction: {cycles: [10], values: [0.5]} || friction.cycles = 10.0: must begin with 0
base/wear_coefficient: {value: 1e-14 / Pa, pressure_exponent: 0.6} || needs reference_pressure for
base/material: titan | base/youngs_modulus, base/poisson_ratio | did you mean 'titanium'
vary: {load: [25 N, 50 N], friction: [0.3, 0.4, 0.5]}, design: zip | base/friction | load has 2
"""
CASES = [[part.strip() for part in line.split("|")] for line in MISTAKES.strip().splitlines()]


@pytest.mark.parametrize(("written", "taken", "parts"), [(w, t, p) for w, t, *p in CASES])
def test_a_mistake_is_told_with_its_place_rule_and_the_nearest_name(
    studies, content, written, taken, parts
):
    for place in filter(None, taken.split(", ")):
        section, _, key = place.partition("/")
        content[section] = {n: v for n, v in content[section].items() if key not in ("", n)}
    for place, new in yaml.safe_load(f"{{{written}}}").items():
        section, _, key = place.partition("/")
        content[section] = {**content.get(section, {}), key: new} if key else new
    told = re.sub(r" \(line \d+\)", "", str(studies.error(content)))
    assert [part for part in parts if part not in told] == [], told


WRONG = """\
title: 7
base:
  radius: 10
  youngs_modulus: 208 GPa
  poisson_ratio: 0.6
  tangential_ratio: 0.8
  frction: 0.5
  wear_coefficient: 7e-13 / Pa
  cycles: 10
  cycles: 20
  roughness:
    kind: wavy
    amplitude: 1 N
    slope_x: 1 deg
vary:
  load: [1 N,
    2 kg]
  tangential_ratio: [0.8, -1]
  roughness.slope_y: [1 deg]
  roughness.slope_x: [1 N]
batch: some
figures: [wear]
output:
  cycles: [1.5]
  stress:
    depth: 1 N
fit:
  free: {frictoin: [0.1, 1]}
"""


def test_all_mistakes_are_told_at_once_each_with_its_line(tmp_path):
    file = tmp_path / "wrong.yaml"
    file.write_text(WRONG)
    with pytest.raises(StudyError) as caught:
        load_study(file, ["cell=1 N", "frict=3"])
    assert [(mistake.key, mistake.line) for mistake in caught.value.mistakes] == [
        ("title", 1),
        ("base.radius", 3),
        ("base.poisson_ratio", 5),
        ("base.frction", 7),
        ("base.cycles", 10),
        ("base.roughness.amplitude", 13),
        ("vary.load[1]", 17),
        ("vary.tangential_ratio[1]", 18),
        ("vary.roughness.slope_x[0]", 20),
        ("batch", 21),
        ("figures", 22),
        ("output.cycles[0]", 24),
        ("output.stress.depth", 26),
        ("fit.data", 27),
        ("fit.free.frictoin", 28),
        ("--set frict", None),
        ("--set cell", None),
    ]


@pytest.mark.parametrize(
    ("wrong", "base", "told"),
    [
        ({"poisson_ratio": 0.6}, {"tangential_ratio": 1.5}, "tangential_ratio = 1.5"),
        ({"radius": 10}, {"tangential_ratio": None, "tangential_load": "40 N"}, "tangential_load"),
        ({"load": "5 kg"}, {"tangential_ratio": 1.5}, "tangential_ratio = 1.5"),
        ({"wear_coefficient": 1}, {"plastic_limit": "0.1 MPa"}, "plastic_limit = 100 kPa"),
        ({"frction": 1}, {"accuracy": "2 %", "error_estimate": False}, "error_estimate = false"),
    ],
)
def test_a_wrong_value_hides_no_broken_rule_that_does_not_need_it(
    studies, content, wrong, base, told
):
    base = content["base"] | base | wrong
    content["base"] = {name: value for name, value in base.items() if value is not None}
    content["vary"] = {"cycles": [10, 0]}
    content["output"] = {"cycle": [1]}
    mistakes = studies.error(content).mistakes
    message = "\n".join(map(str, mistakes))
    assert f"base.{told}" in message
    assert all(f"base.{name}" in message for name in wrong)
    assert "vary.cycles[1] = 0" in message
    assert "output.cycle = [1]" in message
    assert len(mistakes) == 4, message


def test_a_misspelt_key_is_not_told_again_as_one_too_much(studies, content):
    content["base"]["amplitud"] = 3  # nearest to sliding_amplitude, beside tangential_ratio
    with pytest.raises(StudyError) as caught:
        studies.load(content)
    (mistake,) = caught.value.mistakes
    assert (mistake.key, mistake.rule) == ("base.amplitud", "is not known")


def test_a_mistake_of_points_is_told_once_with_a_point_at_which_it_is_made(studies, content):
    del content["base"]["tangential_ratio"]
    content["base"]["tangential_load"] = "12 N"
    content["vary"] = {"load": ["10 N", "20 N", "50 N"], "friction": [0.5, 0.6, 0.9]}
    (first,) = studies.error(content).mistakes
    assert first.key == "base.tangential_load"
    assert "gross sliding" in first.rule
    assert "(at load = 10 N, friction = 0.5 and at 4 more points)" in first.rule
    kept = studies.load(content | {"invalid": "skip"})
    assert [point.values["load"] for point in kept.points() if point.case] == [20.0, *[50.0] * 3]
    assert "gross sliding" in kept.points()[0].mistake


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("5", "must hold keys such as base and vary"),
        ("base: {radius: 1 mm", "is not YAML"),
        ("base:\n\tradius: 1 mm", "(line 2)"),
        ("title: \x9b", "is not YAML"),
        ("base: &a {radius: *a}", "does an alias hold itself?"),
    ],
)
def test_what_is_no_study_file_is_refused_in_a_sentence(tmp_path, text, part):
    file = tmp_path / "study.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(StudyError) as caught:
        load_study(file)
    assert part in str(caught.value)


def test_a_file_that_is_not_there_or_has_a_bad_name_is_told_with_what_is(studies, content):
    studies.write(content)
    with pytest.raises(StudyError, match=r"did you mean '.*study\.yaml'"):
        load_study(studies.folder / "stduy.yaml")
    with pytest.raises(StudyError, match="cannot be read"):
        load_study(studies.folder)
    with pytest.raises(StudyError, match="letters, digits"):
        load_study(studies.write(content, "a study.yaml"))
