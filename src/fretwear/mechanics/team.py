"""Threads that share the work on one case.

A field is done in blocks of rows. What blocks there are follows from the field alone, and what they
give is put together in their order: no bit of a result depends on the number of threads.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property, lru_cache
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

_Part = TypeVar("_Part")
_Result = TypeVar("_Result")
# Fields of so few cells are not worth sharing; others are done in blocks that a cache holds.
_SMALL, _BLOCK = 2**17, 2**15


class Team:
    """A number of threads, including the caller's; the others start when needed."""

    def __init__(self, workers: int = 1) -> None:
        self.workers = workers

    def each(self, function: Callable[[_Part], _Result], parts: Sequence[_Part]) -> list[_Result]:
        """Apply a function to each of some parts; return the results in order.

        Each thread takes the next part as soon as it has done the last one.
        """
        count = min(self.workers, len(parts))
        if count < 2:
            return [function(part) for part in parts]
        left, results = deque(enumerate(parts)), {}

        def work() -> None:
            while True:
                try:
                    number, part = left.popleft()
                except IndexError:
                    return
                results[number] = function(part)

        others = [self._pool.submit(work) for _ in range(1, count)]
        work()
        for other in others:
            # What a thread raises is raised here.
            other.result()
        return [results[number] for number in range(len(parts))]

    def cellwise(
        self,
        function: Callable[..., Any],
        field: NDArray[Any],
        *others: NDArray[Any] | float,
        dtype: type[np.generic] = np.float64,
    ) -> Any:
        """The field that a function makes of others of one shape cell by cell, and of numbers."""
        if field.size <= _SMALL:
            return np.asarray(function(field, *others), dtype)
        result = np.empty(field.shape, dtype)

        def fill(rows: slice) -> None:
            own = (each[rows] if isinstance(each, np.ndarray) else each for each in others)
            result[rows] = function(field[rows], *own)

        self.each(fill, blocks_of_rows(field.shape, _BLOCK))
        return result

    @cached_property
    def _pool(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(self.workers - 1)


ALONE = Team()


@lru_cache(maxsize=256)
def blocks_of_rows(shape: tuple[int, ...], cells: int) -> tuple[slice, ...]:
    """The rows of a field in blocks of so many cells at most, but of one row at least.

    What is done to a block, one operation after the other, stays in a core's cache.
    """
    count, length = shape
    rows = max(1, cells // length)
    return tuple(slice(first, min(first + rows, count)) for first in range(0, count, rows))
