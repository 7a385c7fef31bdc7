from pathlib import Path

import pytest

from fretwear.cli.progress import Log, step_text
from fretwear.study.study import load_study


@pytest.fixture
def log(clock):
    return Log(clock=clock)


def test_a_line_tells_cycle_step_error_half_width_and_time_left(at):
    line = step_text(at(20, step=4, error_estimate=0.00123), 125.4)
    assert line == "cycle 20 of 200, step 4, error 0.12 %, half-width 147.8 um, 2 min left"


def test_a_log_has_the_first_and_the_last_step_and_not_too_many_between(
    log, clock, case, at, capsys
):
    with log.case(case, Path("a.nc")) as observe:
        for cycle in range(0, 201):
            observe(at(cycle))
            clock.now += 0.1
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == f"case {case.case_id}"
    assert lines[1].startswith("cycle 0 of 200")
    assert lines[-1].startswith("cycle 200 of 200")
    assert 10 <= len(lines) <= 13


def test_a_run_of_a_day_gets_hundreds_of_lines_and_not_tens_of_thousands(
    log, clock, case, at, capsys
):
    with log.case(case, Path("a.nc")) as observe:
        for second in range(0, 86400, 10):
            clock.now = float(second)
            observe(at(199 * second / 86400))
    assert 1000 < len(capsys.readouterr().err.splitlines()) < 2000


def test_the_cases_of_a_batch_are_numbered(log, at, capsys):
    cases = load_study("tiny.yaml").cases()
    with log.batch(cases):
        for case in cases.values():
            with log.case(case, Path("a.nc")) as observe:
                observe(at(200))
    lines = capsys.readouterr().err.splitlines()
    assert [line.partition(": ")[0] for line in lines if ": P" in line] == [
        "case 1 of 2",
        "case 2 of 2",
    ]
    assert lines[-1] == "case 2 of 2 done in 0 s, 0 s left"


def test_names_in_messages_are_no_markup_and_long_ones_are_not_broken(log, capsys):
    name = "[bold]" + 50 * "long/" + ":smile:"
    log.note(name)
    log.error(name, 1)
    assert capsys.readouterr().err == f"{name}\nfretwear: error: {name}\n"
