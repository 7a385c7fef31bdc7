"""The command line: each command reads input, calls the package that does the work, and reports.

Nothing heavy is imported before a command needs it, so that help and plans appear at once.
"""

from __future__ import annotations

import os
import sys
from typing import Any

from fretwear.cli.supervise import Stopped, stopping, watch

__all__ = ["app", "main"]


def main(*, watched: bool = True) -> None:
    """Run the command line, in a process that another one watches, and leave with its status."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # Libraries count on both.
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115, PTH123
    try:
        # From here on, because a signal to stop may arrive while the process is still starting.
        with stopping():
            if watched:
                watch()
            from fretwear.cli.program import app

            app()
    except Stopped as stopped:
        stopped.leave()
    except MemoryError:  # before a command could open its log
        os.write(2, b"fretwear: error: there is not enough memory to start\n")
        sys.exit(1)


def __getattr__(name: str) -> Any:
    if name == "app":
        from fretwear.cli.program import app

        return app
    raise AttributeError(f"module 'fretwear.cli' has no attribute {name!r}")
