"""Threads that share the work on one case.

A field is processed in parts. The field alone determines the parts, and their results are joined in
order: no bit of a result depends on the number of threads. The threads belong to the compiled
kernels, which need no interpreter.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Callable
from functools import cache, lru_cache
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from fretwear.arrays import Array, Element

Field = NDArray[np.generic]

_COMPILE = "install fretwear again, or compile in a checkout: python setup.py build_ext --inplace"
_KERNELS = "fretwear.mechanics.kernels"
try:
    kernels: Any = import_module(_KERNELS)
except ImportError as error:
    raise ImportError(
        f"the kernels in C++ have not been compiled, or do not load ({error}): {_COMPILE}",
        name=_KERNELS,
    ) from error
_folder = Path(__file__).parent
_sources = sorted([*_folder.glob("*.cpp"), *_folder.glob("*.h")])
_digest = sha256(b"".join(source.read_bytes() for source in _sources)).hexdigest()
if _sources and kernels.source != _digest:
    raise ImportError(
        f"{kernels.__file__} was compiled from other sources: {_COMPILE}", name=_KERNELS
    )


@cache
def arithmetic() -> str:
    """Return what decides the last bits of a result besides code and parameters.

    Compiler of the kernels, levels of the processor for which they and NumPy run, BLAS with the
    processor that it takes this one for, and the C library.
    """
    from threadpoolctl import threadpool_info

    compiled = import_module("numpy._core._multiarray_umath")
    levels = [name for name in compiled.__cpu_dispatch__ if compiled.__cpu_features__[name]]
    loaded = [library for library in threadpool_info() if library["user_api"] == "blas"]
    loaded.sort(key=lambda library: "numpy" not in library["filepath"])  # SciPy's is often another
    parts = [
        f"kernels {kernels.processor} by {kernels.compiler}",
        f"NumPy {'+'.join(levels) or 'baseline'}",
    ]
    for library in loaded[:1]:
        words = (library["internal_api"], library["version"], library.get("architecture"))
        parts.append(" ".join(str(word) for word in words if word))
    parts.append(" ".join(platform.libc_ver()))
    return ", ".join([*parts, *filter(None, [os.environ.get("GLIBC_TUNABLES")])])


# Fields of so few cells are not worth sharing, as measured. Others are processed in a few equal
# parts: between two parts a thread needs the interpreter, and may have to wait for it.
_SMALL, _PARTS = 2**17, 4


class Team(kernels.Threads):  # type: ignore[misc]
    """A number of ``workers``, threads including the caller's; the others start when needed.

    ``each`` applies a function to each of some parts and returns the results in order; each thread
    takes the next part as soon as it has finished the last one.
    """

    def for_cells(self, count: int) -> Team:
        """The team for a field of so many cells: a single thread if it is small."""
        return self if count > _SMALL else ALONE

    @overload
    def cellwise(
        self, function: Callable[..., object], field: Field, *others: Field | float
    ) -> Array: ...

    @overload
    def cellwise(
        self,
        function: Callable[..., object],
        field: Field,
        *others: Field | float,
        dtype: type[Element],
    ) -> NDArray[Element]: ...

    def cellwise(
        self,
        function: Callable[..., object],
        field: Field,
        *others: Field | float,
        dtype: type[np.generic] = np.float64,
    ) -> NDArray[np.generic]:
        """Apply a function cell by cell to fields of one shape and numbers; return the field."""
        if field.size <= _SMALL:
            return np.asarray(function(field, *others), dtype)
        result = np.empty(field.shape, dtype)

        def fill(rows: slice) -> None:
            parts = (other[rows] if isinstance(other, np.ndarray) else other for other in others)
            result[rows] = function(field[rows], *parts)

        self.each(fill, blocks_of_rows(field.shape, -(-len(field) // _PARTS) * field.shape[1]))
        return result

    def in_single(self, field: NDArray[np.float64], unit: float) -> NDArray[np.float32]:
        """Return a field in some unit, in single precision."""
        result = np.empty(field.shape, np.float32)
        kernels.times(self, field, 1.0 / unit, result)
        return result

    def scaled(self, field: NDArray[np.float64]) -> tuple[NDArray[np.float32], float]:
        """Return a field in units of its largest magnitude, and the unit; 1 for zeros."""
        unit = kernels.largest(self, field)
        unit = unit if unit >= np.finfo(np.float64).tiny else 1.0
        return self.in_single(field, unit), unit


ALONE = Team()


@lru_cache(maxsize=256)
def blocks_of_rows(shape: tuple[int, ...], cells: int) -> tuple[slice, ...]:
    """The rows of a field in blocks of limited size, at least one row each.

    A block stays in a core's cache during all operations on it.
    """
    count, length = shape
    rows = max(1, cells // length)
    return tuple(slice(first, min(first + rows, count)) for first in range(0, count, rows))
