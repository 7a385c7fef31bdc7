"""The jobs of a study before any of them runs, and the records that they leave.

No scipy, xarray or matplotlib here: the Snakefile is read at every call, even if nothing is left to
do. No result depends on a record of a failure, a log or a table of resources: truncated or foreign
ones are ignored, and a failure to write one ends no computation. ``results`` is the
folder of a study's results everywhere.
"""

from __future__ import annotations

import csv
import hashlib
import json
import logging
import math
import os
import re
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from fretwear.data.safe import DataFileError, open_data, open_log, read_data, write_text
from fretwear.problems import Problem
from fretwear.run.resources import Batch, batches, seconds_after
from fretwear.study.plan import SECONDS_TO_START, Plan
from fretwear.study.problems import StudyError, few_of
from fretwear.study.reading import load_plan
from fretwear.study.study import Study
from fretwear.units import duration_text
from fretwear.version import code_digest

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

ENDED = "the process that ran it ended before it did: it was killed, or ran out of memory or time"

LOGS = "logs/simulate"
_SUFFIX = ".failed.json"
_MOST_RECORD = 100_000
_MOST_BYTES = 100_000_000
_MEBIBYTE = 1 << 20
# File systems, and the clients of network ones, differ in the resolution of file times.
_SECONDS_OF_DOUBT = 2.0
_HASH_DIGITS = 12
_FAILURES_LISTED = 20
_STEPS_OF_SNAKEMAKE = ("Building DAG", "Using shell", "Select jobs", "Execute ", "Assuming ")
# Seconds between two looks at the case files, and in times of what a look takes.
_LEAST_PAUSE, _PAUSES = 1.0, 20.0

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
}


def study_file(name: str) -> Path:
    """Return the file of a study given by its name in ``studies/`` or as a path to a YAML file."""
    path, studies = Path(name), Path("studies")
    if path.suffix not in (".yaml", ".yml"):
        return studies / f"{name}.yaml"
    is_bare_name = path.parent == Path()
    return studies / path if is_bare_name and not path.exists() else path


class Job(NamedTuple):
    """The properties of the job of a batch that Snakemake needs."""

    points: str  # the first and the last, for the command line
    title: str
    priority: int  # the longest first, so that none is left at the end
    memory_mb: int  # for a scheduler to reserve
    minutes: int  # likewise


@dataclass(frozen=True)
class StudyJobs:
    """The jobs of a valid study: their files, dependencies and resources."""

    plan: Plan
    keep_older: bool = False  # whether cases computed by other code are kept

    @classmethod
    def of(cls, config: Mapping[str, object]) -> StudyJobs:
        """Return the jobs that ``--config study=NAME keep_older=true`` asks for.

        Any other key is a `StudyError`: a misspelt key must not run the default.
        """
        keys = tuple(_CHOICES)
        rule, remedy = "is not known", f"known are {', '.join(keys)}"
        unknown = [key for key in config if key not in keys]
        problems = [Problem(key, config[key], rule, remedy, None, keys, key) for key in unknown]
        # Snakemake passes some words on as text, others as YAML values.
        given = {key: config.get(key, usual) for key, (usual, _, _) in _CHOICES.items()}
        texts = {key: "" if value is None else str(value) for key, value in given.items()}
        for key, (_, form, rule) in _CHOICES.items():
            if not re.fullmatch(form, texts[key]):
                problems.append(Problem(key, given[key], rule))
        if problems:
            raise StudyError(Path("--config"), problems)
        plan = load_plan(study_file(texts["study"]))
        return cls(plan, texts["keep_older"].lower() == "true")

    @property
    def study(self) -> Study:
        """The study."""
        return self.plan.study

    @property
    def folder(self) -> str:
        """Folder of the results, relative to the working directory."""
        return f"results/{self.study.name}"

    @property
    def code(self) -> str:
        """Digest of the code that computes: unless kept, cases of another are computed again."""
        return "any" if self.keep_older else code_digest()

    @property
    def content(self) -> str:
        """The parts of the study, as JSON, on which everything but the cases depends."""
        content = {key: value for key, value in self.study.content.items() if key != "batch"}
        return json.dumps(content, sort_keys=True, default=str)

    @property
    def measurements(self) -> list[str]:
        """The files with what was measured, or the study if it has numbers only; none of others."""
        fit = self.study.added.get("fit")
        return [*map(str, fit.files or [self.study.file])] if fit else []

    @cached_property
    def batches(self) -> Mapping[str, Batch]:
        """The batches by name, a hash of the contents of their files in any order of points."""
        by_name, cases = {}, self.study.cases()
        for batch in batches(self.plan):
            snapshots = [(case_id, cases[case_id].output_cycles) for case_id in batch.case_ids]
            text = json.dumps([self.code, snapshots], separators=(",", ":"))
            by_name[hashlib.sha256(text.encode()).hexdigest()[:_HASH_DIGITS]] = batch
        return by_name

    @cached_property
    def targets(self) -> tuple[str, ...]:
        """Names of the files that batches leave in `BATCHES` when all of their cases are done.

        A name ends in the number of a round, which increases when a case file was removed or
        changed after the batch was done: the file of the last round is then outdated, and a job is
        needed to bring it up to date. This check writes and removes no files.
        """
        folder, names = Path(self.folder), list[str]()
        present = case_files(folder / "cases")
        for name, batch in self.batches.items():
            rounds = (folder / BATCHES / f"{name}-{number}.json" for number in count())
            names += next(
                [file.stem]
                for file in rounds
                if not file.exists() or is_finished(file, batch.case_ids, present)
            )
        return tuple(names)

    def job(self, target: str) -> Job:
        """Return the job that leaves a file of this name."""
        batch = self.batches[target.rpartition("-")[0]]
        several = f"{len(batch.case_ids)} cases, points {batch.first} to {batch.last}"
        snakemake = _SNAKEMAKE_MB + _SNAKEMAKE_MB_PER_POINT * self.study.size
        return Job(
            points=f"{batch.first}-{batch.last}",
            title=several if len(batch.case_ids) > 1 else batch.case_ids[0],
            priority=math.ceil(batch.seconds),
            memory_mb=math.ceil(_MEMORY_MARGIN * batch.memory_bytes / 1e6 + snakemake),
            minutes=_MINUTES_TO_START + math.ceil(_TIME_MARGIN * batch.seconds / 60.0),
        )

    def verdict(self) -> str:
        """Return which cases failed and why, for the end of a run that continued; may be empty."""
        cases = self.study.cases()
        failed = [
            f"{case_id}: {reason} (log: {log_file(self.folder, case_id)})"
            for case_id, reason in failures(self.folder).items()
            if case_id in cases
        ]
        lines = [f"fretwear: {len(failed)} of {len(cases)} cases failed"]
        lines += [f"  {line}" for line in few_of(failed, _FAILURES_LISTED)]
        end = f"{self.folder}/report.html shows what is done; the next run tries these again."
        return "\n".join([*lines, end]) if failed else ""


def is_news(record: logging.LogRecord) -> bool:
    """Return whether a line of Snakemake is worth showing beside `Progress`.

    Errors and the jobs after the cases are, starts of simulations and the scheduler's steps not.
    """
    if hasattr(record, "rule_msg") and record.levelno <= logging.INFO:
        return bool(record.rule_msg) and getattr(record, "rule_name", "") != "simulate"
    return not record.getMessage().startswith(_STEPS_OF_SNAKEMAKE)


def step_of(record: logging.LogRecord) -> str:
    """Return what a job after the cases does, without date and number; empty for other lines."""
    message = getattr(record, "rule_msg", None) if record.levelno <= logging.INFO else None
    return str(message or "")


class Progress:
    """Reports each case of a running study once it is done, with the time left.

    A thread looks for case files and records of batches, which every kind of job leaves, wherever
    it runs. The time left follows from the plan and from how much longer than planned cases took.
    """

    def __init__(
        self,
        jobs: StudyJobs,
        at_once: int,
        tell: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._tell, self._clock, self._at_once = tell, clock, at_once
        self._cases, estimates = Path(jobs.folder, "cases"), jobs.plan.estimates
        self._before, self._stop = case_files(self._cases), threading.Event()
        records = {Path(jobs.folder, BATCHES, f"{target}.json"): target for target in jobs.targets}
        self._batches = {
            record: jobs.batches[target.rpartition("-")[0]].case_ids
            for record, target in records.items()
            if not record.exists()
        }
        # Seconds of the cases that are not done, as planned.
        self._left = {
            case_id: estimates[case_id].seconds - SECONDS_TO_START
            for case_ids in self._batches.values()
            for case_id in case_ids
        }
        self._count, self._done, self._after = len(self._left), 0.0, seconds_after(jobs.plan)
        self._jobs, self._busy = len(self._batches), 0.0  # seconds of all jobs together so far
        self._looked, self._looking = clock(), threading.Lock()

    def look(self) -> None:
        """Report the cases that are done since the last look, by whichever thread comes first."""
        with self._looking:
            self._tell_done()

    def _tell_done(self) -> None:
        now, running = self._clock(), min(self._at_once, len(self._batches))
        self._busy, self._looked = self._busy + running * (now - self._looked), now
        present = case_files(self._cases)
        done = [n for n in self._left if n in present and present[n] != self._before.get(n)]
        for record in [record for record in self._batches if record.exists()]:
            done += [n for n in self._batches.pop(record) if n in self._left and n not in done]
        for case_id in done:
            self._done += self._left.pop(case_id)
            number = f"case {self._count - len(self._left)} of {self._count}"
            self._tell(
                f"{number} done: {case_id}, about {duration_text(self._seconds_left())} left"
            )

    def _seconds_left(self) -> float:
        """Time, s, until the report is written.

        Jobs that are left share the cores, but the cases of a job follow each other, so that the
        last job keeps a single core busy. Every case that runs counts as half done.
        """
        waiting = [
            [self._left[case_id] for case_id in case_ids if case_id in self._left]
            for case_ids in self._batches.values()
        ]
        works = sorted((sum(case) - 0.5 * case[0] for case in waiting if case), reverse=True)
        running = min(self._at_once, len(works))
        begun = sum(sorted((0.5 * case[0] for case in waiting if case), reverse=True)[:running])
        started = (self._jobs - len(self._batches) + running) * SECONDS_TO_START
        slowness = self._busy / max(started + self._done + begun, 1e-3)
        ahead = (len(works) - running) * SECONDS_TO_START + sum(self._left.values()) - begun
        return math.ceil(slowness * (max([ahead / self._at_once, *works[:1]]) + self._after))

    def start(self) -> None:
        """Look every second, or more rarely at folders that take long to look at."""
        if self._left:
            jobs = f"{len(self._batches)} job{'s' * (len(self._batches) > 1)}"
            self._tell(f"cases to run: {self._count}, in {jobs}")
        threading.Thread(target=self._watch, daemon=True).start()

    def stop(self) -> None:
        """Look a last time."""
        self._stop.set()
        self.look()

    def _watch(self) -> None:
        pause = _LEAST_PAUSE
        while not self._stop.wait(pause):
            begun = time.monotonic()
            self.look()
            pause = max(_LEAST_PAUSE, _PAUSES * (time.monotonic() - begun))


# The workflow of a large study cannot read every case file each time it starts. A batch has checked
# each with `fretwear.data.files.finished_by`; the answer holds as long as sizes and times are
# unchanged.

FileTrace = tuple[int, float]  # size in bytes, and time of the last change, s


def case_files(folder: Path) -> dict[str, FileTrace]:
    """Return size and time of the case files in a folder, by case id, without opening them."""
    with suppress(OSError), os.scandir(folder) as entries:
        files = {file.name[:-3]: file.stat() for file in entries if file.name.endswith(".nc")}
        return {name: (stat.st_size, round(stat.st_mtime, 3)) for name, stat in files.items()}
    return {}


def write_finished(path: Path, cases: Path, case_ids: Iterable[str]) -> None:
    """Record in ``path`` that these cases, with files in the folder ``cases``, are finished."""
    present, listed = case_files(cases), {}
    for case_id in case_ids:
        if case_id not in present:
            problem = "was removed while the other cases of its batch ran"
            raise DataFileError(cases / f"{case_id}.nc", problem, "Run the same command again")
        listed[case_id] = present[case_id]
    write_text(path, json.dumps({"cases": listed}, indent=0) + "\n")


def is_finished(path: Path, case_ids: Iterable[str], present: Mapping[str, FileTrace]) -> bool:
    """Return whether the files of a batch are unchanged since it recorded them in ``path``.

    ``present`` are the existing case files, from `case_files`.
    """
    try:
        left = json.loads(read_data(path, _MOST_BYTES))["cases"]
        traces = ((*left[case_id], *present[case_id]) for case_id in case_ids)
        return all(
            size == size_now and abs(time - modified) <= _SECONDS_OF_DOUBT
            for size, modified, size_now, time in traces
        )
    except (OSError, ValueError, LookupError, TypeError, RecursionError, OverflowError):
        return False


def record(results: str | PathLike[str], case_id: str, reason: str = ENDED) -> None:
    """Record why a case failed.

    The start of a case is recorded too, because a process that is killed cannot do so later.
    """
    with open_log(Path(results, LOGS, f"{case_id}{_SUFFIX}")) as stream:
        stream.write(json.dumps({"case_id": case_id, "reason": reason}) + "\n")


def forget(results: str | PathLike[str], case_id: str) -> None:
    """Remove the record of a case that now has a result."""
    with suppress(OSError):
        Path(results, LOGS, f"{case_id}{_SUFFIX}").unlink(missing_ok=True)


def failures(results: str | PathLike[str]) -> dict[str, str]:
    """Return why cases that were started have no result, by id."""
    reasons = {}
    for file in sorted(Path(results, LOGS).glob(f"*{_SUFFIX}")):
        with suppress(OSError, ValueError, LookupError, TypeError, RecursionError):
            entry, case_id = json.loads(read_data(file, _MOST_RECORD)), file.name[: -len(_SUFFIX)]
            if entry["case_id"] == case_id and isinstance(entry["reason"], str):
                reasons[case_id] = entry["reason"]
    return reasons


def log_file(results: str | PathLike[str], case_id: str) -> Path:
    """Return the log file of a case of a study."""
    return Path(results, LOGS, f"{case_id}.log")


def log_end(results: str | PathLike[str], case_id: str, most: int = 4000) -> str:
    """Return the last lines of the log of a case, about ``most`` bytes; empty without a log."""
    with suppress(OSError), open_data(log_file(results, case_id)) as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - most))
        text = file.read().decode("utf-8", errors="replace")
        return text if size <= most else text.partition("\n")[2]
    return ""


class Spent(NamedTuple):
    """Resources used by jobs, from the tables that Snakemake writes."""

    jobs: int  # how many jobs
    seconds: float  # time on the clock, one job after the other
    processor_seconds: float  # processor time, s
    memory_bytes: float  # memory of the largest; NaN where it was not measured


def spent_on_simulations(results: str | PathLike[str]) -> Spent | None:
    """Sum the resources of the simulation jobs, each by its last run; None if not measured.

    Their tables are in subfolders of ``benchmarks/``; tables of other rules are in ``benchmarks/``
    itself.
    """
    rows = []
    for file in sorted(Path(results, "benchmarks").glob("*/**/*.tsv")):
        with suppress(OSError, ValueError, csv.Error):
            lines = read_data(file, _MOST_RECORD).decode("utf-8").splitlines()
            for last in [*csv.DictReader(lines, dialect="excel-tab")][-1:]:
                texts = [last.get(name) for name in ("s", "cpu_time", "max_rss")]
                row = [math.nan if text in (None, "", "-", "NA") else float(text) for text in texts]
                rows += [row] if math.isfinite(row[0]) else []
    if not rows:
        return None
    columns = zip(*rows, strict=True)
    seconds, processor, memory = (list(filter(math.isfinite, column)) for column in columns)
    largest = max(memory, default=math.nan) * _MEBIBYTE
    return Spent(len(rows), math.fsum(seconds), math.fsum(processor), largest)
