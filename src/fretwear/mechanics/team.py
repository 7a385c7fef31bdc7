"""Threads that share the work on one case.

A field is done in parts. What parts there are follows from the field alone, and what they give is
put together in their order: no bit of a result depends on the number of threads. The threads belong
to the compiled library, whose kernels need no interpreter; without it others share all but them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property, lru_cache
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar
from warnings import warn

import numpy as np
from numpy.typing import NDArray

# The library compiled from kernels.cpp, if it was: threads, and the passes of `kernels`.
try:
    library: Any = import_module("fretwear.mechanics.compiled_kernels")
except ImportError:
    library = None
_sources = [Path(__file__).with_name(name) for name in ("kernels.cpp", "threads.h", "transforms.h")]
if library and all(source.exists() for source in _sources):
    _digest = sha256(b"".join(source.read_bytes() for source in _sources)).hexdigest()
    if getattr(library, "source", "") != _digest:
        warn(
            f"{library.__file__} was compiled from another kernels.cpp; NumPy does the arithmetic "
            "until the package is installed again: pip install -e .",
            stacklevel=1,
        )
        library = None

_Part = TypeVar("_Part")
_Result = TypeVar("_Result")
# Fields of so few cells are not worth sharing, as measured. Others are done in a few equal parts:
# between two parts a thread needs the interpreter, and may have to wait for it.
_SMALL, _PARTS = 2**17, 4


class Team:
    """A number of threads, including the caller's; the others start when needed."""

    def __init__(self, workers: int = 1) -> None:
        self.workers = workers

    def for_cells(self, count: int) -> Team:
        """Who goes over a field of so many cells: one thread if it is small."""
        return self if count > _SMALL else ALONE

    def each(self, function: Callable[[_Part], _Result], parts: Sequence[_Part]) -> list[_Result]:
        """Apply a function to each of some parts; return the results in order.

        Each thread takes the next part as soon as it has done the last one.
        """
        if self.workers < 2 or len(parts) < 2:
            return [function(part) for part in parts]
        if library is None:
            return list(self._pool.map(function, parts))
        results: list[_Result] = self.threads.each(function, parts)
        return results

    def cellwise(
        self,
        function: Callable[..., Any],
        field: NDArray[Any],
        *others: NDArray[Any] | float,
        dtype: type[np.generic] = np.float64,
    ) -> Any:
        """Apply a function cell by cell to fields of one shape and numbers; return the field."""
        shares = shares_of_rows(field.shape)
        if len(shares) == 1:
            return np.asarray(function(field, *others), dtype)
        result = np.empty(field.shape, dtype)

        def fill(rows: slice) -> None:
            own = (each[rows] if isinstance(each, np.ndarray) else each for each in others)
            result[rows] = function(field[rows], *own)

        self.each(fill, shares)
        return result

    @cached_property
    def threads(self) -> Any:
        """What compiled kernels are shared by."""
        return library.Threads(self.workers)

    @cached_property
    def _pool(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(self.workers)


ALONE = Team()


def shares_of_rows(shape: tuple[int, int]) -> tuple[slice, ...]:
    """The rows of a field in parts for the threads of any team: one of a small field."""
    count, length = shape
    shared = count * length > _SMALL
    return blocks_of_rows(shape, -(-count // _PARTS) * length if shared else count * length)


@lru_cache(maxsize=256)
def blocks_of_rows(shape: tuple[int, ...], cells: int) -> tuple[slice, ...]:
    """The rows of a field in blocks of limited size, at least one row each.

    A block stays in a core's cache during all operations on it.
    """
    count, length = shape
    rows = max(1, cells // length)
    return tuple(slice(first, min(first + rows, count)) for first in range(0, count, rows))
