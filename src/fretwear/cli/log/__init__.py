"""What a command tells while it works: a bar, lines of text, JSON lines, or errors only."""

from fretwear.cli.log.base import Log
from fretwear.cli.log.choose import LogFormat, chosen_log, shows_a_bar

__all__ = ["Log", "LogFormat", "chosen_log", "shows_a_bar"]
