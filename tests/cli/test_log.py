"""What a command says on a terminal, in lines and in JSON, the time left, and how it is stopped."""

import fcntl
import io
import json
import math
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import termios
import time
import warnings
from contextlib import contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace

import pyte
import pytest

from fretwear.cli.progress import Log, TimeLeft, step_text
from fretwear.run.simulate import steps
from fretwear.study.reading import load_study, select_case


@pytest.fixture
def case(desk):
    del desk
    return select_case("tiny.yaml", None, ["load=50 N"])


@pytest.fixture
def at(case):
    """The first step of the case, moved to another cycle."""
    step = next(steps(case))

    def moved(cycle, **changes):
        return replace(step, state=replace(step.state, cycle=float(cycle), **changes))

    return moved


@pytest.mark.parametrize("log_format", ["lines", "json"])
def test_quiet_prints_errors_alone(desk, log_format):
    call = ("run", "tiny.yaml", "-q", "--log-format", log_format)
    result = desk.call(*call, status=2)
    assert "one must be chosen" in result.stderr
    assert result.stderr.count('"event"') == (log_format == "json")
    assert desk.call(*call, "--set", "load=50 N", "-o", "a.nc").output == ""
    assert "a.nc" in desk.files()


def events(text):
    return [json.loads(line) for line in text.splitlines()]


SOFT = ("--set", "load=50 N", "--set", "wear_coefficient=1 / Pa")


def test_a_run_is_told_from_its_start_to_its_end(desk, repository):
    before = datetime.now(UTC).timestamp()
    call = ("run", "tiny.yaml", "--set", "load=50 N", "-o", "a.nc", "--log-format", "json")
    result = desk.call(*call)
    assert result.stdout == ""
    told = events(result.stderr)
    times = [event["time"] for event in told]
    assert times == sorted(times)
    assert all(time.endswith("Z") for time in times)
    first, last = (datetime.fromisoformat(times[i]).timestamp() for i in (0, -1))
    assert before - 0.01 <= first <= last <= datetime.now(UTC).timestamp() + 0.01
    names = [event["event"] for event in told]
    assert names[:2] == ["start", "case_start"]
    assert set(names[2:-3]) == {"step"}
    assert names[-3:] == ["case_end", "result", "end"]
    assert told[0]["command"] == "run"
    # A step has the numbers of the dataset under their names.
    step, end = told[-4], told[-1]
    assert step["case_id"].startswith("P50N-")
    assert (step["cycle"], step["cycles"], step["seconds_left"]) == (200, 200, 0)
    assert (step["case_number"], step["case_count"]) == (1, 1)
    assert 0 < step["error_estimate"] < 0.01
    assert step["contact_half_width_x"] == pytest.approx(155e-6, rel=0.01)  # in m
    assert (end["status"], end["exit_status"], end["file"]) == ("done", 0, "a.nc")
    assert_in_reference(told, repository)


@pytest.mark.parametrize(
    ("call", "status", "exit_status", "message"),
    [
        (("run", "tiny.yaml"), "wrong_input", 2, "one must be chosen"),
        (("run", "tiny.yaml", *SOFT), "failed", 1, "no step after"),
        (("merge", "tiny.yaml"), "failed", 1, "no case of the study is done"),
        (("run", "tiny.yaml", "--cse", "x"), "", 2, "no such option: --cse"),
        (("rnu",), "", 2, "rnu"),
    ],
)
def test_an_error_is_an_event_and_the_end_tells_the_status(
    desk, monkeypatch, repository, call, status, exit_status, message
):
    monkeypatch.setenv("FRETWEAR_LOG_FORMAT", "json")
    result = desk.call(*call, status=exit_status)
    told = events(result.stderr)
    (error,) = (event for event in told if event["event"] == "error")
    assert message in error["message"]
    assert told[-1]["exit_status"] == error["exit_status"] == exit_status
    if status:  # A call that cannot be parsed has an error alone.
        assert (told[0]["event"], told[-1]["event"]) == ("start", "end")
        assert told[-1]["status"] == status
    assert_in_reference(told, repository)


def assert_in_reference(told, repository):
    page = (repository / "docs/reference/logs.md").read_text(encoding="utf-8")
    for event in told:
        assert f"| `{event['event']}` |" in page
        assert not [field for field in event if f"`{field}`" not in page]


def test_warnings_defects_and_what_is_not_finite_leave_no_line_that_is_no_json(capsys):
    log = Log("json")
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        log.begin("run")
        warnings.warn("mind the step", UserWarning, stacklevel=1)
    log.error("a defect of fretwear", 1, defect=ZeroDivisionError("division by zero"))
    log.result(Path("a.nc"), "", half=0.5, limit=math.inf, unknown=math.nan)
    _, warning, defect, result = events(capsys.readouterr().err)
    assert (warning["event"], warning["message"]) == ("warning", "mind the step")
    assert "defect of fretwear" in defect["message"]
    assert "ZeroDivisionError" in defect["traceback"]
    assert (result["half"], result["limit"], result["unknown"]) == (0.5, None, None)


@pytest.fixture
def said():
    return io.StringIO()


@pytest.fixture
def log(clock, said):
    return Log(stream=said, clock=clock)


@pytest.mark.parametrize(
    ("seconds", "apart", "least", "most"),
    [(20, 0.1, 10, 13), (86400, 10, 1000, 2000)],
    ids=["seconds", "a day"],
)
def test_a_log_has_the_first_and_the_last_step_and_not_too_many_between(
    log, clock, case, at, said, seconds, apart, least, most
):
    with log.case(case, Path("a.nc")) as observe:
        for number in range(round(seconds / apart) + 1):
            clock.now = number * apart
            observe(at(200 * clock.now / seconds))
    lines = said.getvalue().splitlines()
    assert lines[0] == f"case {case.case_id}"
    assert lines[1].startswith("cycle 0 of 200")
    assert lines[-1].startswith("cycle 200 of 200")
    assert least <= len(lines) <= most
    line = step_text(at(20, step=4, error_estimate=0.00123), 125.4)
    assert line == "cycle 20 of 200, step 4, step error 0.12 %, half-width 148.6 µm, 2 min left"


def test_the_cases_of_a_batch_are_numbered(log, at, said):
    cases = load_study("tiny.yaml").cases()
    log.batch(cases)
    for case in cases.values():
        with log.case(case, Path("a.nc")) as observe:
            observe(at(200))
    lines = said.getvalue().splitlines()
    told = [line.partition(": ")[0] for line in lines if ": P" in line]
    assert told == ["case 1 of 2", "case 2 of 2"]
    assert lines[-1] == "case 2 of 2 done in 0 s, 0 s left"


def test_names_in_messages_are_no_markup_and_long_ones_are_not_broken(log, said):
    name = "[bold]" + 50 * "long/" + ":smile:"
    log.note(name)
    log.error(name, 1)
    assert said.getvalue().splitlines() == [name, f"fretwear: error: {name}"]


def begun(clock, planned, cycles):
    """The time left of a single case, which has just begun."""
    left = TimeLeft({"one": planned}, clock)
    left.begin("one", cycles)
    return left


@pytest.mark.parametrize(("factor", "largest"), [(1.5, 100.0), (1.3, 1e9), (2.0, 50.0), (1.0, 1.0)])
@pytest.mark.parametrize("misjudged", [0.5, 1.0, 2.0])
def test_time_left_is_right_within_a_factor_of_four_all_along(clock, factor, largest, misjudged):
    # Steps grow by a factor until they are as large as they may be, and every one takes 1 s, as
    # real ones nearly do. The speed in cycles alone is a hundredfold off.
    size, cycles = 1.0, [1.0]
    while cycles[-1] < 7000.0:
        size = min(factor * size, largest)
        cycles.append(min(cycles[-1] + size, 7000.0))
    left = begun(clock, misjudged * len(cycles), 7000)
    for number, cycle in enumerate(cycles[:-1], start=1):
        clock.now += 1.0
        left.note(cycle)
        expected = len(cycles) - number
        assert expected / 4.0 - 1.0 <= left.seconds_left <= 4.0 * expected + 1.0


def test_time_left_runs_down_and_its_share_never_falls(clock):
    left = begun(clock, 10.0, 100)
    left.note(0.0)
    clock.now = 4.0
    assert left.seconds_left == pytest.approx(6.0)
    clock.now = 40.0
    assert left.seconds_left == 0.0
    left, shares = begun(clock, 1.0, 1000), []
    for cycle in (0.0, 1.0, 2.0, 500.0, 501.0, 502.0, 1000.0):
        clock.now += 1.0
        left.note(cycle)
        shares.append(left.share)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    # A run that resumes from a checkpoint has less to do.
    whole, rest = begun(clock, 60.0, 1000), begun(clock, 60.0, 1000)
    whole.note(0.0)
    rest.note(900.0)
    assert rest.seconds_left == pytest.approx(0.1 * whole.seconds_left)


def test_time_left_begins_anew_with_each_run_of_a_case_that_keeps_an_accuracy(clock):
    """Runs on ever narrower cells, each of which begins at cycle 0, take longer and longer."""
    cycles = [0.0, 1.0, 3.0, 10.0, 30.0, 50.0]
    left = begun(clock, 6.6, 50)
    for cycle in cycles:
        clock.now += 0.1
        left.note(cycle)
    for number, cycle in enumerate(cycles[:-1], start=1):
        clock.now += 1.0
        left.note(cycle)
        to_come = len(cycles) - number
        assert to_come / 4.0 <= left.seconds_left <= 4.0 * to_come
    clock.now += 1.0
    left.note(50.0)
    assert (left.seconds_left, left.share) == (0.0, 1.0)
    left = begun(clock, 4.0, 50)
    for cycle in (0.0, 50.0, 0.0, 50.0):
        clock.now += 1.0
        left.note(cycle)
    assert left.seconds_left == 0.0


def test_a_batch_learns_from_its_first_cases_how_fast_the_machine_is(clock):
    left = TimeLeft({"first": 2.0, "second": 5.0}, clock)
    left.begin("first", 200)
    assert (left.number, left.batch_seconds_left) == (1, pytest.approx(2.0 + 5.0))
    clock.now = 3.0 * 2.0
    left.note(200)
    left.end()
    assert left.batch_seconds_left == pytest.approx(3.0 * 5.0)
    left.begin("second", 200)
    assert (left.number, left.count) == (2, 2)
    assert left.seconds_left == left.batch_seconds_left == pytest.approx(3.0 * 5.0)


DEADLINE = 60.0


def on_a_terminal(*command, columns=80, **settings):
    """Run a command of fretwear on a terminal of its own; settings are environment variables.

    Returns all it wrote, its exit status, and the lines of the screen after each piece of output.
    """
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    unwanted = ("NO_COLOR", "FORCE_COLOR", "FRETWEAR_LOG_FORMAT", "COLUMNS", "LINES")
    environment = {name: value for name, value in os.environ.items() if name not in unwanted}
    process = subprocess.Popen(
        [sys.executable, "-m", "fretwear", *map(str, command)],
        stdin=slave,
        stdout=slave,
        stderr=slave,
        env={**environment, "TERM": "xterm-256color", **settings},
    )
    os.close(slave)
    raw, screens, screen = "", [], pyte.Screen(columns, 24)
    stream = pyte.ByteStream(screen)
    with suppress(OSError):  # Linux says so that the other side is closed
        while piece := os.read(master, 65536):
            stream.feed(piece)
            raw += piece.decode(errors="replace")
            screens.append([line.rstrip() for line in screen.display if line.strip()])
    os.close(master)
    return SimpleNamespace(raw=raw, screens=screens, status=process.wait(DEADLINE))


RUN = ("run", "tiny.yaml", "--set", "load=50 N", "--set", "cell=0.7 um", "-o", "a.nc")
COLOUR = re.compile(r"\x1b\[[0-9;]*[34][0-9]")


@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize("columns", [80, 40])
def test_a_terminal_shows_where_a_run_is_and_keeps_just_the_result(columns):
    seen = on_a_terminal(*RUN, columns=columns)
    assert seen.status == 0
    lines = [line for screen in seen.screens for line in screen]
    bars = [line for line in lines if line.startswith("cycle ")]
    assert bars
    assert all(line.endswith("left") and len(line) <= columns for line in bars)
    if columns < 80:
        return
    assert any("cycle 200 of 200" in line for line in lines)
    assert any("half-width 15" in line for line in lines)
    first, last = seen.screens[-1]
    assert first.startswith("case P50N")
    assert last.startswith("a.nc: ")
    assert len(seen.raw) < 50_000, "a terminal is not flooded"
    assert {len(line) for line in bars} == {80}
    assert len({line.index("━") for line in bars}) == 1, "nothing jumps"
    assert max(map(len, seen.screens)) == 3


def test_colours_are_off_with_no_color_and_only_when_it_is_not_empty():
    assert COLOUR.search(on_a_terminal("plan", "missing.yaml", NO_COLOR="").raw)
    for call in (("plan", "missing.yaml"), ("--help",)):
        assert not COLOUR.search(on_a_terminal(*call, NO_COLOR="1").raw)


def test_a_terminal_that_cannot_redraw_and_a_log_file_with_forced_colours_get_lines(
    desk, monkeypatch
):
    seen = on_a_terminal(*RUN, columns=120, TERM="dumb")
    assert "\x1b" not in seen.raw
    assert any(line.startswith("cycle 0 of 200, step 0") for line in seen.screens[-1])
    monkeypatch.setenv("FORCE_COLOR", "1")
    result = desk.call(*RUN)
    assert result.stderr.splitlines()[1].startswith("cycle 0 of 200")
    assert "\x1b[?25l" not in result.stderr


SCRIPT = """
import time
import fretwear.cli as signals
signals._SAME_WISH_SECONDS, signals._LONGEST_CLEANING_SECONDS = {patience}
with signals.stopping():
    try:
        print("at work", flush=True)
        time.sleep(60)
    finally:
        print("cleaning", flush=True)
        for _ in range(600):
            time.sleep(0.1)
"""


@contextmanager
def cleaning(asked, patience):
    """A process that was asked to stop and cleans up, which takes for ever."""
    command = [sys.executable, "-c", SCRIPT.format(patience=patience)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as process:
        assert process.stdout.readline() == "at work\n"
        process.send_signal(asked)
        assert process.stdout.readline() == "cleaning\n"
        yield process
        process.kill()


@pytest.mark.parametrize(
    ("asked", "patience", "again", "status"),
    [(signal.SIGINT, (0.0, 60.0), True, 130), (signal.SIGTERM, (60.0, 1.0), False, 143)],
)
def test_a_second_ctrl_c_or_lost_patience_ends_a_process_that_cleans_up_for_too_long(
    asked, patience, again, status
):
    with cleaning(asked, patience) as process:
        if again:
            process.send_signal(asked)
        assert "stopped: at once" in process.communicate(timeout=30)[1]
        assert process.returncode == status


def test_a_wish_that_is_told_twice_is_one_wish():
    with cleaning(signal.SIGINT, patience=(60.0, 60.0)) as process:
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGTERM)
        time.sleep(0.3)
        assert process.poll() is None


WATCHED = """
import os, signal, sys, time
from fretwear.cli import Stopped, _leave, stopping, watch
def wait():  # a signal just before a single long sleep would be handled after it
    for _ in range(600): time.sleep(0.1)
try:
    with stopping():
        watch()
        print("at work", flush=True)
        {work}
except Stopped as stopped:
    _leave(stopped.exit_status, f'stopped: {{stopped}}')
"""


@pytest.mark.parametrize(
    ("work", "status", "words"),
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", 139, "fretwear: error: crashed (SIGSEGV): "),
        ("os.kill(os.getpid(), signal.SIGKILL)", 137, "fretwear: error: killed: out of memory"),
        ("sys.exit(2)", 2, ""),
        ("os.kill(os.getppid(), signal.SIGTERM); wait()", 143, "stopped: by SIGTERM"),
        ("os.kill(os.getppid(), signal.SIGKILL); wait()", -9, "stopped: by SIGTERM"),
    ],
)
def test_who_watches_a_process_tells_what_it_could_not_and_ends_as_it_did(work, status, words):
    command = [sys.executable, "-c", WATCHED.format(work=work)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    assert done.stdout == "at work\n"
    assert (done.returncode, words in done.stderr) == (status, True)
    assert done.stderr.count("\n") == bool(words)
