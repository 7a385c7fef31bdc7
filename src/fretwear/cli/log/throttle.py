"""Not too many lines: often at first, seldom in a long run."""

from __future__ import annotations

import time

from fretwear.cli.log.pace import Clock

_SHORTEST = 2.0
_LONGEST = 60.0
_SHARE = 0.02


class Throttle:
    """Tells whether a line is due: a run of a minute gets some thirty, one of a day a thousand."""

    def __init__(self, clock: Clock = time.monotonic) -> None:
        self._clock = clock
        self._started = clock()
        self._last: float | None = None

    def is_due(self, *, is_last: bool) -> bool:
        """Whether to write; the first and the last line always are."""
        now = self._clock()
        interval = min(_LONGEST, max(_SHORTEST, _SHARE * (now - self._started)))
        if not is_last and self._last is not None and now - self._last < interval:
            return False
        self._last = now
        return True
