"""The command line; large libraries are imported by the commands that need them."""

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
    # xarray would import these (half a second) to recognise arrays that no command has. They stay
    # for a program that has imported xarray; units that need pint import it all the same.
    if "xarray" not in sys.modules:
        sys.modules.update(dict.fromkeys({"dask", "pint"} - sys.modules.keys()))  # type: ignore
    try:
        from fretwear.cli.program import app

        app()
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)


def _stop(number: int, _: FrameType | None) -> NoReturn:
    # A scheduler's second signal must not interrupt what the first one has begun.
    signal.signal(number, signal.SIG_IGN)
    sys.exit(128 + number)
