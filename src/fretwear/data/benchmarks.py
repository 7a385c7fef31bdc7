"""What the simulations of a study took, from the tables that Snakemake writes beside them."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

BENCHMARKS = Path("benchmarks")
_MEBIBYTE = 1 << 20


@dataclass(frozen=True)
class Spent:
    """What jobs took.

    Attributes
    ----------
    jobs : int
        How many jobs.
    seconds : float
        Time on the clock, one job after the other.
    processor_seconds : float
        Processor time, s.
    memory_bytes : float
        Memory of the largest; NaN where it was not measured.
    """

    jobs: int
    seconds: float
    processor_seconds: float
    memory_bytes: float


def spent_on_simulations(results: str | PathLike[str]) -> Spent | None:
    """Add up what the jobs that simulate took, each by its last run.

    Parameters
    ----------
    results : str or path-like
        Folder of the study's results; the benchmarks of simulations lie in folders of
        ``benchmarks/``, those of other rules in ``benchmarks/`` itself.

    Returns
    -------
    Spent or None
        None where nothing was measured.
    """
    rows = list(_rows(Path(results) / BENCHMARKS))
    if not rows:
        return None
    memory = [row[2] for row in rows if math.isfinite(row[2])]
    return Spent(
        jobs=len(rows),
        seconds=math.fsum(row[0] for row in rows),
        processor_seconds=math.fsum(row[1] for row in rows if math.isfinite(row[1])),
        memory_bytes=max(memory, default=math.nan) * _MEBIBYTE,
    )


def _rows(folder: Path) -> Iterator[tuple[float, float, float]]:
    for file in sorted(folder.glob("*/**/*.tsv")):
        try:
            table = list(
                csv.DictReader(file.read_text(encoding="utf-8").splitlines(), dialect="excel-tab")
            )
        except (OSError, UnicodeDecodeError):
            continue
        if table and math.isfinite(seconds := _number(table[-1].get("s"))):
            yield seconds, _number(table[-1].get("cpu_time")), _number(table[-1].get("max_rss"))


def _number(text: str | None) -> float:
    """Return a number; NaN for what Snakemake could not measure of a short job."""
    try:
        return float(text or "nan")
    except ValueError:
        return math.nan
