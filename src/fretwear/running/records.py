"""Records of jobs beside the case files: reasons of failures, logs, resources used.

``results`` is the folder of a study's results everywhere. Nothing of a result depends on these
files: truncated or foreign ones are ignored, and a failure to write one ends no computation.
"""

from __future__ import annotations

import csv
import json
import math
import os
from contextlib import suppress
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from os import PathLike
from pathlib import Path

from fretwear.data.safe import open_data, open_log, read_data

LOGS = Path("logs", "simulate")
BENCHMARKS = Path("benchmarks")
ENDED = "the process that ran it ended before it did: it was killed, or ran out of memory or time"

_SUFFIX = ".failed.json"
_MOST_BYTES = 100_000
_MEBIBYTE = 1 << 20


@dataclass(frozen=True)
class Failure:
    """A case that was started and has no result."""

    case_id: str  # the case
    reason: str  # what went wrong and what to do
    log: str  # log of the case, a file in the folder of the study's results
    time: str  # when, in UTC (ISO 8601)

    def __str__(self) -> str:
        return f"{self.reason} (log: {self.log})"


def record(results: str | PathLike[str], case_id: str, reason: str = ENDED) -> None:
    """Record why a case failed.

    The start of a case is recorded too, because a process that is killed cannot do so later.
    """
    log = (LOGS / f"{case_id}.log").as_posix()
    failure = Failure(case_id, reason, log, datetime.now(UTC).isoformat(timespec="seconds"))
    with open_log(_failure_file(results, case_id)) as stream:
        stream.write(json.dumps(asdict(failure), indent=1) + "\n")


def forget(results: str | PathLike[str], case_id: str) -> None:
    """Remove the record of a case that now has a result."""
    with suppress(OSError):
        _failure_file(results, case_id).unlink(missing_ok=True)


def failures(results: str | PathLike[str]) -> dict[str, Failure]:
    """Return the cases that were started and have no result, by id."""
    found = (_read(file) for file in sorted((Path(results) / LOGS).glob(f"*{_SUFFIX}")))
    return {failure.case_id: failure for failure in found if failure is not None}


def _failure_file(results: str | PathLike[str], case_id: str) -> Path:
    return Path(results) / LOGS / f"{case_id}{_SUFFIX}"


def _read(file: Path) -> Failure | None:
    try:
        failure = Failure(**json.loads(read_data(file, _MOST_BYTES)))
    except (OSError, ValueError, TypeError, RecursionError):
        return None
    valid = all(isinstance(text, str) for text in asdict(failure).values())
    return failure if valid and failure.case_id == file.name.removesuffix(_SUFFIX) else None


def log_file(results: str | PathLike[str], case_id: str) -> Path:
    """Return the log file of a case of a study."""
    return Path(results) / LOGS / f"{case_id}.log"


def log_end(results: str | PathLike[str], case_id: str, most: int = 4000) -> str:
    """Return the last lines of the log of a case, about ``most`` bytes; empty without a log."""
    try:
        with open_data(log_file(results, case_id)) as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - most))
            text = file.read().decode("utf-8", errors="replace")
    except OSError:
        return ""
    return text if size <= most else text.partition("\n")[2]


@dataclass(frozen=True)
class Spent:
    """Resources used by jobs, from the tables that Snakemake writes."""

    jobs: int  # how many jobs
    seconds: float  # time on the clock, one job after the other
    processor_seconds: float  # processor time, s
    memory_bytes: float  # Memory of the largest; NaN where it was not measured.


def spent_on_simulations(results: str | PathLike[str]) -> Spent | None:
    """Sum the resources of the simulation jobs, each by its last run; None if not measured.

    Their tables are in subfolders of ``benchmarks/``, those of other rules in ``benchmarks/``
    itself.
    """
    rows = []
    for file in sorted((Path(results) / BENCHMARKS).glob("*/**/*.tsv")):
        with suppress(OSError, UnicodeDecodeError, csv.Error):
            lines = read_data(file, _MOST_BYTES).decode("utf-8").splitlines()
            for last in [*csv.DictReader(lines, dialect="excel-tab")][-1:]:
                rows.append([_number(last.get(name)) for name in ("s", "cpu_time", "max_rss")])
    rows = [row for row in rows if math.isfinite(row[0])]
    if not rows:
        return None
    columns = zip(*rows, strict=True)
    seconds, processor, memory = (list(filter(math.isfinite, each)) for each in columns)
    return Spent(
        jobs=len(rows),
        seconds=math.fsum(seconds),
        processor_seconds=math.fsum(processor),
        memory_bytes=max(memory, default=math.nan) * _MEBIBYTE,
    )


def _number(text: str | None) -> float:
    """Read what was measured; NaN where it was not."""
    try:
        return float(text or "nan")
    except ValueError:
        return math.nan
