"""The default grid spacing, which resolves the contact up to a limit on its cost."""

from __future__ import annotations

import math

from fretwear.mechanics.surfaces.roughness import Tip
from fretwear.mechanics.wear.grading import NARROWEST_RING, NARROWEST_STRIP
from fretwear.study.contact import (
    CELLS_PER_YIELDING_CONTACT_RADIUS,
    NEARLY_GROSS,
    FrettingContact,
)
from fretwear.theory import (
    EllipticContact,
    HertzContact,
    LimitingState,
    LineContact,
    share_of_band,
)
from fretwear.units import LINE_CONTACT, POINT_CONTACT

Spacing = tuple[float, float]

CELLS_PER_CONTACT_RADIUS = 64
CELLS_PER_SLIDING_EDGE = 8
# On the radius of a contact over a stroke, and the most for the sake of a rounded edge.
CELLS_PER_SLIDING_RADIUS = {POINT_CONTACT: (8, 16), LINE_CONTACT: (16, 400)}
CELLS_PER_STICK_RADIUS = 8
CELLS_PER_SLIP_ANNULUS = (12, 4)  # of a smooth contact, and of one whose tips have their own

CELLS_ACROSS_TIP = 20.0
CELLS_ACROSS_YIELDING_BAND = 1.5
STRIPS_ACROSS_TIP, STRIPS_ACROSS_SLIP, STRIPS_ACROSS_STICK = 32.0, 1.5, 96.0
# Width of cells, over the width that suits a tip, from which on the band that yields counts.
FINEST_IN_TIP = 0.01
MOST_CELLS, MOST_STRIPS = 30_000, 1_000
"""Computed cells of the unworn contact up to which its tips are resolved by default, and strips."""
LEAST_COARSENESS = 0.125
"""Width of graded rings and strips relative to the usual one, however fine the written cell."""
MOST_WRITTEN = 600
"""Cells along an axis of the whole contact on which fields of graded cells are only written."""
LEAST_RATIO, RATIO_ON_GRID = 1.5, 1.4
"""Least ratio of the widths of cells of two runs from which errors are estimated, and the ratio on
equal cells: small spots of stick are lost on much wider ones."""
WIDEST, STEPS_PER_ACCURACY = 2.0, 1.5
"""Width of the first cells of a case that asks for an accuracy, over the default, and tolerance of
its steps, over the accuracy."""
LEAST_SIDE = 0.25
"""Least part of the slip annulus that counts as its narrow side under a bulk stress."""
LARGEST_ROUNDING = 1.1
"""Largest ratio of a length to itself rounded down to two digits."""
# Largest half-width of the window, over the contact radius.
_WINDOW = 1.28

# Fitted to runs, with the costs of `fretwear.study.plan`.
FOLDS_TO_LIMITING_STATE = 8.0
YIELDING_TIMES_TO_WIDEN = 50.0
WIDENING = 0.36
# Limit over the pressure that presses waves flat beyond which strips of waves hardly yield.
_OF_CLOSING = 30.0


def default_spacing(case: FrettingContact) -> Spacing:
    """Return the default spacing (dx, dy), m, of a case.

    It is `usual_spacing` rounded down to two digits, which makes it readable and the same on every
    machine. A punch that ends has a whole number of cells.
    """
    end = case.indenter.end
    dx, dy = (rounded_down(width) for width in usual_spacing(case))
    if math.isfinite(end):
        dx, dy = (end / math.ceil(end / width) for width in (dx, dy))
    return dx, dy


def usual_spacing(case: FrettingContact) -> Spacing:
    """Return the spacing (dx, dy), m, that suits a case.

    It resolves the contact, its stick zone, every wave, and the contacts of asperity tips as far as
    `MOST_CELLS` allow; if only written fields have it, as far as `MOST_WRITTEN` allow.
    """
    (most_x, most_y), (dx, dy) = needed_spacings(case)
    sides = math.prod(2 - is_even for is_even in case.even)
    area = sides * math.prod(case.indenter.half_widths(case.hertz))
    if case.frame is LINE_CONTACT:
        dx = dy = min(most_x, max(dx, case.hertz_radius / MOST_STRIPS))
    # The second pass corrects what the first has widened along one axis only.
    for _ in case.frame.axes[1:] * 2:
        wider = math.sqrt(max(1.0, area / (dx * dy) / MOST_CELLS))
        dx, dy = min(most_x, wider * dx), min(most_y, wider * dy)
    if case.is_graded:
        least = 2.0 * _WINDOW * greatest_contact_radius(case) / MOST_WRITTEN
        dx, dy = (width if width >= least else LARGEST_ROUNDING * least for width in (dx, dy))
    return dx, dy


def needed_spacings(case: FrettingContact) -> tuple[Spacing, Spacing]:
    """Return spacings (dx, dy), m, that resolve contact, stick zone and waves, and the tips too.

    Contact radius, stick radius and slip annulus belong to the smooth elastic sphere. A smooth
    contact that yields does so in a narrow ring at the edge of stick, and so does a rough one that
    is pressed flat: it needs twice the cells, unless the ring is too narrow for these to yield.
    Wave lengths count along their own direction, so dx and dy differ where the waves do.
    """
    zones = zones_of_tip(case)
    radius, stick = case.hertz_radius, case.stick_radius
    in_a_ring = math.isfinite(case.plastic_limit) and _closing_pressure(case) < case.hertz_pressure
    cells = CELLS_PER_CONTACT_RADIUS
    if in_a_ring:
        share = share_of_band(case.yielding_ring, narrowest_cell(case))
        cells *= (CELLS_PER_YIELDING_CONTACT_RADIUS / cells) ** share
    # A bulk stress moves the stick zone, so that one side of the annulus is narrower.
    annulus = radius - stick
    annulus = max(annulus - case.tilt * case.hertz.radius, LEAST_SIDE * annulus)
    contact = min(
        radius / cells,
        # A growing stick zone need not be resolved at its initial size.
        max(stick / CELLS_PER_STICK_RADIUS, 0.0 if case.force_is_held else radius / 128),
        # Slip of tips that stick in part is seen on these.
        annulus / CELLS_PER_SLIP_ANNULUS[bool(zones)],
    )
    if case.loading.stroke:
        edge = case.indenter.edge(case.hertz) / CELLS_PER_SLIDING_EDGE
        usual, most = CELLS_PER_SLIDING_RADIUS[case.frame]
        contact = min(radius / usual, max(edge, radius / most))
    # An elliptical contact is resolved alike along both of its axes.
    wide = (half / radius * contact for half in case.indenter.half_widths(case.hertz))
    fine = [[length / part.cells for length in part.finest] for part in case.surfaces.values()]
    dx, dy = (min(widths) for widths in zip(wide, *fine, strict=True))
    coarse = dx, dy
    tips = ([wide / cells for wide in widths] for widths, cells in zones.values())
    dx, dy = (min(widths) for widths in zip(coarse, *tips, strict=True))
    return coarse, (dx, dy)


def _closing_pressure(case: FrettingContact) -> float:
    """Mean pressure E*·slope/2, Pa, that presses waves flat; zero where smooth.

    Johnson, Greenwood and Higginson (1985), Int. J. Mech. Sci. 27, 383-396.
    """
    return 0.0 if case.rough is None else 0.5 * case.composite_modulus * case.rough.steepest


def zones_of_tip(case: FrettingContact) -> dict[str, tuple[Spacing, float]]:
    """Return the zones of a tip that cells must resolve by name: width, m, and number of cells.

    These are its elastic contact and, where bodies yield, the band that does at its edge of stick;
    none if there are no tips of known shape, or if they are pressed flat. A tip near the middle
    carries the load on its share of the area under the pressure of the smooth contact. Under P*
    that pressure is lower by the factor (1 − X)^(1/3), and so is the load of a tip. Where
    the tip itself is at the plastic limit, its contact carries its load at that pressure, and its
    stick zone its reduced load.
    """
    tip = None if case.rough is None else case.rough.tip
    if tip is None:
        return {}
    if case.frame is LINE_CONTACT:
        return {} if case.loading.stroke else _zones_of_ridge(case, tip)
    if _closing_pressure(case) <= case.hertz_pressure:
        return {}
    of_indenter, reach = 1.0 / case.indenter.curvature_radius, math.pi * case.hertz_radius
    area = 0.5 * min(tip.apart_x, reach) * min(tip.apart_y, reach)
    load = min(case.hertz_pressure * area, case.hertz.load)
    radius_x, radius_y = (1.0 / (c + of_indenter) for c in (tip.curvature_x, tip.curvature_y))
    contact = EllipticContact.of(radius_x, radius_y, load, case.composite_modulus)
    widened = max(1.0, contact.spread_radius(case.slip_limit) / contact.contact_radius)
    along_x, along_y = (widened * half for half in contact.half_widths)
    zones = {"contact of a tip": ((2.0 * along_x, 2.0 * along_y), CELLS_ACROSS_TIP)}
    share = math.cbrt(1.0 - min(case.tangential_ratio, 1.0))
    # A contact that slides as a whole has no edge of stick.
    if math.isfinite(case.plastic_limit) and share > 0.0:
        round_one = HertzContact(contact.radius, contact.load, contact.composite_modulus)
        band = LimitingState(round_one, 1.0 - share).width_above(case.slip_limit)
        part = min(band / contact.contact_radius, 1.0 - math.sqrt(share))
        cell = 2.0 / CELLS_ACROSS_TIP
        # If a band is too narrow for any cells to yield, the cells of the contact are enough.
        if counts := share_of_band(part, FINEST_IN_TIP * cell):
            number = part / cell * (CELLS_ACROSS_YIELDING_BAND * cell / part) ** counts
            zones["band that yields"] = ((part * along_x, part * along_y), number)
    return zones


def _zones_of_ridge(case: FrettingContact, tip: Tip) -> dict[str, tuple[Spacing, float]]:
    """Return the zones of a ridge along y, itself a line contact, and the whole stick zone.

    A ridge carries the pressure of the smooth contact over a wavelength, under P* reduced by the
    factor √(1 − X). Half the pressure that closes the gaps makes its contact half a wavelength wide
    (Westergaard 1939); where the pressure is higher, ridges farther out touch on this width.
    """
    of_indenter = 1.0 / case.indenter.curvature_radius
    load = min(case.hertz_pressure * tip.apart_x, case.hertz.load)
    modulus = case.composite_modulus
    contact = LineContact(1.0 / (tip.curvature_x + of_indenter), load, modulus)
    half, spread = contact.contact_radius, contact.spread_radius(case.slip_limit)
    share = math.sqrt(1.0 - min(case.tangential_ratio, 1.0))
    # The width grows with the load at the plastic limit, and with its root in an elastic contact.
    slip = max(half, spread) * (1.0 - (share if spread > half else math.sqrt(share)))
    width = min(2.0 * max(half, spread), 0.5 * tip.apart_x)
    zones = {
        "contact of a tip": (width, STRIPS_ACROSS_TIP),
        "slip zone of a tip": (min(slip, 0.5 * width), STRIPS_ACROSS_SLIP),
        "stick zone": (2.0 * case.stick_radius or math.inf, STRIPS_ACROSS_STICK),
    }
    return {name: ((width, math.inf), number) for name, (width, number) in zones.items()}


def rounded_down(length: float, digits: int = 2) -> float:
    """Return a length rounded down to a few digits."""
    unit = 10.0 ** (math.floor(math.log10(length)) + 1 - digits)
    # The nudge keeps 0.5 um from becoming 0.49 um by the last bit of a division.
    return float(f"{math.floor(length / unit * (1.0 + 1e-9)) * unit:.{digits}g}")


def greatest_contact_radius(case: FrettingContact) -> float:
    """Return an upper bound, m, of the contact radius during a run."""
    if case.loading.stroke:
        return case.scar_half_width + case.loading.travel
    # Where a displacement is imposed the tangential load falls as the contact wears.
    ratio = min(case.tangential_ratio, NEARLY_GROSS if case.force_is_held else 0.95)
    limiting = case.indenter.limiting(case.hertz, ratio).contact_radius / case.hertz_radius
    worn = case.cycles * case.wear_growth
    grown = -math.expm1(-worn * case.hertz_pressure / FOLDS_TO_LIMITING_STATE)
    wider = 1.0 + (limiting - 1.0) * grown
    if stick_shrinks(case):
        wider *= (1.0 + worn * case.slip_limit / YIELDING_TIMES_TO_WIDEN) ** WIDENING
    smooth = max(case.hertz_radius * wider, case.hertz.spread_radius(case.slip_limit))
    # Tips can touch as far out as the sphere has receded by the height of the waves.
    tips = 0.0 if case.rough is None else case.rough.tips
    reach = math.hypot(smooth, math.sqrt(2.0 * case.indenter.curvature_radius * tips))
    return min(reach, case.indenter.end)


def stick_shrinks(case: FrettingContact) -> bool:
    """Whether the stick edge yields and slip follows it: then the contact widens without bound.

    A band too narrow for the cells to yield has no such effect.
    """
    if math.isinf(case.plastic_limit) or not case.slip_model.follows_shape:
        return False
    if case.rough is not None and _closing_pressure(case) > case.hertz_pressure:
        yields = "band that yields" in zones_of_tip(case)
        return yields or case.slip_limit < _OF_CLOSING * _closing_pressure(case)
    return share_of_band(case.yielding_ring, narrowest_cell(case)) > 0.0


def narrowest_cell(case: FrettingContact) -> float:
    """Return the width, m, of the narrowest cells, rings or strips of a smooth contact."""
    radius, stick = case.hertz_radius, case.stick_radius
    if not case.is_graded:
        return radius / CELLS_PER_YIELDING_CONTACT_RADIUS
    if case.frame is LINE_CONTACT:
        return NARROWEST_STRIP * radius
    return NARROWEST_RING * min(radius - stick, stick or radius)
