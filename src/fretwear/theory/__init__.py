"""Closed forms: elastic constants, Hertz, partial slip, the limit of infinitely many cycles.

Everything is axisymmetric about the axis of the sphere, in SI units; ``r`` is the distance from
that axis.  Arrays of any shape are accepted for ``r`` and returned in that shape.
"""

from fretwear.theory.hertz import HertzContact
from fretwear.theory.limiting_state import LimitingState
from fretwear.theory.materials import (
    composite_modulus,
    composite_shear_modulus,
    coupling_ratio,
    require_positive,
    shear_modulus,
)
from fretwear.theory.partial_slip import CattaneoMindlin, gross_slip_energy

__all__ = [
    "CattaneoMindlin",
    "HertzContact",
    "LimitingState",
    "composite_modulus",
    "composite_shear_modulus",
    "coupling_ratio",
    "gross_slip_energy",
    "require_positive",
    "shear_modulus",
]
