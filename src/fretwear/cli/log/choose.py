"""Which log a command writes: by its options, the environment and where it writes to."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from enum import StrEnum
from itertools import pairwise

from fretwear.cli.log.base import Log, QuietLog

FORMAT_OPTION = "--log-format"
FORMAT_VARIABLE = "FRETWEAR_LOG_FORMAT"


class LogFormat(StrEnum):
    """How progress and errors are written."""

    AUTO = "auto"
    LINES = "lines"
    JSON = "json"


def chosen_log(log_format: LogFormat, *, quiet: bool) -> Log:
    """Return the log in a format; a quiet one tells of errors only."""
    log = _log(log_format)
    return QuietLog(log) if quiet else log


def _log(log_format: LogFormat) -> Log:
    if log_format is LogFormat.JSON:
        from fretwear.cli.log.json_lines import JsonLog

        return JsonLog()
    if log_format is LogFormat.AUTO and shows_a_bar():
        from fretwear.cli.log.bar import BarLog

        return BarLog()
    from fretwear.cli.log.lines import LinesLog

    return LinesLog()


def shows_a_bar() -> bool:
    """Whether the standard error stream is a terminal that can redraw a line.

    The colours that FORCE_COLOR wants in a log file do not make a terminal of it.
    """
    return sys.stderr.isatty() and os.environ.get("TERM", "").lower() not in ("dumb", "unknown")


def format_in_call(arguments: Sequence[str], environment: Mapping[str, str]) -> LogFormat:
    """Tell in which format a call wants its errors that is too wrong to be parsed."""
    words = [word for argument in arguments for word in argument.split("=", 1)]
    named = [value for name, value in pairwise(words) if name == FORMAT_OPTION]
    wanted = named[-1] if named else environment.get(FORMAT_VARIABLE, "")
    return LogFormat.JSON if wanted == LogFormat.JSON else LogFormat.AUTO
