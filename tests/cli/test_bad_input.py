import pytest

WAVES = {"kind": "wavy", "amplitude": "0.2 um", "slope_x": "5.7 deg", "slope_y": "1 deg"}

# What a user can get wrong: (changes, key, value, part of the rule)
MISTAKES = {
    "misspelt key": ({"base/lod": "50 N"}, "base.lod", "50 N", "did you mean 'load'"),
    "missing key": ({"base/radius": None}, "base.radius", "", "is missing"),
    "both tangential": ({"base/tangential_load": "9 N"}, "base.tangential_load", "9 N", "one"),
    "neither tangential": (
        {"base/tangential_ratio": None},
        "base.tangential_ratio",
        "",
        "is missing, and",
    ),
    "wrong dimension": ({"base/radius": "10 N"}, "base.radius", "10 N", "must be a length"),
    "missing unit": ({"vary/load": ["25 N", 50]}, "vary.load[1]", "50", "needs a unit"),
    "negative": ({"vary/load": ["-25 N"]}, "vary.load[0]", "-25 N", "larger than 0"),
    "zero": ({"base/radius": "0 mm"}, "base.radius", "0 mm", "larger than 0"),
    "Poisson's ratio": ({"base/poisson_ratio": 0.6}, "base.poisson_ratio", "0.6", "at most 0.5"),
    "friction": ({"base/friction": 0}, "base.friction", "0", "larger than 0"),
    "gross sliding": (
        {"base/tangential_ratio": None, "base/tangential_load": "20 N"},
        "base.tangential_load",
        "20 N",
        "load = 25 N",
    ),
    "plastic limit": ({"base/plastic_limit": "0.1 MPa"}, "base.plastic_limit", "100 kPa", "carry"),
    "empty list": ({"vary/load": []}, "vary.load", "[]", "empty list"),
    "duplicate": ({"vary/load": ["25 N", "0.025 kN"]}, "vary.load[1]", "0.025 kN", "vary.load[0]"),
    "unequal lists": ({"design": "zip", "vary/friction": [0.3, 0.4, 0.5]}, "vary", "", "3"),
    "snapshot": ({"output/cycles": [0, 999]}, "output.cycles", "999", "beyond the last cycle"),
    "coarse cell": ({"base/roughness": WAVES}, "base.cell", "[10 um, 10 um]", "would be fine"),
}


@pytest.mark.parametrize("command", ["run", "plan", "merge", "figures", "report"])
@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_and_nothing_is_written(desk, content, mistake, command):
    changes, key, value, rule = MISTAKES[mistake]
    for place, new in changes.items():
        *sections, last = place.split("/")
        section = content
        for name in sections:
            section = section[name]
        section[last] = new
        if new is None:
            del section[last]
    desk.write(content)
    result = desk.call(command, "tiny.yaml")
    assert result.exit_code == 2
    for part in ("tiny.yaml", key, value, rule):
        assert part in result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout == ""
    assert desk.files() == ["tiny.yaml"]


def test_all_mistakes_are_named_at_once(desk, content):
    content["base"].update(lod="50 N", radius="10 N", friction=-1)
    desk.write(content)
    result = desk.call("plan", "tiny.yaml")
    assert "3 problems" in result.stderr
    for key in ("base.lod", "base.radius", "base.friction"):
        assert key in result.stderr


@pytest.mark.parametrize(
    ("text", "reason"),
    [("base: [1, 2", "not YAML"), ("", "empty"), ("just words", "must hold keys")],
)
def test_a_file_that_is_no_study_is_refused(desk, text, reason):
    desk.write(text, "odd.yaml")
    result = desk.call("run", "odd.yaml")
    assert result.exit_code == 2
    assert "odd.yaml" in result.stderr
    assert reason in result.stderr
    assert desk.files() == ["odd.yaml", "tiny.yaml"]


def test_a_missing_file_is_refused_with_a_likely_name(desk):
    result = desk.call("run", "tyni.yaml")
    assert result.exit_code == 2
    assert "tyni.yaml: there is no such file" in result.stderr
    assert "'tiny.yaml'" in result.stderr


def test_a_mistake_on_the_command_line_is_named_as_it_was_written(desk):
    result = desk.call("run", "tiny.yaml", "--set", "laod=30 N", "--set", "friction=two")
    assert result.exit_code == 2
    assert "--set laod = 30 N" in result.stderr
    assert "did you mean 'load'" in result.stderr
    assert "--set friction = two" in result.stderr


@pytest.mark.parametrize(
    "arguments", [["run"], ["rnu", "tiny.yaml"], ["run", "tiny.yaml", "--cse", "x"], ["show"]]
)
def test_a_wrong_call_is_wrong_input(desk, arguments):
    assert desk.call(*arguments).exit_code == 2
