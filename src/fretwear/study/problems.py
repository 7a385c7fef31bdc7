"""Problems of a study file as one error, printable on any terminal."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from fretwear.problems import Problem

ENDINGS = (".yaml", ".yml")
"""Endings of study files."""

_UNPRINTABLE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)

_FORMULA = {"=", "+", "-", "@", "\t", "\r"}
_QUANTITY = re.compile(r"[-+](\d+\.?\d*|\.\d+|inf)(e[-+]?\d+)?( ?[^\W\d][\w^/ ·]*)?", re.IGNORECASE)


def printable(text: str) -> str:
    """Return a text with terminal control characters shown as escapes.

    Characters that reverse the direction of text, and surrogates, which stand for bytes of file
    names that are not text, are shown as escapes too.
    """
    return _UNPRINTABLE.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def as_cell(value: object) -> object:
    """Return a value for a table of text; text that a spreadsheet would compute gets an apostrophe.

    Quantities, such as ``-5 um``, are no formulas.
    """
    if isinstance(value, str) and value[:1] in _FORMULA and not _QUANTITY.fullmatch(value):
        return f"'{value}"
    return value


class StudyError(ValueError):
    """A study file that cannot be run; `problems` lists everything that is wrong, in order."""

    def __init__(self, file: Path, problems: Iterable[Problem]) -> None:
        self.file = file
        self.problems = tuple(problems)
        super().__init__(file, self.problems)

    def __str__(self) -> str:
        if len(self.problems) == 1:
            return printable(f"{self.file}: {self.problems[0]}")
        listed = "\n".join(f"  {problem}" for problem in self.problems)
        return printable(f"{self.file}: {len(self.problems)} problems\n{listed}")


def few_of(things: Sequence[object], most: int = 5) -> list[str]:
    """Return the first few items as text, and the number of the others."""
    more = [f"and {len(things) - most} more"] if len(things) > most else []
    return [*map(str, things[:most]), *more]
