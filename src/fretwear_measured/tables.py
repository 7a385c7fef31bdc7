"""Tables of numbers in text files, as instruments, recorders and spreadsheets write them.

The line before the first numbers names the columns, with units in brackets, behind a slash or in a
line of their own. Its separator is also the table's; other commas are decimal commas.
Keys beside the name of a file set what the file lacks (`Layout`).
"""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretwear.arrays import Array
from fretwear.units import Dimension, QuantityError, listed, parse_quantity

_MOST_HEADLINES = 500
_BOMS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_NUMBER = r"[-+−]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_MISSING = {"", "nan", "na", "n/a", "-", "--", "---", "***", "bad", "null"}
_UNITS = "m cm mm um µm μm nm pm N mN kN uN µN μN s ms min h V mV"
_UNIT = re.compile(rf"[(\[]?({'|'.join(_UNITS.split())}|N/m|N/mm|kN/m|1)[)\]]?")
_HEAD = re.compile(r"(?P<name>[^(\[/]*?)[\s_]*(?:[(\[/]\s*(?P<unit>[^)\]]*?)\s*[)\]]?)?")
# A word with the unit in brackets behind it, where blanks separate columns.
_WORD = re.compile(r"[^\s(\[]+(?:\s*[(\[][^)\]]*[)\]])?")


@dataclass(frozen=True)
class Layout:
    """What a user says of a table, where the file does not."""

    columns: tuple[int | str, ...] | None = None  #: those to use, by number from 0 or by name
    units: tuple[str, ...] | None = None  #: their units
    skip: int = 0  #: lines before the names of the columns
    decimal: str | None = None  #: sign between whole numbers and decimals: . or ,
    encoding: str | None = None  #: such as latin-1


@dataclass(frozen=True)
class Table:
    """The columns of a file."""

    names: tuple[str, ...]  #: in lower case; empty if the file does not name them
    units: tuple[str, ...]  #: empty where unknown
    values: Array  #: shape (rows, columns), NaN where missing
    lines: tuple[int, ...]  #: numbers of the rows in the file, from 1
    layout: Layout

    def find(self, place: int, words: Collection[str]) -> int | None:
        """The number of a column: that at a place of `Layout.columns`, or one of these words."""
        if chosen := self.layout.columns:
            asked = chosen[place] if place < len(chosen) else chosen[-1]
            if isinstance(asked, int) and 0 <= asked < self.values.shape[1]:
                return asked
            if isinstance(asked, str) and asked.casefold() in self.names:
                return self.names.index(asked.casefold())
            there = listed(self.names) if self.names else f"0 to {self.values.shape[1] - 1}"
            raise QuantityError(f"has no column {asked!r}", f"its columns are {there}")
        for number, name in enumerate(self.names):
            if name in words or {*re.findall(r"\w+", name)} & {*words}:
                return number
        return place if not self.names and place < self.values.shape[1] else None

    def column(
        self, place: int, words: Sequence[str], dimension: Dimension, example: str
    ) -> tuple[Array, str]:
        """A column in SI units, and its name; `words` are those that its name may have.

        It is the one at a place of the keys `columns` and `units`, if they are given.
        """
        number = self.find(place, words)
        if number is None:
            there = f"{listed(self.names)}, not {listed(words, 'or')}"
            raise QuantityError(f"has the columns {there}", f"{example}, or columns: [0, 1]")
        unit = self.units[number]
        if given := self.layout.units:
            unit = given[min(place, len(given) - 1)]
        name = self.names[number] if self.names else ""
        if not unit:
            column = f"its column {name!r}" if name else f"its column {number}"
            raise QuantityError(f"has no unit for {column}", f"{example}, or units: [um, um]")
        scale = parse_quantity(f"1 {unit}", dimension, units_required=True)
        return self.values[:, number] * scale, name


def read_text_table(path: Path, layout: Layout = Layout()) -> Table:
    """Read the table of a text file; `QuantityError` says why it cannot be read."""
    lines = _text(path, layout.encoding).splitlines()
    if layout.skip >= len(lines) > 0:
        raise QuantityError(f"has {len(lines)} lines, and skip leaves none of them")
    rows = [(n, line.strip()) for n, line in enumerate(lines, 1) if n > layout.skip]
    rows = [(n, line) for n, line in rows if line and not line.startswith("#")]
    # The first of two lines of numbers begins the table; a number alone may be in a preamble.
    first = next(
        (
            at
            for at, (_, line) in enumerate(rows[:_MOST_HEADLINES])
            if _is_numeric(line) and all(_is_numeric(other) for _, other in rows[at + 1 : at + 2])
        ),
        None,
    )
    if first is None:
        raise QuantityError("has no table of numbers", "say where it begins: skip: 12")
    heads = [line for _, line in rows[:first]]
    names, units, separator = _heads(heads, rows[first][1])
    cells = [_split(line, separator) for _, line in rows[first:]]
    if separator is not None and all(len(row) == 1 for row in cells):
        separator, cells = None, [_split(line, None) for _, line in rows[first:]]
    decimal = layout.decimal
    if decimal is None:
        written = [cell for row in cells for cell in row]
        comma = any("," in cell for cell in written) and not any("." in cell for cell in written)
        decimal = "," if comma else "."  # cells with such a comma are quoted
    count = len(names) or max(map(len, cells))
    values = np.full((len(cells), count), np.nan)
    for place, ((number, line), row) in enumerate(zip(rows[first:], cells, strict=True)):
        if any(row[count:]):
            rule = f"has {len(row)} cells in line {number}, but {count} columns: {line[:40]!r}"
            raise QuantityError(rule, "export decimal commas with semicolons between the columns")
        for column, cell in enumerate(row[:count]):
            values[place, column] = _value(cell, decimal, number)
    return Table(names, units or ("",) * count, values, tuple(n for n, _ in rows[first:]), layout)


def _text(path: Path, encoding: str | None) -> str:
    """The text of a file in its encoding: given, by its first bytes, UTF-8 or Windows'."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise QuantityError(f"cannot be read: {error.strerror}") from error
    by_mark = next((name for mark, name in _BOMS if content.startswith(mark)), None)
    if by_mark is None and b"\0" in content[:200]:
        by_mark = "utf-16-le" if content[1:2] == b"\0" else "utf-16-be"
    known = encoding or by_mark
    for name in (known,) if known else ("utf-8", "cp1252", "latin-1"):
        try:
            text = content.decode(name)
        except UnicodeDecodeError:
            continue
        except LookupError as error:
            raise QuantityError(f"has no encoding {encoding!r}", "such as latin-1") from error
        if sum(not (c.isprintable() or c.isspace()) for c in text[:1000]) < 10:
            return text
    raise QuantityError("cannot be read as text", "give its encoding, such as encoding: utf-16")


def _split(line: str, separator: str | None) -> list[str]:
    """The cells of a line, without empty ones at its end."""
    if separator:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    else:
        cells = re.split(r"[;\t]\s*|,\s+|\s+", line)
    cells = [cell.strip().strip('"').strip() for cell in cells]
    while len(cells) > 1 and not cells[-1]:
        cells.pop()
    return cells


def _is_numeric(line: str) -> bool:
    """Whether a line has two cells or more, all of them numbers or signs of a missing one."""
    cells = _split(line, next((s for s in ("\t", ";") if s in line), None))
    if len(cells) == 1 and "," in line:
        cells = _split(line, ",")
    numbers = [cell for cell in cells if cell.casefold() not in _MISSING]
    return (
        len(cells) > 1
        and len(numbers) > 0
        and all(re.fullmatch(_NUMBER, part) for cell in numbers for part in cell.split(","))
    )


def _heads(lines: Sequence[str], first: str) -> tuple[tuple[str, ...], tuple[str, ...], str | None]:
    """Names and units of the columns, from the lines above the numbers, and their separator."""
    above = lines[-1] if lines else first
    separator = next((s for s in ("\t", ";", ",") if s in above), None)

    def cells(line: str) -> list[str]:
        return _split(line, separator) if separator else _WORD.findall(line)

    if not lines:
        return (), (), separator if separator != "," or "." in first else None
    own = cells(above)
    if len(lines) > 1 and all(_UNIT.fullmatch(cell) or not cell for cell in own) and any(own):
        names = cells(lines[-2])
        units = [cell.strip("()[]") for cell in own]
        units += [""] * (len(names) - len(units))
    else:
        found = [_HEAD.fullmatch(cell) for cell in own]
        names = [at["name"] if at else cell for at, cell in zip(found, own, strict=True)]
        units = [(at["unit"] or "") if at else "" for at in found]
    for number, name in enumerate(names):
        word, _, unit = re.sub(r"[\s_]+", " ", name).rpartition(" ")
        if not units[number] and word and _UNIT.fullmatch(unit):
            names[number], units[number] = word, unit
    return tuple(name.strip().casefold() for name in names), tuple(units), separator


def _value(cell: str, decimal: str, line: int) -> float:
    if cell.casefold() in _MISSING:
        return np.nan
    text = cell.replace("−", "-")
    if decimal == ",":
        text = text.replace(",", ".")
    if not re.fullmatch(_NUMBER, text):
        rule = f"has {cell[:20]!r} in line {line}, which is no number"
        raise QuantityError(rule, "remove it, or say how decimals are written: decimal: ','")
    return float(text)
