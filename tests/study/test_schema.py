import json
from pathlib import Path

import pytest
import yaml

from fretwear.study.parameters import base_names
from fretwear.study.study import load_study, study_schema

jsonschema = pytest.importorskip("jsonschema")
STUDIES = Path(__file__).parents[2] / "studies"


@pytest.fixture(scope="module")
def validator():
    schema = study_schema()
    assert json.loads(json.dumps(schema, allow_nan=False)) == schema
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("file", sorted(STUDIES.glob("*.yaml")), ids=lambda file: file.stem)
def test_the_studies_of_the_repository_pass_schema_and_checks(validator, file):
    validator.validate(yaml.safe_load(file.read_text()))
    if "kind: measured" in file.read_text():
        pytest.importorskip("SurfaceTopography", reason="needs the extra surfaces")
    assert load_study(file).cases()


def test_the_schema_describes_every_parameter():
    properties = study_schema()["properties"]
    names = set(base_names())
    assert set(properties["base"]["properties"]) == names
    assert names < set(properties["vary"]["properties"])
    for name, value in properties["base"]["properties"].items():
        assert value["description"], name


def test_a_sound_study_passes_in_every_design(validator, content):
    kinds = [{"kind": kind, "points": 8} for kind in ("sobol", "latin_hypercube")]
    for design in ("grid", "zip", *kinds):
        validator.validate({**content, "design": design})
    # A parameter that is only varied is not missing.
    del content["base"]["load"]
    validator.validate(content)


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
        *(("base", {name: None}) for name in ("radius", "friction", "cycles", "tangential_ratio")),
        ("vary", {"load": []}),
        ("vary", {"load": ["50 N", "50 N"]}),
        ("vary", {"frction": [1]}),
        ("output", {"cycles": [-1]}),
        ("output", {"cycle": [1]}),
    ],
)
def test_what_the_checks_refuse_the_schema_refuses(validator, studies, content, section, changes):
    content[section].update(changes)
    # A parameter without a value is left out.
    content[section] = {
        name: value for name, value in content[section].items() if value is not None
    }
    assert not validator.is_valid(content)
    assert studies.error(content).problems
