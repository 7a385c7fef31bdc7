import json
from pathlib import Path

import pytest
import yaml

from fretwear.study.sections import study_schema
from fretwear.study.study import load_study
from fretwear.study.tree import base_names

jsonschema = pytest.importorskip("jsonschema")
STUDIES = Path(__file__).parents[2] / "studies"


@pytest.fixture
def validator():
    schema = study_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_the_schema_is_json():
    assert json.loads(json.dumps(study_schema(), allow_nan=False)) == study_schema()


@pytest.mark.parametrize("file", sorted(STUDIES.glob("*.yaml")), ids=lambda file: file.stem)
def test_the_studies_of_the_repository_pass_schema_and_checks(validator, file):
    validator.validate(yaml.safe_load(file.read_text()))
    assert load_study(file).cases()


def test_the_schema_describes_every_parameter():
    properties = study_schema()["properties"]
    names = set(base_names())
    assert set(properties["base"]["properties"]) == names
    assert names < set(properties["vary"]["properties"])
    for name, value in properties["base"]["properties"].items():
        assert value["description"], name


def test_a_sound_study_passes(validator, content):
    validator.validate(content)


@pytest.mark.parametrize(
    "design",
    ["grid", "zip", {"kind": "sobol", "points": 8}, {"kind": "latin_hypercube", "points": 8}],
)
def test_every_design_passes(validator, content, design):
    validator.validate({**content, "design": design})


@pytest.mark.parametrize(
    ("section", "changes"),
    [
        ("base", {"lod": "50 N"}),
        ("base", {"load": 50}),
        ("base", {"load": "50"}),
        ("base", {"load": "-50 N"}),
        ("base", {"poisson_ratio": 0.6}),
        ("base", {"friction": 0}),
        ("base", {"youngs_modulus": ["1 GPa", "2 GPa", "3 GPa"]}),
        ("base", {"tangential_load": "20 N"}),
        ("base", {"tangential_load": "none"}),
        ("base", {"slip_model": "other"}),
        ("base", {"roughness": {"amplitude": 0.2}}),
        ("base", {"cycles": 0}),
        ("vary", {"load": []}),
        ("vary", {"load": ["50 N", "50 N"]}),
        ("vary", {"frction": [1]}),
        ("output", {"cycles": [-1]}),
        ("output", {"cycle": [1]}),
    ],
)
def test_what_the_checks_refuse_the_schema_refuses(validator, studies, content, section, changes):
    content[section].update(changes)
    assert not validator.is_valid(content)
    assert studies.error(content).problems


@pytest.mark.parametrize("name", ["radius", "friction", "roughness", "cycles", "tangential_ratio"])
def test_a_missing_parameter_fails(validator, content, name):
    del content["base"][name]
    assert not validator.is_valid(content)


def test_a_parameter_that_is_only_varied_is_not_missing(validator, content):
    del content["base"]["load"]
    validator.validate(content)
