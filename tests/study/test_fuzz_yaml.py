"""Odd bytes, odd YAML and odd numbers, where files of plain values do not come."""

import math
from copy import deepcopy

import pytest
import yaml
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from fretwear.running.resources import batches, core_seconds
from fretwear.study.plan import plan_study
from fretwear.study.problems import StudyError
from fretwear.study.sections import NAMES as SECTIONS
from fretwear.study.study import Study, load_study
from fretwear.study.tree import parameter_names

ODD = (
    "!!int ''",
    "!!int -",
    "!!int 1:x",
    "!!bool x",
    "!!null x",
    "!!float ''",
    "!!float 0x10",
    "!!timestamp x",
    "!!timestamp 2001-99-99",
    "2001-99-99",
    "!!binary '%'",
    "!!binary aGFsbG8=",
    "!!set {a, b}",
    "!!omap [a: 1]",
    "!!merge x",
    "!!python/object/apply:os.system ['exit 1']",
    "!!python/name:os.system",
    "!unknown x",
    "&a [*a]",
    "&a {b: *a}",
    "*unknown",
    "{<<: {load: 3 N}}",
    "{a: 1, a: 2}",
    "{1: 2, null: 3, [a]: 4}",
    "? - complex\n    : key",
    "0x" + "F" * 5000,
    "-0b" + "1" * 20000,
    "1" * 5000,
    "1:" * 3000 + "1",
    ".nan",
    "-.inf",
    "1e400 N",
    "1e-400 N",
    "-0.0 N",
    "１ N",
    "1_000 N",
    '"\\ud800"',
    '"\\0"',
    "\u2028",
    "\ufeff",
    "[" * 100,
    "{a: " * 50,
    "'",
    "|\n  text",
    "- -",
    "---",
    "...",
    "%YAML 9.9",
    "\t",
    "@",
)
NAMES = list(parameter_names())

fragments = st.one_of(st.sampled_from(ODD), st.text(max_size=20))
magnitudes = st.one_of(st.floats(5e-324, 1.7e308), st.floats(-30, 30).map(lambda x: 10.0**x))
of_files = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


def outcome(file, content, assignments=()):
    """A study that can be planned, or problems that can be printed."""
    file.write_bytes(content)
    found: Study | StudyError
    try:
        found = load_study(file, assignments)
    except StudyError as error:
        found = error
    if isinstance(found, StudyError):
        assert found.problems
        assert str(found).encode()
    else:
        planned = plan_study(found)
        assert core_seconds(batches(planned)) >= 0.0
        for row in planned.rows():
            assert "\n".join(row).encode()
    return found


@of_files
@given(content=st.binary(max_size=300))
def test_any_bytes(tmp_path, content):
    assert isinstance(outcome(tmp_path / "study.yaml", content), StudyError)


@of_files
@given(fragment=fragments, section=st.sampled_from([*SECTIONS, *NAMES, ""]), vary=st.booleans())
def test_any_yaml_in_the_place_of_a_value(tmp_path, content, fragment, section, vary):
    content = deepcopy(content)
    if section in SECTIONS:
        content[section] = "PLACE"
    elif section and vary:
        content["vary"][section] = ["PLACE"]
    elif section:
        content["base"][section] = "PLACE"
    text = yaml.safe_dump(content, sort_keys=False)
    text = text.replace("PLACE", fragment) if section else f"{text}\n{fragment}\n"
    outcome(tmp_path / "study.yaml", text.encode("utf-8", "surrogatepass"))


@pytest.mark.parametrize("fragment", ODD)
def test_odd_yaml_is_no_number(tmp_path, content, fragment):
    content["base"]["friction"] = "PLACE"
    text = yaml.safe_dump(content, sort_keys=False).replace("PLACE", fragment)
    error = outcome(tmp_path / "study.yaml", text.encode("utf-8", "surrogatepass"))
    assert isinstance(error, StudyError)


@pytest.mark.parametrize("section", SECTIONS)
@pytest.mark.parametrize("fragment", ["0x" + "F" * 5000, "[0x" + "F" * 5000 + "]"])
def test_numbers_too_long_to_be_printed(tmp_path, content, section, fragment):
    content[section] = "PLACE"
    text = yaml.safe_dump(content, sort_keys=False).replace("PLACE", fragment)
    assert isinstance(outcome(tmp_path / "study.yaml", text.encode()), StudyError)


@of_files
@given(numbers=st.dictionaries(st.sampled_from(NAMES), magnitudes, max_size=6))
@example(numbers={"radius": 5e-324})
@example(numbers={"tangential_ratio": 1e-17})
@example(numbers={"tangential_ratio": 1e-16, "cell": 1.0})
@example(numbers={"tangential_load": 1e-20})
def test_numbers_of_any_magnitude(tmp_path, content, numbers):
    content = deepcopy(content)
    units = {"radius": "m", "load": "N", "youngs_modulus": "Pa", "wear_coefficient": "/ Pa"}
    units |= {"plastic_limit": "Pa", "cell": "m", "tangential_load": "N"}
    units |= {"roughness.amplitude": "m", "roughness.slope_x": "rad", "roughness.slope_y": "rad"}
    for name, number in numbers.items():
        content["base"][name] = f"{number!r} {units.get(name, '')}".strip()
    if numbers.keys() & {"tangential_load"}:
        content["base"].pop("tangential_ratio")
    found = outcome(tmp_path / "study.yaml", yaml.safe_dump(content).encode())
    if isinstance(found, Study):
        for case in found.cases().values():
            assert all(map(math.isfinite, (case.hertz_radius, case.hertz_pressure, case.coupling)))
            assert min(case.hertz_radius, case.hertz_pressure, *case.grid_spacing) > 0.0


@of_files
@given(name=st.one_of(st.sampled_from(NAMES), st.text(max_size=8)), value=fragments)
def test_any_assignment(tmp_path, content, name, value):
    text = yaml.safe_dump(content).encode()
    outcome(tmp_path / "study.yaml", text, [f"{name}={value}"])
    outcome(tmp_path / "study.yaml", text, [f"{name}{value}"])
