"""Being stopped from outside: by Ctrl-C, or by a scheduler's SIGTERM."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

_WORDS = {signal.SIGINT: "by Ctrl-C", signal.SIGTERM: "by SIGTERM"}


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
    # A second Ctrl-C must not interrupt the cleaning up of the first.
    for each in _WORDS:
        signal.signal(each, signal.SIG_IGN)
    raise Stopped(number)
