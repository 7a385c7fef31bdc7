"""Where a smooth contact yields, and whether its grid can see that."""

from __future__ import annotations

import math

from fretwear.study.case import Case


def yielding_ring_width(case: Case) -> float:
    """Return the width in m of the ring at the edge of stick that comes to yield.

    Wear moves all pressure of a smooth contact into its stick zone, of radius c, where it tends to
    p∞ = (E*/π) [ (2/R) √(c² − r²) + (d∞ − c²/R) / √(c² − r²) ],  d∞ = P/(2E*c) + c²/(3R):
    Hertzian contact and flat punch, Johnson (1985), Contact Mechanics, sections 3.4 and 4.2. The
    ring is where that exceeds the plastic limit: zero for an elastic case, c where everything does.
    """
    if math.isinf(case.plastic_limit):
        return 0.0
    c, radius, modulus = case.stick_radius, case.radius, case.composite_modulus
    punch = case.load / (2.0 * modulus * c) - 2.0 * c**2 / (3.0 * radius)
    half = math.pi * case.plastic_limit * radius / (4.0 * modulus)
    discriminant = half**2 - 0.5 * punch * radius
    if discriminant <= 0.0:
        return c
    # The smaller root of (2/R) w² − (π p/E*) w + (d∞ − c²/R) = 0 in w = √(c² − r²).
    root = 0.5 * punch * radius / (half + math.sqrt(discriminant))
    return c if root >= c else root**2 / (c + math.sqrt((c - root) * (c + root)))


def is_ring_unseen(case: Case) -> bool:
    """Whether a smooth contact yields in a ring narrower than a cell of its grid.

    Of a rough one every tip yields by itself, which the grid of the waves sees.
    """
    if case.roughness is not None or math.isinf(case.plastic_limit):
        return False
    return yielding_ring_width(case) < max(case.grid_spacing)
