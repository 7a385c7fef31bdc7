"""Closed forms: elastic constants, Hertz, partial slip, the limit of infinitely many cycles.

SI units. A sphere is axisymmetric, ``r`` the distance from its axis; a cylinder is in plane
strain, ``x`` the distance from its centre line, and its loads are per length. Arrays of any shape
are accepted for ``r`` and ``x`` and returned in that shape.
"""

from fretwear.theory.elliptic import EllipticContact
from fretwear.theory.hertz import HertzContact
from fretwear.theory.limiting_state import LimitingState
from fretwear.theory.line_contact import FlatPunchContact, LineContact, LineLimitingState
from fretwear.theory.materials import composite_modulus, coupling_ratio, require_positive
from fretwear.theory.partial_slip import CattaneoMindlin, LinePartialSlip, gross_slip_energy
from fretwear.theory.punch import RoundContact, RoundedPunch

__all__ = [
    "CattaneoMindlin",
    "EllipticContact",
    "FlatPunchContact",
    "HertzContact",
    "LimitingState",
    "LineContact",
    "LineLimitingState",
    "LinePartialSlip",
    "RoundContact",
    "RoundedPunch",
    "composite_modulus",
    "coupling_ratio",
    "gross_slip_energy",
    "require_positive",
]
