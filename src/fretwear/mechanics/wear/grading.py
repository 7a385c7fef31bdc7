"""Graded widths of rings and strips, narrow at the edges of stick and of contact."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Strips
from fretwear.mechanics.wear.state import Stage, WearProblem
from fretwear.theory import LimitingState, LineContact, share_of_band

# A step seldom widens a contact by more; extending the cells beforehand costs less than repeating
# the step.
WIDENED = 1.04
# Width of the rings in units of the slip annulus or the stick radius: narrowest at the stick edge,
# where the elastic pressure grows without bound, widest near the edge of contact. At both places
# they are at most such fractions of the contact.
NARROWEST_RING = 1.0 / 1500.0
_ACROSS_SLIP, _ACROSS_STICK = 40.0, 200.0
_WIDEST_IN_SLIP, _WIDEST = 0.006, 0.016
# Width at the edge of the unworn contact, whose position is known to a fraction of a ring.
_AT_CONTACT = 0.002
# Growth of the width with the distance from its minimum.
_GRADING = 0.2
# Number of rings across the band that yields in the limit of many cycles, and number of such bands
# inside and outside the stick edge over which rings are narrowest. The edge moves inward, and the
# rings follow when fewer bands are left.
_ACROSS_BAND = 9.0
_AHEAD, _BEHIND, _LEFT = 4.0, 1.0, 1.0
_MOST_BANDED = 75.0
_LEAST_ANNULUS = 1e-3
# Peak pressure over the plastic limit, above which rings are graded for bodies that yield.
_NEARLY = 0.9
# Rings are replaced once they are wider than new ones by this factor.
_LENIENT = 1.5
_SAMPLES = 2001
# Stick radius over the contact radius below which rings are graded for gross sliding: less than a
# part in 10⁷ of the area sticks.
_LEAST_STICK = 3e-4
# Widths of strips in units of the Hertzian half-width: the narrowest at the stick edge, where the
# elastic pressure grows without bound, and the widest; and growth of the width with the distance.
NARROWEST_STRIP, _WIDEST_STRIP, _STRIP_GRADING = 1e-4, 0.004, 0.05
# Widest strip in units of the present half-width of a contact in gross sliding.
_WIDEST_SLIDING = 0.006
# Least number of strips across an unworn slip zone.
_STRIPS_ACROSS_SLIP = 20.0
# If bodies yield, stick edge and yielding band move inward. So widths grow more slowly there, and a
# band in the limit of many cycles has so many strips at first.
_INWARD_GRADING, _STRIPS_ACROSS_BAND = 0.03, 6.0


@dataclass(frozen=True)
class Grading:
    """The widths that the rings of a contact need."""

    stick: float  # radius of the edge of the stick zone, m
    contact: float  # largest expected radius of the contact, m
    unworn: float  # radius of the unworn contact, m
    narrowest: float  # width at the stick edge, m
    ahead: float = 0.0  # distance inward over which this width is kept, m
    behind: float = 0.0  # the same outward, m
    coarseness: float = 1.0  # factor on all widths

    @classmethod
    def of(cls, problem: WearProblem, stick: float, contact: float, *, yields: bool) -> Grading:
        """The grading for given radii of stick zone and contact, m, of bodies that yield or not."""
        yields = yields and not math.isinf(problem.slip_limit)
        hertz, coarseness = problem.hertz, problem.coarseness
        unworn = hertz.contact_radius
        stick = stick if stick > _LEAST_STICK * contact else 0.0
        ratio = 1.0 - (min(stick, (1.0 - 1e-9) * contact) / unworn) ** 3
        limiting = LimitingState(hertz, ratio) if 0.0 < ratio < 1.0 else None
        if limiting is not None:
            contact = max(contact, min(limiting.contact_radius, 2.0 * contact))
        # If all rings stick, the annulus is narrower than one of them.
        contact = max(contact, (1.0 + _LEAST_ANNULUS) * stick) if stick >= contact else contact
        narrowest = NARROWEST_RING * min(contact - stick, stick or contact)
        if not yields or stick == 0.0:
            return cls(stick, contact, unworn, narrowest, coarseness=coarseness)
        if limiting is not None:
            band = limiting.width_above(problem.slip_limit)
        else:
            # The stick zone is as wide as the unworn contact: take the band of a flat punch.
            punch = hertz.load / (2.0 * math.pi * stick * problem.slip_limit)
            band = min(0.5 * punch**2 / stick, stick)
        finest = min((contact - stick) / _ACROSS_SLIP, stick / _ACROSS_STICK)
        # A band too narrow for the rings of an elastic contact to yield does not change them.
        share = share_of_band(band, narrowest)
        narrowest *= (min(finest, band / _ACROSS_BAND) / narrowest) ** share
        # If the slip annulus needs narrower rings than a wide band does, a limited number suffices.
        band = min(share * band, _MOST_BANDED * narrowest)
        return cls(stick, contact, unworn, narrowest, _AHEAD * band, _BEHIND * band, coarseness)

    def width(self, r: Array) -> Array:
        """Width of the rings at radii, m."""
        excess = np.maximum(self.stick - self.ahead - r, r - self.stick - self.behind)
        width = self.narrowest + _GRADING * np.maximum(excess, 0.0)
        in_slip = min((self.contact - self.stick) / _ACROSS_SLIP, _WIDEST_IN_SLIP * self.contact)
        width = np.minimum(width, _AT_CONTACT * self.unworn + _GRADING * np.abs(r - self.unworn))
        outside = np.maximum(np.maximum(self.stick - r, r - self.contact), 0.0)
        width = np.minimum(width, in_slip + _GRADING * outside)
        return self.coarseness * np.minimum(width, _WIDEST * self.contact)

    def suits(self, rings: Rings) -> bool:
        """Whether rings are fine enough wherever required."""
        left = _LEFT / _AHEAD * self.ahead
        places = np.array([self.stick - left, self.stick + 0.5 * self.behind, self.contact])
        edges = np.asarray(rings.edges)
        ring = np.clip(np.searchsorted(edges, places), 1, edges.size - 1)
        widths = edges[ring] - edges[ring - 1]
        return bool((widths <= _LENIENT * self.width(places)).all())


def first_rings(problem: WearProblem) -> Rings:
    """Rings for the first loading of a problem, graded to the edge of its stick zone.

    It raises a ValueError for a problem without rotational symmetry.
    """
    if problem.rough is not None or not problem.indenter.is_axisymmetric:
        raise ValueError("rings need a smooth indenter with rotational symmetry")
    hertz, load = problem.hertz, problem.stick_load
    stick = hertz.with_load(load).contact_radius if load > 0.0 else 0.0
    yields = hertz.peak_pressure > problem.slip_limit
    grading = Grading.of(problem, stick, hertz.contact_radius, yields=yields)
    return graded_rings(grading, math.sqrt(2.0) * max(problem.extent))


def graded_rings(grading: Grading, outer: float) -> Rings:
    """Rings of graded widths with one edge at the stick radius, out to a radius, m."""
    steps = np.linspace(0.0, 1.0, _SAMPLES)
    inner, outside = (
        grading.stick + length * steps**3 for length in (-grading.stick, outer - grading.stick)
    )
    edges = [_divided(part, grading.width(part)) for part in (inner, outside)]
    return Rings((0.0, *edges[0][-2::-1].tolist(), *edges[1][1:].tolist()))


def next_rings(rings: Rings, problem: WearProblem, stage: Stage) -> Rings:
    """Rings for the next step, which follow the stick edge and reach far enough."""
    stick = rings.radius_of(stage.reduced.pressure)
    touched = rings.radius_of(stage.wear + stage.pressure)
    radii = stick, touched
    grading, banded = (Grading.of(problem, *radii, yields=yields) for yields in (False, True))
    # A contact with a limit behaves as one without until it nearly yields. A peak that becomes
    # singular is higher on narrower rings.
    finer = max(1.0, grading.narrowest / banded.narrowest)
    peak = float(stage.pressure.max()) * math.sqrt(finer)
    if peak > _NEARLY * problem.slip_limit or stage.plastic.any():
        grading = banded
    if not grading.suits(rings):
        rings = replace(rings, edges=graded_rings(grading, rings.edges[-1]).edges)
    return rings.reaching(WIDENED * touched)


def first_strips(problem: WearProblem) -> Strips:
    """Strips for the first loading of a problem, graded to the edge of its stick zone.

    A rough contact, which sticks and slips in many places, has equal strips.
    """
    hertz, outer, wider = problem.hertz, problem.extent[0], problem.coarseness
    assert isinstance(hertz, LineContact)
    if problem.wavelengths is not None:
        width = problem.spacing[0]
        edges = np.arange(math.ceil((outer + problem.wavelengths[0]) / width) + 1) * width
        return Strips(tuple(edges.tolist()), hertz.reference)
    load, scale = problem.stick_load, wider * hertz.contact_radius
    stick = hertz.with_load(load).contact_radius if load > 0.0 else 0.0
    annulus = (hertz.contact_radius - stick) / _STRIPS_ACROSS_SLIP
    narrowest = wider * min(NARROWEST_STRIP * hertz.contact_radius, annulus)
    inward = _STRIP_GRADING * wider
    if not math.isinf(problem.slip_limit):
        limiting = problem.indenter.limiting(hertz, min(1.0 - load / hertz.load, 0.9999))
        band = limiting.width_above(problem.slip_limit)
        # A band too narrow for the strips of an elastic contact to yield does not change them.
        share = share_of_band(band, narrowest)
        narrowest *= min(1.0, band / _STRIPS_ACROSS_BAND / narrowest) ** share
        inward *= min(1.0, _INWARD_GRADING / inward) ** share
    widths = narrowest, _WIDEST_STRIP * scale
    # A strip that holds only the stick zone would be a sliver.
    stick = stick if stick > narrowest else 0.0
    inner = stick - _distances(stick, *widths, inward)[::-1]
    inner[0] = 0.0
    outside = stick + _distances(outer - stick, *widths, _STRIP_GRADING * wider)[1:]
    return Strips((*inner.tolist(), *outside.tolist()), hertz.reference)


def widened_strips(strips: Strips, problem: WearProblem, stage: Stage) -> Strips:
    """Wider strips if a smooth contact slides as a whole; otherwise the same ones.

    Without a stick edge nothing needs narrow strips, and the scar may outgrow the unworn contact.
    """
    if problem.wavelengths is not None or stage.reduced.pressure.any():
        return strips
    radius = strips.radius_of(stage.wear + stage.pressure)
    widest = _WIDEST_SLIDING * problem.coarseness * radius
    outermost = strips.edges[-1] - strips.edges[-2]
    return strips if outermost > 0.5 * widest else strips.merged(widest)


def _divided(positions: Array, widths: Array) -> Array:
    """Positions that divide an interval into a whole number of steps of about the given widths."""
    lengths = np.abs(np.diff(positions))
    count = np.concatenate(
        [[0.0], np.cumsum(0.5 * lengths * (1.0 / widths[1:] + 1.0 / widths[:-1]))]
    )
    steps = np.linspace(0.0, count[-1], math.ceil(count[-1]) + 1)
    return np.asarray(np.interp(steps, count, positions))


def _distances(length: float, narrowest: float, widest: float, grading: float) -> Array:
    """Distances from 0 to a length whose spacing grows with the distance between two bounds."""
    first, last = narrowest / grading, widest / grading
    middle = math.log(last / first) / grading
    # The count of strips up to a distance: linear, logarithmic, linear.
    start = first / narrowest
    total = length / narrowest
    if length >= first:
        total = start + math.log(min(length, last) / first) / grading
    total += max(length - last, 0.0) / widest
    count = np.linspace(0.0, total, math.ceil(total) + 1)
    growing = first * np.exp(grading * np.clip(count - start, 0.0, middle))
    result: Array = np.where(count < start, count * narrowest, growing)
    result += np.maximum(count - start - middle, 0.0) * widest
    result[-1] = length
    return result
