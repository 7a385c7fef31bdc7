"""Partial slip under a load that changes in phase with the tangential force.

Load and force follow a straight line between (P₁, −Q) and (P₂, Q) and back. If the force changes
faster than µ times the load, Q > µ (P₂ − P₁)/2, the contact of the load P₀ = (P₁ + P₂)/2 − Q/µ
always sticks (Jäger 1998; Barber, Davies and Hills, "Frictional elastic contact with periodic
loading", Int. J. Solids Struct. 48, 2011). While the load P rises, the traction changes by µ [p(P)
+ p(P₁) − 2p(P′)], with P′ falling in proportion from P₁ to P₀; while it falls again, by µ [p(P) +
p(P₂) − 2p(P″)] in the other direction, with P″ falling from P₂ to P₀. Points in contact slip by 2µκ
dg(P′) and by 2µκ dg(P″). So one cycle wears

    Δw = 2Kµκ [∫p(P) dg(P′) + ∫p(P) dg(P″)] = β p̄ g(P₀)

with a mean p̄ of the pressure over the slip of a point. Wear outside the contact of P₀ leaves that
contact unchanged, as under a constant load, and adds to g(P₀).

A stage is the contact under P₂. A depth worn evenly in all contacts of a point lowers their
pressures alike, so p̄ = ω p(P₂) − q with the share ω of the slip in contact and an offset q. Both
are taken from the stage before; the stiff part is implicit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf

import numpy as np

from fretwear.arrays import Array, Single
from fretwear.mechanics.contact.cells import HalfSpace
from fretwear.mechanics.contact.problem import Layer, solve_contact
from fretwear.mechanics.slip.models import ReducedContact, contact_under
from fretwear.mechanics.wear.integrator import (
    OVERESTIMATE,
    TOLERANCE,
    TR_BDF2,
    Attempt,
    Evolution,
    assessed,
    march,
)
from fretwear.mechanics.wear.stage import all_worn
from fretwear.mechanics.wear.state import Pulse, Stage, State, WearProblem
from fretwear.mechanics.wear.window import holding_cells

# Contacts solved between P₀ and P₁, and between P₁ and P₂; phases of half a cycle.
_BELOW, _ABOVE, _PHASES = 5, 6, 96


def load_cycle(
    problem: WearProblem, half_space: HalfSpace, shape: Array, stage: Stage, tolerance: float
) -> Pulse:
    """The cycle of a shape, m, from its contacts under some loads from P₀ to P₂.

    Between two loads, the squared pressure and the power 2/3 of the gap change linearly in P^(2/3)
    or, in a line contact, in P, as at the edge of a smooth contact. From the ends of these contacts
    follows the load under which each cell touches.
    """
    geometry, low, high = half_space.geometry, stage.reduced, stage.load
    least = problem.load_at(-1.0)
    steps = np.linspace(high, least, _ABOVE + 1)[1:], np.linspace(least, low.load, _BELOW + 1)[1:-1]
    family = [ReducedContact(stage.pressure, stage.gap, stage.approach, high)]
    for load in np.concatenate(steps):
        guess = family[-1].pressure
        family.append(contact_under(half_space, shape, float(load), None, guess, tolerance))
    family = [low, *family[::-1]]
    loads = np.array([contact.load for contact in family])
    power = 1.0 if geometry.plane_strain else 2.0 / 3.0
    nodes = loads**power
    pressure, gap = (
        np.stack([getattr(contact, name)[:, 0] for contact in family])
        for name in ("pressure", "gap")
    )
    touching = pressure > 0.0
    # A cell first touches after the contacts that are narrower.
    first, cells = (~touching).sum(axis=0), np.arange(touching.shape[1])
    ends = touching.sum(axis=1)
    limit = np.interp(cells + 0.5, ends, nodes)
    edge = np.flatnonzero((first > 0) & (first < len(family)))
    inner, outer = first[edge], first[edge] - 1
    square, power_of_gap = pressure**2, gap ** (2.0 / 3.0)
    rest = np.maximum(limit[edge] - nodes[outer], 1e-9 * nodes[inner])
    part = (nodes[inner] - limit[edge]) / rest
    square[outer, edge] = -square[inner, edge] / np.maximum(part, 1e-9)
    power_of_gap[inner, edge] = -power_of_gap[outer, edge] * part

    def interpolated(values: Array, load: Array) -> Array:
        place = load**power
        index = np.clip(np.searchsorted(nodes, place, "right") - 1, 0, nodes.size - 2)
        share = ((place - nodes[index]) / np.diff(nodes)[index])[:, None]
        return np.maximum((1.0 - share) * values[index] + share * values[index + 1], 0.0)

    phase = np.linspace(0.0, 1.0, _PHASES + 1)
    loaded = np.sqrt(interpolated(square, least + (high - least) * phase))
    weights = np.zeros_like(loaded)
    for start, way in ((least, slice(None)), (high, slice(None, None, -1))):
        gaps = interpolated(power_of_gap, start + (low.load - start) * phase)[way] ** 1.5
        slips = 0.5 * np.abs(np.diff(gaps, axis=0))
        weights[:-1] += slips
        weights[1:] += slips
    doubled = np.maximum(2.0 * low.gap[:, 0], np.finfo(float).tiny)
    return Pulse(
        path=2.0
        * problem.friction_law.coefficient
        * problem.coupling
        * (weights * loaded).sum(axis=0)[:, None],
        share=((weights * (loaded > 0.0)).sum(axis=0) / doubled)[:, None],
        least=loaded[0][:, None],
        least_load=least,
        loads=loads,
        approaches=np.array([contact.approach for contact in family]),
        power=power,
    )


@dataclass(frozen=True)
class _Layer(Layer):
    """Opening by wear at the end of a stage, W = W₀ + (eˣ − 1) g with x = x₀ + τ p of each cell."""

    opening: Array  # W₀, m
    gap: Array  # g at the start of the stage, m
    unloaded: Array  # x₀
    rate: Array  # τ, 1/Pa

    def exponent(self, pressure: Array) -> Array:
        return np.maximum(self.unloaded + self.rate * pressure, 0.0)

    def add_displacement(self, pressure: Array, result: Array) -> None:
        result += self.opening + np.expm1(self.exponent(pressure)) * self.gap

    def scaled_tangent(self, unit: float, pressure: Array) -> Single:
        exponent = self.exponent(pressure)
        slope = np.where(exponent > 0.0, self.rate * np.exp(exponent) * self.gap, 0.0)
        return (slope / unit).astype(np.float32)


def evolve_pulsating(
    problem: WearProblem,
    stops: Sequence[float],
    tolerance: float = TOLERANCE,
    start: State | None = None,
) -> Iterator[State]:
    """Integrate wear under a pulsating load; parameters and errors as for `evolve`."""
    return march(problem, stops, start, partial(_PulsatingEvolution, tolerance=tolerance))


class _PulsatingEvolution(Evolution):
    """The steps of partial slip under a pulsating load, on graded cells of elastic bodies."""

    def load(self) -> None:
        """Load the bodies anew."""
        super().load()
        self.state = replace(self.state, pulse=self._pulse(self.state))

    def _pulse(self, stage: Stage) -> Pulse:
        """The cycle of a stage."""
        bodies = self.workspace.on(self.state.geometry)
        shape, tolerance = bodies.unworn + stage.opening, self.accuracy.reduced
        return load_cycle(self.problem, bodies.half_space, shape, stage, tolerance)

    def _mean(self, stage: Stage) -> tuple[Array, Array, Array]:
        """Mean pressure p̄ over the slip of each point, Pa, the share ω and the offset q, Pa."""
        assert stage.pulse is not None
        slip = 4.0 * self.problem.slip(stage.reduced)
        mean = stage.pulse.path / np.maximum(slip, np.finfo(float).tiny)
        return mean, stage.pulse.share, stage.pulse.share * stage.pressure - mean

    def attempt(self, step: float, end: float, *, output_step: bool) -> Attempt[State]:
        """Take both stages, and compare them with the embedded formulas."""
        base, geometry, numbers = self.state, self.state.geometry, TR_BDF2
        rate, ahead = self.problem.wear_growth * step, numbers.ratio
        implicit, weight = numbers.implicit * rate, numbers.explicit * rate
        e0, share, offset = self._mean(base)
        guess = base.pressure + numbers.middle * step * base.pressure_rate
        first, lagged = self._stage(base, implicit * e0, implicit, share, offset, guess)
        e1, then, since = self._mean(first)
        second, expected = self._stage(
            first,
            weight * (e0 + e1) - implicit * (e0 + lagged),
            implicit,
            np.clip(then + ahead * (then - share), 0.0, 1.0),
            since + ahead * (since - offset),
            first.pressure + ahead * (first.pressure - base.pressure),
            verified=output_step,
        )
        fitting = holding_cells(geometry, self.workspace, second.pressure, second.approach)
        if fitting is not geometry:
            self._move_to(fitting)
            return None
        e2, *_ = self._mean(second)
        missed = sum(d * e for d, e in zip(numbers.difference, (e0, e1, e2), strict=True))
        lost = max(
            geometry.integral(np.abs(exponent * second.reduced.gap))
            for exponent in (rate * np.asarray(missed), implicit * (e2 - expected))
        )
        error = lost / (OVERESTIMATE * geometry.integral(second.wear) or inf)
        state = State(
            **vars(second),
            cycle=end,
            geometry=geometry,
            next_step=step,
            pressure_rate=(second.pressure - first.pressure) / ((1.0 - numbers.middle) * step),
            source_rate=np.zeros_like(second.pressure),
            step=base.step + 1,
            error_estimate=error,
            convolutions=base.convolutions,
        )
        return state, *assessed(error / self.tolerance)

    def _stage(
        self,
        base: Stage,
        unloaded: Array,
        rate: float,
        share: Array,
        offset: Array,
        guess: Array,
        *,
        verified: bool = False,
    ) -> tuple[Stage, Array]:
        """A stage whose exponent is unloaded + rate · (ω p − q), and p̄ at its end, Pa."""
        bodies, problem = self.workspace.on(self.state.geometry), self.problem
        kept = problem.debris_fraction
        unloaded, gap = unloaded - rate * offset, base.reduced.gap
        layer = _Layer(base.opening, gap, (1.0 - kept) * unloaded, (1.0 - kept) * rate * share)
        contact = solve_contact(
            problem.contact(bodies.half_space, bodies.unworn, layer),
            np.maximum(guess, 0.0),
            self.accuracy.contact,
            verified=verified,
        )
        opening = layer.displacement(contact.pressure)
        opened = opening - base.opening
        exponent = np.maximum(unloaded + rate * share * contact.pressure, 0.0)
        reduced = replace(base.reduced, gap=gap + opened)
        stage = Stage(
            pressure=contact.pressure,
            gap=np.maximum(contact.gap, 0.0),
            wear=base.wear + all_worn(kept, opened, gap, reduced.gap, exponent),
            opening=opening,
            plastic=base.plastic,
            load=base.load,
            approach=contact.approach,
            residual=contact.residual,
            reduced=reduced,
        )
        stage = replace(stage, pulse=self._pulse(stage))
        return stage, share * contact.pressure - offset
