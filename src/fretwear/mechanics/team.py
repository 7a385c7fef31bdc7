"""Threads that share the work on one case.

A field is done in blocks of rows. What blocks there are follows from the field alone, and what they
give is put together in their order: no bit of a result depends on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from typing import TypeVar

_Part = TypeVar("_Part")
_Result = TypeVar("_Result")


class Team:
    """So many threads, the caller's one of them; the others start when they are needed."""

    def __init__(self, workers: int = 1) -> None:
        self.workers = workers

    def each(self, function: Callable[[_Part], _Result], parts: Sequence[_Part]) -> list[_Result]:
        """What a function returns for each of some parts, in their order.

        Parts whose numbers leave the same rest on division by `workers` are done by one thread.
        """
        count = min(self.workers, len(parts))
        if count < 2:
            return [function(part) for part in parts]

        def share(first: int) -> list[_Result]:
            return [function(part) for part in parts[first :: self.workers]]

        others = [self._pool.submit(share, first) for first in range(1, count)]
        # What a thread raises is raised here when its result is taken.
        shares = [share(0), *(other.result() for other in others)]
        return [shares[number % count][number // count] for number in range(len(parts))]

    @cached_property
    def _pool(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(self.workers - 1)


ALONE = Team()


def blocks_of_rows(shape: tuple[int, ...], cells: int) -> list[slice]:
    """The rows of a field in blocks of so many cells at most, but of one row at least.

    What is done to a block, one operation after the other, stays in a core's cache.
    """
    count, length = shape
    rows = max(1, cells // length)
    return [slice(first, min(first + rows, count)) for first in range(0, count, rows)]
