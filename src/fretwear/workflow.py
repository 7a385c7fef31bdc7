"""What the workflow has to know of a study before it plans any job.

No numpy here: the Snakefile is read at every call, also where nothing is to be done.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import fretwear
from fretwear.study.case import Case
from fretwear.study.cost import estimate
from fretwear.study.file import Study, load_study

STUDIES = Path("studies")
RESULTS = Path("results")

# A job that a scheduler ends for a wrong guess is lost; one that asks for too much only waits.
_MEMORY_MARGIN = 2.0
_TIME_MARGIN = 5.0
_MINUTES_TO_START = 5


def study_file(name: str) -> Path:
    """Return the file of a study given by its name in ``studies/`` or as a path to a YAML file."""
    path = Path(name)
    if path.suffix not in (".yaml", ".yml"):
        return STUDIES / f"{name}.yaml"
    is_bare_name = path.parent == Path()
    return STUDIES / path if is_bare_name and not path.exists() else path


@dataclass(frozen=True)
class StudyJobs:
    """The jobs of a study: their files, what they depend on, and what they take.

    Attributes
    ----------
    study : Study
        The study, sound.
    """

    study: Study

    @classmethod
    def of(cls, name: str) -> StudyJobs:
        """Return the jobs of a study given as for `study_file`.

        Raises
        ------
        StudyError
            With everything that is wrong with the study.
        """
        return cls(load_study(study_file(name)))

    @property
    def folder(self) -> str:
        """Folder of the results, relative to the working directory."""
        return str(RESULTS / self.study.name)

    @cached_property
    def cases(self) -> Mapping[str, Case]:
        """The cases to run by id."""
        return self.study.cases()

    @property
    def version(self) -> str:
        """Version of the package: another one computes everything anew."""
        return fretwear.__version__

    @property
    def content(self) -> str:
        """The whole study as JSON, on which everything but the single cases depends."""
        return json.dumps(self.study.content, sort_keys=True, default=str)

    def parameters(self, case_id: str) -> str:
        """Everything that the file of a case depends on, as JSON."""
        case = self.cases[case_id]
        parameters = {**case.canonical_parameters(), "output_cycles": list(case.output_cycles)}
        return json.dumps(parameters, sort_keys=True)

    def memory_mb(self, case_id: str) -> int:
        """Memory in MB that a scheduler should reserve for a case."""
        return math.ceil(_MEMORY_MARGIN * estimate(self.cases[case_id]).memory_bytes / 1e6)

    def minutes(self, case_id: str) -> int:
        """Time in min that a scheduler should reserve for a case."""
        seconds = _TIME_MARGIN * estimate(self.cases[case_id]).seconds
        return _MINUTES_TO_START + math.ceil(seconds / 60.0)
