"""What a merged study takes from a case, kept at the end of the case file as well.

The netCDF library takes ten milliseconds to open a file of a hundred variables. Merging thousands
of cases reads these bytes instead, which the checksum of the file covers.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any, Self

import netCDF4
import numpy as np
from numpy.typing import NDArray

from fretwear.vocabulary import (
    CASE_ID,
    CODE_DIGEST,
    CYCLE,
    FIELDS,
    HEADLINES,
    Variable,
    X,
    Y,
)

_FIELDS = {field.name: field for field in FIELDS}

MERGED_PROFILES: dict[str, Variable] = {
    "pressure_profile": _FIELDS["pressure"],
    "shear_profile": _FIELDS["shear_traction"],
    "gap_profile": _FIELDS["gap"],
    "wear_profile": _FIELDS["wear_depth"],
    "wear_rate_profile": _FIELDS["wear_rate"],
    "contact_state_profile": _FIELDS["contact_state"],
}
"""Fields along x on the line nearest y = 0, by their names in a merged study."""

MERGED_HISTORIES = (CYCLE.name, *HEADLINES, "tangential_force")
"""Histories in a merged study."""

_TEXTS = CASE_ID.name, CODE_DIGEST.name, "source"


class ExcerptError(ValueError):
    """Bytes that are not an excerpt."""

    def __init__(self) -> None:
        super().__init__("no excerpt of a case")


def _is_text(value: object) -> bool:
    return isinstance(value, str) and value.isprintable()


@dataclass(frozen=True)
class Excerpt:
    """Scalars, profiles and histories of a case."""

    texts: dict[str, str]  # case id, code digest and source
    cycles: NDArray[np.float64]  # of the snapshots, (cycle,)
    cells: NDArray[np.float64]  # m, (x,)
    history: NDArray[np.float64]  # of `MERGED_HISTORIES`, in their order, (history, step)
    scalars: dict[str, NDArray[np.float64]]  # by name, (cycle,)
    profiles: list[NDArray[np.generic]]  # of `MERGED_PROFILES`, in their order, (cycle, x)

    @classmethod
    def of(cls, file: netCDF4.Dataset, histories: netCDF4.Dataset) -> Self:
        """Read the excerpt of an open case file, whose structure was checked, and its histories."""
        variables, about = file.variables, file.__dict__
        row: tuple[object, ...] = np.s_[:, :]
        if Y.name in variables:
            row = np.s_[:, :, int(np.abs(variables[Y.name][:]).argmin())]
        scalars = {
            name: variable[:].astype(np.float64)
            for name, variable in variables.items()
            if variable.dimensions == (CYCLE.name,) and name != CYCLE.name
        }
        return cls(
            {name: str(about.get(name, "")) for name in _TEXTS},
            variables[CYCLE.name][:],
            variables[X.name][:],
            np.stack([histories.variables[name][:] for name in MERGED_HISTORIES]),
            scalars,
            [variables[f.name][row].astype(f.dtype) for f in MERGED_PROFILES.values()],
        )

    def to_bytes(self) -> bytes:
        """Return the excerpt as a line of JSON and the arrays."""
        head = {
            "texts": self.texts,
            "sizes": [self.cycles.size, self.cells.size, self.history.shape[1]],
            "scalars": [*self.scalars],
        }
        arrays = [self.cycles, self.cells, self.history, *self.scalars.values()]
        content = [array.astype("<f8").tobytes() for array in arrays]
        content += [profile.tobytes() for profile in self.profiles]
        return b"".join([json.dumps(head).encode(), b"\n", *content])

    @classmethod
    def from_bytes(cls, content: bytes) -> Self:
        """Return the excerpt of these bytes; `ExcerptError` if they are none."""
        line, _, rest = content.partition(b"\n")
        try:
            head: Any = json.loads(line)
            texts, names = head["texts"], head["scalars"]
            cycles, cells, steps = head["sizes"]
        except (ValueError, TypeError, LookupError, RecursionError) as cause:
            raise ExcerptError from cause
        is_sound = (
            isinstance(texts, dict)
            and all(_is_text(texts.get(name)) for name in _TEXTS)
            and isinstance(names, list)
            and all(isinstance(name, str) for name in names)
            and all(type(size) is int and size > 0 for size in (cycles, cells, steps))
        )
        if not is_sound:
            raise ExcerptError
        shapes = [("<f8", (cycles,)), ("<f8", (cells,)), ("<f8", (len(MERGED_HISTORIES), steps))]
        shapes += [("<f8", (cycles,)) for _ in names]
        shapes += [(np.dtype(f.dtype).str, (cycles, cells)) for f in MERGED_PROFILES.values()]
        sizes = [math.prod(shape) * np.dtype(dtype).itemsize for dtype, shape in shapes]
        if sum(sizes) != len(rest):
            raise ExcerptError
        arrays, at = list[NDArray[Any]](), 0
        for (dtype, shape), size in zip(shapes, sizes, strict=True):
            arrays.append(np.frombuffer(rest[at : at + size], dtype).reshape(shape))
            at += size
        first, second, history, *others = arrays
        for axis in (first, second):
            if not (np.isfinite(axis).all() and (np.diff(axis) > 0).all()):
                raise ExcerptError
        scalars = dict(zip(names, others[: len(names)], strict=True))
        return cls(texts, first, second, history, scalars, others[len(names) :])
