"""The command line: each command reads its input, calls the room that does the work, reports.

Nothing heavy is imported before a command needs it, so that help and plans come at once.
"""

from fretwear.cli.app import app, main

__all__ = ["app", "main"]
