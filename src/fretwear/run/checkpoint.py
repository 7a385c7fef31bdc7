"""Checkpoints: the record of a run so far, in one file that NumPy reads."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import Self

import numpy as np

from fretwear.arrays import Array
from fretwear.data.atomic import DataFileError, atomic_path
from fretwear.run.progress import Step
from fretwear.run.simulate import RunRecord
from fretwear.study.case import Case
from fretwear.version import case_digest

SECONDS_BETWEEN = 30.0
_ARRAY, _TUPLE, _TYPE = "_array", "_tuple", "_type"


class Checkpoint:
    """The checkpoint of a run: an observer that keeps the run record in a file.

    The file is read when the observer is made, and written every `SECONDS_BETWEEN` and, in a
    ``with`` statement, when the run is interrupted. `tell` takes one line where the run resumes, or
    why it cannot. The caller removes the file once the result is stored.
    """

    def __init__(self, path: Path, case: Case, tell: Callable[[str], None]) -> None:
        self.path, self._case, self._saved = path, case, time.monotonic()
        self.record = RunRecord()
        if path.exists():
            try:
                self.record = read_checkpoint(path, case)
                tell(f"{path}: resuming after cycle {self.record.history[-1]['cycle']:.6g}")
            except DataFileError as error:
                tell(str(error))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        if error is not None and self.record.history:
            with suppress(DataFileError):  # The interruption is raised, not this error.
                self.save()

    def __call__(self, _: Step) -> None:
        """Save the record if the last time is long ago."""
        if time.monotonic() - self._saved >= SECONDS_BETWEEN:
            self.save()

    def save(self) -> None:
        """Write the record; the file appears complete, or not at all with a `DataFileError`."""
        arrays: list[Array] = []
        content = {"identity": _identity(self._case), "record": _packed(self.record, arrays)}
        text = np.frombuffer(json.dumps(content).encode(), np.uint8)
        with atomic_path(self.path) as temporary, temporary.open("wb") as stream:
            np.savez(stream, text, *arrays)
        self._saved = time.monotonic()


def read_checkpoint(path: Path, case: Case) -> RunRecord:
    """Read the record of a run of `case`; `DataFileError` if it is damaged or of another run."""
    try:
        with np.load(path, allow_pickle=False) as file:
            text, *arrays = (file[f"arr_{n}"] for n in range(len(file.files)))
        content = json.loads(text.tobytes())
        if content["identity"] == json.loads(json.dumps(_identity(case))):
            record = _restored(content["record"], arrays)
            assert isinstance(record, RunRecord)
            return record
        fault = "this checkpoint is of another run, or of other code"
    except Exception:  # Readers raise all sorts of errors for other kinds of files.
        fault = "this is no checkpoint, or a damaged one"
    raise DataFileError(path, fault, "The run starts at cycle 0")


def _identity(case: Case) -> list[object]:
    return [case_digest(case), case.canonical_parameters(), list(case.output_cycles)]


def _packed(value: object, arrays: list[Array]) -> object:
    """Turn a value into plain ones that JSON holds; arrays are appended, each once."""
    if isinstance(value, np.ndarray):
        if not any(array is value for array in arrays):
            arrays.append(value)
        return {_ARRAY: next(n for n, array in enumerate(arrays) if array is value)}
    if is_dataclass(value):
        kind = type(value)
        values = {one.name: _packed(getattr(value, one.name), arrays) for one in fields(value)}
        return {_TYPE: [kind.__module__, kind.__name__], **values}
    if isinstance(value, tuple):
        return {_TUPLE: [_packed(each, arrays) for each in value]}
    if isinstance(value, list):
        return [_packed(each, arrays) for each in value]
    if isinstance(value, dict):
        return {name: _packed(each, arrays) for name, each in value.items()}
    return value.item() if isinstance(value, np.generic) else value


def _restored(packed: object, arrays: list[Array]) -> object:
    """Restore what `_packed` made; only dataclasses of this package are built from a file."""
    if isinstance(packed, list):
        return [_restored(each, arrays) for each in packed]
    if not isinstance(packed, dict):
        return packed
    if _ARRAY in packed:
        return arrays[packed[_ARRAY]]
    if _TUPLE in packed:
        return tuple(_restored(each, arrays) for each in packed[_TUPLE])
    values = {name: _restored(each, arrays) for name, each in packed.items() if name != _TYPE}
    if _TYPE not in packed:
        return values
    module, name = packed[_TYPE]
    kind = getattr(import_module(module), name) if module.startswith("fretwear.") else None
    if not (isinstance(kind, type) and is_dataclass(kind)):
        raise TypeError(f"{name} is no part of a run record")
    return kind(**values)
