"""Partial slip from a second normal contact at a reduced load.

Ciavarella (1998) and Jäger (1998): for equal bodies under P = const and Q rising to its
amplitude, the shear traction is µ (p − p*), where p* is the normal pressure of the same shape at
the load P* = P − Q/µ. The contact of that problem is the stick zone, its gap g* gives the slip
s = µκ g*, κ = E*/G*.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fretwear.mechanics.arrays import Array, Mask
from fretwear.mechanics.contact import solve_contact
from fretwear.mechanics.contact_problem import ContactProblem
from fretwear.mechanics.halfspace import HalfSpace
from fretwear.mechanics.layers import Layer, WearLayer, WinklerLayer
from fretwear.mechanics.window import Window
from fretwear.theory import HertzContact

_FIRST_TOLERANCE = 1e-8
_TOLERANCE = 1e-7
_COARSE = 1e-2
_MARGIN = 4


@dataclass(frozen=True)
class ReducedContact:
    """The normal contact at the reduced load P*.

    Attributes
    ----------
    pressure, gap
        p*, Pa, and g*, m, shape of the window; the gap is exactly zero in the stick zone.
    approach
        δ*, m.
    convolutions
        Half-space convolutions spent on it, most of them on a smaller window.
    """

    pressure: Array
    gap: Array
    approach: float
    convolutions: int = 0

    @property
    def stick(self) -> Mask:
        """Cells of the stick zone."""
        result: Mask = self.pressure > 0
        return result


@dataclass(frozen=True)
class Friction:
    """Coulomb friction of elastically similar bodies.

    Parameters
    ----------
    coefficient
        µ.
    coupling
        κ = E*/G*.
    """

    coefficient: float
    coupling: float

    def shear_traction(self, pressure: Array, reduced: ReducedContact) -> Array:
        """Traction along x at +Q, Pa: µ p in the slip zone, µ (p − p*) in the stick zone."""
        return self.coefficient * (pressure - reduced.pressure)

    def slip(self, reduced: ReducedContact) -> Array:
        """Slip amplitude from 0 to Q, m: s = µκ g*; a whole cycle travels 4 s."""
        return self.coefficient * self.coupling * reduced.gap

    def tangential_displacement(self, approach: float, reduced: ReducedContact) -> float:
        """Relative displacement of distant points along x at +Q, m: µκ (δ − δ*)."""
        return self.coefficient * self.coupling * (approach - reduced.approach)

    def dissipated_energy(self, window: Window, pressure: Array, reduced: ReducedContact) -> float:
        """Energy that one cycle dissipates in the contact, J: D = ∬ 4 µ p s dA."""
        slip = self.slip(reduced)
        return 4.0 * self.coefficient * window.integral(pressure * slip)


class SlipModel(Protocol):
    """How slip follows from the contact, and how wear follows from slip within a step."""

    @property
    def follows_shape(self) -> bool:
        """Whether plastic flow of the shape changes the reduced contact."""
        ...

    def reduced(
        self, half_space: HalfSpace, shape: Array, start: Array | None = None, slack: float = 1.0
    ) -> ReducedContact:
        """The reduced contact of a shape, m.

        ``start`` is a guess of its pressure, Pa, ``slack`` the tolerance in units of the usual one.
        """
        ...

    def wear_layer(
        self, wear: Array, gap: Array, shift: Array | None, exponent: Array, rate: float
    ) -> Layer:
        """Wear depth at the end of a stage against pressure; see `WearLayer`."""
        ...

    def gap_after(self, gap: Array, wear: Array) -> Array:
        """g*, m, after wear by ``wear``, m, outside the stick zone and no plastic flow."""
        ...


@dataclass(frozen=True)
class JaegerSlip:
    """Slip of the current shape from the reduced-load problem.

    Parameters
    ----------
    load
        P* = P − Q/µ, N.
    """

    load: float
    follows_shape: bool = True

    def reduced(
        self, half_space: HalfSpace, shape: Array, start: Array | None = None, slack: float = 1.0
    ) -> ReducedContact:
        """Solve the normal contact of the shape at the reduced load.

        The stick zone is smaller than the contact: the problem is solved on a window that holds
        the start and a margin, and again on a larger one if the zone wants to leave it.
        """
        window = half_space.window
        convolutions, tolerance = 0, slack * _TOLERANCE
        if start is None:
            # An elastic run solves this once and lives on it for ever.
            tolerance = _FIRST_TOLERANCE
            problem = ContactProblem(half_space, shape, self.load)
            coarse = solve_contact(problem, None, _COARSE, verified=False)
            start, convolutions = coarse.pressure, coarse.convolutions
        held: Mask = start > 0
        while True:
            part = half_space.part(window.holding(held, _MARGIN))
            size = part.window.shape
            problem = ContactProblem(part, window.resized(shape, size), self.load)
            contact = solve_contact(problem, window.resized(start, size), tolerance, verified=False)
            pressure = part.window.resized(contact.pressure, window.shape)
            # The gap on the whole window comes from a convolution of its own; one in single
            # precision is good enough beyond the part if the contact itself need not be better.
            passing = slack > 1.0
            displace = half_space.displacement_in_single if passing else half_space.displacement
            gap = displace(pressure) + shape - contact.approach
            if passing:
                gap[window.part(size)] = contact.gap
            convolutions += contact.convolutions + 1
            missed = (gap < 0) & ~part.window.covered(window.shape)
            if not missed.any():
                break
            held, start = held | missed, pressure
        # Noise in the stick zone would grow with wear like exp(β∫p dN): zero means zero.
        gap = np.where(pressure > 0, 0.0, np.maximum(gap, 0.0))
        return ReducedContact(pressure, gap, contact.approach, convolutions)

    def wear_layer(
        self, wear: Array, gap: Array, shift: Array | None, exponent: Array, rate: float
    ) -> Layer:
        """Wear grows exponentially: what is worn off adds to g* and so to the slip."""
        return WearLayer(wear, gap, shift, exponent, rate)

    def gap_after(self, gap: Array, wear: Array) -> Array:
        """Wear outside the stick zone leaves p* and δ* as they are and adds to g*."""
        return gap + wear


@dataclass(frozen=True)
class CattaneoMindlinSlip:
    """Slip of the unworn smooth sphere, whatever the shape: the model of simpler studies.

    Stick is a disc of the radius c = a (1 − Q/µP)^(1/3) for ever, slip the closed form of
    Hertzian contact; both ignore wear and roughness.

    Parameters
    ----------
    hertz
        Contact of the smooth sphere at the reduced load P* = P − Q/µ; its radius is c.
    """

    hertz: HertzContact
    follows_shape: bool = False

    def reduced(
        self,
        half_space: HalfSpace,
        shape: Array,  # noqa: ARG002 - the model does not look at the shape
        start: Array | None = None,  # noqa: ARG002
        slack: float = 1.0,  # noqa: ARG002
    ) -> ReducedContact:
        """Hertz pressure and gap of the disc of radius c."""
        window = half_space.window
        r = np.hypot(*np.meshgrid(window.x, window.y, indexing="ij"))
        return ReducedContact(self.hertz.pressure(r), self.hertz.gap(r), self.hertz.approach)

    def wear_layer(
        self,
        wear: Array,
        gap: Array,
        shift: Array | None,  # noqa: ARG002 - the reduced contact never shifts
        exponent: Array,
        rate: float,
    ) -> Layer:
        """Wear in proportion to ∫p dN, because slip is constant."""
        return WinklerLayer(rate * gap, wear + exponent * gap)

    def gap_after(self, gap: Array, wear: Array) -> Array:  # noqa: ARG002
        """Slip never changes."""
        return gap
