"""What was measured, kept between runs."""

import json
import platform
import time
from importlib.metadata import version
from pathlib import Path

from benchmarks.verification.section import Data, Section

DIGITS = 6


class Store:
    """A JSON file with one entry per section: data, seconds, versions.

    Parameters
    ----------
    path
        The file; made when the first section is measured.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._entries: dict[str, Data] = {}
        if path.exists():
            self._entries = json.loads(path.read_text(encoding="utf-8"))

    def measure(self, section: Section) -> None:
        """Run a section and keep what it finds; a library it lacks leaves the old data."""
        print(f"{section.name} ...", end=" ", flush=True)
        start = time.process_time()
        try:
            data = section.measure()
        except ModuleNotFoundError as missing:
            print(f"skipped: {missing.name} is not installed")
            return
        seconds = time.process_time() - start
        print(f"{seconds:.0f} s", flush=True)
        self._entries[section.name] = {
            "seconds": round(seconds),
            "versions": {
                "Python": platform.python_version(),
                **{name: version(name) for name in ("fretwear", "numpy", "scipy")},
            },
            "data": rounded(data),
        }
        text = json.dumps(self._entries, indent=1, ensure_ascii=False) + "\n"
        self._path.write_text(text, encoding="utf-8")

    def entry(self, section: Section) -> Data | None:
        """Data, seconds and versions of a section, or None where it was never run."""
        return self._entries.get(section.name)


def rounded(value: object) -> object:
    """The same data with floats of so many digits as a reader can use."""
    if isinstance(value, dict):
        return {str(key): rounded(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(entry) for entry in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value
