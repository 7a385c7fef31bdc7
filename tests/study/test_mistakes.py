"""Mistakes that users make, each answered by one message: the whole of it, as it is read."""

import math
import re

import pytest
import yaml

from fretwear.running.resources import machine_warnings
from fretwear.study.plan import Plan

from .test_file import change

# What is written in a sound study, and what is taken out of it; then the whole message, without the
# file and lines. Three dots continue a line.
MISTAKES = """
base/P: 50 N | without base/load
    base.P = 50 N: is not a case parameter
    write load
base/E: 208 GPa | without base/youngs_modulus
    base.E = 208 GPa: is not a case parameter
    write youngs_modulus
base/diameter: 20 mm | without base/radius
    base.diameter = 20 mm: is not a case parameter
    write radius: half of the diameter
base/stroke: 2 um | without base/tangential_ratio
    base.stroke = 2 um: is not a case parameter
    write displacement_amplitude: half of the stroke
base/yield_stress: 1500 MPa
    base.yield_stress = 1500 MPa: is not a case parameter
    write plastic_limit: about three times the yield stress
base/youngs_modulus: 208000
    base.youngs_modulus = 208000: needs a unit: it is a pressure such as 208 GPa
    did you mean '208000 MPa'?
base/wear_coefficient: 1e-4
    base.wear_coefficient = 0.0001: needs a unit: it is an inverse pressure such as 7e-13 / Pa
    did you mean '0.0001 mm^3/J'?
base/radius: 10 Mm
    base.radius = 10 Mm: must be a length such as 10 mm, but 'Mm' is a thousand kilometres
    did you mean '10 mm'?
base/cycles: 30 000
    base.cycles = 30 000: must be a whole number such as 30000
    write 30000, without separators
base/youngs_modulus: 208'000 MPa
    base.youngs_modulus = 208'000 MPa: must be a pressure such as 208 GPa
    write 208000 MPa, without separators
base/cycles: 50 %
    base.cycles = 50 %: must be a whole number such as 30000
base/plastic_limit: elastic
    base.plastic_limit = elastic: must be a pressure such as 4500 MPa or none
    write none for no limit
base/plastic_limit: 300 HV
    base.plastic_limit = 300 HV: must be a pressure such as 4500 MPa or none, but HV is a scale
    ... of hardness
    one HV or HB is about 9.81 MPa: write '2942 MPa'
base/roughness: smooth
    base.roughness = smooth: must be none or a roughness
    write none for smooth bodies
base/roughness: {kind: fractal}
    base.roughness.kind = fractal: must be wavy, self_affine or measured
    did you mean 'self_affine'?
base/indenter: ball | without base/radius
    base.indenter = ball: must be an indenter
    such as indenter: {kind: sphere, radius: 10 mm}
design: {kind: lhs, points: 8} | without vary
    design.kind = lhs: must be grid, zip, latin_hypercube or sobol
    did you mean 'latin_hypercube'?
design: full_factorial
    design = full_factorial: must be grid, zip, latin_hypercube or sobol
    did you mean 'grid'?
design: {kind: sobol, n: 4}, vary/load: {from: 1 N, to: 9 N}
    design.n = 4: is not known
    write points for it
design: {kind: sobol, points: 4}, vary/load: {min: 1 N, max: 9 N}
    vary.load = {min: 1 N, max: 9 N}: must be a list, or a range with from and to
    such as load: {from: 50 N, to: ...}
design: {kind: sobol, points: 512}, vary: {load: [1 N, 9 N], friction: [0.2, 0.9]} |
    ... without base/friction, base/load
    vary: has only 4 combinations of values for the 512 points of design: sobol
    a range is written load: {from: 1 N, to: 9 N}; design: grid runs each combination
vary/load: 1 N to 9 N
    vary.load = 1 N to 9 N: must be a list of values
    list the values; a sampled design takes {from: 10 N, to: 100 N}
vary/cycles: 100
    vary.cycles = 100: must be a list of values
    write [100]
vary/load: "linspace(1 N, 9 N, 5)"
    vary.load = linspace(1 N, 9 N, 5): must be a list of values
    such as [50 N]
base/material: alumina
    base.material = alumina: has no effect: youngs_modulus, poisson_ratio and plastic_limit are
    ... given too
    leave out material, or what it stands for
seeds: [1, 2] | without base/roughness
    base.roughness: must give the other parts of the roughness, because roughness.seed is varied
    such as roughness: {kind: self_affine, rms_height: 0.2 um, hurst: 0.8,
    ... rolloff_wavelength: 80 um, shortest_wavelength: 8 um}
seeds: [1, 2], base/roughness: {kind: wavy, amplitude: 1 um, slope_x: 1 deg, slope_y: 1 deg}
    seeds = [1, 2]: seed is not a parameter of wavy
    it has amplitude, slope_x, slope_y; kind: self_affine has seed
load: [1 N, 2 N] | without base/load, vary
    load = [1 N, 2 N]: is not a section of a study
    put it under vary: vary.load
varry: {load: [1 N, 2 N]} | without base/load, vary
    varry = {load: [1 N, 2 N]}: is not a section of a study
    did you mean 'vary'?
output: [0, 100]
    output = [0, 100]: must hold keys with values, one to a line
    write output: {cycles: [0, 1000]}
base: [{radius: 10 mm}, {load: 1 N}]
    base = [{radius: 10 mm}, {load: 1 N}]: must hold keys with values, one to a line
    leave out the dashes
base/indenter: {kind: sphere}
    base.radius = 10 mm: is redundant: indenter is given too
    write it inside indenter, beside its kind, as in {kind: sphere, radius: 10 mm}
vary: {load: [10 N, 20 N]} | without base
    base: is missing
    such as base: {radius: 10 mm, youngs_modulus: 208 GPa, poisson_ratio: 0.3, tangential_ratio:
    ... 0.8, friction: 0.5, wear_coefficient: 7e-13 / Pa, cycles: 30000}
base/tangential_load: 40 N, vary: {load: [10 N, 20 N], friction: [0.2, 0.3]} | without
    ... base/tangential_ratio
    base.tangential_load = 40 N: is gross sliding: Q must be less than µP = 2 N (at load = 10
    ... N, friction = 0.2, and at 3 more combinations)
    lower tangential_load, or raise load or friction
"""


def mistakes():
    """What is written, what is taken out, and the message, of each mistake."""
    for block in re.split(r"\n(?! )", MISTAKES.strip()):
        first, _, message = re.sub(r"\n    \.\.\.", "", block).partition("\n    ")
        written, _, taken = first.partition(" | without ")
        yield pytest.param(written, taken.split(", ") if taken else [], message, id=first[:60])


@pytest.mark.parametrize(("written", "taken", "message"), [*mistakes()])
def test_a_mistake_is_answered_once_in_words_that_mend_it(
    studies, content, written, taken, message
):
    for place in taken:
        change(content, place, None)
    for place, new in yaml.safe_load(f"{{{written}}}").items():
        change(content, place, new)
    told = str(studies.error(content)).removeprefix(f"{studies.folder / 'study.yaml'}: ")
    assert re.sub(r" \(line \d+\)", "", told) == message


def test_what_is_left_out_or_not_used_is_told(studies, content):
    content["base"] |= {"load": "50 N", "friction": "50 %"}
    del content["base"]["roughness"], content["base"]["plastic_limit"]
    study = studies.load(content)
    assert study.unused == ["base.load = 50 N is not used, because load is varied"]
    assert study.unused == [*machine_warnings(Plan(study))]
    assert dict(Plan(study).derived())["without roughness and plastic_limit"] == "smooth, elastic"
    (case, *_) = study.cases().values()
    assert (case.friction, case.roughness, case.plastic_limit) == (0.5, None, math.inf)
    del content["base"]["load"]
    content["base"]["plastic_limit"] = "none"
    study = studies.load(content)
    assert study.unused == []
    assert dict(Plan(study).derived())["without roughness"] == "smooth"
