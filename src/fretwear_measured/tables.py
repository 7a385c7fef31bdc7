"""Tables of numbers in files of instruments, recorders and spreadsheets.

The line before the first numbers names the columns, with units in brackets, behind a slash or in a
line of their own. Tabs, semicolons, commas or blanks separate the numbers; other commas are decimal
commas. Keys beside the name of a file set what the file lacks (`Layout`).
"""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from fretwear.arrays import Array
from fretwear.units import Dimension, QuantityError, listed, parse_quantity

TABLES = (".csv", ".txt", ".dat", ".asc", ".tsv", ".prn", ".lvm", ".tdms")
"""Endings of the files that are read as tables."""
_MOST_HEADLINES, _SAMPLE = 500, 300  # lines
_BOMS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_NUMBER = r"[-+−]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_WRITTEN = re.compile(r"[-+−]?[\d.,]*\d[.,]?(?:[eE][-+]?\d+)?")  # with decimals and thousands
_BLANKS = re.compile(r"\s*[-+−\d.,eE]*\d(?:\s+[-+−\d.,eE]*\d)+\s*")
_THOUSANDS = r"[-+]?[1-9]\d{{0,2}}(?:{0}\d{{3}})+"
_MISSING = {"", "nan", "na", "n/a", "-", "--", "---", "***", "bad", "null", "over"}
_UNITS = (
    "m cm mm um µm μm nm pm N mN kN uN µN μN s sec ms msec min h V mV Hz rpm K C °C degC % - 1 "
    "Pa MPa J mJ Nm newton volt micron micrometer millimeter second"
)
_ANY_UNIT = "|".join(_UNITS.split())
_UNIT = re.compile(rf"[(\[]?((?:{_ANY_UNIT})(?:/(?:{_ANY_UNIT}))?)[)\]]?")
_HEADS = (
    re.compile(r"(?P<name>[^(\[]*?)[\s_]*[(\[]\s*(?P<unit>[^)\]]*?)\s*[)\]]?(?P<more>[^)\]]*)"),
    re.compile(r"(?P<name>[^/]*?)\s*/\s*(?P<unit>\S*)(?P<more>)"),
)
# A word with the unit in brackets behind it, where blanks separate columns.
_WORD = re.compile(r"[^\s(\[]+(?:\s*[(\[][^)\]]*[)\]])?")
_EXTRA = "install it: pip install 'fretwear[recordings]'"
_SUBSTRING = 5  # letters of a word that may be a part of a longer one, such as frictionforce


@dataclass(frozen=True)
class Layout:
    """What a user says of a table, where the file does not."""

    columns: tuple[int | str, ...] | None = None  #: those to use, by number from 0 or by name
    units: tuple[str, ...] | None = None  #: their units
    skip: int = 0  #: lines before the names of the columns
    decimal: str | None = None  #: sign between whole numbers and decimals: . or ,
    encoding: str | None = None  #: such as latin-1
    scale: tuple[str, ...] | None = None  #: factors of the columns, such as 20 um/V or -1


PLAIN = Layout()
"""Nothing is said."""


@dataclass(frozen=True)
class Sought:
    """A quantity sought among the columns of a table, by words in their names."""

    dimension: Dimension
    words: tuple[str, ...]  #: lists of words, the most telling ones first
    foreign: str = ""  #: words of columns that hold something else

    def rank(self, name: str, unit: str) -> tuple[bool, int] | None:
        """How far a column is from what is sought, by its unit and its words; None: another one."""
        if has_word(name, self.foreign):
            return None
        rank = next((n for n, words in enumerate(self.words) if has_word(name, words)), None)
        return None if rank is None else (bool(unit.strip("-1#")) and not self.fits(unit), rank)

    def fits(self, unit: str) -> bool:
        """Whether a unit is one of the quantity."""
        try:
            parse_quantity(f"1 {unit}", self.dimension, units_required=True)
        except QuantityError:
            return False
        return True


def has_word(name: str, words: str) -> bool:
    """Whether a name has one of some words, as a word or, if it is long, as a part of one."""
    parts = {*re.findall(r"[^\W_]+", name), re.sub(r"[\W_]", "", name)}
    return any(w in parts or (len(w) >= _SUBSTRING and w in name) for w in words.split())


@dataclass(frozen=True)
class Table:
    """The columns of a file."""

    names: tuple[str, ...]  #: in lower case; empty if the file does not name them
    units: tuple[str, ...]  #: empty where unknown
    values: Array  #: shape (rows, columns), NaN where missing
    layout: Layout
    lines: Sequence[int] = ()  #: numbers of the rows in the file, from 1
    #: cells that are no numbers, by column, with their rows
    words: Mapping[int, pd.Series[str]] = field(default_factory=dict)

    def choose(self, sought: Sequence[Sought], example: str, first: int = 0) -> list[int]:
        """The number of a column for each quantity, all different; `QuantityError` otherwise.

        They are those of `Layout.columns` from a place on, or the only ones that fit.
        """
        count = self.values.shape[1]
        if asked := self.layout.columns:
            chosen = [self._numbered(one) for one in asked[first : first + len(sought)]]
            if len({*chosen}) < len(sought):
                given = ", ".join(map(str, asked))
                rule = f"needs {len(sought)} different columns, not columns: [{given}]"
                raise QuantityError(rule, f"its columns are {self._there}")
            return chosen
        if not self.names:
            if first + len(sought) > count or 1 < len(sought) < count:
                rule = f"has {count} columns without names, not {len(sought)}"
                raise QuantityError(rule, f"name them, {example}, or say which: columns: [1, 2]")
            return [*range(first, first + len(sought))]
        found = [self.ranked(one) for one in sought]
        best = [[n for n, rank in one.items() if rank == min(one.values())] for one in found]
        options = _different(best) or _different([[*one] for one in found])
        if len(options) == 1:
            return [*options[0]]
        for each, numbers in zip(sought, zip(*options, strict=True), strict=False):
            if several := sorted({*numbers}) if len({*numbers}) > 1 else []:
                names = listed(f"{self.names[n]!r}" for n in several)
                rule = f"has several columns that may be {each.dimension.name}: {names}"
                pick = ", ".join(map(str, options[0]))
                raise QuantityError(rule, f"say which, by number from 0: columns: [{pick}]")
        missing = next((s for s, one in zip(sought, best, strict=True) if not one), sought[-1])
        words = listed(sorted(one.split()[0] for one in missing.words), "or")
        there = f"{listed(self.names)}, not {words}"
        fits = [[n for n, u in enumerate(self.units) if u and one.fits(u)] for one in sought]
        pick = ", ".join(map(str, (_different(fits) or [(*range(len(sought)),)])[0]))
        raise QuantityError(f"has the columns {there}", f"{example}, or columns: [{pick}]")

    def ranked(self, sought: Sought) -> dict[int, tuple[bool, int]]:
        """The columns that may hold a quantity, with their ranks."""
        ranks = (sought.rank(*column) for column in zip(self.names, self.units, strict=False))
        return {n: rank for n, rank in enumerate(ranks) if rank is not None}

    def read(self, sought: Sequence[Sought], example: str) -> tuple[list[int], list[Array]]:
        """The numbers of the columns for some quantities, and their values in SI units."""
        numbers = self.choose(sought, example)
        columns = zip(numbers, sought, strict=True)
        return numbers, [
            self.in_si(number, place, one.dimension, example)
            for place, (number, one) in enumerate(columns)
        ]

    def column(
        self, place: int, words: Sequence[str], dimension: Dimension, example: str
    ) -> tuple[Array, str]:
        """A column in SI units, and its name; `words` are those that its name may have.

        It is the one at a place of the keys `columns` and `units`, if they are given.
        """
        (number,) = self.choose([Sought(dimension, tuple(words))], example, place)
        name = self.names[number] if self.names else ""
        return self.in_si(number, place, dimension, example), name

    def in_si(self, number: int, place: int, dimension: Dimension, example: str) -> Array:
        """A column in SI units, by its number and its place in the keys `units` and `scale`."""
        if (words := self.words.get(number)) is not None:
            row, cell = next(iter(words.items()))
            column = f"its column {self.label(number)}"
            if np.isnan(self.values[:, number]).all():
                rule = f"has no numbers in {column}, but {cell[:30]!r} in line {self.lines[row]}"
                raise QuantityError(
                    rule, f"choose others: columns: [0, 1]; there are {self._there}"
                )
            decimal = "," if cell.rfind(",") > cell.rfind(".") else "."
            rule = f"has {cell[:20]!r} in line {self.lines[row]}, which is no number"
            remedy = "remove it"
            if {",", "."} & {*cell}:
                remedy += f", or say how decimals are written: decimal: '{decimal}'"
            raise QuantityError(rule, remedy)
        units, scales = self.layout.units, self.layout.scale
        unit = units[min(place, len(units) - 1)] if units else self.units[number]
        scale = scales[min(place, len(scales) - 1)] if scales else "1"
        plain = re.fullmatch(_NUMBER, scale)
        if not unit and plain:
            rule = f"has no unit for its column {self.label(number)}"
            units_of_example = ", ".join(re.findall(r"[(](.*?)[)]", example)) or "um, um"
            raise QuantityError(rule, f"{example}, or units: [{units_of_example}]")
        # A scale without a unit of the column, such as 20 um/V, tells that unit itself.
        unit = unit or scale.rpartition("/")[2]
        text = f"{scale} {unit}" if plain else f"{scale}*({unit})" if "/" in scale else scale
        sign, text = (-1.0, text[1:]) if text[0] == "-" else (1.0, text)
        try:
            size = sign * parse_quantity(text, dimension, units_required=True)
        except QuantityError as error:
            rule = f"has a wrong unit for its column {self.label(number)}: it {error.rule}"
            remedy = "choose another, or say what a volt stands for: scale: [1, 10 N/V]"
            raise QuantityError(rule, error.hint or remedy) from error
        return self.values[:, number] * size

    def label(self, number: int) -> str:
        """The name of a column, or its number."""
        return repr(self.names[number]) if self.names and self.names[number] else str(number)

    @property
    def _there(self) -> str:
        return listed(self.names) if any(self.names) else f"0 to {self.values.shape[1] - 1}"

    def _numbered(self, asked: int | str) -> int:
        """The number of a column from its number or its name."""
        if isinstance(asked, int) and 0 <= asked < self.values.shape[1]:
            return asked
        same = [n for n, name in enumerate(self.names) if name in _head(str(asked).casefold())]
        if isinstance(asked, int) or not same:
            raise QuantityError(f"has no column {asked!r}", f"its columns are {self._there}")
        if len(same) > 1:
            rule = f"has {len(same)} columns named {asked!r}"
            raise QuantityError(rule, f"say which, by number: {listed(map(str, same), 'or')}")
        return same[0]


def _different(found: Sequence[Sequence[int]]) -> list[tuple[int, ...]]:
    """All ways to choose one number of each list, no number twice."""
    return [chosen for chosen in product(*found) if len({*chosen}) == len(chosen)]


def open_table(path: Path, layout: Layout = PLAIN) -> Table:
    """Read the table of a text, of a LabVIEW measurement (.lvm) or of TDMS (.tdms)."""
    if path.suffix.lower() == ".tdms":
        return _tdms_table(path, layout)
    if path.suffix.lower() == ".lvm":
        text = read_text(path, layout.encoding)
        if text.startswith("LabVIEW Measurement"):
            return _lvm_table(text, layout)
    return read_text_table(path, layout)


def read_text_table(path: Path, layout: Layout = PLAIN) -> Table:
    """Read the table of a text file; `QuantityError` says why it cannot be read."""
    lines = read_text(path, layout.encoding).splitlines()
    if layout.skip >= len(lines) > 0:
        raise QuantityError(f"has {len(lines)} lines, and skip leaves none of them")
    kept = [n for n, line in enumerate(lines) if n >= layout.skip and _is_content(line)]
    first = _first_numbers([lines[n] for n in kept[: _MOST_HEADLINES + 1]])
    if first is None:
        rule = f"has no table of numbers within {_MOST_HEADLINES} lines"
        raise QuantityError(rule, "say where the names of its columns are: skip: 12")
    at, rows = kept[first:], [lines[n] for n in kept[first:]]
    names, units = _heads([lines[n] for n in kept[:first]])
    separator = _separator(rows[0])
    if separator == "," and not names and layout.decimal is None and "." not in rows[0]:
        separator = None  # these may be decimal commas
    decimal = layout.decimal or _decimal_sign(rows, separator)
    widths = [line.count(separator) + 1 if separator else len(line.split()) for line in rows]
    cells = pd.read_csv(
        io.StringIO("\n".join(rows).replace("−", "-")),
        sep=separator or r"\s+",
        header=None,
        names=range(max(widths)),
        index_col=False,
        decimal=decimal,
        na_values=[*_MISSING, *map(str.upper, _MISSING)],
        skipinitialspace=separator != "\t",
        skip_blank_lines=False,
        low_memory=False,
    )
    if cells[0].isna().all() and cells.notna().any().sum() == len(names):
        cells = cells.drop(columns=0).set_axis(range(cells.shape[1] - 1), axis="columns")
    width = len(names) or cells.shape[1]
    if (extra := cells.iloc[:, width:].notna().any(axis="columns")).any():
        row = int(extra.to_numpy().argmax())
        rule = f"has {widths[row]} cells in line {at[row] + 1}, but {width} columns"
        remedy = "give every column a name above its numbers"
        if separator == ",":
            remedy = "export decimal commas with semicolons between the columns"
        raise QuantityError(f"{rule}: {rows[row].strip()[:40]!r}", remedy)
    values, words = np.full((len(rows), width), np.nan), {}
    for column in cells.columns[:width]:
        values[:, column], words[column] = _numbers(cells[column], decimal, layout)
    # A line without any number, such as a title between two parts, does not count.
    counts = np.asarray(np.isfinite(values).any(axis=1))
    words = {n: kept for n, one in words.items() if len(kept := one[counts[one.index]])}
    return Table(names, units or ("",) * width, values, layout, [n + 1 for n in at], words)


def _numbers(cells: pd.Series, decimal: str, layout: Layout) -> tuple[Array, pd.Series]:
    """The numbers of a column, NaN where it has none, and its cells that are no numbers."""
    if cells.dtype.kind in "fi":
        return cells.to_numpy(float), cells[:0]
    text = cells.fillna("").astype(str).str.strip()
    if layout.decimal:
        group = "." if decimal == "," else ","
        grouped = _THOUSANDS.format(re.escape(group)) + rf"(?:\{decimal}\d*)?"
        text = text.mask(text.str.fullmatch(grouped), text.str.replace(group, "", regex=False))
    number = text.str.fullmatch(_NUMBER.replace(r"\.", re.escape(decimal)))
    values = pd.to_numeric(text.str.replace(decimal, ".", regex=False).where(number))
    return values.to_numpy(float), text[~number & ~text.str.casefold().isin(_MISSING)]


def _decimal_sign(rows: Sequence[str], separator: str | None) -> str:
    """The decimal sign of the numbers; `QuantityError` if their commas may separate thousands."""
    for part in (rows[:_SAMPLE], rows):
        if separator == "," and '"' not in part[0]:
            return "."
        cells = {
            cell for row in part for cell in _split(row, separator) if "," in cell or "." in cell
        }
        cells = {cell for cell in cells if _WRITTEN.fullmatch(cell)}
        commas = {cell for cell in cells if "," in cell}
        if not commas or any("." in cell for cell in cells):
            return "."
        if not all(re.fullmatch(_THOUSANDS.format(","), cell) for cell in commas):
            return ","
    one = min(commas)
    rule = f"has {one!r}, which may be {one.replace(',', '.', 1)} or {one.replace(',', '')}"
    raise QuantityError(
        f"{rule}: every comma stands before three digits", "say which: decimal: ',' or decimal: '.'"
    )


def _lvm_table(text: str, layout: Layout) -> Table:
    """The table of a LabVIEW measurement, whose parts follow each other."""
    try:
        import lvm_read
    except ImportError as error:
        raise QuantityError("needs the package lvm-read, which is not installed", _EXTRA) from error
    try:
        # Its `read` would also load a pickle beside the file, which may run code.
        content = lvm_read.read_str(text)
        parts = [content[n] for n in range(content["Segments"])]
        names = [name.casefold() for name in parts[0]["Channel names"]]
        data = [np.asarray(part["data"], float) for part in parts]
    except Exception as error:
        rule = f"cannot be read as a LabVIEW measurement: {str(error)[:100]}"
        raise QuantityError(rule, "save it as text with tabs, named .txt") from error
    has_time = content.get("X_Columns", "One") != "No"
    labels = (["s"] if has_time else []) + [*parts[0].get("Y_Unit_Label", [])]
    units = [*map(_spelled, labels), *[""] * len(names)]
    columns = ["time" if name == "x_value" else name for name in names]
    values = [
        np.pad(one, ((0, 0), (0, max(len(names) - one.shape[1], 0))), constant_values=np.nan)
        for one in data
    ]
    if not has_time:
        steps = [np.nanmax(part.get("Delta_X", [np.nan])) for part in parts]
        times = [step * np.arange(len(one)) for step, one in zip(steps, values, strict=True)]
        columns, units = ["time", *columns], ["s", *units]
        values = [np.column_stack(pair) for pair in zip(times, values, strict=True)]
    count = len(columns)
    return Table((*columns,), (*units[:count],), np.concatenate(values)[:, :count], layout)


def _tdms_table(path: Path, layout: Layout) -> Table:
    """The channels of a TDMS file, the names of several groups in front of theirs."""
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise QuantityError("needs the package nptdms, which is not installed", _EXTRA) from error
    try:
        groups = TdmsFile.read(path).groups()
    except Exception as error:
        raise QuantityError(
            f"cannot be read as TDMS: {str(error)[:100]}", "save it as text"
        ) from error
    columns: dict[tuple[str, str], pd.Series] = {}
    for group in groups:
        for channel in group.channels():
            of = f"{group.name} " if len(groups) > 1 else ""
            unit = _spelled(str(channel.properties.get("unit_string", "")))
            columns[f"{of}{channel.name}".casefold(), unit] = pd.Series(channel[:])
            if step := channel.properties.get("wf_increment"):
                columns.setdefault((f"{of}time", "s"), pd.Series(step * np.arange(len(channel))))
    if not columns:
        raise QuantityError("has no channels", "save it as text")
    values = np.full((max(map(len, columns.values())), len(columns)), np.nan)
    words = {}
    for n, column in enumerate(columns.values()):
        values[: len(column), n], words[n] = _numbers(column, ".", layout)
    names, units = zip(*columns, strict=True)
    lines = range(1, len(values) + 1)
    return Table(names, units, values, layout, lines, {n: w for n, w in words.items() if len(w)})


def _is_content(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _first_numbers(lines: Sequence[str]) -> int | None:
    """The first of two lines of numbers, else of two with numbers beside words such as a clock.

    A number alone may be in a preamble.
    """
    rows = [_split(line, _separator(line)) for line in lines]
    forms = [[_is_number(cell) or cell.casefold() in _MISSING for cell in row] for row in rows]
    counts = [sum(map(_is_number, row)) for row in rows]
    plain = [
        len(form) > 1 and all(form) and count > 0 for form, count in zip(forms, counts, strict=True)
    ]
    for n in range(len(rows)):
        if all(plain[n : n + 2]):
            return n
    pairs = zip(forms, forms[1:], counts, strict=False)
    return next(
        (n for n, (form, following, count) in enumerate(pairs) if count > 1 and form == following),
        None,
    )


def read_text(path: Path, encoding: str | None = None) -> str:
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


def _separator(line: str) -> str | None:
    """The sign between the cells of a line; None: blanks."""
    if (separator := next((s for s in "\t;" if s in line), None)) is None and "," in line:
        return None if _BLANKS.fullmatch(line) else ","
    return separator


def _split(line: str, separator: str | None) -> list[str]:
    """The cells of a line, without empty ones at its end."""
    if separator is None:
        cells = line.split()
    elif '"' in line:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=separator != "\t"))
    else:
        cells = line.split(separator)
    cells = [cell.strip().strip('"').strip() for cell in cells]
    while len(cells) > 1 and not cells[-1]:
        cells.pop()
    return cells


def _is_number(cell: str) -> bool:
    """Whether a cell is a number, with any signs of decimals and thousands."""
    return _WRITTEN.fullmatch(cell) is not None


def _heads(lines: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names and units of the columns, from the lines above the numbers."""
    if not lines:
        return (), ()
    separator = next((s for s in "\t;," if s in lines[-1]), None)

    def cells(line: str) -> list[str]:
        return _split(line, separator) if separator else _WORD.findall(line)

    own, above = cells(lines[-1]), cells(lines[-2]) if len(lines) > 1 else []
    if (
        any(own)
        and all(_UNIT.fullmatch(_spelled(cell)) or not cell for cell in own)
        and len(above) >= len(own)
    ):
        names, units = above, [cell.strip("()[]") for cell in own]
        units += [""] * (len(names) - len(units))
    else:
        names, units = map(list, zip(*map(_head, own), strict=True))
    for number, name in enumerate(names):
        word, _, unit = re.sub(r"[\s_]+", " ", name).rpartition(" ")
        if not units[number] and word and _UNIT.fullmatch(unit):
            names[number], units[number] = word.rstrip(","), unit
    return tuple(name.strip().casefold().replace("x_value", "time") for name in names), tuple(
        map(_spelled, units)
    )


def _head(cell: str) -> tuple[str, str]:
    """The name and the unit of a column."""
    for form in _HEADS:
        if found := form.fullmatch(cell):
            return f"{found['name']} {found['more']}".strip(), found["unit"]
    return cell, ""


def _spelled(unit: str) -> str:
    """A unit as `parse_quantity` knows it, without capitals and plurals of words."""
    unit = re.sub(r"[A-Za-z]{4,}", lambda word: word[0].lower().removesuffix("s"), unit)
    return re.sub(r"\b([mu]?)sec\b", r"\1s", unit, flags=re.IGNORECASE)
