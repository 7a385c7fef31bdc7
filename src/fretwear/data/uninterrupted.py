"""Work that is not to be interrupted half-way: Ctrl-C and SIGTERM wait until it is done.

Python raises what a signal handler raises wherever the process is at. Inside of a library that
holds a lock, as xarray does around the netCDF library, that leaves the lock taken, and closing the
file then waits for it for ever.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Put off Ctrl-C and SIGTERM until the ``with`` block is left; then they do what they do.

    Only the main thread receives signals: in another one there is nothing to put off.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        del frame
        received.append(number)

    # None stands for a handler that is not Python's and could not be put back.
    before = {number: handler for number in _SIGNALS if (handler := signal.getsignal(number))}
    for number in before:
        signal.signal(number, note)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if received:
            signal.raise_signal(received[0])
