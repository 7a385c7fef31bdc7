"""What a person sees of a command on a terminal."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import termios
import time

import pyte
import pytest

DEADLINE = 60.0


class Seen:
    """What a command has shown.

    Attributes
    ----------
    raw : str
        Everything with its control sequences.
    screens : list of list of str
        The lines of the screen after each piece of output; the last one is what remains.
    status : int
        Exit status.
    """

    def __init__(self):
        self.raw = ""
        self.screens = []
        self.status = None

    @property
    def last(self):
        return self.screens[-1]

    def ever(self, text):
        return any(text in line for screen in self.screens for line in screen)


def on_a_terminal(*command, columns=80, folder=".", **settings):
    """Run a command of fretwear on a terminal of its own; settings are environment variables."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    unwanted = ("NO_COLOR", "FORCE_COLOR", "FRETWEAR_LOG_FORMAT", "COLUMNS", "LINES")
    environment = {name: value for name, value in os.environ.items() if name not in unwanted}
    process = subprocess.Popen(
        [sys.executable, "-m", "fretwear", *map(str, command)],
        cwd=folder,
        stdin=slave,
        stdout=slave,
        stderr=slave,
        env={**environment, "TERM": "xterm-256color", **settings},
    )
    os.close(slave)
    seen, screen = Seen(), pyte.Screen(columns, 24)
    stream = pyte.ByteStream(screen)
    give_up = time.monotonic() + DEADLINE
    while time.monotonic() < give_up:
        try:
            piece = os.read(master, 65536)
        except OSError:  # Linux says so that the other side is closed
            break
        if not piece:
            break
        stream.feed(piece)
        seen.raw += piece.decode(errors="replace")
        seen.screens.append([line.rstrip() for line in screen.display if line.strip()])
    os.close(master)
    seen.status = process.wait(DEADLINE)
    return seen


RUN = ("run", "tiny.yaml", "--set", "load=50 N", "--set", "cell=0.7 um", "-o", "a.nc")
COLOUR = re.compile(r"\x1b\[[0-9;]*[34][0-9]")


@pytest.mark.usefixtures("desk")
def test_a_terminal_shows_where_a_run_is_and_keeps_just_the_result():
    seen = on_a_terminal(*RUN)
    assert seen.status == 0
    assert seen.ever("cycle 200 of 200")
    assert seen.ever("half-width 15")
    assert len(seen.last) == 2
    assert seen.last[0].startswith("case P50N")
    assert seen.last[1].startswith("a.nc: ")
    assert len(seen.raw) < 50_000, "a terminal is not flooded"
    bars = [line for screen in seen.screens for line in screen if line.startswith("cycle ")]
    assert bars
    assert all(line.endswith("left") and len(line) == 80 for line in bars)
    assert len({line.index("━") for line in bars}) == 1, "nothing jumps"
    assert max(map(len, seen.screens)) == 3


@pytest.mark.usefixtures("desk")
def test_a_narrow_terminal_keeps_the_time_left():
    seen = on_a_terminal(*RUN, columns=40)
    bars = [line for screen in seen.screens for line in screen if line.startswith("cycle ")]
    assert all(line.endswith("left") and len(line) <= 40 for line in bars)


def test_colours_are_off_with_no_color_and_only_when_it_is_not_empty():
    assert COLOUR.search(on_a_terminal("plan", "missing.yaml", NO_COLOR="").raw)
    for call in (("plan", "missing.yaml"), ("--help",)):
        assert not COLOUR.search(on_a_terminal(*call, NO_COLOR="1").raw)


@pytest.mark.usefixtures("desk")
def test_a_terminal_that_cannot_redraw_gets_lines():
    seen = on_a_terminal(*RUN, columns=120, TERM="dumb")
    assert "\x1b" not in seen.raw
    assert any(line.startswith("cycle 0 of 200, step 0") for line in seen.last)


def test_a_log_file_gets_lines_though_colours_are_forced(desk, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    result = desk.call(*RUN)
    assert result.stderr.splitlines()[1].startswith("cycle 0 of 200")
    assert "\x1b[?25l" not in result.stderr
