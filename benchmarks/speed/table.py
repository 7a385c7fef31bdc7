"""The table of speeds: required, aimed at, measured."""

import math
import os
import platform
import subprocess
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from benchmarks.pages import ROOT

_PACKAGES = ("fretwear", "numpy", "scipy", "ducc0", "tamaas", "ContactMechanics", "muGrid")


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Parameters
    ----------
    name
        Key of the row.
    job
        What was run.
    measured
        The number; NaN where it was not measured.
    unit
        Its unit.
    asked, aim
        The required and the desired value.
    at_least
        Whether large is good.
    note
        Further numbers of the same job.
    """

    name: str
    job: str
    measured: float
    unit: str
    asked: float
    aim: float
    at_least: bool = False
    note: str = ""

    @property
    def verdict(self) -> str:
        """How the number compares with both bounds."""
        if math.isnan(self.measured):
            return "not measured"
        if self._reaches(self.aim):
            return "reaches the aim"
        return "holds" if self._reaches(self.asked) else "falls short"

    def _reaches(self, bound: float) -> bool:
        return self.measured >= bound if self.at_least else self.measured <= bound

    def as_json(self) -> dict[str, Any]:
        entry = asdict(self) | {"verdict": self.verdict}
        return entry | {"measured": None} if math.isnan(self.measured) else entry


def from_json(entry: dict[str, Any]) -> Row:
    """A row that `Row.as_json` has written."""
    fields = {key: value for key, value in entry.items() if key != "verdict"}
    return Row(
        **{**fields, "measured": math.nan if entry["measured"] is None else entry["measured"]}
    )


def missing(name: str, job: str, unit: str, asked: float, aim: float, why: str) -> Row:
    """A row that was not measured, and why."""
    return Row(name, job, math.nan, unit, asked, aim, note=why)


def number(value: float) -> str:
    """Three significant digits, no powers of ten."""
    if math.isnan(value):
        return "–"
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


HEADER = ("job", "asked", "aim", "measured", "unit", "verdict")


def cells(row: Row) -> list[str]:
    """The texts of a row, in the order of `HEADER`."""
    sign = "≥ " if row.at_least else "≤ "
    bounds = [sign + number(bound) for bound in (row.asked, row.aim)]
    return [row.job, *bounds, number(row.measured), row.unit, row.verdict]


def line(row: Row) -> str:
    """A row for a terminal."""
    job, asked, aim, measured, unit, verdict = cells(row)
    return f"{job:<58}{asked:>8}{aim:>8}{measured:>9} {unit:<8}{verdict:<16}{row.note}"


def header() -> str:
    """The heading above the lines."""
    job, asked, aim, measured, unit, verdict = HEADER
    return f"{job:<58}{asked:>8}{aim:>8}{measured:>9} {unit:<8}{verdict:<16}also"


def surroundings() -> dict[str, Any]:
    """Machine, load and versions, by which a reader judges the numbers."""
    versions = {"Python": platform.python_version()}
    for package in _PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)),
        "load_average": round(os.getloadavg()[0], 2),
        "versions": versions,
        "commit": _commit(),
    }


def document(rows: Iterable[Row], **more: Any) -> dict[str, Any]:
    """The content of the JSON file."""
    return {**surroundings(), **more, "rows": [row.as_json() for row in rows]}


def falling_short(rows: Sequence[Row]) -> list[Row]:
    """The measured rows that fall short of the requirement."""
    return [row for row in rows if row.verdict == "falls short"]


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = [text.partition(":")[2].strip() for text in lines if text.startswith("model name")]
    return names[0] if names else platform.processor()


def _commit() -> str:
    done = subprocess.run(
        ["git", "describe", "--always", "--dirty"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout.strip()
