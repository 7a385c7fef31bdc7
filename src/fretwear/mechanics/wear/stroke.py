"""Contacts in gross sliding, over a stroke that need not be small against the contact.

Each point of a body meets different points of the other body in the course of a stroke, and the
wear of the indenter moves with it. So a stroke is a series of contacts, one for each of several
positions ξ of the indenter, of the shape

    h(x, ξ) = h₀(x − ξ) + w₁(x − ξ) + w₂(x),   dw₁/dN = 4sK₁ ⟨p(X + ξ, ξ)⟩,
                                                 dw₂/dN = 4sK₂ ⟨p(x, ξ)⟩,

where ⟨⟩ is the mean over the stroke from −s to s, and 4s the path of a cycle. Both directions and
both sides are equivalent, so half of the positions suffice; the contact at each is even along y
only. A load in phase with the motion is a function of the position, P(ξ) = P (1 + r)/2 + P (1 −
r)/2 · ξ/s: directions are still equivalent, but sides and the two halves of a scar are not.

The contacts of a stage at all positions are one problem, `fretwear.mechanics.wear.rubbing`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import ceil, inf, nan
from typing import Self

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.grid import fast_shape
from fretwear.mechanics.contact.problem import ContactError
from fretwear.mechanics.slip.models import ReducedContact
from fretwear.mechanics.surfaces.coating import Interface
from fretwear.mechanics.surfaces.laws import Means
from fretwear.mechanics.surfaces.setup import Setup
from fretwear.mechanics.wear import integrator
from fretwear.mechanics.wear.integrator import TOLERANCE, TR_BDF2, Integrator
from fretwear.mechanics.wear.rubbing import Contacts, Rubbing, positions
from fretwear.mechanics.wear.state import State, WearProblem, Workspace

# Cells between a contact and the border, and the factor by which they grow.
_MARGIN, _GROWTH = 6, 1.2
_FIRST_STEP = 0.1
# Largest number of passes over the stroke in which bodies sink during a loading.
_LARGEST_PASSES = 20
# Largest number of contacts of a stage in which places change the side of an interface.
_LARGEST_SIDES = 20


@dataclass(frozen=True, kw_only=True)
class StrokeState(State):
    """A state of a contact in gross sliding.

    Pressure, gap, approach and load are those in the middle of the stroke; wear is the sum of both
    bodies there.
    """

    #: Wear depth of the flat and of the indenter, each in its own coordinates, m, on the cells of
    #: the geometry, shape (2, n, m).
    worn: Array
    #: Wear depth of each body in this one cycle, m; of a flat as if no substrate were exposed.
    rates: Array
    sunk: Array  #: plastic depth of each body, m
    #: Pressure at each position, Pa, on cells of either side along x, shape (positions, nx, m).
    pressures: Array

    @property
    def wear_indenter(self) -> Array:
        """Wear depth of the indenter in its own coordinates, m."""
        return np.asarray(self.worn[1])

    @property
    def wear_flat(self) -> Array:
        """Wear depth of the flat, m."""
        return np.asarray(self.worn[0])

    def wear_of_each(self, setup: Setup) -> dict[str, Array]:
        """Wear depth of indenter and flat, in coordinates of their own, m, if known."""
        if not setup.wear_law.is_of_each:
            return {}
        return {"indenter": self.wear_indenter, "flat": self.wear_flat}

    def flat_wear(self, interface: Interface) -> Array:
        """Wear depth of a coated flat, m."""
        return self.wear_flat

    def rate(self, interface: Interface | None) -> Array:
        """Wear depth of both bodies in this one cycle, m, each in its coordinates."""
        exposed = 1.0 if interface is None else interface.alone.slope(self.wear_flat)
        return np.asarray(exposed * self.rates[0] + self.rates[1])

    def on(self, workspace: Workspace, geometry: Geometry) -> Self:
        """The same state on more cells; its gap is computed on cells that are new."""
        old = self.geometry
        if geometry.shape == old.shape:
            return self
        moved = super().on(workspace, geometry)
        zeros = np.zeros(geometry.shape)
        more, rows = np.subtract(geometry.shape, old.shape)
        more = more * self.pressures.shape[1] // old.shape[0] // 2
        return replace(
            moved,
            reduced=replace(self.reduced, pressure=zeros, gap=zeros + self.reduced.gap[0, 0]),
            pressures=np.pad(self.pressures, ((0, 0), (more, more), (0, rows))),
            convolutions=self.convolutions,
            worn=np.stack([old.resized(field, geometry) for field in self.worn]),
            rates=np.stack([old.resized(field, geometry) for field in self.rates]),
            sunk=np.stack([old.resized(field, geometry) for field in self.sunk]),
        )


def slide(
    problem: WearProblem,
    stops: Sequence[float],
    tolerance: float = TOLERANCE,
    start: StrokeState | None = None,
) -> Iterator[StrokeState]:
    """Integrate the wear of both bodies over the cycles; parameters and errors as for `evolve`."""
    return integrator.march(problem, stops, start, partial(_Slider, tolerance=tolerance))


class _Slider(Integrator[StrokeState]):
    """The steps of a contact in gross sliding; of two bodies, the flat comes first."""

    def __init__(self, problem: WearProblem, state: StrokeState | None, tolerance: float) -> None:
        super().__init__(problem, state, tolerance)
        # Fraction of the wear that opens the gap: all but the debris.
        self.opens = 1.0 - problem.debris_fraction
        #: of coating and substrate, by the wear of the flat alone
        self.interface = None if problem.interface is None else problem.interface.alone
        if state is not None:
            self._resize(*state.geometry.shape)

    def _resize(self, x: int, y: int) -> None:
        """Use so many cells, or more if both sides along x are computed; move the state to them."""
        if not self.problem.even[0]:
            ends = 0.5 * x * self.problem.spacing[0], y * self.problem.spacing[1]
            x, fast = fast_shape(ends, self.problem.spacing, self.problem.even)
            y = fast if y > 1 else 1
        self.rubbing = Rubbing(self.problem, (x, y))
        if self.previous is not None:
            self.state = self.state.on(self.workspace, self.rubbing.geometry)

    def _outgrown(self, contacts: Contacts) -> bool:
        """Add cells if the contacts come near the border; return whether they did."""
        touched, (x, y) = contacts.pressures > 0, self.rubbing.geometry.shape
        wider = bool(touched[:, :_MARGIN].any() or touched[:, -_MARGIN:].any())
        higher = y > 1 and bool(touched[:, :, -_MARGIN:].any())
        if wider or higher:
            self._resize(ceil(_GROWTH * x) if wider else x, ceil(_GROWTH * y) if higher else y)
        return wider or higher

    def settling(self) -> float:
        """As in the base class: wear deepens a cell by what its pressure displaces it."""
        growth = self.opens * float(self.rates(self.state.cycle).max(axis=(1, 2)).sum())
        return self.rubbing.self_influence / growth if growth > 0 else inf

    def load(self) -> None:
        """Load the bodies anew."""
        problem, hertz = self.problem, self.problem.hertz
        x, y = (0, 0) if self.previous is None else self.previous.geometry.shape
        reach = problem.extent[0] + float(positions(problem)[0][-1])
        sides = 1 if problem.even[0] else 2
        x = max(x, sides * (ceil(reach / problem.spacing[0]) + 2 * _MARGIN))
        y = max(y, ceil(problem.extent[1] / problem.spacing[1]) + 2 * _MARGIN)
        self._resize(x, 1 if problem.geometry.plane_strain else y)
        wide, high = problem.indenter.half_widths(hertz)
        cycle, step = getattr(self.previous, "cycle", 0.0), getattr(self.previous, "step", 0)
        while True:
            rubbing, previous = self.rubbing, self.previous
            distance = rubbing.x[:, None] - rubbing.places[:, None, None]
            touching = (distance / wide) ** 2 + (rubbing.y / high) ** 2 < 1.0
            start = touching.astype(np.float64)
            worn, sunk = np.zeros((2, 2, *rubbing.geometry.shape))
            if previous is not None:
                start = np.maximum(start, (previous.pressures > 0).any(axis=0))
                worn, sunk = previous.worn, previous.sunk
            rigid, change = np.zeros((2, 1, 1)), inf
            contacts = self._contacts(cycle, worn, sunk, rigid, start)
            # Cells that sink at one position carry less at others, which sink more in the next
            # pass. Depths only grow and are bounded, so this ends.
            for _ in range(_LARGEST_PASSES):
                if self._outgrown(contacts) or change <= self.tolerance or not contacts.flow.any():
                    break
                sunk, means, start = sunk + contacts.flow, contacts.means, contacts.pressures
                contacts = self._contacts(cycle, worn, sunk, rigid, start)
                change = float(np.abs(contacts.means - means).sum() / means.sum())
            else:
                raise ContactError(
                    f"plastic flow of the first strokes did not settle in {_LARGEST_PASSES}: the "
                    f"last one changed pressures by {change:.1e} instead of {self.tolerance:.0e}"
                )
            if rubbing is self.rubbing:
                break
        growth = self.opens * self.rates(cycle).max(axis=(1, 2)).sum() * hertz.peak_pressure
        first = _FIRST_STEP * hertz.peak_pressure * rubbing.self_influence
        if problem.interface is not None:
            first = problem.interface.exposure(first)
        first = first / growth if growth > 0 else inf
        state = self._state(cycle, step, contacts, worn, sunk + contacts.flow)
        through = getattr(self.previous, "worn_through", nan)
        self.state = replace(state, next_step=first, worn_through=through)

    def _contacts(
        self, cycle: float, worn: Array, sunk: Array, compliance: Array, start: Array
    ) -> Contacts:
        """The contacts at a cycle; see `Rubbing.solve`."""
        self.rubbing.limit = self.problem.at(cycle).slip_limit
        return self.rubbing.solve(self.opens * worn + sunk, compliance, start)

    def _over_substrate(
        self, cycle: float, worn: Array, sunk: Array, compliance: Array, start: Array
    ) -> Contacts:
        """The contacts of a stage, its points on the side of the interface to which they wear.

        Depth and compliance are of a flat on which no substrate is exposed.
        """
        base, interface = self.state.worn[0], self.interface
        if interface is None or interface.ratio == 1.0:
            return self._contacts(cycle, worn, sunk, compliance, start)
        left = np.where(interface.reached(base), 0.0, interface.depth - base)
        compliance = np.array(np.broadcast_to(compliance, worn.shape))
        # All debris kept: the contact does not depend on the wear.
        of_flat = compliance[0] / (self.opens or 1.0)
        below = worn[0] - base + of_flat * self.rubbing.means_of_flat(start, worn.shape) > left
        for _ in range(_LARGEST_SIDES):
            slope, reached = np.ones(worn.shape), worn.copy()
            slope[0][below] = interface.ratio
            reached[0][below] = (base + left + interface.ratio * (worn[0] - base - left))[below]
            contacts = self._contacts(cycle, reached, sunk, slope * compliance, start)
            now = worn[0] - base + of_flat * contacts.means[0] > left
            if np.array_equal(now, below):
                return contacts
            below, start = now, contacts.pressures
        raise ContactError(
            f"the places that a stroke wears through did not settle in {_LARGEST_SIDES} contacts"
        )

    def rates(self, cycle: float, means: Means | None = None) -> Array:
        """Wear depth of both bodies per mean pressure and cycle, m/Pa.

        The shape is (2, 1, 1), or the wear's where the coefficient depends on the place.
        """
        problem = self.problem.at(cycle)
        problem = problem.under(problem.unworn_means if means is None else means)
        wears = (1.0, 0.0) if problem.coating is None else (0.0, 1.0)
        shares = np.array(problem.surface_law.shares or wears)[::-1, None, None]
        rates = np.asarray(
            4.0 * problem.loading.stroke * problem.combined_wear_coefficient * shares
        )
        zones = problem.wear_law.zones
        return rates if zones is None else rates * zones.factors(self.rubbing.geometry)

    def means(self, cycle: float, pressures: Array) -> Means:
        """Means of the contacts at all positions, on which coefficients of wear may depend."""
        problem, rubbing = self.problem.at(cycle), self.rubbing
        if not problem.wear_law.follows_contact:
            return Means()
        touched = float(rubbing.weights @ (pressures > 0).sum(axis=(1, 2)))
        area = 2.0 / rubbing.sides * rubbing.area * touched
        load, stroke = problem.load_at(0.0), problem.loading.stroke
        force = problem.friction_law.coefficient * load
        wide, high = rubbing.half_widths(pressures)
        return Means(4.0 * force * stroke / area, load / area, stroke, wide, high)

    def attempt(
        self, step: float, end: float, *, output_step: bool
    ) -> integrator.Attempt[StrokeState]:
        """Take both stages, and compare them with the embedded formulas."""
        del output_step
        base = self.state

        def stage(
            cycle: float, explicit: Array, sunk: Array, rates: Array, start: Array
        ) -> Contacts:
            compliance = self.opens * TR_BDF2.implicit * step * rates
            return self._over_substrate(cycle, explicit, sunk, compliance, start)

        middle, started = base.cycle + TR_BDF2.middle * step, base.rates
        # The means that the wear coefficient follows are those of the stage before.
        means = self.means(base.cycle, base.pressures)
        explicit = base.worn + TR_BDF2.implicit * step * started
        first = stage(middle, explicit, base.sunk, self.rates(middle, means), base.pressures)
        reached = self.means(middle, first.pressures)
        halfway = self.rates(middle, reached) * first.means
        sunk = base.sunk + first.flow
        explicit = base.worn + TR_BDF2.explicit * step * (started + halfway)
        rates = self.rates(end, reached.ahead(means, TR_BDF2.ratio))
        last = stage(end, explicit, sunk, rates, first.pressures)
        if self._outgrown(last):
            return None
        ended = rates * last.means
        worn, missed = (
            np.asarray(step * (a * started + b * halfway + c * ended))
            for a, b, c in (TR_BDF2.weights, TR_BDF2.difference)
        )
        worn = base.worn + worn
        allowed = integrator.OVERESTIMATE * integrator.GLIDING * self.tolerance
        if (interface := self.interface) is not None and interface.ratio != 1.0:
            worn[0] = interface.deepened(base.worn[0], worn[0] - base.worn[0])
            slope = interface.slope(worn[0])
            growth = self.opens * slope * rates[0] * step / self.rubbing.self_influence
            missed[0] *= slope * integrator.left_where_bare(interface, worn[0], growth)
        error = float(np.abs(missed).sum() / max(worn.sum(), np.finfo(float).tiny)) / allowed
        state = self._state(end, base.step + 1, last, worn, sunk + last.flow)
        state = replace(state, error_estimate=error * self.tolerance)
        return state, *integrator.assessed(error)

    def left_of_coating(self, state: StrokeState) -> float:
        """As in the base class, by the wear of the flat alone."""
        interface = self.interface
        return inf if interface is None else interface.cycles_left(state.worn[0], state.rates[0])

    def _state(
        self, cycle: float, step: int, contacts: Contacts, worn: Array, sunk: Array
    ) -> StrokeState:
        """The state with the contact in the middle of the stroke."""
        problem, geometry = self.problem.at(cycle), self.rubbing.geometry
        bodies = self.workspace.on(geometry)
        opening, plastic = self.opens * worn.sum(axis=0), sunk.sum(axis=0)
        middle = contacts.pressures[np.abs(self.rubbing.places).argmin(), -geometry.shape[0] :]
        separation = bodies.half_space.displacement(middle) + bodies.unworn + opening + plastic
        free = (middle > 0) & (middle < problem.slip_limit)
        approach = float(separation[free].mean())
        gap = separation - approach
        residual = np.abs(np.where(free, gap, np.minimum(gap, 0.0))).max() / approach
        slip = problem.loading.stroke / (problem.friction_law.coefficient * problem.coupling)
        zeros = np.zeros(geometry.shape)
        reduced = ReducedContact(zeros, np.full(geometry.shape, slip), approach - slip, load=0.0)
        rates = self.rates(cycle, self.means(cycle, contacts.pressures))
        return StrokeState(
            cycle=cycle,
            next_step=0.0,
            geometry=geometry,
            pressure=middle,
            gap=np.where(middle > 0, 0.0, np.maximum(gap, 0.0)),
            wear=worn.sum(axis=0),
            opening=opening,
            plastic=plastic,
            load=problem.load_at(0.0),
            approach=approach,
            residual=float(residual),
            reduced=reduced,
            pressure_rate=zeros,
            source_rate=zeros,
            step=step,
            worn=worn,
            rates=rates * contacts.means,
            sunk=sunk,
            pressures=contacts.pressures,
        )
