"""Which cases of a study are finished: what each batch leaves when all of its cases are done.

The workflow of a large study cannot follow every case file by itself; it follows one small file
per batch, in which the case files are listed as they were when the batch had checked them.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from fretwear.data.safe import write_text

# File systems differ in how finely they keep the time of a file, and clients of a network one too.
_SECONDS_OF_DOUBT = 2.0


@dataclass(frozen=True)
class FileTrace:
    """What tells a file from one that was written later, without reading it."""

    size: int
    modified: float

    @classmethod
    def of(cls, status: os.stat_result) -> FileTrace:
        """The trace of a file."""
        return cls(status.st_size, round(status.st_mtime, 3))

    def agrees(self, other: FileTrace) -> bool:
        """Whether both may be of one file."""
        near = abs(self.modified - other.modified) <= _SECONDS_OF_DOUBT
        return self.size == other.size and near


def case_files(folder: Path) -> dict[str, FileTrace]:
    """Return the traces of the case files in a folder, by case id; the files are not opened."""
    try:
        with os.scandir(folder) as entries:
            files = [entry for entry in entries if entry.name.endswith(".nc")]
            return {entry.name[:-3]: FileTrace.of(entry.stat()) for entry in files}
    except OSError:
        return {}


def write_finished(path: Path, cases: Path, case_ids: Iterable[str]) -> None:
    """Write that the cases of a batch are finished.

    Parameters
    ----------
    path : pathlib.Path
        File to write.
    cases : pathlib.Path
        Folder of the case files.
    case_ids : iterable of str
        The cases, whose files have been checked.

    Raises
    ------
    OSError, DataFileError
        When a case file is gone, or the file cannot be written.
    """
    listed = {}
    for case_id in case_ids:
        trace = FileTrace.of((cases / f"{case_id}.nc").stat())
        listed[case_id] = [trace.size, trace.modified]
    write_text(path, json.dumps({"cases": listed}, indent=0) + "\n")


def is_finished(path: Path, case_ids: Iterable[str], present: Mapping[str, FileTrace]) -> bool:
    """Say whether all cases of a batch are still as the batch left them.

    Parameters
    ----------
    path : pathlib.Path
        What the batch has left.
    case_ids : iterable of str
        Its cases.
    present : mapping of str to FileTrace
        The case files that are there, from `case_files`.
    """
    try:
        listed = json.loads(path.read_text(encoding="utf-8"))["cases"]
        left = {case_id: FileTrace(*listed[case_id]) for case_id in case_ids}
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return all(case_id in present and present[case_id].agrees(left[case_id]) for case_id in left)
