"""Variables of datasets: name, unit, words and symbol, and how each is shown.

A scalar of the contact is declared beside its formula, by `scalar`; other variables are rows of a
table, which `variables` reads.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypedDict, Unpack

from fretwear.units import (
    LINE_CONTACT,
    MEGAPASCAL,
    MICROMETRE,
    NO_UNIT,
    PERCENT,
    ContactFrame,
    Unit,
)

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import ArrayLike


class ContactState(IntEnum):
    """The state of a cell of the surface during a cycle."""

    OPEN = 0
    SLIP = 1
    STICK = 2


class SlidingRegime(IntEnum):
    """Whether a part of the contact sticks during a cycle."""

    PARTIAL_SLIP = 0
    GROSS_SLIP = 1


# What the discretisation error of a scalar comes from; `fretwear.run.errors` has the rules.
ErrorKind: TypeAlias = Literal[
    "whole", "edge", "stick", "local", "plastic", "volume", "depth", "cycle", "life", "peak"
]


@dataclass(frozen=True)
class Variable:
    """One variable of a dataset."""

    name: str  # name in the dataset
    si_unit: str  # as UDUNITS reads it, ``"1"`` for a pure number, empty for flags and text
    words: str  # its long name, and the label of an axis
    symbol: str = ""  # in mathtext, empty without an established one
    comment: str = ""  # remarks for readers
    unit: Unit | None = None  # unit for people; None: one that suits the size of the values
    dtype: str = "float64"  # type in memory and in the file
    cf_axis: str = ""  # CF axis (``"X"``, ``"Y"``, ``"Z"``), empty where there is none
    across: bool = False  # whether it needs the axis y, which a line contact lacks
    of_line: bool = False  # whether it is a headline of line contacts alone
    from_zero: bool = True  # whether a linear axis starts at zero
    may_be_logarithmic: bool = False  # on the axis of a wide range
    # Whether the value is meaningful by itself. The peak pressure of an elastic contact is not: a
    # single cell at a singularity has it.
    is_headline: bool = True
    # Whether it may be NaN, such as the mean stick pressure where nothing sticks.
    may_lack: bool = False
    error_kind: ErrorKind = "whole"
    is_error: bool = False
    # Value of a field outside the window of a case, where the surfaces do not touch; NaN: unknown.
    outside: float = 0.0
    is_odd: bool = False  # whether it is odd along x and along y where the contact is even
    flags: tuple[IntEnum, ...] = ()  # possible states; empty for a physical quantity
    # Whether the history of all steps lacks it, because each value takes a contact solution.
    is_at_snapshots: bool = False

    @property
    def marked(self) -> str:
        """The words, with a dagger where the value alone means little."""
        return self.words + ("" if self.is_headline else " †")

    @property
    def error(self) -> Variable:
        """The estimated discretisation error of this variable, in the same unit."""
        name, words = f"{self.name}_error", f"estimated error of the {self.words}"
        comment = "by a run on wider cells, and of the slip model"
        if self.error_kind == "peak":
            comment += "; infinite where the value grows without bound as cells get narrower"
        apart = replace(self, name=name, words=words, symbol="", comment=comment, flags=())
        return replace(apart, is_error=True)

    def allows(self, values: ArrayLike) -> bool:
        """Whether values are finite, or NaN or infinite if that has a meaning."""
        import numpy as np  # `fretwear --help` does without it

        values = np.asarray(values)
        sound = np.isfinite(values)
        if self.may_lack:
            sound |= np.isnan(values)
        if self.is_error and self.error_kind == "peak":
            sound |= np.isposinf(values)
        return bool(sound.all())

    def in_units(self, si_unit: str) -> Variable:
        """Return the variable in the frame in which it has the given unit."""
        return self if si_unit == self.si_unit else self.in_frame(LINE_CONTACT)

    def in_dataset(self, dataset: xr.Dataset) -> Variable:
        """Return the variable in the frame in which a dataset has it."""
        return self.in_units(dataset.variables[self.name].attrs.get("units", self.si_unit))

    def in_frame(self, frame: ContactFrame) -> Variable:
        """Return the variable as a line contact has it, where integrals are per length."""
        unit = frame.unit(self.si_unit)
        variable = replace(
            self, is_headline=self.is_headline or (self.of_line and frame is LINE_CONTACT)
        )
        if unit == self.si_unit:
            return variable
        words = frame.words(self.words, self.si_unit)
        return replace(variable, si_unit=unit, words=words, unit=None)

    @property
    def label(self) -> str:
        """The words as the label of an axis, without the unit."""
        return self.words[:1].upper() + self.words[1:]

    @property
    def attributes(self) -> dict[str, object]:
        """CF attributes of the variable; empty entries are left out."""
        texts = {"long_name": self.words, "units": self.si_unit, "axis": self.cf_axis}
        texts |= {"positive": "down" * (self.cf_axis == "Z"), "comment": self.comment}
        attributes: dict[str, object] = {name: text for name, text in texts.items() if text}
        if self.flags:
            import numpy as np  # `fretwear --help` does without it

            attributes["flag_values"] = np.array(self.flags, dtype=self.dtype)
            attributes["flag_meanings"] = " ".join(flag.name.lower() for flag in self.flags)
        return attributes


_UNITS = {"": None, "1": NO_UNIT, "MPa": MEGAPASCAL, "µm": MICROMETRE, "%": PERCENT}
_MARKS: dict[str, dict[str, Any]] = {
    "": {},
    "none": {"may_lack": True},
    "log": {"may_be_logarithmic": True},
    "free": {"from_zero": False},
    "X": {"cf_axis": "X"},
    "Y": {"cf_axis": "Y"},
    "Z": {"cf_axis": "Z"},
    "int8": {"dtype": "int8"},
    "int32": {"dtype": "int32"},
    "nan": {"outside": math.nan, "may_lack": True},
    "odd": {"is_odd": True},
    "flags": {"dtype": "int8", "flags": tuple(ContactState)},
}


def variables(table: str, dtype: str = "float64") -> tuple[Variable, ...]:
    """Read rows of name, SI unit, symbol, unit for people, words, mark, comment.

    Indented lines continue a comment.
    """
    found = []
    for row in re.sub(r"\n +", " ", table.strip()).splitlines():
        cells = (cell.strip() for cell in row.split("|"))
        name, si_unit, symbol, unit, words, mark, comment = cells
        words = words or name.replace("_", " ")
        marked = {"dtype": dtype, **_MARKS[mark]}
        found.append(Variable(name, si_unit, words, symbol, comment, _UNITS[unit], **marked))
    return tuple(found)


# Of the class whose property is declared.
_Formula: TypeAlias = Callable[[Any], float]
_Condition: TypeAlias = Callable[[Any], object]


class Properties(TypedDict, total=False):
    """Fields of the `Variable` of a scalar."""

    flags: tuple[IntEnum, ...]
    across: bool
    of_line: bool
    from_zero: bool
    may_be_logarithmic: bool
    is_headline: bool
    may_lack: bool
    is_at_snapshots: bool
    error_kind: ErrorKind


class Scalar(cached_property[float]):
    """A scalar of the contact, declared beside its formula by `scalar`."""

    def __init__(
        self,
        formula: _Formula,
        variable: Variable,
        needs: _Condition | None,
    ) -> None:
        super().__init__(formula)
        self.variable = variable
        self.needs = needs  #: tells whether a contact has it; None if every contact does


def scalar(
    si_unit: str,
    words: str,
    *,
    symbol: str = "",
    unit: str = "",
    needs: _Condition | None = None,
    **properties: Unpack[Properties],
) -> Callable[[_Formula], Scalar]:
    """Declare a property of `Measures` as a scalar of the contact; its docstring is the comment.

    `si_unit` is that of a point contact, as UDUNITS reads it; in a line contact, forces, energies,
    volumes and areas are per length. `unit` is the unit for people, ``"µm"``, ``"MPa"``, ``"%"`` or
    ``"1"``; without it, the unit suits the size of the values. `needs` takes the `Measures` of a
    state and tells whether this contact has the scalar; without it, every contact does. The
    `error_kind` among the fields of `Variable` says how its error is estimated.
    """

    def declare(formula: _Formula) -> Scalar:
        comment = " ".join((formula.__doc__ or "").split()).removesuffix(".")
        word = comment.partition(" ")[0]
        if word[1:].islower():  # neither a symbol nor NaN
            comment = comment[0].lower() + comment[1:]
        named = Variable(formula.__name__, si_unit, words, symbol, comment, _UNITS[unit])
        return Scalar(formula, replace(named, **properties), needs)

    return declare


def declared_scalars(measures: type) -> tuple[Scalar, ...]:
    """Return the scalars of a class in the order of their declaration."""
    return tuple(entry for entry in vars(measures).values() if isinstance(entry, Scalar))
