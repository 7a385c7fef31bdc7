"""Being stopped from outside: by Ctrl-C, or by a scheduler's SIGTERM."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

_WORDS = {signal.SIGINT: "by Ctrl-C", signal.SIGTERM: "by SIGTERM"}

# A terminal and a workflow may both tell a process to stop: that is one wish. Later, it is another.
_SAME_WISH_SECONDS = 1.0
_LONGEST_CLEANING_SECONDS = 60.0


class Stopped(BaseException):
    """The process was asked to stop; no error, so that no handler of errors catches it.

    Attributes
    ----------
    signal : signal.Signals
        What asked for it.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.signal = signal.Signals(number)

    @property
    def exit_status(self) -> int:
        """Exit status that shells give to a process which a signal has ended."""
        return 128 + self.signal

    def __str__(self) -> str:
        return _WORDS[self.signal]


@contextmanager
def stopping() -> Iterator[None]:
    """Raise `Stopped` where the process is at when it is asked to stop, so that it cleans up."""
    before = {number: signal.signal(number, _stop) for number in _WORDS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _stop(number: int, frame: FrameType | None) -> NoReturn:
    del frame
    begun = time.monotonic()

    def hurry(number: int, frame: FrameType | None) -> None:
        del frame
        if time.monotonic() - begun > _SAME_WISH_SECONDS:
            _end(number)

    # The scheduler's signal must not interrupt the cleaning up of the first; people who press
    # Ctrl-C again mean it. Files are whole or not there, so nothing is spoilt.
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    signal.signal(signal.SIGINT, hurry)
    # What was interrupted inside of a library may have left it unable to clean up.
    watch = threading.Timer(_LONGEST_CLEANING_SECONDS, _end, [number])
    watch.daemon = True
    watch.start()
    raise Stopped(number)


def _end(number: int) -> None:
    os.write(2, b"fretwear: stopped: at once, without cleaning up\n")
    os._exit(128 + number)
