"""Checkpoint files: named arrays and numbers, written atomically, read without pickle."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from fretwear.data.files import add_checksum, damage
from fretwear.data.safe import DataFileError, atomic_path

_NUMBERS = "numbers"
_START_ANEW = "The run starts at cycle 0"


class CheckpointError(DataFileError):
    """A checkpoint that cannot be used: damaged, or of another run."""


def write_checkpoint(
    path: Path,
    arrays: Mapping[str, NDArray[Any]],
    numbers: Mapping[str, Any],
    identity: Mapping[str, Any],
) -> None:
    """Write a checkpoint; it appears under its name only when it is whole.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    arrays : mapping of str to numpy.ndarray
        Numeric arrays of any shape.
    numbers : mapping
        Anything that JSON can hold.
    identity : mapping
        What the run is (version, parameters): must be equal when it is read.

    Raises
    ------
    DataFileError
        When it cannot be written.
    """
    text = json.dumps({"identity": identity, "numbers": numbers}, sort_keys=True)
    encoded = np.frombuffer(text.encode(), dtype=np.uint8)
    with atomic_path(path) as temporary:
        with temporary.open("wb") as stream:
            np.savez(stream, allow_pickle=False, **{_NUMBERS: encoded}, **arrays)
        add_checksum(temporary)


def read_checkpoint(
    path: Path, identity: Mapping[str, Any]
) -> tuple[dict[str, NDArray[Any]], dict[str, Any]] | None:
    """Read what `write_checkpoint` wrote; None where there is no such file.

    Raises
    ------
    CheckpointError
        When the file is damaged, or when its identity is another one.
    """
    if not path.exists():
        return None
    # The container has checksums of its own, but none of its headers.
    if problem := damage(path, "checkpoint"):
        raise CheckpointError(path, f"this checkpoint is damaged ({problem})", _START_ANEW)
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        content = json.loads(arrays.pop(_NUMBERS).tobytes())
        found, numbers = content["identity"], content["numbers"]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, BadZipFile) as cause:
        problem = "this is no checkpoint, or one of another version"
        raise CheckpointError(path, problem, _START_ANEW) from cause
    expected = json.loads(json.dumps(identity))
    if found != expected:
        keys = sorted(key for key in {*found, *expected} if found.get(key) != expected.get(key))
        problem = f"this checkpoint is of another run (another {', '.join(keys)})"
        raise CheckpointError(path, problem, _START_ANEW)
    return arrays, numbers
