"""A checksum behind the content of a file, which tells whole files from damaged ones.

The netCDF library is no judge of that: a file that was not finished opens without an error, and
one whose structure is damaged can hang or crash the process that opens it. The checksum is tested
before the library sees the file. It stands in a last line behind the content; libraries for
netCDF-4 and HDF5 ignore what follows the content.
"""

from __future__ import annotations

import os
import zlib
from enum import Enum
from pathlib import Path
from typing import BinaryIO

_MARK = b"\nfretwear crc32 "
_LENGTH = len(_MARK) + 8 + 1
_BLOCK_BYTES = 1 << 20


class Seal(Enum):
    """State of the seal of a file."""

    INTACT = "intact"
    MISSING = "missing"
    BROKEN = "broken"


def seal(path: Path) -> None:
    """Put the checksum behind the content of a file; nothing may be written to it afterwards."""
    with path.open("r+b") as stream:
        line = _line(stream, path.stat().st_size)
        stream.seek(0, os.SEEK_END)
        stream.write(line)


def check_seal(path: Path) -> Seal:
    """Read a file and compare it with its checksum.

    Returns
    -------
    Seal
        ``MISSING`` when there is no checksum: the file was not finished, was cut short, or was
        written to by another program. ``BROKEN`` when it does not fit: a bit has changed.
    """
    with path.open("rb") as stream:
        content = path.stat().st_size - _LENGTH
        stream.seek(max(content, 0))
        found = stream.read()
        if not found.startswith(_MARK):
            return Seal.MISSING
        stream.seek(0)
        return Seal.INTACT if found == _line(stream, content) else Seal.BROKEN


def damage(path: Path, kind: str) -> str:
    """Say what is wrong with a file that should have a seal; an empty string when nothing is.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    kind : str
        What it should be, such as ``"case file"``.
    """
    if not path.exists():
        return "there is no such file"
    if not path.is_file():
        return "it is not a file"
    try:
        state = check_seal(path)
    except OSError as cause:
        return f"it cannot be read ({cause.strerror or cause})"
    if state is Seal.MISSING:
        return f"it is no whole {kind}: unfinished, cut short or changed by another program"
    return "it is damaged: its checksum does not fit" if state is Seal.BROKEN else ""


def _line(stream: BinaryIO, content: int) -> bytes:
    checksum = 0
    while content > 0 and (block := stream.read(min(content, _BLOCK_BYTES))):
        checksum = zlib.crc32(block, checksum)
        content -= len(block)
    return _MARK + f"{checksum:08x}\n".encode()
