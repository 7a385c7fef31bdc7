"""Whatever a file holds, reading it ends in a study or in a list of problems."""

import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fretwear.study.problems import StudyError
from fretwear.study.sections import NAMES
from fretwear.study.study import Study, load_study
from fretwear.study.tree import parameter_names

anything = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.dates(),
        st.binary(max_size=5),
        st.text(max_size=10),
        st.sampled_from(["50 N", "208 GPa", "0.2 um", "5.7 deg", "7e-13 / Pa", "none", "1e-3"]),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.dictionaries(
            st.one_of(st.text(max_size=5), st.integers(), st.sampled_from(["from", "to", "kind"])),
            inner,
            max_size=4,
        ),
    ),
    max_leaves=8,
)
names = st.sampled_from(list(parameter_names()))
settings_of_files = settings(
    max_examples=150,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


def outcome(file, text):
    file.write_text(text, encoding="utf-8", errors="replace")
    found: Study | StudyError
    try:
        found = load_study(file)
    except StudyError as error:
        found = error
    if isinstance(found, StudyError):
        assert found.problems
        assert str(file) in str(found)
        assert all(problem.rule for problem in found.problems)
    return found


@settings_of_files
@given(text=st.text(max_size=200))
def test_any_text(tmp_path, text):
    assert isinstance(outcome(tmp_path / "study.yaml", text), StudyError)


@settings_of_files
@given(changes=st.dictionaries(st.sampled_from(NAMES), anything, min_size=1))
def test_any_value_of_any_section(tmp_path, content, changes):
    content.update(changes)
    outcome(tmp_path / "study.yaml", yaml.safe_dump(content))


@settings_of_files
@given(
    base=st.dictionaries(names, anything, max_size=4),
    vary=st.dictionaries(names, anything, max_size=3),
)
def test_any_value_of_any_parameter(tmp_path, content, base, vary):
    content["base"].update(base)
    content["vary"].update(vary)
    outcome(tmp_path / "study.yaml", yaml.safe_dump(content))


@settings_of_files
@given(
    load=st.lists(st.floats(0.1, 1000.0), min_size=1, max_size=3, unique=True),
    ratio=st.lists(st.floats(0.01, 1.2), min_size=1, max_size=3, unique=True),
    limit=st.floats(1.0, 10000.0),
    slope=st.floats(0.0, 44.0),
    amplitude=st.lists(st.floats(0.0, 2.0), min_size=1, max_size=3, unique=True),
    skip=st.booleans(),
)
def test_every_sound_study_has_cases_that_python_accepts(
    tmp_path, content, load, ratio, limit, slope, amplitude, skip
):
    content["invalid"] = "skip" if skip else "stop"
    content["base"]["roughness"] = {"slope_x": f"{slope} deg", "slope_y": "1 deg"}
    content["vary"] = {
        "load": [f"{value!r} N" for value in load],
        "tangential_ratio": ratio,
        "plastic_limit": ["none", f"{limit} MPa"],
        "roughness.amplitude": [f"{value!r} um" for value in amplitude],
    }
    found = outcome(tmp_path / "study.yaml", yaml.safe_dump(content))
    if isinstance(found, Study):
        for point in found.points():
            if point.case is not None:
                assert point.case.replace() == point.case
