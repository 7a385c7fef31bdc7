"""The implicit stages of a wear step: each one contact, or a few where the bodies yield.

A stage asks for the pressure whose wear gives the shape that carries it: one normal contact with
a `fretwear.mechanics.layers.WearLayer`. Where the pressure is at its limit the surface sinks by
the penetration of that contact. This changes the contact at the reduced load, which is solved
again on the stage's own shape, in turn with the contact itself, until the wear is settled.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from fretwear.mechanics.arrays import Array, is_finite
from fretwear.mechanics.contact import Contact, ContactError, solve_contact
from fretwear.mechanics.contact_problem import ContactProblem
from fretwear.mechanics.layers import Layer
from fretwear.mechanics.slip import ReducedContact
from fretwear.mechanics.state import CONTACT_TOLERANCE, State, WearProblem
from fretwear.mechanics.window import Window

_LARGEST_SWEEPS = 12
_SWEEP_TOLERANCE = 0.005
# Of the reduced contact between the requested cycles: its error moves wear by less than a part
# in 10⁷.
_PASSING_SLACK = 10.0


@dataclass(frozen=True)
class Stage:
    """The contact at the end of a stage, consistent in itself.

    Attributes
    ----------
    pressure, gap, wear, plastic
        p, Pa; gap, wear depth and plastic depth, m; shape of the window.
    approach
        δ, m.
    residual
        Of the contact, see `fretwear.mechanics.contact.Contact`.
    reduced
        The contact at the reduced load on this stage's shape.
    yielded
        Whether plastic flow in this stage changed the reduced contact.
    """

    pressure: Array
    gap: Array
    wear: Array
    plastic: Array
    approach: float
    residual: float
    reduced: ReducedContact
    yielded: bool = False

    @classmethod
    def of(cls, state: State) -> Stage:
        """The state that a step starts from."""
        return cls(
            pressure=state.pressure,
            gap=state.gap,
            wear=state.wear,
            plastic=state.plastic,
            approach=state.approach,
            residual=state.residual,
            reduced=state.reduced,
            yielded=state.yielded,
        )

    @property
    def is_finite(self) -> bool:
        """Whether every field is finite everywhere."""
        fields = (self.pressure, self.gap, self.wear, self.plastic, self.reduced.gap)
        return all(is_finite(each) for each in fields)

    @property
    def source(self) -> Array:
        """G = g* − W, m: changes by plastic flow only."""
        result: Array = self.reduced.gap - self.wear
        return result


class StageSolver:
    """Solves stages on one window.

    Parameters
    ----------
    problem
        What is worn.
    window
        Where.
    tolerance
        Of the wear of a step, relative to the wear volume.

    Attributes
    ----------
    bodies
        The half-space of the window.
    convolutions
        Spent so far.
    """

    def __init__(self, problem: WearProblem, window: Window, tolerance: float) -> None:
        self.problem = problem
        self.window = window
        self.tolerance = tolerance
        self.convolutions = 0
        self.bodies = problem.half_space(window)
        self._unworn = problem.surface.shape(window)

    def solve(
        self,
        base: Stage,
        known: Array,
        rate: float,
        start: Array,
        guess: Array,
        slack: float = 1.0,
        *,
        seen: bool = True,
    ) -> Stage:
        """One implicit stage.

        Parameters
        ----------
        base
            Where it starts.
        known, rate
            The stage's exponent is x = known + rate · p with its pressure p, Pa.
        start
            First guess of the pressure, Pa.
        guess
            First guess of the change of G by plastic flow, m.
        slack
            Tolerance of the contact in units of that of a state.
        seen
            Whether the stage ends at a requested cycle: only there the reduced contact is solved
            to the last digit, and the residual is computed by a convolution of its own.

        Raises
        ------
        ContactError
            If a contact does not converge, flow and wear do not settle, or a value is not finite.
        """
        model, window = self.problem.slip_model, self.window
        reduced = base.reduced
        shift = guess if base.yielded else None
        relaxation, before = 1.0, inf
        for _ in range(_LARGEST_SWEEPS):
            layer = model.wear_layer(base.wear, base.reduced.gap, shift, known, rate)
            contact = self._contact(base.plastic, layer, start, slack, verified=seen)
            start = contact.pressure
            wear, gap = layer.displacement(start), np.maximum(contact.gap, 0.0)
            worn = wear - base.wear
            overshoot = _overshoot(contact, worn)
            if overshoot is not None:
                for field in (wear, worn, gap):
                    field -= overshoot
            plastic, yielded = base.plastic, False
            if contact.yields:
                plastic = plastic + contact.penetration
                yielded = model.follows_shape
            if yielded:
                reduced = model.reduced(
                    self.bodies,
                    self._unworn + wear + plastic,
                    reduced.pressure,
                    1.0 if seen else _PASSING_SLACK,
                )
                self.convolutions += reduced.convolutions
            else:
                reduced_gap = model.gap_after(base.reduced.gap, worn)
                reduced = replace(base.reduced, gap=reduced_gap)
            stage = Stage(
                pressure=start,
                gap=gap,
                wear=wear,
                plastic=plastic,
                approach=contact.approach,
                residual=contact.residual,
                reduced=reduced,
                yielded=yielded,
            )
            if not yielded and shift is None:
                break
            missing = stage.source - base.source
            if shift is not None:
                missing -= shift
            change = window.integral(np.abs(missing) * np.expm1(known + rate * start))
            if change <= _SWEEP_TOLERANCE * self.tolerance * window.integral(wear):
                break
            if change > 0.5 * before:
                # Flow lets wear catch up, and that stops the flow: meet in the middle.
                relaxation = max(0.5 * relaxation, 0.1)
            before = change
            shift = missing if shift is None else shift + relaxation * missing
        else:
            raise ContactError(
                f"plastic flow and wear of a stage did not settle in {_LARGEST_SWEEPS} sweeps"
            )
        if not stage.is_finite:
            raise ContactError("wear of a stage leads to values that are not finite")
        return stage

    def _contact(
        self, plastic: Array, layer: Layer, start: Array, slack: float, *, verified: bool
    ) -> Contact:
        problem = ContactProblem(
            self.bodies, self._unworn + plastic, self.problem.load, self.problem.limit, layer
        )
        try:
            contact = solve_contact(problem, start, slack * CONTACT_TOLERANCE, verified=verified)
        except ContactError as error:
            self.convolutions += error.convolutions
            raise
        self.convolutions += contact.convolutions
        return contact


def _overshoot(contact: Contact, wear: Array) -> Array | None:
    """What a long step removes, m, after a cell has lost its pressure; None if there is no such.

    Wear needs pressure, so it cannot open a gap: an open cell that wore in this stage touches.
    """
    lost = (contact.pressure <= 0) & (wear > 0)
    if not lost.any():
        return None
    result: Array = np.where(lost, np.minimum(contact.gap, wear), 0.0)
    return np.maximum(result, 0.0, out=result)
