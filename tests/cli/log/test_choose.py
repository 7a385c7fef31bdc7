import pytest

from fretwear.cli.app import format_in_call
from fretwear.cli.common import LogFormat


def test_quiet_prints_nothing_when_all_goes_well(desk):
    result = desk.call("run", "tiny.yaml", "--set", "load=50 N", "-o", "a.nc", "--quiet")
    assert (result.exit_code, result.output) == (0, "")
    assert "a.nc" in desk.files()


@pytest.mark.parametrize("log_format", ["lines", "json"])
def test_quiet_still_prints_errors(desk, log_format):
    result = desk.call("run", "tiny.yaml", "-q", "--log-format", log_format)
    assert result.exit_code == 2
    assert "one must be chosen" in result.stderr
    assert result.stderr.count('"event"') == (log_format == "json")


@pytest.mark.parametrize(
    ("arguments", "environment", "expected"),
    [
        (["run", "--log-format", "json"], {}, LogFormat.JSON),
        (["run", "--log-format=json"], {}, LogFormat.JSON),
        (["run"], {"FRETWEAR_LOG_FORMAT": "json"}, LogFormat.JSON),
        (["run", "--log-format", "lines"], {"FRETWEAR_LOG_FORMAT": "json"}, LogFormat.LINES),
        (["run", "--log-format"], {}, LogFormat.LINES),
        (["run", "json"], {}, LogFormat.LINES),
    ],
)
def test_the_wanted_format_is_known_before_a_call_is_parsed(arguments, environment, expected):
    assert format_in_call(arguments, environment) is expected
