"""Whatever a file holds, reading it ends in a study to be planned or in a list of problems."""

import math
import re
from copy import deepcopy

import pytest
import yaml
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from fretwear.run.resources import batches, core_seconds
from fretwear.study.parameters import parameter_names
from fretwear.study.plan import Plan
from fretwear.study.problems import StudyError
from fretwear.study.reading import load_study
from fretwear.study.sections import SECTIONS
from fretwear.study.study import Study

# fmt: off
ODD = (
    "!!int ''", "!!int -", "!!int 1:x", "!!bool x", "!!null x", "!!float ''", "!!float 0x10",
    "!!timestamp x", "!!timestamp 2001-99-99", "2001-99-99", "!!binary '%'", "!!binary aGFsbG8=",
    "!!set {a, b}", "!!omap [a: 1]", "!!merge x", "!!python/object/apply:os.system ['exit 1']",
    "!!python/name:os.system", "!unknown x", "&a [*a]", "&a {b: *a}", "*unknown",
    "{<<: {load: 3 N}}", "{a: 1, a: 2}", "{1: 2, null: 3, [a]: 4}", "? - complex\n    : key",
    "0x" + "F" * 5000, "-0b" + "1" * 20000, "1" * 5000, "1:" * 3000 + "1", ".nan", "-.inf",
    "1e400 N", "1e-400 N", "-0.0 N", "１ N", "1_000 N", '"\\ud800"', '"\\0"', "\u2028", "\ufeff",
    "[" * 100, "{a: " * 50, "'", "|\n  text", "- -", "---", "...", "%YAML 9.9", "\t", "@",
)
# fmt: on
NAMES = list(parameter_names())

texts = st.sampled_from(["50 N", "208 GPa", "0.2 um", "5.7 deg", "7e-13 / Pa", "none", "1e-3"])
plain_keys = st.text(max_size=5) | st.integers() | st.sampled_from(["from", "to", "kind"])
plain_numbers = st.booleans() | st.integers() | st.floats()
plain_others = st.none() | st.dates() | st.binary(max_size=5) | st.text(max_size=10) | texts
plain = st.recursive(
    plain_numbers | plain_others,
    lambda some: st.lists(some, max_size=4) | st.dictionaries(plain_keys, some, max_size=4),
    max_leaves=8,
)
fragments = st.one_of(st.sampled_from(ODD), st.text(max_size=20))
magnitudes = st.one_of(st.floats(5e-324, 1.7e308), st.floats(-30, 30).map(lambda x: 10.0**x))
# What the suite can afford out of the examples of the profile.
of_files = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    max_examples=settings.default.max_examples // 4,
)


def told(error, file):
    assert error.problems
    assert all(problem.rule for problem in error.problems)
    assert str(file) in str(error)
    assert str(error).encode()
    return error


@pytest.fixture
def outcome(tmp_path):
    """A study that can be planned, or problems that can be printed."""

    def read(content, assignments=()):
        file = tmp_path / "study.yaml"
        text = content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass")
        file.write_bytes(text)
        try:
            found = load_study(file, assignments)
        except StudyError as error:
            return told(error, file)
        planned = Plan(found)
        assert core_seconds(batches(planned)) >= 0.0
        for row in planned.rows():
            assert "\n".join(row).encode()
        return found

    return read


@of_files
@given(content=st.binary(max_size=300) | st.text(max_size=200))
def test_any_bytes(outcome, content):
    assert isinstance(outcome(content), StudyError)


@of_files
@given(
    sections=st.dictionaries(st.sampled_from(SECTIONS), plain, max_size=2),
    base=st.dictionaries(st.sampled_from(NAMES), plain, max_size=4),
    vary=st.dictionaries(st.sampled_from(NAMES), plain, max_size=3),
)
def test_any_plain_value_of_any_section_and_parameter(outcome, content, sections, base, vary):
    content = deepcopy(content)
    content["base"].update(base)
    content["vary"].update(vary)
    outcome(yaml.safe_dump(content | sections))


@of_files
@given(fragment=fragments, section=st.sampled_from([*SECTIONS, *NAMES, ""]), vary=st.booleans())
def test_any_yaml_in_the_place_of_a_value(outcome, content, fragment, section, vary):
    content = deepcopy(content)
    if section in SECTIONS:
        content[section] = "PLACE"
    elif section and vary:
        content["vary"][section] = ["PLACE"]
    elif section:
        content["base"][section] = "PLACE"
    text = yaml.safe_dump(content, sort_keys=False)
    outcome(text.replace("PLACE", fragment) if section else f"{text}\n{fragment}\n")


LONG = "0x" + "F" * 5000  # too long to be printed


@pytest.mark.parametrize(
    ("section", "fragment"),
    [
        *(("friction", fragment) for fragment in ODD),
        *((section, fragment) for section in SECTIONS for fragment in (LONG, f"[{LONG}]")),
    ],
)
def test_odd_yaml_is_neither_a_number_nor_a_section(outcome, content, section, fragment):
    (content if section in SECTIONS else content["base"])[section] = "PLACE"
    text = yaml.safe_dump(content, sort_keys=False).replace("PLACE", fragment)
    assert isinstance(outcome(text), StudyError)


# What the core schema of YAML 1.2 (section 10.3.2) takes for numbers.
CORE = {
    r"[-+]?[0-9]+": int,
    r"0o[0-7]+": lambda text: int(text[2:], 8),
    r"0x[0-9a-fA-F]+": lambda text: int(text, 16),
    r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?": float,
}


@of_files
@given(
    text=st.text("0123456789" * 3 + "+-_.:eExXoObBaF٣３ ", min_size=1, max_size=8),
    name=st.sampled_from(["friction", "cycles"]),
)
@example(text="010", name="friction")
@example(text="0:30.5", name="friction")
@example(text="0100", name="cycles")
@example(text="1_00", name="cycles")
@example(text="-0.0", name="poisson_ratio")
def test_a_number_is_what_yaml_says_or_refused(outcome, content, text, name):
    content = deepcopy(content)
    content["vary"], content["output"] = {}, {}
    content["base"].update({"load": "50 N", "plastic_limit": "none", name: "PLACE"})
    found = outcome(yaml.safe_dump(content).replace("PLACE", text))
    if isinstance(found, Study):
        (case,) = found.cases().values()
        text = text.split("#")[0].strip()
        expected = next(read(text) for form, read in CORE.items() if re.fullmatch(form, text))
        assert getattr(case, name) == expected


@of_files
@given(numbers=st.dictionaries(st.sampled_from(NAMES), magnitudes, max_size=6))
@example(numbers={"radius": 5e-324})
@example(numbers={"tangential_ratio": 1e-17})
@example(numbers={"tangential_ratio": 1e-16, "cell": 1.0})
@example(numbers={"tangential_load": 1e-20})
def test_numbers_of_any_magnitude(outcome, content, numbers):
    content = deepcopy(content)
    units = {"radius": "m", "load": "N", "youngs_modulus": "Pa", "wear_coefficient": "/ Pa"}
    units |= {"plastic_limit": "Pa", "cell": "m", "tangential_load": "N"}
    units |= {"roughness.amplitude": "m", "roughness.slope_x": "rad", "roughness.slope_y": "rad"}
    for name, number in numbers.items():
        content["base"][name] = f"{number!r} {units.get(name, '')}".strip()
    if "tangential_load" in numbers:
        content["base"].pop("tangential_ratio")
    found = outcome(yaml.safe_dump(content))
    if isinstance(found, Study):
        for case in found.cases().values():
            assert all(map(math.isfinite, (case.hertz_radius, case.hertz_pressure, case.coupling)))
            assert min(case.hertz_radius, case.hertz_pressure, *case.grid_spacing) > 0.0


@of_files
@given(name=st.one_of(st.sampled_from(NAMES), st.text(max_size=8)), value=fragments)
def test_any_assignment(outcome, content, name, value):
    text = yaml.safe_dump(content)
    outcome(text, [f"{name}={value}"])
    outcome(text, [f"{name}{value}"])
