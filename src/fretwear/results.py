"""Every result, defined once: its name, unit, words and symbol, and how it is shown.

Datasets, tables, figures, report and messages take the words of a quantity from here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterable
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import TYPE_CHECKING, Any

from fretwear.units import (
    LINE_CONTACT,
    MEGAPASCAL,
    MICROMETRE,
    NO_UNIT,
    PERCENT,
    POINT_CONTACT,
    ContactFrame,
    Unit,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

SYMMETRIES: dict[str, tuple[bool, bool]] = {
    "even_xy": (True, True),
    "even_x": (True, False),
    "even_y": (False, True),
    "none": (False, False),
}
"""Whether a contact is even along x and along y, so that only its positive side is kept."""


class ContactState(IntEnum):
    """The state of a cell of the surface during a cycle."""

    OPEN = 0
    SLIP = 1
    STICK = 2


class SlidingRegime(IntEnum):
    """Whether a part of the contact sticks during a cycle."""

    PARTIAL_SLIP = 0
    GROSS_SLIP = 1


class PointStatus(IntEnum):
    """The outcome of a point of a study."""

    DONE = 0
    FAILED = 1
    INVALID = 2

    @property
    def word(self) -> str:
        """The status in a word."""
        return self.name.lower()


@dataclass(frozen=True)
class Variable:
    """One variable of a dataset."""

    name: str  # name in the dataset
    si_unit: str  # as UDUNITS reads it, ``"1"`` for a pure number, empty for flags and text
    words: str  # its long name, and the label of an axis
    symbol: str = ""  # in mathtext, empty without an established one
    comment: str = ""  # what a reader must know beyond the words
    unit: Unit | None = None  # unit for people; None: one that suits the size of the values
    dtype: str = "float64"  # type in memory and in the file
    cf_axis: str = ""  # CF axis (``"X"``, ``"Y"``, ``"Z"``), empty where there is none
    across: bool = False  # whether it needs the axis y, which a line contact lacks
    of_line: bool = False  # whether it is a headline of line contacts alone
    from_zero: bool = True  # whether a linear axis starts at zero
    may_be_logarithmic: bool = False  # on the axis of a wide range
    # Whether the value is meaningful by itself. The peak pressure of an elastic contact, which a
    # single cell at a singularity has, is not.
    is_headline: bool = True
    # Whether it is NaN where undefined, such as the mean stick pressure where nothing sticks.
    may_lack: bool = False
    # Whether it may grow without bound as cells get narrower; its error is then infinite.
    may_diverge: bool = False
    is_error: bool = False
    # Value of a field outside the window of a case, where the surfaces do not touch; NaN: unknown.
    outside: float = 0.0
    is_odd: bool = False  # whether it is odd along x and along y where the contact is even
    flags: tuple[IntEnum, ...] = ()  # possible states; empty for a physical quantity

    @property
    def marked(self) -> str:
        """The words, with a dagger where the value alone means little."""
        return self.words + ("" if self.is_headline else " †")

    @property
    def error(self) -> Variable:
        """The estimated discretisation error of this variable, in the same unit."""
        name, words = f"{self.name}_error", f"estimated error of the {self.words}"
        comment = "by a run on wider cells, and of the slip model"
        if self.may_diverge:
            comment += "; infinite where the value grows without bound as cells get narrower"
        apart = replace(self, name=name, words=words, symbol="", comment=comment, flags=())
        return replace(apart, is_error=True)

    def allows(self, values: ArrayLike) -> bool:
        """Whether values are finite, or NaN or infinite where that has a meaning."""
        import numpy as np  # `fretwear --help` does without it

        values = np.asarray(values)
        sound = np.isfinite(values)
        if self.may_lack:
            sound |= np.isnan(values)
        if self.may_diverge and self.is_error:
            sound |= np.isposinf(values)
        return bool(sound.all())

    def in_units(self, si_unit: str) -> Variable:
        """Return the variable in the frame in which it has the given unit."""
        return self if si_unit == self.si_unit else self.in_frame(LINE_CONTACT)

    def in_frame(self, frame: ContactFrame) -> Variable:
        """Return the variable as a line contact has it, where integrals are per length."""
        unit = frame.unit(self.si_unit)
        about = replace(
            self, is_headline=self.is_headline or (self.of_line and frame is LINE_CONTACT)
        )
        if unit == self.si_unit:
            return about
        return replace(about, si_unit=unit, words=frame.words(self.words, self.si_unit), unit=None)

    @property
    def label(self) -> str:
        """The words as the label of an axis, without the unit."""
        return self.words[:1].upper() + self.words[1:]

    @property
    def attributes(self) -> dict[str, Any]:
        """CF attributes of the variable; empty entries are left out."""
        texts = {"long_name": self.words, "units": self.si_unit, "axis": self.cf_axis}
        texts |= {"positive": "down" * (self.cf_axis == "Z"), "comment": self.comment}
        attributes: dict[str, Any] = {name: text for name, text in texts.items() if text}
        if self.flags:
            import numpy as np  # `fretwear --help` does without it

            attributes["flag_values"] = np.array(self.flags, dtype=self.dtype)
            attributes["flag_meanings"] = " ".join(flag.name.lower() for flag in self.flags)
        return attributes


_UNITS = {"": None, "1": NO_UNIT, "MPa": MEGAPASCAL, "µm": MICROMETRE, "%": PERCENT}
_MARKS: dict[str, dict[str, Any]] = {
    "": {},
    "†": {"is_headline": False},
    "∞": {"is_headline": False, "may_diverge": True},
    "none": {"may_lack": True},
    "log": {"may_be_logarithmic": True},
    "free": {"from_zero": False},
    "point": {"from_zero": False, "across": True},
    "line": {"from_zero": False, "is_headline": False, "of_line": True},
    "y": {"from_zero": False, "across": True, "is_headline": False},
    "X": {"cf_axis": "X"},
    "Y": {"cf_axis": "Y"},
    "Z": {"cf_axis": "Z"},
    "int8": {"dtype": "int8"},
    "int32": {"dtype": "int32"},
    "nan": {"outside": math.nan, "may_lack": True},
    "odd": {"is_odd": True},
    "flags": {"dtype": "int8", "flags": tuple(ContactState)},
    "regimes": {"flags": tuple(SlidingRegime)},
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


(
    X, Y, CYCLE, PHASE, STEP, POINT, CASE_ID, CODE_DIGEST, STATUS, WARNINGS, ERROR_ESTIMATE,
    CONVOLUTIONS,
) = variables("""
x     | m | $x$ | | position along the slip direction  | X | cell centres
y     | m | $y$ | | position across the slip direction | Y | cell centres
cycle | 1 | $N$ | | number of load cycles | |
phase | 1 | | | part of a cycle, from +Q over -Q back to +Q | |
step  | 1 | | | accepted step of the wear integration | int32 |
point | 1 | | | point of the study | int32 |
case_id        |   | | | id of the case and name of its file | |
code_digest    |   | | | digest of the code and libraries that computed the case | |
status         |   | | | what became of the point | int8 |
warnings       |   | | | what is less accurate in the case or outside the model | |
error_estimate | 1 | | | estimated relative error of the step | |
convolutions   | 1 | | | convolutions spent on the step | int32 |
""")  # fmt: skip


_FIELDS = variables(
    r"""
pressure       | Pa | $p$ | MPa | | | normal pressure at the load P
shear_traction | Pa | $q$ | MPa | | |
    along x at the tangential load +Q; at -Q it has the opposite sign
slip           | m  | $s$ |     | slip amplitude | |
    from zero tangential load to +Q; the path of a whole cycle is four times this
wear_depth     | m  | $w$ |     | | | of both bodies together since cycle 0
wear_rate      | m  |     |     | wear depth per cycle | | in the cycle that begins here
plastic_depth  | m  |     |     | | | permanent sinking since cycle 0
gap            | m  | $g$ |     | | nan | between the surfaces at the load P; NaN
                            beyond the end of a punch
contact_state  |    |     |     | state of the contact | flags |
    of whole cells: sums over these differ from areas and mean pressures, whose edges lie within a
    cell, and differ more the fewer cells a zone is wide; contact_fraction and stick_fraction say
    what part of a cell counts
contact_fraction | 1 |    | 1   | | |
    part of a cell in contact; its sum over the whole contact times the area of a cell is
    contact_area
stick_fraction | 1  |     | 1   | | |
    part of a cell that sticks; its sum over the whole contact times the area of a cell is
    stick_area
wear_depth_indenter | m | $w_1$ | | wear depth of the indenter || since cycle 0
wear_depth_flat | m | $w_2$ | | wear depth of the flat || since cycle 0
slip_x | m | $s_x$ | | slip amplitude along x || from zero tangential load to +Q
slip_y | m | $s_y$ | | slip amplitude along y | odd | from zero tangential load to +Q
shear_traction_y | Pa | $q_y$ | MPa | shear traction along y | odd | at the tangential load +Q; at
    -Q it has the opposite sign
friction_coefficient | 1 | $µ(x,y)$ | 1 | coefficient of friction | | where it follows slip
""",
    "float32",
)
FIELDS, BODY_FIELDS, VECTOR_FIELDS = _FIELDS[:-6], _FIELDS[-6:-4], _FIELDS[-4:-1]
"""Fields of every case, fields of each body, which need a wear coefficient for each, and fields of
friction in two directions."""

FRICTION_FIELD = _FIELDS[-1]
"""The field of cases whose friction follows slip."""

_SCALARS = variables(
    r"""
approach                | m  | $δ$   | µm | | | of the bodies
tangential_displacement | m  | $δ_x$ |    | | | of distant points at +Q
normal_force            | N  | $P$   |    | | | of the whole contact
tangential_force        | N  | $Q$   |    | tangential force amplitude | | given or computed
regime                  | 1  |       | 1  | sliding regime | regimes | 0 partial slip, 1 gross slip
sliding_ratio           | 1  | $A$   | 1  | | none |
    dissipated energy over 4 U Q, U the displacement amplitude, of the rig if there is one
sliding_criterion       | 1  | $B$   | 1  | energy sliding criterion | none |
    dissipated energy over 4 U0 Q, U0 the displacement at which the force of the loop vanishes; at
    the snapshots only
contact_radius          | m  | $a_\mathrm{c}$ | µm | contact outline radius | point |
    of a disc as large as the apparent contact: all within the convex outline of the real one
stick_radius            | m  | $c$   | µm | stick outline radius | point |
    of a disc as large as all within the convex outline of the stick zone
scar_half_width_x       | m  | $b_x$ | µm | scar half-width along x | free |
    half the extent over all lines, where the scar is deeper than 1 % of its maximum
scar_half_width_y       | m  | $b_y$ | µm | scar half-width along y | point |
    half the extent over all lines, where the scar is deeper than 1 % of its maximum
contact_half_width_x    | m  | $a_x$ | µm | contact half-width along x | line | outermost edge
    on the line of cells nearest y = 0
contact_half_width_y    | m  | $a_y$ | µm | contact half-width along y | y | outermost edge
    on the line of cells nearest x = 0
stick_half_width_x      | m  | $c_x$ | µm | stick half-width along x | line | outermost edge
    on the line of cells nearest y = 0
stick_half_width_y      | m  | $c_y$ | µm | stick half-width along y | y | outermost edge
    on the line of cells nearest x = 0
contact_area            | m2 | $A_\mathrm{c}$ | | | |
    to the edge within a cell: the sum of contact_fraction, not of cells by contact_state
stick_area              | m2 | $A_\mathrm{stick}$ | | | |
    to the edge within a cell: the sum of stick_fraction, not of cells by contact_state
mean_stick_pressure     | Pa | $\bar{p}_\mathrm{stick}$ | MPa | | none |
    load in the stick zone over its area, both to the edge within a cell; NaN where nothing sticks
stick_load_share        | 1  | $P_\mathrm{stick}/P$ | % | stick share of the load | none |
    to the edge within a cell; NaN where nothing sticks
peak_pressure           | Pa | $p_\mathrm{max}$ | MPa | | ∞ | of a single cell; wear of
    elastic bodies makes it singular at the edge of a stick zone, and its error infinite
central_pressure        | Pa | $p(0)$ | MPa | | † | of the cell nearest the origin;
    zero if this cell is open, as in a valley of waves
wear_volume             | m3 | $V$    | | | log | of both bodies since cycle 0
maximum_wear_depth      | m  | $w_\mathrm{max}$ | | | | of both bodies together since cycle 0
plastic_volume          | m3 |        | | | | displaced since cycle 0
dissipated_energy       | J  | $E_\mathrm{d}$ | | dissipated energy per cycle | log |
wear_volume_indenter | m3 | $V_1$ || wear volume of the indenter | log |
    since cycle 0
wear_volume_flat | m3 | $V_2$ || wear volume of the flat | log | since cycle 0
mean_slip_friction | 1 | $\bar{µ}$ | 1 | mean coefficient of friction in the slip zone | |
    weighted by pressure
"""
)
SCALARS, OPTIONAL_SCALARS = _SCALARS[:-3], _SCALARS[-3:]
"""Scalars of all cases, and of some: wear of each body, friction that follows slip."""

AT_SNAPSHOTS = ("sliding_criterion",)
"""Scalars absent from the history of all steps, because each value takes a contact solution."""


def of_steps(scalars: Iterable[Variable]) -> tuple[Variable, ...]:
    """Return the scalars that the history of all steps has."""
    return tuple(scalar for scalar in scalars if scalar.name not in AT_SNAPSHOTS)


LOOP = variables("""
force        | N | $Q$ | | tangential force | | round a cycle
displacement | m | $δ_x$ | µm | tangential displacement | |
    of distant points round a cycle, of the rig if there is one
""")
"""The loop of a cycle, dimensions ``(cycle, phase)``."""

(DEPTH,) = variables(
    "z | m | $z$ | µm | depth below the surface of the flat | Z | positive downwards"
)
HEADLINES = (
    "wear_volume",
    "maximum_wear_depth",
    "contact_radius",
    "stick_radius",
    "contact_area",
    "stick_area",
    "scar_half_width_x",
    "scar_half_width_y",
    "mean_stick_pressure",
    "stick_load_share",
    "dissipated_energy",
)
"""The scalars that answer the question of a study, in the order of a report; see `headlines`."""

IN_LINE_CONTACTS = {"contact_radius": "contact_half_width_x", "stick_radius": "stick_half_width_x"}
"""Scalars that take the place of others in line contacts and in files of earlier versions."""

FORCES = {
    "normal_load": ("normal_force",),
    "tangential_load": ("tangential_force", "sliding_ratio"),
}
"""Results reported as well if the parameter of this name is not given."""

RESULTS: dict[str, Variable] = {
    variable.name: variable for variable in (*_FIELDS, *SCALARS, *OPTIONAL_SCALARS)
}
"""Every field and scalar by name."""


def headlines(names: Container[str]) -> list[str]:
    """Return the `HEADLINES` of results with these names."""
    there = (name if name in names else IN_LINE_CONTACTS.get(name, name) for name in HEADLINES)
    return [name for name in there if name in names]


def scalars_of(frame: ContactFrame) -> tuple[Variable, ...]:
    """Return the scalars of a point or a line contact."""
    there = (scalar for scalar in SCALARS if Y.name in frame.axes or not scalar.across)
    return tuple(scalar.in_frame(frame) for scalar in there)


def contact_frame(names: Iterable[object]) -> ContactFrame:
    """Return the frame of a dataset with these dimensions or variables."""
    across = {Y.name, *(scalar.name for scalar in SCALARS if scalar.across)}
    return LINE_CONTACT if across.isdisjoint(names) else POINT_CONTACT
