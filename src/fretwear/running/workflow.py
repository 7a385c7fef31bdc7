"""The jobs of a study before any of them runs, and the records that they leave.

No scipy, xarray or matplotlib here: the Snakefile is read at every call, even if nothing is left to
do. Nothing of a result depends on a record of a failure, a log or a table of resources: truncated
or foreign ones are ignored, and a failure to write one ends no computation. ``results`` is the
folder of a study's results everywhere.
"""

from __future__ import annotations

import csv
import hashlib
import json
import math
import os
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import cached_property
from itertools import count
from os import PathLike
from pathlib import Path
from typing import Any

from fretwear.data.safe import DataFileError, open_data, open_log, read_data, write_text
from fretwear.running.resources import Batch, batches
from fretwear.study.plan import Plan
from fretwear.study.problems import Problem, StudyError, few_of
from fretwear.study.study import Study, load_study
from fretwear.version import __version__, code_digest

STUDIES = Path("studies")
RESULTS = Path("results")
BATCHES = "batches"
CAPTION = str(Path(__file__).with_name("caption.rst"))
"""Template of what Snakemake's report says of a figure; none of the results ever is one."""


def workspace() -> Path:
    """Folder with the workflow, its settings and the studies that come with the package.

    It is the root of a checkout; an installed package contains a copy.
    """
    package = Path(__file__).parents[1]
    installed = package / "workspace"
    return installed if installed.is_dir() else package.parents[1]


SNAKEFILE = str(workspace() / "Snakefile")
"""The workflow itself, for the Snakefile of a folder made by ``fretwear init`` to include."""

LOGS = Path("logs", "simulate")
ENDED = "the process that ran it ended before it did: it was killed, or ran out of memory or time"

_SUFFIX = ".failed.json"
_MOST_RECORD = 100_000
_MEBIBYTE = 1 << 20

# File systems differ in how finely they keep the time of a file, and clients of a network one too.
_SECONDS_OF_DOUBT = 2.0
_HASH_DIGITS = 12
_MOST_BYTES = 100_000_000
_FAILURES_LISTED = 20

# A job that exceeds its request is lost; one that requests too much only waits.
_MEMORY_MARGIN = 2.0
_TIME_MARGIN = 5.0
_MINUTES_TO_START = 5
# In a job on a cluster Snakemake runs twice beside the simulation, and reads the study each time.
_SNAKEMAKE_MB = 300
_SNAKEMAKE_MB_PER_POINT = 0.008


# The usual value, the form of another one, and what it must be.
_CHOICES = {
    "study": ("demo", r".+", "must be a name, such as --config study=demo"),
    "keep_older": ("false", r"(?i:true|false)", "must be true or false"),
    "threads": ("1", r"[1-9]\d{0,3}", "must be how many threads a case takes, such as threads=4"),
}


def chosen(config: Mapping[str, object]) -> dict[str, Any]:
    """Return the settings of ``--config study=NAME keep_older=true threads=4`` for `StudyJobs.of`.

    Any other key is a `StudyError`: a misspelt key must not run the default.
    """
    values, known = {}, tuple(_CHOICES)
    problems = [
        Problem(key, value, "is not known", f"known are {', '.join(known)}", None, known, key)
        for key, value in config.items()
        if key not in known
    ]
    for key, (usual, form, rule) in _CHOICES.items():
        value = config.get(key, usual)
        # Snakemake passes some words on as text, others as YAML values.
        values[key] = "" if value is None else str(value)
        if not re.fullmatch(form, values[key]):
            problems.append(Problem(key, value, rule))
    if problems:
        raise StudyError(Path("--config"), problems)
    return {
        "name": values["study"],
        "keep_older": values["keep_older"].lower() == "true",
        "threads": int(values["threads"]),
    }


def study_file(name: str) -> Path:
    """Return the file of a study given by its name in ``studies/`` or as a path to a YAML file."""
    path = Path(name)
    if path.suffix not in (".yaml", ".yml"):
        return STUDIES / f"{name}.yaml"
    is_bare_name = path.parent == Path()
    return STUDIES / path if is_bare_name and not path.exists() else path


@dataclass(frozen=True)
class StudyJobs:
    """The jobs of a valid study: their files, dependencies and resources."""

    study: Study
    keep_older: bool = False  # whether cases computed by other code are kept
    threads: int = 1  # per case

    @classmethod
    def of(cls, name: str, *, keep_older: bool = False, threads: int = 1) -> StudyJobs:
        """Return the jobs of a study given as for `study_file`."""
        return cls(load_study(study_file(name)), keep_older, threads)

    @property
    def folder(self) -> str:
        """Folder of the results, relative to the working directory."""
        return str(RESULTS / self.study.name)

    @property
    def version(self) -> str:
        """Version of the package: with another one merging, drawing and reporting are repeated."""
        return __version__

    @property
    def code(self) -> str:
        """Digest of the code that computes: unless kept, cases of another are computed again."""
        return "any" if self.keep_older else code_digest()

    @property
    def options(self) -> str:
        """Options of the commands that compute and merge cases."""
        return "--keep-older" if self.keep_older else ""

    @property
    def content(self) -> str:
        """The parts of the study, as JSON, on which everything but the cases depends."""
        content = {key: value for key, value in self.study.content.items() if key != "batch"}
        return json.dumps(content, sort_keys=True, default=str)

    @cached_property
    def batches(self) -> Mapping[str, Batch]:
        """The batches by name, a hash of the contents of their files in any order of points."""
        return {self._name(batch): batch for batch in batches(Plan(self.study))}

    @cached_property
    def targets(self) -> tuple[str, ...]:
        """Names of the files that batches leave in `BATCHES` when all of their cases are done.

        A name ends in the number of a round, which increases when a case file was removed or
        changed after the batch was done: the file of the last round is then outdated, and a job is
        needed to bring it up to date. Finding this out writes and removes nothing.
        """
        folder = Path(self.folder)
        present = case_files(folder / "cases")
        return tuple(
            f"{name}-{_round(folder / BATCHES / name, batch, present)}"
            for name, batch in self.batches.items()
        )

    def batch(self, target: str) -> Batch:
        """Return the batch that leaves a file of this name."""
        return self.batches[target.rpartition("-")[0]]

    def points(self, target: str) -> str:
        """Return the points of a batch for the command line, first and last."""
        batch = self.batch(target)
        return f"{batch.first}-{batch.last}"

    def title(self, target: str) -> str:
        """Return a description of a batch."""
        batch = self.batch(target)
        several = f"{len(batch.case_ids)} cases, points {batch.first} to {batch.last}"
        return several if len(batch.case_ids) > 1 else batch.case_ids[0]

    def memory_mb(self, target: str) -> int:
        """Memory in MB that a scheduler should reserve for a batch."""
        simulation = _MEMORY_MARGIN * self.batch(target).memory_bytes / 1e6
        snakemake = _SNAKEMAKE_MB + _SNAKEMAKE_MB_PER_POINT * self.study.size
        return math.ceil(simulation + snakemake)

    def minutes(self, target: str) -> int:
        """Time in min that a scheduler should reserve for a batch."""
        return _MINUTES_TO_START + math.ceil(_TIME_MARGIN * self.batch(target).seconds / 60.0)

    def priority(self, target: str) -> int:
        """Return the priority of a batch: the longest first, so that none is left at the end."""
        return math.ceil(self.batch(target).seconds)

    @property
    def failures(self) -> Mapping[str, Failure]:
        """The cases that were started and have no result, by id."""
        found = failures(self.folder)
        return {case_id: found[case_id] for case_id in found if case_id in self._snapshots}

    def verdict(self) -> str:
        """Return which cases failed and why, for the end of a run that continued."""
        failed = [
            f"{each.case_id}: {each.reason} (log: {self.folder}/{each.log})"
            for each in self.failures.values()
        ]
        lines = [f"fretwear: {len(failed)} of {len(self._snapshots)} cases failed"]
        lines += [f"  {each}" for each in few_of(failed, _FAILURES_LISTED)]
        end = f"{self.folder}/report.html shows what is done; the next run tries these again."
        return "\n".join([*lines, end])

    def _name(self, batch: Batch) -> str:
        cases = self._snapshots
        everything = [self.code, [(each, cases[each]) for each in batch.case_ids]]
        text = json.dumps(everything, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()[:_HASH_DIGITS]

    @cached_property
    def _snapshots(self) -> Mapping[str, tuple[int, ...]]:
        return {case_id: case.output_cycles for case_id, case in self.study.cases().items()}


def _round(path: Path, batch: Batch, present: Mapping[str, FileTrace]) -> int:
    rounds = ((number, Path(f"{path}-{number}.json")) for number in count())
    return next(
        number
        for number, left in rounds
        if not left.exists() or is_finished(left, batch.case_ids, present)
    )


# The workflow of a large study cannot read every case file each time it starts. A batch has checked
# each with `fretwear.data.files.finished_by`; the answer holds as long as sizes and times are
# unchanged.

FileTrace = tuple[int, float]
"""Size in bytes and time of the last change, s: tell a file from one that was written later."""


def case_files(folder: Path) -> dict[str, FileTrace]:
    """Return size and time of the case files in a folder, by case id, without opening them."""
    try:
        with os.scandir(folder) as entries:
            found = {each.name[:-3]: each.stat() for each in entries if each.name.endswith(".nc")}
            return {name: (file.st_size, round(file.st_mtime, 3)) for name, file in found.items()}
    except OSError:
        return {}


def write_finished(path: Path, cases: Path, case_ids: Iterable[str]) -> None:
    """Record in ``path`` that these cases, with files in the folder ``cases``, are finished."""
    present = case_files(cases)
    listed = {}
    for case_id in case_ids:
        if case_id not in present:
            problem = "was removed while the other cases of its batch ran"
            raise DataFileError(cases / f"{case_id}.nc", problem, "Run the same command again")
        listed[case_id] = present[case_id]
    write_text(path, json.dumps({"cases": listed}, indent=0) + "\n")


def is_finished(path: Path, case_ids: Iterable[str], present: Mapping[str, FileTrace]) -> bool:
    """Return whether the files of a batch are unchanged since it recorded them in ``path``.

    ``present`` are the case files that are there, from `case_files`.
    """
    try:
        left = json.loads(read_data(path, _MOST_BYTES))["cases"]
        for size, modified, case_id in ((*left[case_id], case_id) for case_id in case_ids):
            found = present[case_id]
            if found[0] != size or not abs(found[1] - modified) <= _SECONDS_OF_DOUBT:
                return False
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return False
    return True


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
        failure = Failure(**json.loads(read_data(file, _MOST_RECORD)))
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
    for file in sorted(Path(results, "benchmarks").glob("*/**/*.tsv")):
        with suppress(OSError, UnicodeDecodeError, csv.Error):
            lines = read_data(file, _MOST_RECORD).decode("utf-8").splitlines()
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
