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
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, product, repeat
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fretwear.arrays import Array
from fretwear.units import Dimension, QuantityError, listed, parse_quantity
from fretwear_measured.times import (
    are_same,
    common_times,
    count_readings,
    rise,
    times_of_segments,
    times_of_waveforms,
    until_last,
    usual_step,
    values_at,
)

if TYPE_CHECKING:
    import pandas as pd

TEXTS = (".csv", ".txt", ".dat", ".asc", ".tsv", ".prn")
TABLES = (*TEXTS, ".lvm", ".tdms")
"""Endings of the files that are read as tables."""
_ARCHIVES = b"PK\3\4", b"\x1f\x8b", b"7z\xbc\xaf", b"BZh"
_MOST_HEADLINES, _SAMPLE = 500, 300  # lines
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_WRITTEN = re.compile(r"[-+−]?[\d.,]*\d[.,]?(?:[eE][-+]?\d+)?")  # with decimals and thousands
_BLANKS = re.compile(r"\s*[-+−\d.,eE]*\d(?:\s+[-+−\d.,eE]*\d)+\s*")
_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(?:,\d{3})+")
_MISSING = re.compile(
    "(?i)|nan|n/?a|no[ _]?data|bad|over|null|none|void|invalid|masked|[-+]?inf(inity)?|-+|[*]+"
)
_UNITS = (
    "m|cm|mm|um|µm|μm|nm|pm|N|mN|kN|uN|µN|μN|s|sec|ms|msec|min|h|V|mV|Hz|rpm|K|C|°C|degC|%|-|1|"
    "Pa|MPa|J|mJ|Nm|newton|volt|micron|micrometer|millimeter|second"
)
_UNIT = re.compile(rf"[(\[]?((?:{_UNITS})(?:/(?:{_UNITS}))?)[)\]]?")
_HEADS = (
    re.compile(r"(?P<name>[^(\[]*?)[\s_]*[(\[]\s*(?P<unit>[^)\]]*?)\s*[)\]]?(?P<more>[^)\]]*)"),
    re.compile(r"(?P<name>[^/]*?)\s*/\s*(?P<unit>\S*)(?P<more>)"),
    re.compile(rf"(?P<name>.+?),?[\s_]+(?P<unit>{_UNIT.pattern})(?P<more>)"),
    re.compile(r"(?P<name>.*)(?P<unit>)(?P<more>)"),
)
# A word with the unit in brackets behind it, where blanks separate columns.
_WORD = re.compile(r"[^\s(\[]+(?:\s*[(\[][^)\]]*[)\]])?")
_VOLTS = ("V", "mV", "volt")
LARGEST = 1e300  # number
_FAR_AWAY = 10.0  # of a mark, over the range of the other values
_FULL = 0.9  # of the readings of another channel
_SUBSTRING = 5  # letters of a word that may be a part of a longer one, such as frictionforce


class NoTableError(QuantityError):
    """A file without text or without numbers in columns."""


def ensure(holds: object, rule: str, remedy: str = "") -> None:
    """Raise `QuantityError` with a rule and its remedy unless a condition holds."""
    if not holds:
        raise QuantityError(rule, remedy)


@contextmanager
def library(package: str, extra: str, kind: str, remedy: str) -> Iterator[None]:
    """Errors of an optional library, of all sorts, as sentences."""
    try:
        yield
    except QuantityError:
        raise
    except ImportError as error:
        rule = f"needs the package {package}, which is not installed"
        raise QuantityError(rule, f"install it: pip install 'fretwear[{extra}]'") from error
    except Exception as error:
        reason = re.sub(r"\s+", " ", str(error).strip())[:150] or type(error).__name__
        if type(error).__name__ == "CannotDetectFileFormat":
            reason = "no reader knows its format"
        raise QuantityError(f"cannot be read as {kind}: {reason}", remedy) from error


def pick(asked: int | str, names: Sequence[str], kind: str) -> int:
    """The place of what is asked for, by number from 0 or by name, among columns or channels."""
    same = [n for n, name in enumerate(names) if asked in (n, name)]
    there = listed(f"{n}: {name}" if name else str(n) for n, name in enumerate(names))
    ensure(same, f"has no {kind} {asked!r}", f"its {kind}s are {there}")
    numbers = listed(map(str, same), "or")
    ensure(len(same) == 1, f"has {len(same)} {kind}s {asked!r}", f"say which number: {numbers}")
    return same[0]


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

    def fits(self, unit: str) -> bool:
        """Whether a unit is one of the quantity."""
        try:
            parse_quantity(f"1 {unit}", self.dimension, units_required=True)
        except QuantityError:
            return False
        return True


SECONDS = Dimension("time", "s", "s", "1 s")
TIME = Sought(SECONDS, ("time timestamp zeit t clock",), "cycle cycles")


def unmarked(values: Array) -> Array:
    """Values with NaN in place of marks of missing ones, such as -9999 or -1.8e308.

    They are a lowest or highest value that repeats, ten times as far away from the others as these
    reach.
    """
    kept = np.where(np.abs(values) < LARGEST, values, np.nan)
    for extreme in (np.fmin.reduce(kept, axis=None), np.fmax.reduce(kept, axis=None)):
        mark = kept == extreme
        others = kept[np.isfinite(kept) & ~mark]
        if mark.sum() > 1 and others.size:
            away = max(others.min() - extreme, extreme - others.max())
            kept[mark & (away > _FAR_AWAY * np.ptp(others) > 0.0)] = np.nan
    return kept


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
    #: cells that are no numbers, by column, with their rows
    words: Mapping[int, pd.Series[str]] = field(default_factory=dict)
    lines: Sequence[int] = ()  #: numbers of the rows in the file, from 1
    widths: Sequence[int] = ()  #: cells of the rows
    above: Sequence[str] = ()  #: the lines above the numbers
    #: times of the columns, s, shape (rows,), empty or None where the file has them in columns
    times: Sequence[Array | None] = ()
    note: str = ""  #: what was interpolated

    def choose(self, sought: Sequence[Sought], example: str) -> list[int]:
        """The number of a column for each quantity, all different; `QuantityError` otherwise.

        They are those of `Layout.columns`, or the only ones that fit.
        """
        count = self.values.shape[1]
        if 0 < len(self.names) < count:
            row = next(n for n, width in enumerate(self.widths) if width > len(self.names))
            rule = f"has {self.widths[row]} cells in line {self.lines[row]}"
            remedy = "give every column a name, and separate decimal commas by semicolons"
            raise QuantityError(f"{rule}, but {len(self.names)} columns", remedy)
        asked = self.layout.columns or ()
        found = [self.ranked(one) for one in sought]
        if asked or not self.names:
            names = self.names or [""] * count
            keys = [one if isinstance(one, int) else _head(one)[0] for one in asked[: len(sought)]]
            usable = [pick(key, names, "column") for key in keys] if asked else range(count)
            found = [{number: (False, 0)} for number in usable]
        best = [[n for n, rank in one.items() if rank == min(one.values())] for one in found]
        options = _different(best) or _different(found)
        if len(options) == 1 and len(found) == len(sought):
            return [*options[0]]
        for each, numbers in zip(sought, zip(*options, strict=True), strict=False):
            if len({*numbers}) > 1:
                several = listed(repr(self.names[n]) for n in sorted({*numbers}))
                rule = f"has several columns that may be {each.dimension.name}: {several}"
                first = ", ".join(map(str, options[0]))
                raise QuantityError(rule, f"say which, by number from 0: columns: [{first}]")
        missing = next((s for s, one in zip(sought, best, strict=False) if not one), sought[-1])
        words = listed(sorted(one.split()[0] for one in missing.words), "or")
        if asked or not self.names:
            selection = (
                f"columns: [{', '.join(map(str, asked))}]" if asked else f"{count} without names"
            )
            rule = f"needs {len(sought)} different columns, not {selection}"
        else:
            rule = f"has the columns {listed(self.names)}, not {words}"
        volts = [n for n, unit in enumerate(self.units) if unit in _VOLTS]
        fits = [[n for n, u in enumerate(self.units) if u and s.fits(u)] or volts for s in sought]
        chosen = [*(_different(fits) or [(*range(len(sought)),)])[0]]
        remedy = f"columns: [{', '.join(map(str, chosen))}]{self._scale_of_volts(chosen, sought)}"
        raise QuantityError(rule, f"{example}, or {remedy}")

    def ranked(self, sought: Sought) -> dict[int, tuple[bool, int]]:
        """The columns that may hold a quantity: whether the unit is another one, and the words."""
        return {
            n: (bool(unit.strip("-1#")) and not sought.fits(unit), rank)
            for n, (name, unit) in enumerate(zip(self.names, self.units, strict=False))
            for rank in [n for n, words in enumerate(sought.words) if has_word(name, words)][:1]
            if not has_word(name, sought.foreign)
        }

    def read(self, sought: Sequence[Sought], example: str) -> tuple[list[int], list[Array]]:
        """The numbers of the columns for some quantities, and their values in SI units."""
        chosen, values = self.choose(sought, example), []
        table = self.aligned(chosen)
        units = _repeated(self.layout.units) or [self.units[n] for n in chosen]
        scales = _repeated(self.layout.scale or ("1",))
        for number, one, unit, scale in zip(chosen, sought, units, scales, strict=False):
            numbers, column = table.numbers(number), f"its column {self.label(number)}"
            plain, examples = re.fullmatch(_NUMBER, scale), re.findall(r"[(](.*?)[)]", example)
            remedy = f"{example}, or units: [{', '.join(examples)}]"
            ensure(unit or not plain, f"has no unit for {column}", remedy)
            # A scale without a unit of the column, such as 20 um/V, tells that unit itself.
            text = f"{scale} {unit}"
            if not plain:
                text = f"{scale}*({unit or scale.rpartition('/')[2]})" if "/" in scale else scale
            try:
                size = parse_quantity(text, one.dimension, units_required=True)
            except QuantityError as error:
                remedy = f"choose another{self._scale_of_volts(chosen, sought)}"
                rule = f"has a wrong unit for {column}: it {error.rule}"
                hint = f"{error.hint} Name that unit in units" if error.hint else remedy
                raise QuantityError(rule, hint) from error
            values.append(size * unmarked(numbers))
        return chosen, values

    def time_of(self, number: int) -> Array | None:
        """Times of the readings of a column, s, NaN behind the last one; None if unknown.

        Several columns of time belong to the columns on their right, up to the next one, or to
        those on their left if the last column is one of them and the first one is not.
        """
        time, found = self.times[number] if self.times else None, self._clocks
        own = [n for n in found if n <= number][-1:]
        if found and found[0] > 0 and found[-1] == len(self.names) - 1:
            own = [n for n in found if n >= number][:1]
        if time is None and own and len(found) > 1:
            unit = f"1 {self.units[own[0]] or 's'}"
            time = parse_quantity(unit, SECONDS, units_required=True) * self.values[:, own[0]]
        return None if time is None else until_last(time, self.values[:, number])

    @cached_property
    def _clocks(self) -> list[int]:
        return [n for n in self._columns_of_time if rise(self.values[:, n])]

    @cached_property
    def _columns_of_time(self) -> list[int]:
        bare = replace(self, names=tuple(re.sub(r"\d+", " ", name) for name in self.names))
        return [n for n, (misfits, _) in bare.ranked(TIME).items() if not misfits]

    def aligned(self, chosen: Sequence[int]) -> Table:
        """The table with some columns at the same times; itself if that holds, or they have none.

        All columns are interpolated linearly at those times of the one with the longest steps that
        the chosen ones have in common. If there are none, columns of time in a table of rows are
        clocks with other zeros, or something else; `QuantityError` elsewhere.
        """
        times = {n: time for n in chosen if (time := self.time_of(n)) is not None}
        first, *others = times.values() or [np.empty(0)]
        remedy = "if each row is one moment, save it as text with one column of time"
        counts = {n: count_readings(self.values[:, n]) for n in chosen}
        is_even = min(counts.values()) >= _FULL * max(counts.values())
        if len(times) < len(chosen) and (self.times or len(self._columns_of_time) > 1):
            rule = listed(f"{count} readings of {self.label(n)}" for n, count in counts.items())
            ensure(is_even, f"has {rule}, but no rising times of both", remedy)
        if len(times) < len(chosen) or all(are_same(first, time) for time in others):
            return self
        columns = {n: unmarked(self.numbers(n)) for n in chosen}
        for number, time in times.items():
            rule = f"has times that do not rise for its column {self.label(number)}"
            ensure(rise(time), rule, remedy)
        slowest = max(times, key=lambda n: usual_step(times[n]))
        moved = [n for n, time in times.items() if not are_same(times[slowest], time)]
        common = common_times(times[slowest], [*times.values()])
        if common.size < 2 and is_even and not self.times:
            return self  # clocks with other zeros, or a temperature T that rises
        rule = f"has columns without a common time: {listed(map(self.label, chosen))}"
        ensure(common.size > 1, rule, remedy)
        values = np.full((common.size, self.values.shape[1]), np.nan)
        for n in range(values.shape[1]):
            time = self.time_of(n)
            if time is None:  # such as a count of cycles beside one of the channels
                count = count_readings(self.values[:, n])
                time = next((t for t in times.values() if count_readings(t) == count), None)
            if time is not None and rise(time):
                column = columns.get(n, self.values[:, n])
                values[:, n] = values_at(common, time, column)
        note = f"{listed(map(self.label, moved))} interpolated linearly at {common.size} times of "
        note += f"{self.label(slowest)}, since their rates or starts differ"
        same = [common] * values.shape[1]
        return replace(self, values=values, times=same, note=note, words={}, lines=(), widths=())

    def numbers(self, number: int) -> Array:
        """The numbers of a column; `QuantityError` if it has words too."""
        if (words := self.words.get(number)) is None:
            return self.values[:, number]
        row, cell = next(iter(words.items()))
        where = f"{cell[:30]!r} in line {self.lines[row]}"
        if np.isnan(self.values[:, number]).all():
            there = f"its columns are {listed(map(self.label, range(len(self.units))))}"
            rule = f"has no numbers in its column {self.label(number)}, but {where}"
            raise QuantityError(rule, f"choose others: columns: [0, 1]; {there}")
        remedy = "remove it, or write nan"
        if {",", "."} & {*cell}:
            decimal = "," if cell.rfind(",") > cell.rfind(".") else "."
            remedy = f"remove it, or say how decimals are written: decimal: '{decimal}'"
        raise QuantityError(f"has {where}, which is no number", remedy)

    def label(self, number: int) -> str:
        """The name of a column, or its number."""
        return repr(self.names[number]) if self.names and self.names[number] else str(number)

    def _scale_of_volts(self, chosen: Sequence[int], sought: Sequence[Sought]) -> str:
        """The key for columns in volts, as it continues a remedy."""
        volts = [self.units[number] in _VOLTS for number in chosen]
        units = [one.dimension.example.split()[-1] for one in sought]
        scales = [f"10 {u}/V" if v else "1" for u, v in zip(units, volts, strict=True)]
        return f", and say what a volt is: scale: [{', '.join(scales)}]" if any(volts) else ""


def _different(found: Sequence[Collection[int]]) -> list[tuple[int, ...]]:
    """All ways to choose one number of each list, no number twice."""
    return [chosen for chosen in product(*found) if len({*chosen}) == len(chosen)]


def _repeated(values: Sequence[str] | None) -> Iterable[str]:
    """The values of a key, the last one for all further columns."""
    return chain(values, repeat(values[-1])) if values else ()


def open_table(path: Path, layout: Layout = PLAIN) -> Table:
    """Read the table of a text, of a LabVIEW measurement (.lvm) or of TDMS (.tdms)."""
    remedy = "save it as text with tabs, named .txt"
    if path.suffix.lower() == ".tdms":
        with library("nptdms", "recordings", "TDMS", remedy):
            return _tdms_table(path, layout)
    text = read_text(path, layout.encoding)
    if path.suffix.lower() == ".lvm" and text.startswith("LabVIEW Measurement"):
        with library("lvm-read", "recordings", "a LabVIEW measurement", remedy):
            return _lvm_table(text, layout)
    return table_of_text(text, layout)


def table_of_text(text: str, layout: Layout = PLAIN) -> Table:
    """The table of a text; `QuantityError` says why it has none."""
    import pandas as pd  # takes half a second

    lines = text.replace("−", "-").splitlines()
    rule = f"has {len(lines)} lines, and skip leaves none of them"
    ensure(not layout.skip >= len(lines) > 0, rule)
    kept = [n for n, line in enumerate(lines) if n >= layout.skip and line.strip()]
    first = _first_numbers([lines[n] for n in kept[: _MOST_HEADLINES + 1]])
    if first is None:
        rule = f"has no table of numbers within {_MOST_HEADLINES} lines"
        raise NoTableError(rule, "say where the names of its columns are: skip: 12")
    above = [lines[n] for n in kept[:first]]
    kept = [n for n in kept[first:] if not lines[n].lstrip().startswith("#")]
    rows = [lines[n] for n in kept]
    separator = _separator(rows[0])
    decimal = layout.decimal or _decimal_sign(rows, separator)
    widths = [line.count(separator) + 1 if separator else len(line.split()) for line in rows]
    cells = pd.read_csv(
        io.StringIO("\n".join(rows)),
        sep=separator or r"\s+",
        header=None,
        names=range(max(widths)),
        index_col=False,
        decimal=decimal,
        skipinitialspace=separator != "\t",
        skip_blank_lines=False,
        low_memory=False,
    )
    width = 1 + int(np.flatnonzero(cells.notna().any()).max(initial=0))
    bare = [re.sub(r"^\s*#+ *", "", line) for line in above]  # numpy writes names behind a #
    names, units = _heads(bare, separator, width)
    if len(names) != width:
        plain = [line for line in above if not line.lstrip().startswith("#")]
        names, units = _heads(plain, separator, width)
    cells = cells.reindex(columns=range(max(width, len(names))))
    table = _table(names, units, cells, layout, decimal)
    return replace(table, lines=[n + 1 for n in kept], widths=widths, above=above)


def _table(
    names: Sequence[str], units: Sequence[str], cells: pd.DataFrame, layout: Layout, decimal: str
) -> Table:
    """The table of cells, each a number or a word."""
    columns = [_numbers(cells[column], decimal, layout) for column in cells]
    values = np.stack([numbers for numbers, _ in columns], axis=1)
    # A line without any number, such as a title between two parts, does not count.
    counts = np.asarray(np.isfinite(values).any(axis=1))
    words = {n: kept for n, (_, one) in enumerate(columns) if len(kept := one[counts[one.index]])}
    return Table((*names,), (*units,) or ("",) * len(columns), values, layout, words)


def _numbers(cells: pd.Series, decimal: str, layout: Layout) -> tuple[Array, pd.Series]:
    """The numbers of a column, NaN where it has none, and its cells that are no numbers."""
    import pandas as pd  # takes half a second

    if cells.dtype.kind in "fi":
        return cells.to_numpy(float), cells[:0]
    text = cells.fillna("").astype(str).str.strip()
    if layout.decimal:
        group = r"\." if decimal == "," else ","
        text = text.str.replace(rf"(?<=\d){group}(?=\d{{3}}(?!\d))", "", regex=True)
    number = text.str.fullmatch(_NUMBER.replace(r"\.", re.escape(decimal)))
    values = pd.to_numeric(text.str.replace(decimal, ".", regex=False).where(number))
    return values.to_numpy(float), text[~number & ~text.str.fullmatch(_MISSING)]


def _decimal_sign(rows: Sequence[str], separator: str | None) -> str:
    """The decimal sign of the numbers; `QuantityError` if their commas may separate thousands."""
    if separator == "," and '"' not in rows[0]:
        return "."
    for part in (rows[:_SAMPLE], rows):
        cells = {c for row in part for c in _split(row, separator) if _WRITTEN.fullmatch(c)}
        commas = {cell for cell in cells if "," in cell}
        if not commas or any("." in cell for cell in cells):
            return "."
        if not all(_THOUSANDS.fullmatch(cell) for cell in commas):
            return ","
    one = min(commas)
    rule = f"has {one!r}, which may be {one.replace(',', '.', 1)} or {one.replace(',', '')}"
    rule += ": every comma stands before three digits"
    raise QuantityError(rule, "say which: decimal: ',' or decimal: '.'")


def _lvm_table(text: str, layout: Layout) -> Table:
    """The table of a LabVIEW measurement, whose parts follow each other."""
    import lvm_read
    import pandas as pd  # takes half a second

    # Its `read` would also load a pickle beside the file, which may run code.
    content = lvm_read.read_str(text)
    parts = [content[n] for n in range(content["Segments"])]
    names = [*map(_tidy, parts[0]["Channel names"])]
    cells = pd.concat([pd.DataFrame(part["data"]) for part in parts], ignore_index=True)
    first = [] if content.get("X_Columns") == "No" else ["s"]
    units = [*map(_spelled, [*first, *parts[0].get("Y_Unit_Label", [])]), *[""] * len(names)]
    cells = cells.reindex(columns=range(len(names)))
    table = _table(names, units[: len(names)], cells, layout, ".")
    return replace(table, times=times_of_segments(content, len(names)))


def _tdms_table(path: Path, layout: Layout) -> Table:
    """The channels of a TDMS file, the names of several groups in front of theirs."""
    import pandas as pd  # takes half a second
    from nptdms import TdmsFile

    groups = TdmsFile.read(path).groups()
    channels = [channel for group in groups for channel in group.channels()]
    names = [f"{one.group_name} {one.name}" if len(groups) > 1 else one.name for one in channels]
    units = [_spelled(str(one.properties.get("unit_string", ""))) for one in channels]
    cells = pd.DataFrame({n: pd.Series(one[:]) for n, one in enumerate(channels)})
    table = _table([*map(str.casefold, names)], units, cells, layout, ".")
    times = times_of_waveforms([one.properties for one in channels], len(cells))
    return replace(table, lines=range(1, len(cells) + 1), times=times)


def _first_numbers(lines: Sequence[str]) -> int | None:
    """The first of two lines of numbers, else of two with numbers beside words such as a clock.

    A number alone may be in a preamble.
    """
    forms = []  # of each line, with 1 for a number, 0 for one that is missing, w for a word
    for line in lines:
        cells = [] if line.lstrip().startswith("#") else _split(line, _separator(line))
        signs = ("1" if _WRITTEN.fullmatch(c) else "w0"[bool(_MISSING.fullmatch(c))] for c in cells)
        forms.append("".join(signs))
    plain = [len(form) > 1 and "1" in form and "w" not in form for form in forms]
    like = [form.count("1") > 1 and form.replace("0", "1") for form in forms]
    pairs = [n for n in range(len(forms) - 1) if plain[n] and plain[n + 1]]
    pairs = pairs or [n for n in range(len(forms) - 1) if like[n] and like[n] == like[n + 1]]
    return pairs[0] if pairs else None


def read_text(path: Path, encoding: str | None = None) -> str:
    """The text of a file in its encoding: given, UTF-16, UTF-8 or that of Windows."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise QuantityError(f"cannot be read: {error.strerror}") from error
    ensure(content.strip(), "is empty", "export it again")
    is_packed = content.startswith(_ARCHIVES)
    ensure(not is_packed, "is an archive or a spreadsheet", "unpack it, or save it as .csv")
    high, low = (content[n:200:2].count(0) for n in (0, 1))
    usual: tuple[str, ...] = ("utf-8-sig", "cp1252", "latin-1") if high + low == 0 else ("utf-16",)
    if high + low > 0 and content[:2] not in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        usual = ("utf-16-be" if high > low else "utf-16-le",)
    for name in (encoding,) if encoding else usual:
        try:
            text = content.decode(name)
        except UnicodeDecodeError:
            continue
        except LookupError as error:
            raise QuantityError(f"has no encoding {encoding!r}", "such as latin-1") from error
        if sum(not (c.isprintable() or c.isspace()) for c in text[:1000]) < 10:
            return text
    raise NoTableError("cannot be read as text", "give its encoding, such as encoding: utf-16")


def _separator(line: str) -> str | None:
    """The sign between the cells of a line; None: blanks."""
    if (separator := next((s for s in "\t;" if s in line), None)) is None and "," in line:
        return None if _BLANKS.fullmatch(line) else ","
    return separator


def _split(line: str, separator: str | None) -> list[str]:
    """The cells of a line, without empty ones at its end."""
    if separator and '"' in line:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=separator != "\t"))
    else:
        cells = line.split(separator)
    cells = [cell.strip().strip('"').strip() for cell in cells]
    while len(cells) > 1 and not cells[-1]:
        cells.pop()
    return cells


def _heads(lines: Sequence[str], separator: str | None, width: int) -> tuple[list[str], list[str]]:
    """Names and units of the columns, from the lines above the numbers."""
    if not lines:
        return [], []

    def cells(line: str, sign: str | None) -> list[str]:
        return _split(line, sign) if sign else _WORD.findall(line)

    there = next((sign for sign in "\t;," if sign in lines[-1]), None)
    signs = (separator, "\t", ";", ",", None)
    sign = next((one for one in signs if len(cells(lines[-1], one)) == width), there)
    own, above = cells(lines[-1], sign), cells(lines[-2], sign) if len(lines) > 1 else []
    is_units = all(_UNIT.fullmatch(_spelled(cell)) or not cell for cell in own)
    if any(own) and is_units and len(above) >= len(own):
        units = [_spelled(cell.strip("()[]")) for cell in own]
        return [*map(_tidy, above)], units + [""] * (len(above) - len(own))
    names, units = map(list, zip(*map(_head, own), strict=True))
    return names, units


def _head(cell: str) -> tuple[str, str]:
    """The name and the unit of a column."""
    found = next(found for form in _HEADS if (found := form.fullmatch(cell)))
    return _tidy(f"{found['name']} {found['more']}"), _spelled(found["unit"])


def _tidy(name: str) -> str:
    name = re.sub(r"[\s_]+", " ", name).strip().casefold()
    return "time" if name == "x value" else name


def _spelled(unit: str) -> str:
    """A unit as `parse_quantity` knows it, without capitals and plurals of words."""
    unit = re.sub(r"[A-Za-z]{4,}", lambda word: word[0].lower().removesuffix("s"), unit)
    return re.sub(r"\b([mu]?)sec\b", r"\1s", unit, flags=re.IGNORECASE)
