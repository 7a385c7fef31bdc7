"""Mistakes that users make, each answered by one message: the whole of it, as it is read."""

import math
import re

import pytest
import yaml

from fretwear.run.resources import machine_warnings
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
base/accuracy: 2 %, base/error_estimate: false
    base.error_estimate = false: leaves out the error estimates that an accuracy needs
    give one of the two
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
base/roughness: {rms_height: 0.1 um}
    base.roughness = {rms_height: 0.1 um}: lacks its kind: rms_height belongs to kind self_affine
    write {kind: self_affine, rms_height: 0.1 um, hurst: 0.8, rolloff_wavelength: 80 um,
    ... shortest_wavelength: 8 um, seed: 7}
base/roughness: {kind: wavy, rms_height: 0.1 um, hurst: 0.7}
    base.roughness = {kind: wavy, rms_height: 0.1 um, hurst: 0.7}: is not of kind wavy: rms_height
    ... and hurst belong to kind self_affine
    write {kind: self_affine, rms_height: 0.1 um, hurst: 0.7, rolloff_wavelength: 80 um,
    ... shortest_wavelength: 8 um, seed: 7}
base/tangential_ratio: 80
    base.tangential_ratio = 80: is gross sliding: Q/(µP) must be less than 1
    did you mean '80 %'?
base/debris: 0.85
    base.debris = 0.85: is not a case parameter
    write debris_fraction
base/roughness: {Ra: 0.4 um}
    base.roughness.Ra = 0.4 um: is not known
    amplitude, slope_x and slope_y are missing, such as amplitude: 0.2 um, slope_x: 5.7 deg,
    ... slope_y: 1 deg
base/roughness: {amplitud: 0.4 um, slope_x: 3 deg, slope_y: 1 deg}
    base.roughness.amplitud = 0.4 um: is not known
    write amplitude for it
base/friction: {cycle: [0, 500], values: [0.2, 0.6]}
    base.friction.cycle = [0, 500]: is not known
    write cycles for it
base/friction: [[0, 0.2], [500, 0.6]]
    base.friction = [[0, 0.2], [500, 0.6]]: must be a plain number such as 0.5
    write {cycles: [0, 500], values: [0.2, 0.6]}
base/friction: {cycles: [500, 0], values: [0.2, 0.6]}
    base.friction.cycles[0] = 500: must be 0, where a table starts
    list the cycles, with their values, in ascending order
base/youngs_modulus: {indenter: 208 GPa, flat: 70 GPa}
    base.youngs_modulus = {indenter: 208 GPa, flat: 70 GPa}: must be one value, or two for two
    ... bodies
    two are a list: [208 GPa, 70 GPa]
base/cycles: 7k
    base.cycles = 7k: must be a whole number such as 30000
    write 7000
base/load: -50 N
    base.load = -50 N: must be larger than 0
    did you mean '50 N'?
base/load: 50 N/mm | without vary
    base.load = 50 N/mm: is a force per length, but the load of this sphere is a force
    such as load: 50 N
output: {snapshots: 10}
    output.snapshots = 10: is not known
    write cycles, a list of those at which fields are kept
design: {kind: sobol, points: 8}, vary/load: {from: 5 N, to: 9 N, scale: logarithmic}
    vary.load.scale = logarithmic: must be linear or log
    did you mean 'log'?
base/wear_coefficient: 0
    base.wear_coefficient = 0: must be larger than 0
base/wear_coefficient: 7e-4 mm3 N m
    base.wear_coefficient = 7e-4 mm3 N m: must be an inverse pressure such as 7e-13 / Pa, but 'mm3 N
    ... m' is another quantity
    did you mean '7e-4 mm3/(N m)'?
base/junction_growth: none
    base.junction_growth = none: must be a plain number such as 9
    write 0 for none
base/coupled: true
    base.coupled = true: is not a case parameter
    write slip_model: coupled
base/error_estimate: 'yes'
    base.error_estimate = yes: must be true or false
    write true
base/material: [tool steel, titan] | without base/youngs_modulus, base/poisson_ratio
    base.material[1] = titan: is not in the table of materials
    did you mean 'titanium'?
base/radius: [10, 20] | without vary
    base.radius = [10, 20]: must be a length such as 10 mm
    a list of values, each a case, belongs under vary: vary.radius
vary/load: [20, 50]
    vary.load = [20, 50]: needs a unit: it is a force such as 50 N
    did you mean [20 N, 50 N]?
vary/roughness: [none, wavy] | without base/roughness
    vary.roughness[1] = wavy: needs amplitude, slope_x and slope_y
    such as roughness: {kind: wavy, amplitude: 0.2 um, slope_x: 5.7 deg, slope_y: 1 deg}
base/load: {from: 10 N, to: 50 N} | without vary
    base.load = {from: 10 N, to: 50 N}: must be a force such as 50 N
    a range belongs under vary, in a sampled design: vary.load
base/friction: 50 percent
    base.friction = 50 percent: must be a plain number such as 0.5, without a unit
    write 50 %
design: {kind: sobol, points: 8} | without vary
    vary: is missing: a sampled design needs something to vary
    such as load: {from: 10 N, to: 100 N}
seeds: 3, base/roughness: {kind: self_affine, rms_height: 0.1 um, hurst: 0.8, rolloff_wavelength:
    ... 60 um, shortest_wavelength: 20 um}
    seeds = 3: must be a list of values
    write [3], or [1, 2, 3] for 3 surfaces
radius: 10 mm, load: 50 N, friction: 0.5 | without base, vary
    base: is missing, and radius, load and friction stand outside of it
    write base: above them, and indent them
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
base/load: 5 kg
    base.load = 5 kg: must be a force such as 50 N, but 'kg' is another quantity
    write the weight of this mass: '49.03 N'
base/load: [20 N, 50 N]
    base.load = [20 N, 50 N]: must be a force such as 50 N
    a list of values, each a case, belongs under vary: vary.load
base/load: '50,5 N'
    base.load = 50,5 N: must be a force such as 50 N
    write a decimal point, not a comma
base/wear_coefficient: 7e-13 Pa
    base.wear_coefficient = 7e-13 Pa: must be an inverse pressure such as 7e-13 / Pa, but 'Pa' is a
    ... pressure
    did you mean '7e-13 / Pa'?
base/rig_stiffness: 28 um/N, base/displacement_amplitude: 1 um | without base/tangential_ratio
    base.rig_stiffness = 28 um/N: must be a force per length such as 28 N/um or none, but 'um/N' is
    ... another quantity
    did you mean '28 N/um'?
base/youngs_modulus: 208 Gpa
    base.youngs_modulus = 208 Gpa: must be a pressure such as 208 GPa, but has an unknown unit
    ... 'Gpa'
    did you mean 'GPa'?
base/poisson_ratio: 0.6
    base.poisson_ratio = 0.6: must be larger than -1 and at most 0.5
base/tangential_ratio: 1.2
    base.tangential_ratio = 1.2: is gross sliding: Q/(µP) must be less than 1
    partial slip needs a ratio between 0 and 1, such as 0.8; for gross slip write
    ... displacement_amplitude or sliding_amplitude instead
base/temperature: 300 K
    base.temperature = 300 K: is not a case parameter
    leave it out: the model does not depend on it
base/duration: 3600 s | without base/cycles
    base.duration = 3600 s: is not a case parameter
    write cycles: the duration times the frequency
base/foo: 3
    base.foo = 3: is not a case parameter
    fretwear schema lists all parameters
base/material: Ti6Al4V | without base/youngs_modulus, base/poisson_ratio
    base.material = Ti6Al4V: must be a material of the table, or a pair of them
    did you mean 'Ti-6Al-4V'?
base/roughness: {kind: wavy, amplitude: 0.2 um, slope_x: 3, slope_y: 1 deg}
    base.roughness.slope_x = 3: needs a unit: it is an angle such as 5.7 deg
    did you mean '3 deg'?
base/friction: {cycles: [0, 500], values: [0.2]}
    base.friction = {cycles: [0, 500], values: [0.2]}: has 2 cycles and 1 values
    give a value for each cycle
base/blocks: [{cycles: 9, radius: 9 mm}] | without base/cycles
    base.blocks[0].radius = 9 mm: is a key that a block cannot change
    known are cycles, pulsating_load, load, indentation, tangential_ratio, tangential_load,
    ... sliding_amplitude, sliding_distance, rig_stiffness, tangential_compliance,
    ... displacement_amplitude, displacement_ratio, friction
vary: [load, friction]
    vary = [load, friction]: must hold keys with values, one to a line
    write vary: {load: [20 N, 50 N]}
vary/load: {from: 20 N, to: 50 N}
    vary.load = {from: 20 N, to: 50 N}: is a range, which design: grid cannot take
    write a list, or design: {kind: latin_hypercube, points: 64, seed: 1}
design: {kind: sobol, points: 8}, vary/load: {from: 40 N, to: 10 N}
    vary.load.to = 10 N: must be more than vary.load.from = 40 N, and finite
output: {cycles: [0, 500000]}
    output.cycles = 500000: is beyond the last cycle, 1000
    give cycles from 0 to 1000, or raise cycles
outputs: {cycles: [0]}
    outputs = {cycles: [0]}: is not a section of a study
    did you mean 'output'?
title: ""
    title = '': must be text
    put it in quotes
base/cycles: '30,000'
    base.cycles = 30,000: must be a whole number such as 30000
    write 30000, without separators
base/accuracy: 2
    base.accuracy = 2: must be at least 0.001 and at most 0.2
    did you mean '2 %'?
base/accuracy: [1 %, 2 %]
    base.accuracy = [1 %, 2 %]: must be a plain number such as 0.02 or none
    a list of values, each a case, belongs under vary: vary.accuracy
base/debris_fraction: 85
    base.debris_fraction = 85: must be at least 0 and at most 1
    did you mean '85 %'?
base/budget: 3 min
    base.budget = 3 min: must be a plain number such as 10, without a unit
base/load: N 50
    base.load = N 50: must be a force such as 50 N
    write 50 N
base/load: 50 Newton
    base.load = 50 Newton: must be a force such as 50 N, but has an unknown unit 'Newton'
    did you mean '50 newton'?
base/load: “50 N”
    base.load = “50 N”: must be a force such as 50 N
    write 50 N
base/poisson_ratio: 1/3
    base.poisson_ratio = 1/3: must be a plain number such as 0.3, without a unit
    write 0.33333
base/wear_coefficient: 7e−13 / Pa
    base.wear_coefficient = 7e−13 / Pa: must be an inverse pressure such as 7e-13 / Pa, but has a
    ... unit that cannot be read: 'e−13 / Pa'
    write 7e-13 / Pa
base/wear_coefficient: 7×10⁻¹³ / Pa
    base.wear_coefficient = 7×10⁻¹³ / Pa: must be an inverse pressure such as 7e-13 / Pa, but has a
    ... unit that cannot be read: '×10⁻¹³ / Pa'
    write 7e-13 / Pa
base/wear_coefficient: 7x10^-13 / Pa
    base.wear_coefficient = 7x10^-13 / Pa: must be an inverse pressure such as 7e-13 / Pa, but has a
    ... unit that cannot be read: 'x10^-13 / Pa'
    write 7e-13 / Pa
base/frequency: 300 rpm
    base.frequency = 300 rpm: must be a frequency such as 5 Hz, but has an unknown unit 'rpm'
    there are 60 seconds to a minute: write '5 Hz'
base/plastic_limit: None
    base.plastic_limit = None: must be a pressure such as 4500 MPa or none
    write none for no limit
base/output: {cycles: [0]}
    base.output = {cycles: [0]}: is not a case parameter
    it is a section of its own, beside base
samples: 16
    samples = 16: is not a section of a study
    write design: {kind: latin_hypercube, points: 16}
vary/hardness: [3 GPa, 4 GPa]
    vary.hardness = [3 GPa, 4 GPa]: is not a case parameter
    write plastic_limit: about the hardness
vary/load: [[20 N, 50 N]]
    vary.load[0] = [20 N, 50 N]: must be a force such as 50 N
    write one list of values, without inner ones
vary/load: 20 N:10 N:50 N
    vary.load = 20 N:10 N:50 N: must be a list of values
    list the values; a sampled design takes {from: 10 N, to: 100 N}
base/cell: 1 um, base/roughness: {kind: wavy, slope_x: 3 deg, slope_y: 1 deg}, vary:
    ... {roughness.amplitude: {from: 50 nm, to: 60 nm}}, design: {kind: sobol, points: 2} |
    ... without output
    base.cell = [1 um, 1 um]: is too coarse for the roughness: the wave along x is 4.47 um long and
    ... needs at least 8 cells (at roughness.amplitude = 0.058506 µm, and at roughness.amplitude =
    ... 0.050495 µm)
    [558 nm, 1 um] or finer would be fine, or leave cell out
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


def test_values_beyond_any_material_and_an_uneven_sequence_are_warned_of(studies, content):
    content["base"] |= {"friction": 50, "wear_coefficient": "7e-4 mm3/(N mm)"}
    content["vary"] = {"load": {"from": "10 N", "to": "40 N"}}
    content["design"] = {"kind": "sobol", "points": 12}
    del content["base"]["load"]
    even, unlikely = machine_warnings(Plan(studies.load(content)))
    assert even == (
        "design.points = 12 is not a power of two, so the Sobol sequence fills the ranges "
        "unevenly; 8 or 16 points do it evenly"
    )
    first, case, *_, remedy = unlikely.split("\n")
    assert first == "in 12 cases the contact has values beyond those of any known material:"
    assert case.endswith(": coefficient of friction 50, wear coefficient 7e-10 / Pa")
    assert remedy.strip() == "check units, percentages and powers of ten"
    content["base"] |= {"friction": 0.5, "wear_coefficient": "7e-4 mm3/(N m)"}
    content["design"]["points"] = 8
    assert [*machine_warnings(Plan(studies.load(content)))] == []


def test_what_is_left_out_or_not_used_is_told(studies, content):
    content["base"] |= {"load": "50 N", "friction": "50 %"}
    del content["base"]["roughness"], content["base"]["plastic_limit"]
    study = studies.load(content)
    assert study.remarks == ["base.load = 50 N is not used, because load is varied"]
    assert study.remarks == [*machine_warnings(Plan(study))]
    words = "roughness (smooth), plastic_limit (elastic)"
    assert dict(Plan(study).derived())["not given"] == words
    (case, *_) = study.cases().values()
    assert (case.friction, case.roughness, case.plastic_limit) == (0.5, None, math.inf)
    del content["base"]["load"]
    content["base"]["plastic_limit"] = "none"
    study = studies.load(content)
    assert study.remarks == []
    assert dict(Plan(study).derived())["not given"] == "roughness (smooth)"
    content["base"] |= {"cell": "2 um", "accuracy": "5 %", "budget": 3}
    told = [f"base.{what} is not used, because " for what in ("accuracy = 5 %", "budget = 3")]
    assert studies.load(content).remarks == [f"{text}cell is given" for text in told]
    del content["base"]["cell"]
    content["base"]["accuracy"] = "none"
    assert studies.load(content).remarks == [f"{told[1]}accuracy is none"]
