"""Every result by name: coordinates, fields, scalars and loops.

Datasets, tables, figures, report and messages take the words of a quantity from here. A scalar is
declared in `fretwear.mechanics.wear.measures`, beside its formula.
"""

from __future__ import annotations

from collections.abc import Container, Iterable
from enum import IntEnum

from fretwear.mechanics.wear.measures import Measures
from fretwear.units import LINE_CONTACT, POINT_CONTACT, ContactFrame
from fretwear.variable import Variable, declared_scalars, variables

SYMMETRIES: dict[str, tuple[bool, bool]] = {
    "even_xy": (True, True),
    "even_x": (True, False),
    "even_y": (False, True),
    "none": (False, False),
}
"""Whether a contact is even along x and along y, so that only its positive side is kept."""


class PointStatus(IntEnum):
    """The outcome of a point of a study."""

    DONE = 0
    FAILED = 1
    INVALID = 2

    @property
    def word(self) -> str:
        """The status in a word."""
        return self.name.lower()


(
    X, Y, CYCLE, PHASE, STEP, POINT, CASE_ID, CODE_DIGEST, STATUS, WARNINGS, ERROR_ESTIMATE,
    CONVOLUTIONS, CONTACT_SPOTS, STICK_SPOTS,
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
contact_spots  | 1 | | | spots that joined the outline of the contact or left it | int32 |
    in the step
stick_spots    | 1 | | | spots that joined the outline of the stick zone or left it | int32 |
    in the step
""")  # fmt: skip


FIELDS = variables(
    r"""
pressure       | Pa | $p$ | MPa | | | normal pressure at the load P; in the outermost three
    cells of a worn stroke uncertain by up to 13 % of the peak
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
    of whole cells
contact_fraction | 1 |    | 1   | | |
    part of a cell in contact
stick_fraction | 1  |     | 1   | | |
    part of a cell that sticks
""",
    "float32",
)
"""Fields of every case."""

BODY_FIELDS = variables(
    r"""
wear_depth_indenter | m | $w_1$ | | wear depth of the indenter || since cycle 0
wear_depth_flat | m | $w_2$ | | wear depth of the flat || since cycle 0
""",
    "float32",
)
"""Fields of each body, which need a wear coefficient for each."""

VECTOR_FIELDS = variables(
    r"""
slip_x | m | $s_x$ | | slip amplitude along x || from zero tangential load to +Q
slip_y | m | $s_y$ | | slip amplitude along y | odd | from zero tangential load to +Q
shear_traction_y | Pa | $q_y$ | MPa | shear traction along y | odd | at the tangential load +Q; at
    -Q it has the opposite sign
""",
    "float32",
)
"""Fields of friction in two directions."""

(FRICTION_FIELD,) = variables(
    "friction_coefficient | 1 | $µ(x,y)$ | 1 | coefficient of friction | | where it follows slip",
    "float32",
)
"""The field of cases whose friction follows slip."""

_DECLARED = declared_scalars(Measures)
SCALARS = tuple(scalar.variable for scalar in _DECLARED if not scalar.needs)
OPTIONAL_SCALARS = tuple(scalar.variable for scalar in _DECLARED if scalar.needs)
"""Scalars of all cases, and of some: wear of each body, friction that follows slip."""


def of_steps(scalars: Iterable[Variable]) -> tuple[Variable, ...]:
    """Return the scalars that the history of all steps has."""
    return tuple(scalar for scalar in scalars if not scalar.is_at_snapshots)


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
    "worn_through_cycle",
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

_FIELDS = (*FIELDS, *BODY_FIELDS, *VECTOR_FIELDS, FRICTION_FIELD)
RESULTS = {result.name: result for result in (*_FIELDS, *SCALARS, *OPTIONAL_SCALARS)}
"""Every field and scalar by name."""


def headlines(names: Container[str]) -> list[str]:
    """Return the `HEADLINES` of results with these names."""
    there = (name if name in names else IN_LINE_CONTACTS.get(name, name) for name in HEADLINES)
    return [name for name in there if name in names]


def scalars_of(frame: ContactFrame, names: Container[str] = ()) -> tuple[Variable, ...]:
    """Return the scalars of a point or a line contact, and the optional ones with these names."""
    there = (scalar for scalar in SCALARS if Y.name in frame.axes or not scalar.across)
    of_some = (scalar for scalar in OPTIONAL_SCALARS if scalar.name in names)
    return tuple(scalar.in_frame(frame) for scalar in (*there, *of_some))


def contact_frame(names: Iterable[object]) -> ContactFrame:
    """Return the frame of a dataset with these dimensions or variables."""
    across = {Y.name, *(scalar.name for scalar in SCALARS if scalar.across)}
    return LINE_CONTACT if across.isdisjoint(names) else POINT_CONTACT
