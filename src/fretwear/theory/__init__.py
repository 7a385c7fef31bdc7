"""Closed forms: elastic constants, Hertz, partial slip, the limit of infinitely many cycles.

SI units. A sphere is axisymmetric, ``r`` the distance from its axis; a cylinder is in plane
strain, ``x`` the distance from its centre line, and its loads are per length. Arrays of any shape
are accepted for ``r`` and ``x`` and returned in that shape.

References
----------
H. Hertz (1882), Über die Berührung fester elastischer Körper, J. reine angew. Math. 92, 156–171.
C. Cattaneo (1938), Sul contatto di due corpi elastici, Rend. Accad. Naz. Lincei 27.
R. D. Mindlin (1949), Compliance of elastic bodies in contact, J. Appl. Mech. 16, 259–268.
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press.
B. C. Carlson (1995), Numer. Algor. 10, 13–26 (elliptic integrals in a form that has no special case
for a circle).
M. Ciavarella (1998), The generalized Cattaneo partial slip plane contact problem,
Int. J. Solids Struct. 35, 2349–2362.
M. Ciavarella, D. A. Hills, G. Monno (1998), The influence of rounded edges on indentation by a
flat punch, J. Mech. Eng. Sci. 212, 319–328.
J. Jäger (1998), A new principle in contact mechanics, J. Tribol. 120, 677–684.
M. Ciavarella, D. A. Hills (1999), A note on some oscillating contact problems subject to wear,
J. Mech. Eng. Sci. 213, 851–857 (the limit of many cycles).
V. L. Popov, M. Heß (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction,
Springer.
"""

from fretwear.theory.line_contact import FlatPunchContact, LineContact
from fretwear.theory.partial_slip import (
    LimitingState,
    LineLimitingState,
    LinePartialSlip,
    PartialSlip,
    gross_slip_energy,
    share_of_band,
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
    "EllipticContact",
    "FlatPunchContact",
    "HertzContact",
    "LimitingState",
    "LineContact",
    "LineLimitingState",
    "LinePartialSlip",
    "PartialSlip",
    "Reduced",
    "RoundContact",
    "RoundedPunch",
    "composite_modulus",
    "coupling_ratio",
    "find_root",
    "gross_slip_energy",
    "share_of_band",
]
