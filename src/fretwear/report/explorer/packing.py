"""Numbers packed for the script of a page: a header and arrays, compressed, as text."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

MISSING = -32768
_STEPS = 32767
_ALIGNMENT = 8


class Packer:
    """Collects arrays and says where each of them stands.

    The script reads little-endian numbers; every array begins at a multiple of eight bytes.
    """

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def add_rounded(self, values: ArrayLike) -> dict[str, Any]:
        """Add values rounded to a 32767th of the largest in their row, two bytes each.

        Parameters
        ----------
        values : array_like, shape (rows, columns)
            The values; NaN is kept.

        Returns
        -------
        dict
            ``at``, the position in bytes, and ``scales``, by which the whole numbers of each
            row are to be multiplied.
        """
        rows = np.atleast_2d(np.asarray(values, dtype=np.float64))
        largest = np.nan_to_num(np.abs(rows)).max(axis=1, initial=0.0, keepdims=True)
        scales = np.where(largest > 0.0, largest / _STEPS, 1.0)
        known = np.isfinite(rows)
        whole = np.where(known, np.rint(np.where(known, rows, 0.0) / scales), MISSING)
        return {"at": self._add(whole.astype("<i2")), "scales": scales[:, 0].tolist()}

    def add_floats(self, values: ArrayLike) -> int:
        """Add values as single-precision numbers; return the position in bytes."""
        return self._add(np.asarray(values, dtype="<f4"))

    def text(self, header: Mapping[str, Any]) -> str:
        """Return everything as base64 of a gzip stream.

        The stream holds the length of the header as a little-endian 32-bit number and four
        unused bytes, the header as JSON padded with spaces, and the arrays.

        Parameters
        ----------
        header : mapping
            What JSON can hold; no NaN.
        """
        words = json.dumps(header, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        encoded = words.encode("utf-8")
        encoded += b" " * (-len(encoded) % _ALIGNMENT)
        content = [len(encoded).to_bytes(_ALIGNMENT, "little"), encoded, *self._parts]
        return compressed(b"".join(content))

    def _add(self, array: NDArray[Any]) -> int:
        position, data = self._size, array.tobytes()
        data += b"\0" * (-len(data) % _ALIGNMENT)
        self._parts.append(data)
        self._size += len(data)
        return position


def compressed(content: bytes) -> str:
    """Return bytes as base64 of a gzip stream without a date: the same bytes, the same text."""
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode("ascii")
