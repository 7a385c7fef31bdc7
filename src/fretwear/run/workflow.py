"""The jobs of a study for the Snakefile, which is read at every start even if nothing is left.

Heavy libraries are therefore imported only where needed.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from fretwear.run.resources import Job, grouped, seconds_after
from fretwear.study.mistakes import Mistake, StudyError
from fretwear.study.plan import Plan
from fretwear.study.reading import load_study
from fretwear.version import case_digest, code_digest

if TYPE_CHECKING:
    from snakemake.settings.types import DAGSettings

_KEYS = ("study", "keep_older")
# A job that exceeds its request is lost; one that requests too much only waits.
_MEMORY_MARGIN, _TIME_MARGIN, _MINUTES_TO_START = 2.0, 5.0, 5
# In a cluster job Snakemake runs beside the simulation.
_SNAKEMAKE_MB = 300
# Memory of the steps after the simulations: libraries of figures, and a share for each case.
_AFTER_MB, _MB_PER_CASE, _MOST_ON_SUBMITTING_MACHINE = 1500, 0.2, 300
# A fit takes twenty to forty runs, of which twice as many run side by side as parameters are free.
FIT_THREADS, _FIT_RUNS = 8, 40
_STARTED = "fretwear_started"


def workspace() -> Path:
    """Folder with the workflow, its settings and the studies that come with the package.

    It is the root of a checkout; an installed package contains a copy.
    """
    package = Path(__file__).parents[1]
    installed = package / "workspace"
    return installed if installed.is_dir() else package.parents[1]


SNAKEFILE = str(workspace() / "Snakefile")
"""The workflow itself, for the Snakefile of a folder made by ``fretwear init`` to include."""


def study_file(name: str) -> Path:
    """Return the file of a study given by its name in ``studies/`` or as a path to a YAML file."""
    path = Path(name)
    if path.suffix not in (".yaml", ".yml"):
        return Path("studies", f"{name}.yaml")
    return path if path.exists() or path.parent != Path() else Path("studies", path)


def mark_start(folder: Path = Path(".snakemake")) -> None:
    """Write process and machine of this Snakemake beside its locks."""
    import psutil

    this = [platform.node(), os.getpid(), psutil.Process().create_time()]
    (folder / _STARTED).write_text(json.dumps(this), encoding="utf-8")


def release_locks(folder: Path = Path(".snakemake")) -> None:
    """Remove the locks of a Snakemake that was killed on this machine.

    Locks stay if their Snakemake still runs, ran on another machine or left no mark; Snakemake says
    how to remove them.
    """
    import psutil

    mark, locks = folder / _STARTED, [*(folder / "locks").glob("*.lock")]
    try:
        node, pid, created = json.loads(mark.read_bytes())
        newest = max(lock.stat().st_mtime for lock in locks)
        is_of_locks = node == platform.node() and newest <= mark.stat().st_mtime
    except (OSError, ValueError):
        return
    with suppress(psutil.NoSuchProcess):
        if not is_of_locks or psutil.Process(pid).create_time() == created:
            return
    for lock in locks:
        lock.unlink(missing_ok=True)


@dataclass(frozen=True)
class StudyJobs:
    """The jobs of a valid study, as ``--config study=NAME keep_older=true`` asks for them."""

    plan: Plan
    keep_older: bool = False  # whether cases computed by other code are kept

    @classmethod
    def of(cls, config: Mapping[str, object]) -> StudyJobs:
        """Read the study; `StudyError` if it is wrong, or a key of the configuration is."""
        mistakes = [
            Mistake(key, config[key], "is not known", "known are study, keep_older")
            for key in config
            if key not in _KEYS
        ]
        keep_older = str(config.get("keep_older", False)).lower()
        if keep_older not in ("true", "false"):
            mistakes.append(Mistake("keep_older", keep_older, "must be true or false"))
        if mistakes:
            raise StudyError(Path("--config"), mistakes)
        plan = Plan(load_study(study_file(str(config.get("study", "demo")))))
        return cls(plan, keep_older == "true")

    @property
    def results(self) -> Path:
        """Folder of the results, relative to the working directory."""
        return Path("results", self.plan.study.name)

    @property
    def content(self) -> str:
        """The parts of the study, as JSON, on which everything except the cases depends."""
        content = {key: value for key, value in self.plan.study.content.items() if key != "batch"}
        return json.dumps(content, sort_keys=True, default=str)

    @property
    def measurements(self) -> list[str]:
        """The files with measured data, or the study if it has only numbers; none without a fit."""
        fit = self.plan.study.added.get("fit")
        return [*map(str, fit.files or [self.plan.study.file])] if fit else []

    @property
    def code(self) -> str:
        """Digest of the code of results that sections of the study add to cases."""
        sections = self.plan.study.added.values()
        return code_digest(*sorted({type(each).__module__.split(".")[0] for each in sections}))

    @cached_property
    def jobs(self) -> Mapping[str, Job]:
        """The jobs by name: a digest of the cases, their snapshots and, unless kept, the code."""
        cases, named = self.plan.study.cases(), {}
        for job in grouped(self.plan):
            mine = {name: cases[name] for name in job.case_ids}
            codes = ["any"] if self.keep_older else [case_digest(case) for case in mine.values()]
            text = json.dumps([codes, [(name, case.output_cycles) for name, case in mine.items()]])
            named[hashlib.sha256(text.encode()).hexdigest()[:12]] = job
        return named

    def memory_mb_of_fit(self, processes: int) -> int:
        """Return the memory that a scheduler reserves for a fit of some processes."""
        largest = max(cost.memory_bytes for cost in self.plan.estimates.values())
        return math.ceil(_MEMORY_MARGIN * processes * largest / 1e6 + _SNAKEMAKE_MB)

    @property
    def minutes_of_fit(self) -> int:
        """The time that a scheduler reserves for a fit."""
        once = math.fsum(cost.seconds for cost in self.plan.estimates.values())
        return _MINUTES_TO_START + math.ceil(_TIME_MARGIN * _FIT_RUNS * once / 60.0)

    @property
    def is_small(self) -> bool:
        """Whether the steps after the simulations take less time than starting a job."""
        return len(self.plan.estimates) <= _MOST_ON_SUBMITTING_MACHINE

    @property
    def memory_mb_after(self) -> int:
        """The memory that a scheduler reserves for merging, figures or the report."""
        return math.ceil(_AFTER_MB + _MB_PER_CASE * len(self.plan.estimates))

    @property
    def minutes_after(self) -> int:
        """The time that a scheduler reserves for merging, figures or the report."""
        return _MINUTES_TO_START + math.ceil(_TIME_MARGIN * seconds_after(self.plan) / 60.0)

    def remove_forced(self, results: Path, rule: str, settings: DAGSettings) -> None:
        """Remove the case files of jobs that Snakemake must repeat, by rule or by marker."""
        for name, job in self.jobs.items():
            marker = (results / "jobs" / name).as_posix()
            if settings.forceall or {rule, marker} & {*settings.forcerun}:
                for case_id in job.case_ids:
                    (results / "cases" / f"{case_id}.nc").unlink(missing_ok=True)

    def options(self, name: str) -> str:
        """Return the options with which ``fretwear run`` does a job."""
        kept = ["--keep-older"] * self.keep_older
        return " ".join([*kept, *(f"--case {each}" for each in self.jobs[name].case_ids)])

    def memory_mb(self, name: str) -> int:
        """Return the memory that a scheduler reserves for a job."""
        return math.ceil(_MEMORY_MARGIN * self.jobs[name].memory_bytes / 1e6 + _SNAKEMAKE_MB)

    def minutes(self, name: str) -> int:
        """Return the time that a scheduler reserves for a job."""
        return _MINUTES_TO_START + math.ceil(_TIME_MARGIN * self.jobs[name].seconds / 60.0)

    def check(self, results: Path) -> Iterator[str]:
        """Repeat jobs whose case files are gone; yield remarks for the user before the start."""
        older, cases = 0, self.plan.study.cases()
        for name, job in self.jobs.items():
            marker = results / "jobs" / name
            files = {n: results / "cases" / f"{n}.nc" for n in job.case_ids}
            present = {n: file for n, file in files.items() if file.exists()}
            if len(present) < len(files):
                marker.unlink(missing_ok=True)
            if present and not marker.exists():
                from fretwear.data.files import finished_by

                for name, file in present.items():
                    code = finished_by(file, cases[name])
                    older += code not in (None, case_digest(cases[name]))
        if older:
            are = "case is" if older == 1 else "cases are"
            fate = "kept" if self.keep_older else "computed again; keep_older=true keeps them"
            yield f"{older} finished {are} of other code: {fate}"
