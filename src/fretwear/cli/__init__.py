"""The command line; large libraries are imported by the commands that need them."""

import gc
import os
import signal
import sys
from types import FrameType
from typing import NoReturn


def main() -> None:
    """Run the command line; at a request to stop it cleans up and exits as shells expect."""
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        # A process started by nohup outlives its terminal.
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _stop)
    # Loading is a tenth faster with little garbage collection, and without a search for plug-ins.
    gc.set_threshold(100_000)
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    try:
        from fretwear.cli.program import app

        app()
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)


def _stop(number: int, _: FrameType | None) -> NoReturn:
    # A scheduler's second signal must not interrupt what the first one has begun.
    signal.signal(number, signal.SIG_IGN)
    sys.exit(128 + number)
