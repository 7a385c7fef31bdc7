"""The kinds of profiles: quantity, label and unit, and how a rough one is made readable."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretwear.figures.half_profile import peak_envelope, wave_mean
from fretwear.figures.wording import MEGAPASCAL, MICROMETRE, Unit

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ProfileKind:
    """What one family of profiles shows, and how.

    Parameters
    ----------
    variable : str
        Name of the field.
    label : str
        What the y axis says, without the unit.
    unit : Unit or None
        Unit of the y axis; None chooses a length unit by the size of the values.
    at_edge : bool
        Whether the quantity is to be seen at the edge of the contact and vanishes inside a
        smooth one, as the gap does.
    is_traction : bool
        Whether it is a pressure or shear traction, whose peak at the edge of the stick zone has
        no limit in elastic bodies.
    downward : bool
        Whether larger values are drawn lower, as the depth of a scar is.
    envelope : callable
        Turns a crowded rough profile into a readable one.
    envelope_words : str
        What a caption calls that.
    """

    variable: str
    label: str
    unit: Unit | None = MEGAPASCAL
    at_edge: bool = False
    is_traction: bool = False
    downward: bool = False
    envelope: Callable[[Array, Array, float], Array] = peak_envelope
    envelope_words: str = "envelope through the peak of every wave"


PRESSURE = ProfileKind("pressure", "Pressure", is_traction=True)
SHEAR = ProfileKind("shear_traction", "Shear traction", is_traction=True)
GAP = ProfileKind(
    "gap",
    "Gap",
    MICROMETRE,
    at_edge=True,
    envelope=wave_mean,
    envelope_words="mean over one wavelength",
)
WEAR_RATE = ProfileKind("wear_rate", "Wear in one cycle", None)
WEAR = ProfileKind(
    "wear_depth",
    "Wear depth",
    MICROMETRE,
    downward=True,
    envelope=wave_mean,
    envelope_words="mean over one wavelength",
)

KINDS = {kind.variable: kind for kind in (PRESSURE, SHEAR, GAP, WEAR_RATE, WEAR)}

PROFILE_KINDS = {
    "pressure_profiles": PRESSURE,
    "shear_profiles": SHEAR,
    "gap_profiles": GAP,
    "wear_rate_profiles": WEAR_RATE,
    "wear_profiles": WEAR,
}


def kind_of(quantity: str | ProfileKind) -> ProfileKind:
    """Return the kind of profile of a quantity given by the name of its field.

    Raises
    ------
    ValueError
        When there are no profiles of it; the error names those there are.
    """
    if isinstance(quantity, ProfileKind):
        return quantity
    if quantity not in KINDS:
        raise ValueError(
            f"quantity = {quantity!r}: there are profiles of {', '.join(map(repr, KINDS))}."
        )
    return KINDS[quantity]
