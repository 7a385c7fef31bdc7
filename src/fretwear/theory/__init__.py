"""Closed forms: elastic constants, Hertz, partial slip, the limit of infinitely many cycles.

SI units. A sphere is axisymmetric, ``r`` the distance from its axis; a cylinder is in plane
strain, ``x`` the distance from its centre line, and its loads are per length. Arrays of any shape
are accepted for ``r`` and ``x`` and returned in that shape.
"""

from fretwear.theory.line_contact import FlatPunchContact, LineContact
from fretwear.theory.partial_slip import (
    CattaneoMindlin,
    LimitingState,
    LineLimitingState,
    LinePartialSlip,
    gross_slip_energy,
)
from fretwear.theory.point_contact import (
    EllipticContact,
    HertzContact,
    Reduced,
    RoundContact,
    RoundedPunch,
    composite_modulus,
    coupling_ratio,
    find_root,
)

__all__ = [
    "CattaneoMindlin",
    "EllipticContact",
    "FlatPunchContact",
    "HertzContact",
    "LimitingState",
    "LineContact",
    "LineLimitingState",
    "LinePartialSlip",
    "Reduced",
    "RoundContact",
    "RoundedPunch",
    "composite_modulus",
    "coupling_ratio",
    "find_root",
    "gross_slip_energy",
]
