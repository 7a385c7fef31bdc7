"""Commands on a pseudo-terminal, and what a person sees of them there."""

import fcntl
import os
import pty
import struct
import subprocess
import sys
import termios
import time

import pyte

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

    def __init__(self) -> None:
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
