"""The default cells of a case: rings, strips or a grid, as fine as the contact needs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.film import Film
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactProblem, solve_contact
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Row, Strips
from fretwear.mechanics.slip.models import Auto, Cerruti, Jaeger, SlipModel
from fretwear.mechanics.surfaces.roughness import Tip
from fretwear.mechanics.surfaces.setup import Setup
from fretwear.mechanics.wear.grading import NARROWEST_RING, NARROWEST_STRIP
from fretwear.theory import EllipticContact, HertzContact, LimitingState, LineContact, share_of_band
from fretwear.units import LINE_CONTACT, POINT_CONTACT

Spacing = tuple[float, float]

CELLS_PER_CONTACT_RADIUS = 64
CELLS_PER_SLIDING_EDGE = 8
# Cells on the radius of a contact over a stroke, and their largest number for a rounded edge.
CELLS_PER_SLIDING_RADIUS = {POINT_CONTACT: (8, 16), LINE_CONTACT: (16, 400)}
CELLS_PER_STICK_RADIUS = 8
CELLS_PER_SLIP_ANNULUS = (12, 4)  # of a smooth contact, and of one with cells for its tips

CELLS_ACROSS_TIP = 20.0
CELLS_ACROSS_YIELDING_BAND = 1.5
STRIPS_ACROSS_TIP, STRIPS_ACROSS_SLIP, STRIPS_ACROSS_STICK = 32.0, 1.5, 96.0
# Width of cells over the width that suits a tip, from which on the yielding band counts.
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
# Largest half-width of the window over the contact radius.
_WINDOW = 1.28
# Contact radii that cells for the peak pressure of coated bodies cover, farther on a soft layer.
_REACH, _CELLS_TO_REACH = 1.2, 200

# Fitted to runs, with the costs of `fretwear.study.plan`.
FOLDS_TO_LIMITING_STATE = 8.0
YIELDING_TIMES_TO_WIDEN = 50.0
WIDENING = 0.36
# Limit over the pressure that presses waves flat, beyond which strips of waves hardly yield.
_OF_CLOSING = 30.0
# Error of energy and wear by friction along x alone, over (1 − 1/κ)².
_OF_SLIP_MODEL = 0.125
# Stick zone and slip annulus over the contact radius, up to which a grid does not resolve them.
_NARROW = 0.05
# From this wear β N p_lim on, a grid takes many steps, while slip averaged over directions reduces
# the deepest wear by only 1 to 4 %.
_LONG = 40.0
# Wear β N p at which the elastic pressure p at the stick edge becomes singular.
_TO_SINGULAR = 2.5
# Slip along y of an unworn sphere over its mean, less one, over κ − 1: 0.64 to 0.88 for Q/µP of 0.8
# to 0.2 (Coulomb friction as a vector). Rings lack as much of the deepest wear, and less later:
# against grids, for limits of 3 to 6 p0, less than half of it at a wear β N p_lim of 20.
_OF_DIRECTION, _FORGOTTEN = 0.75, 20.0
CELLS_PER_YIELDING_CONTACT_RADIUS = 128
NEARLY_GROSS = 0.9999  # load ratio that stands for gross slip in a limiting state of partial slip


@dataclass(frozen=True, eq=False)
class Discretisation:
    """The cells that suit a contact over its cycles: their kind, and their default widths.

    It also knows where wear takes the contact, and which effects these cells neglect.
    """

    setup: Setup
    slip_model: SlipModel  #: as written, possibly ``auto``
    cycles: int
    force_is_held: bool  #: whether P and Q are constant

    @cached_property
    def geometry(self) -> type[Geometry]:
        """The kind of cells: rings for rotational symmetry, which slip along one direction breaks.

        Rings remain, unless a slip model along one direction is written, in two cases: under a
        pulsating load, if a grid would not resolve the slip annulus, the stick zone or the yielding
        ring at its edge; and if yielding bodies wear so long that the direction hardly matters at
        the end. Slip is then the mean over all directions.
        """
        setup = self.setup
        if setup.frame is LINE_CONTACT:
            return Row if setup.bulk_stress else Strips
        is_round = setup.indenter.is_axisymmetric and self._is_plain and not setup.bulk_stress
        if not is_round or self.slip_model.couples:
            return Grid
        if not (self.slip_varies and isinstance(self.slip_model, Auto)):
            return Grid if self.slip_varies else Rings
        is_narrow = not _NARROW < setup.stick_radius / setup.hertz_radius < 1.0 - _NARROW
        cell = setup.hertz_radius / CELLS_PER_YIELDING_CONTACT_RADIUS
        is_narrow |= self.edge_yields and self.yielding_ring < cell
        fits = setup.normal.pulsating_load == 1.0 and not (is_narrow or self.folds > _LONG)
        return Grid if fits else Rings

    @property
    def slip_varies(self) -> bool:
        """Whether slip depends on the direction from the middle of a round contact."""
        varies = self.setup.coupling != 1.0 or self.setup.coating is not None
        return varies and not self.slip_model.is_isotropic

    @cached_property
    def solved_slip_model(self) -> SlipModel:
        """The slip model; `auto` becomes one that the cells can resolve."""
        if not isinstance(self.slip_model, Auto):
            return self.slip_model
        has_directions = self.geometry is Grid and not self.setup.loading.stroke
        return Cerruti() if has_directions else Jaeger()

    @cached_property
    def is_graded(self) -> bool:
        """Whether cells are graded rings or strips, so that only written fields have the `cell`."""
        return self._is_plain and not issubclass(self.geometry, Grid)

    @cached_property
    def _is_plain(self) -> bool:
        return self.setup.rough is None and not self.setup.loading.stroke

    @cached_property
    def default_spacing(self) -> Spacing:
        """The default spacing (dx, dy), m, of a case.

        It is `usual_spacing` rounded down to two digits, so it is readable and the same on every
        machine. A punch that ends has a whole number of cells.
        """
        end = self.setup.indenter.end
        dx, dy = (rounded_down(width) for width in self.usual_spacing)
        if math.isfinite(end):
            dx, dy = (end / math.ceil(end / width) for width in (dx, dy))
        return dx, dy

    @cached_property
    def usual_spacing(self) -> Spacing:
        """The spacing (dx, dy), m, that suits a case.

        It resolves the contact, its stick zone, every wave, and the contacts of asperity tips as
        far as `MOST_CELLS` allow; if only written fields have it, as far as `MOST_WRITTEN` allow.
        """
        setup = self.setup
        (most_x, most_y), (dx, dy) = self.needed_spacings
        sides = math.prod(2 - is_even for is_even in setup.even)
        area = sides * math.prod(setup.indenter.half_widths(setup.hertz))
        if setup.frame is LINE_CONTACT:
            dx = dy = min(most_x, max(dx, setup.hertz_radius / MOST_STRIPS))
        # The second pass corrects axes that the first has widened alone.
        for _ in setup.frame.axes[1:] * 2:
            wider = math.sqrt(max(1.0, area / (dx * dy) / MOST_CELLS))
            dx, dy = min(most_x, wider * dx), min(most_y, wider * dy)
        if self.is_graded:
            least = 2.0 * _WINDOW * self.greatest_contact_radius / MOST_WRITTEN
            dx, dy = (width if width >= least else LARGEST_ROUNDING * least for width in (dx, dy))
        return dx, dy

    @cached_property
    def needed_spacings(self) -> tuple[Spacing, Spacing]:
        """Spacings (dx, dy), m, that resolve contact, stick zone and waves, and the tips too.

        Contact radius, stick radius and slip annulus describe the smooth elastic sphere. A
        smooth contact yields in a narrow ring at the stick edge, and so does a rough one that is
        pressed flat. This needs twice the cells, unless the ring is too narrow for the cells to
        yield. Wave lengths count along their own direction, so dx and dy differ where the waves do.
        """
        setup = self.setup
        zones = self.zones_of_tip
        radius, stick = setup.hertz_radius, setup.stick_radius
        in_a_ring = (
            math.isfinite(setup.slip_limit) and self._closing_pressure < setup.hertz_pressure
        )
        cells = CELLS_PER_CONTACT_RADIUS
        if in_a_ring:
            share = share_of_band(self.yielding_ring, self.narrowest_cell)
            cells *= (CELLS_PER_YIELDING_CONTACT_RADIUS / cells) ** share
        # A bulk stress moves the stick zone, which narrows the annulus on one side.
        annulus = radius - stick
        annulus = max(annulus - setup.tilt * setup.hertz.radius, LEAST_SIDE * annulus)
        contact = min(
            radius / cells,
            # A growing stick zone need not be resolved at its initial size.
            max(stick / CELLS_PER_STICK_RADIUS, 0.0 if self.force_is_held else radius / 128),
            # These cells resolve the slip of tips that stick in part.
            annulus / CELLS_PER_SLIP_ANNULUS[bool(zones)],
        )
        if setup.loading.stroke:
            edge = setup.indenter.edge(setup.hertz) / CELLS_PER_SLIDING_EDGE
            usual, most = CELLS_PER_SLIDING_RADIUS[setup.frame]
            contact = min(radius / usual, max(edge, radius / most))
        # An elliptical contact is resolved alike along both of its axes.
        wide = (half / radius * contact for half in setup.indenter.half_widths(setup.hertz))
        fine = [[length / part.cells for length in part.finest] for part in setup.surfaces.values()]
        dx, dy = (min(widths) for widths in zip(wide, *fine, strict=True))
        coarse = dx, dy
        tips = ([wide / cells for wide in widths] for widths, cells in zones.values())
        dx, dy = (min(widths) for widths in zip(coarse, *tips, strict=True))
        return coarse, (dx, dy)

    @cached_property
    def narrowest_cell(self) -> float:
        """The width, m, of the narrowest cells, rings or strips of a smooth contact."""
        setup = self.setup
        radius, stick = setup.hertz_radius, setup.stick_radius
        if not self.is_graded:
            return radius / CELLS_PER_YIELDING_CONTACT_RADIUS
        if setup.frame is LINE_CONTACT:
            return NARROWEST_STRIP * radius
        return NARROWEST_RING * min(radius - stick, stick or radius)

    @cached_property
    def zones_of_tip(self) -> dict[str, tuple[Spacing, float]]:
        """The zones of a tip that cells must resolve by name: width, m, and number of cells.

        These are its elastic contact and, if bodies yield, the band that yields at its stick edge;
        none if there are no tips of known shape, or if they are pressed flat. A tip near the middle
        carries the load on its share of the area under the pressure of the smooth contact. Under P*
        that pressure, and so the load of a tip, is lower by the factor (1 − X)^(1/3). If the tip
        itself is at the plastic limit, its contact carries its load at that pressure, and its stick
        zone carries its reduced load.
        """
        setup = self.setup
        tip = None if setup.rough is None else setup.rough.tip
        if tip is None:
            return {}
        if setup.frame is LINE_CONTACT:
            return {} if setup.loading.stroke else self._zones_of_ridge(tip)
        if self._closing_pressure <= setup.hertz_pressure:
            return {}
        of_indenter, reach = 1.0 / setup.indenter.curvature_radius, math.pi * setup.hertz_radius
        area = 0.5 * min(tip.apart_x, reach) * min(tip.apart_y, reach)
        load = min(setup.hertz_pressure * area, setup.hertz.load)
        radius_x, radius_y = (1.0 / (c + of_indenter) for c in (tip.curvature_x, tip.curvature_y))
        contact = EllipticContact.of(radius_x, radius_y, load, setup.composite_modulus)
        widened = max(1.0, contact.spread_radius(setup.slip_limit) / contact.contact_radius)
        along_x, along_y = (widened * half for half in contact.half_widths)
        zones = {"contact of a tip": ((2.0 * along_x, 2.0 * along_y), CELLS_ACROSS_TIP)}
        share = math.cbrt(1.0 - min(setup.tangential_ratio, 1.0))
        # A contact that slides as a whole has no stick edge.
        if math.isfinite(setup.slip_limit) and share > 0.0:
            round_one = HertzContact(contact.radius, contact.load, contact.composite_modulus)
            band = LimitingState(round_one, 1.0 - share).width_above(setup.slip_limit)
            part = min(band / contact.contact_radius, 1.0 - math.sqrt(share))
            cell = 2.0 / CELLS_ACROSS_TIP
            # If a band is too narrow for any cells to yield, the cells of the contact suffice.
            if counts := share_of_band(part, FINEST_IN_TIP * cell):
                number = part / cell * (CELLS_ACROSS_YIELDING_BAND * cell / part) ** counts
                zones["band that yields"] = ((part * along_x, part * along_y), number)
        return zones

    def _zones_of_ridge(self, tip: Tip) -> dict[str, tuple[Spacing, float]]:
        """The zones of a ridge along y, itself a line contact, and the whole stick zone.

        A ridge carries the pressure of the smooth contact over a wavelength, reduced under P* by
        the factor √(1 − X). At half the pressure that closes the gaps its contact is half a
        wavelength wide (Westergaard 1939); at a higher pressure, ridges farther out touch on this
        width.
        """
        setup = self.setup
        of_indenter = 1.0 / setup.indenter.curvature_radius
        load = min(setup.hertz_pressure * tip.apart_x, setup.hertz.load)
        modulus = setup.composite_modulus
        contact = LineContact(1.0 / (tip.curvature_x + of_indenter), load, modulus)
        half, spread = contact.contact_radius, contact.spread_radius(setup.slip_limit)
        share = math.sqrt(1.0 - min(setup.tangential_ratio, 1.0))
        # The width grows with the load at the plastic limit, with its root in an elastic contact.
        slip = max(half, spread) * (1.0 - (share if spread > half else math.sqrt(share)))
        width = min(2.0 * max(half, spread), 0.5 * tip.apart_x)
        zones = {
            "contact of a tip": (width, STRIPS_ACROSS_TIP),
            "slip zone of a tip": (min(slip, 0.5 * width), STRIPS_ACROSS_SLIP),
            "stick zone": (2.0 * setup.stick_radius or math.inf, STRIPS_ACROSS_STICK),
        }
        return {name: ((width, math.inf), number) for name, (width, number) in zones.items()}

    @cached_property
    def _closing_pressure(self) -> float:
        """Mean pressure E*·slope/2, Pa, that presses waves flat; zero where smooth.

        Johnson, Greenwood and Higginson (1985), Int. J. Mech. Sci. 27, 383-396.
        """
        setup = self.setup
        return 0.0 if setup.rough is None else 0.5 * setup.composite_modulus * setup.rough.steepest

    @cached_property
    def greatest_contact_radius(self) -> float:
        """An upper bound, m, of the contact radius during a run."""
        setup = self.setup
        if setup.loading.stroke:
            return self.scar_half_width + setup.loading.travel
        # Under an imposed displacement the tangential load falls as the contact wears.
        ratio = min(setup.tangential_ratio, NEARLY_GROSS if self.force_is_held else 0.95)
        limiting = setup.indenter.limiting(setup.hertz, ratio).contact_radius / setup.hertz_radius
        worn = self.cycles * setup.largest_wear_growth
        grown = -math.expm1(-worn * setup.hertz_pressure / FOLDS_TO_LIMITING_STATE)
        wider = 1.0 + (limiting - 1.0) * grown
        if self.stick_shrinks:
            wider *= (1.0 + worn * setup.slip_limit / YIELDING_TIMES_TO_WIDEN) ** WIDENING
        smooth = max(setup.hertz_radius * wider, setup.hertz.spread_radius(setup.slip_limit))
        # Tips can touch as far out as the sphere has receded by the height of the waves.
        tips = 0.0 if setup.rough is None else setup.rough.tips
        reach = math.hypot(smooth, math.sqrt(2.0 * setup.indenter.curvature_radius * tips))
        return min(reach, setup.indenter.end)

    @cached_property
    def stick_shrinks(self) -> bool:
        """Whether the stick edge yields and slip follows it; then the contact widens without bound.

        A band too narrow for the cells to yield has no such effect.
        """
        setup = self.setup
        if math.isinf(setup.slip_limit) or not self.slip_model.follows_shape:
            return False
        if setup.rough is not None and self._closing_pressure > setup.hertz_pressure:
            yields = "band that yields" in self.zones_of_tip
            return yields or setup.slip_limit < _OF_CLOSING * self._closing_pressure
        return share_of_band(self.yielding_ring, self.narrowest_cell) > 0.0

    @property
    def scar_half_width(self) -> float:
        """Half-width, m, of the contact at the end of a run with strokes, from the worn volume."""
        setup = self.setup
        path = 4.0 * setup.loading.stroke * self.cycles * (1.0 - setup.debris_fraction)
        most = setup.combined_wear_coefficient * setup.faster_below
        volume = most * path * setup.load_at(0.0)
        width = setup.hertz.scar_half_width(volume, setup.indenter.curvature_radius)
        return min(width, setup.indenter.end)

    @cached_property
    def folds(self) -> float:
        """Wear β N p_lim: how often a contact at the plastic limit wears e-fold; 0 if elastic."""
        limit = self.setup.slip_limit
        return 0.0 if math.isinf(limit) else self.cycles * self.setup.largest_wear_growth * limit

    @cached_property
    def edge_yields(self) -> bool:
        """Whether wear brings the stick edge of a smooth contact to the plastic limit.

        The neighbourhood of the edge has no length scale: its pressure p depends on β N p alone. On
        rings and strips it reached the limit at 2.5 (1 − p/p_lim) or up to a third later, for Q/µP
        of 0.1 to 0.9 and limits of 1.05 to 5 p0.
        """
        setup = self.setup
        if math.isinf(setup.slip_limit):
            return False
        edge = float(setup.hertz.pressure(setup.stick_radius))
        worn = self.cycles * setup.largest_wear_growth * edge
        return worn > _TO_SINGULAR * (1.0 - edge / setup.slip_limit)

    @cached_property
    def yielding_ring(self) -> float:
        """Width, m, of the ring at the stick edge that yields in the course of wear.

        Wear moves all pressure of a smooth contact into its stick zone, where it tends to
        `LimitingState.pressure`. The ring is the part where this exceeds the plastic limit: of zero
        width in an elastic case, at most the stick radius.
        """
        setup = self.setup
        if math.isinf(setup.slip_limit):
            return 0.0
        ratio = min(setup.tangential_ratio, NEARLY_GROSS)
        return setup.indenter.limiting(setup.hertz, ratio).width_above(setup.slip_limit)

    @property
    def error_of_slip_model(self) -> float:
        """Relative error of energy and wear without traction along y.

        A traction along x alone dissipates more by 0.12 (1 − 1/κ)² than friction as a vector, for ν
        of 0.15 to 0.5 and Q/µP of 0.4 and 0.8, and likewise wear at 300 cycles. Slip alike in all
        directions, as on rings, errs by twice as much.
        """
        if (
            self.slip_model.is_isotropic
            or self.slip_model.couples
            or self.setup.frame is LINE_CONTACT
        ):
            return 0.0
        part = _OF_SLIP_MODEL * (2.0 if self.solved_slip_model.is_isotropic else 1.0)
        return part * (1.0 - 1.0 / self.setup.coupling) ** 2

    def error_of_directions(self, cycle: float) -> float:
        """Largest relative lack of the deepest wear if slip has no direction."""
        slides = self.setup.tangential_ratio >= 1.0  # in gross sliding slip is the same everywhere
        if slides or not (issubclass(self.geometry, Rings) and self.slip_varies):
            return 0.0
        worn = self.folds * cycle / self.cycles
        return _OF_DIRECTION * abs(self.setup.coupling - 1.0) / (1.0 + worn / _FORGOTTEN)


def unworn_peak(setup: Setup, film: Film | None) -> float:
    """Peak pressure, Pa, of the unworn smooth elastic bodies with a film on the flat.

    A body without rotational symmetry counts as the sphere that sets its scales.
    """
    hertz, modulus = setup.hertz, setup.composite_modulus
    wider = 1.0 if setup.film is None else setup.film.widening(modulus)
    edges = np.linspace(0.0, _REACH * wider * hertz.contact_radius, _CELLS_TO_REACH + 1)
    cells: Rings | Strips = Rings(tuple(edges.tolist()))
    if isinstance(hertz, LineContact):
        cells = Strips(cells.edges, hertz.reference)
    x, y = cells.x[:, None], np.zeros((1, 1))
    shape: Array = 0.5 * x**2 / hertz.radius
    if setup.frame is LINE_CONTACT or setup.indenter.is_axisymmetric:
        shape = setup.indenter.gap(x, y)
    load, approach = setup.normal.held
    bodies = cells.half_space(modulus, film)
    contact = solve_contact(ContactProblem(bodies, shape, load, approach=approach))
    return float(contact.pressure.max())


def rounded_down(length: float, digits: int = 2) -> float:
    """Return a length rounded down to a few digits."""
    unit = 10.0 ** (math.floor(math.log10(length)) + 1 - digits)
    # The nudge keeps 0.5 um from becoming 0.49 um by the last bit of a division.
    return float(f"{math.floor(length / unit * (1.0 + 1e-9)) * unit:.{digits}g}")
