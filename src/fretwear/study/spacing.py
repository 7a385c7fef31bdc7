"""The default grid spacing of a case, and how coarse a spacing may be."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fretwear.study.case import Case

CELLS_PER_CONTACT_RADIUS = 64
CELLS_PER_YIELDING_CONTACT_RADIUS = 128
CELLS_PER_STICK_RADIUS = 8
CELLS_PER_SLIP_ANNULUS = 12
CELLS_PER_WAVELENGTH = 16

LEAST_CELLS_PER_CONTACT_RADIUS = 8
LEAST_CELLS_PER_STICK_RADIUS = 2
LEAST_CELLS_PER_SLIP_ANNULUS = 1
LEAST_CELLS_PER_WAVELENGTH = 8


def default_spacing(case: Case) -> tuple[float, float]:
    """Return the (dx, dy) in m that resolves the contact, its stick zone and every wave.

    Contact radius, stick radius and slip annulus are those of the smooth elastic sphere.  A smooth
    contact that yields does so in a narrow ring at the edge of stick, which asks for twice the
    cells; on a rough one the waves ask for more than that.  Wave
    lengths count along their own direction, so dx and dy differ where the waves do.  The result
    is rounded down to two digits, which makes it readable and the same on every machine.
    """
    yields_in_a_ring = case.roughness is None and math.isfinite(case.plastic_limit)
    contact = min(
        case.hertz_radius
        / (CELLS_PER_YIELDING_CONTACT_RADIUS if yields_in_a_ring else CELLS_PER_CONTACT_RADIUS),
        case.stick_radius / CELLS_PER_STICK_RADIUS,
        (case.hertz_radius - case.stick_radius) / CELLS_PER_SLIP_ANNULUS,
    )
    if case.roughness is None:
        return _round_down(contact), _round_down(contact)
    return (
        _round_down(min(contact, case.roughness.wavelength_x / CELLS_PER_WAVELENGTH)),
        _round_down(min(contact, case.roughness.wavelength_y / CELLS_PER_WAVELENGTH)),
    )


def coarsest_for_contact(case: Case) -> float:
    """Return the largest spacing in m that still shows the contact, its stick and slip zones."""
    return min(
        case.hertz_radius / LEAST_CELLS_PER_CONTACT_RADIUS,
        case.stick_radius / LEAST_CELLS_PER_STICK_RADIUS,
        (case.hertz_radius - case.stick_radius) / LEAST_CELLS_PER_SLIP_ANNULUS,
    )


def _round_down(length: float) -> float:
    unit = 10.0 ** (math.floor(math.log10(length)) - 1)
    # The nudge keeps 0.5 um from becoming 0.49 um by the last bit of a division.
    return float(f"{math.floor(length / unit * (1.0 + 1e-9)) * unit:.2g}")
