"""Names, dimensions, units and types of every variable that a case file holds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

DOMAIN_DIMS = ("cycle", "x", "y")
SYMMETRIES = ("even_xy", "none")


class ContactState(IntEnum):
    """What a cell of the surface does during a cycle."""

    OPEN = 0
    SLIP = 1
    STICK = 2


@dataclass(frozen=True)
class Variable:
    """One variable of a dataset.

    Attributes
    ----------
    name : str
        Name in the dataset.
    units : str
        SI units as UDUNITS reads them, ``"1"`` for a pure number, empty for flags and strings.
    long_name : str
        What the values are, in words that serve as the label of an axis.
    dtype : str
        Type in memory and in the file.
    axis : str
        CF axis (``"X"`` or ``"Y"``), empty where there is none.
    comment : str
        What a reader has to know beyond the long name.
    """

    name: str
    units: str
    long_name: str
    dtype: str = "float64"
    axis: str = ""
    comment: str = ""

    @property
    def attributes(self) -> dict[str, Any]:
        """CF attributes of the variable; empty entries are left out."""
        named = {
            "long_name": self.long_name,
            "units": self.units,
            "axis": self.axis,
            "comment": self.comment,
        }
        return {key: value for key, value in named.items() if value}


@dataclass(frozen=True)
class Field(Variable):
    """A variable on the surface, dimensions ``(cycle, x, y)``.

    Attributes
    ----------
    outside : float
        Value outside the window of a case, where the surfaces do not touch; NaN when that does
        not tell it.
    flags : tuple of ContactState
        The values that can occur, for a field of flags; empty for a physical quantity.
    """

    dtype: str = "float32"
    outside: float = 0.0
    flags: tuple[ContactState, ...] = ()

    @property
    def attributes(self) -> dict[str, Any]:
        """CF attributes of the variable, flags included; empty entries are left out."""
        if not self.flags:
            return super().attributes
        return {
            **super().attributes,
            "flag_values": np.array(self.flags, dtype=self.dtype),
            "flag_meanings": " ".join(flag.name.lower() for flag in self.flags),
        }


X = Variable("x", "m", "position along the slip direction", axis="X", comment="cell centres")
Y = Variable("y", "m", "position across the slip direction", axis="Y", comment="cell centres")
CYCLE = Variable("cycle", "1", "number of load cycles")
STEP = Variable("step", "1", "accepted step of the wear integration", dtype="int32")

FIELDS: tuple[Field, ...] = (
    Field("pressure", "Pa", "normal pressure", comment="at the normal load P"),
    Field(
        "shear_traction",
        "Pa",
        "shear traction along x",
        comment="at the tangential load +Q; at -Q it has the opposite sign",
    ),
    Field(
        "slip",
        "m",
        "slip amplitude",
        comment="from zero tangential load to +Q; the path of a whole cycle is four times this",
    ),
    Field("wear_depth", "m", "wear depth", comment="of both bodies together since cycle 0"),
    Field("wear_rate", "m", "wear depth in one cycle", comment="in the cycle that begins here"),
    Field("plastic_depth", "m", "plastic depth", comment="permanent sinking since cycle 0"),
    Field("gap", "m", "gap between the surfaces", comment="at the normal load P", outside=math.nan),
    Field(
        "contact_state",
        "",
        "state of the contact",
        dtype="int8",
        flags=tuple(ContactState),
    ),
)

SCALARS: tuple[Variable, ...] = (
    Variable("approach", "m", "approach of the bodies"),
    Variable("tangential_displacement", "m", "tangential displacement at +Q"),
    Variable(
        "contact_half_width_x",
        "m",
        "contact half-width along x",
        comment="outermost edge on the line of cells nearest y = 0",
    ),
    Variable(
        "contact_half_width_y",
        "m",
        "contact half-width along y",
        comment="outermost edge on the line of cells nearest x = 0",
    ),
    Variable(
        "stick_half_width_x",
        "m",
        "half-width of the stick zone along x",
        comment="outermost edge on the line of cells nearest y = 0",
    ),
    Variable(
        "stick_half_width_y",
        "m",
        "half-width of the stick zone along y",
        comment="outermost edge on the line of cells nearest x = 0",
    ),
    Variable("contact_area", "m2", "contact area"),
    Variable("stick_area", "m2", "area of the stick zone"),
    Variable("peak_pressure", "Pa", "highest pressure"),
    Variable("central_pressure", "Pa", "pressure in the middle of the contact"),
    Variable("wear_volume", "m3", "wear volume", comment="of both bodies since cycle 0"),
    Variable("plastic_volume", "m3", "plastically displaced volume", comment="since cycle 0"),
    Variable("dissipated_energy", "J", "energy dissipated in one cycle"),
)

ERROR_ESTIMATE = Variable("error_estimate", "1", "estimated relative error of the step")
CONVOLUTIONS = Variable("convolutions", "1", "convolutions spent on the step", dtype="int32")

CASE_DIMS: dict[str, tuple[str, ...]] = {
    **{coordinate.name: (coordinate.name,) for coordinate in (CYCLE, X, Y)},
    **{scalar.name: DOMAIN_DIMS[:1] for scalar in SCALARS},
    **{field.name: DOMAIN_DIMS for field in FIELDS},
}
