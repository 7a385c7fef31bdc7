"""Partial slip from a second normal contact at a reduced load, and the wear that it drives.

Friction along x bears q ≤ µp. The unused friction µp* = µp − q solves a normal contact. A traction
q displaces the surface along x by K_xx q = κ A q (Cerruti), a pressure p normally by K p. The slip
s = µκ g* from zero to the amplitude of the force follows from the gap of that contact,

    g* = A p* + h + (K − A) p − d*,    p* ≥ 0,   g* ≥ 0,   g* p* = 0,

where h is the shape of the surfaces. Under P = const and the amplitude Q it bears the load P* = P −
Q/µ. Distant points pass each other by U = µκ (d − d*). A given U therefore gives the reduced
approach d*; if the lowest point of the shape lies above it, the contact slides as a whole. A bulk
stress that stretches the flat by ε along x, in phase with Q, adds ε x/(µκ) to h, which moves the
stick zone (Hills and Nowell 1994).

A traction moves the surface farther along x than across, so A depends on the direction (`Cerruti`).
Where µ differs between places, µ is replaced by a reference µ_r with ψ = µ/µ_r, the shape of the
reduced contact by h + K p − A(ψp) and its load by ∬ψp − Q/µ_r; the force under which the whole
contact slides is µ_r ∬ψp.

In line contacts and at a Poisson's ratio of zero A = K, and p* is the pressure of the same shape
under the load P*: Ciavarella (1998) and Jäger (1998). `Jaeger` has A = K in all contacts. Traction
along y changes slip in the order of ν²; `Coupled` has it.

The wear of one implicit step is a layer between the bodies: a larger pressure wears a cell deeper.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import sqrt
from typing import ClassVar, Literal, NamedTuple

import numpy as np

from fretwear.arrays import Array, Mask, Single
from fretwear.mechanics.contact.cells import HalfSpace
from fretwear.mechanics.contact.problem import (
    ContactError,
    ContactProblem,
    Layer,
    projected,
    solve_contact,
)
from fretwear.mechanics.slip.coupled import Sheared, shear
from fretwear.mechanics.slip.shear import bodies_under_shear
from fretwear.mechanics.surfaces.coating import Interface
from fretwear.mechanics.surfaces.loading import Sliding
from fretwear.mechanics.surfaces.setup import Setup
from fretwear.quantity import Part
from fretwear.theory import LineContact

# Largest tolerance of a stick zone that vanishes.
_COARSE = 1e-2
# At tolerances of this or more, displacements in single precision suffice.
_SINGLE_IS_ENOUGH = 1e-6
# Residual of shear tractions over the tolerance of a normal contact, and least unused friction in
# the stick zone over the largest.
_RESIDUAL, _TINY = 300.0, 1e-12
# A stick zone less deep than this fraction of the approach counts as none.
_NO_DEPTH = 1e-9
# `WearLayer`: bounds of exponent and tangent, and the exponent below which φ' is a line.
_LARGEST_EXPONENT, _LARGEST_TANGENT, _SMALL_EXPONENT = 200.0, 1e30, 3e-5
# Newton steps to the exponent at which wear reaches an interface, and their end.
_CROSSINGS, _CROSSED = 30, 1e-12


@dataclass(frozen=True)
class ReducedContact:
    """The normal contact at the reduced load P*; if that is zero nothing sticks."""

    pressure: Array  # p*, Pa, shape of the geometry
    gap: Array  # g*, m, exactly zero in the stick zone
    approach: float  # δ*, m
    load: float  # P*, N
    convolutions: int = 0  # half-space convolutions spent, most of them on a smaller window
    # Derivative of g* by the approach of the bodies, where g* depends on it; None if unknown.
    response: Array | None = None
    sheared: Sheared | None = None  # tractions of friction in two directions, if they are computed
    follows_pressure: bool = False  # whether a change of the pressure alone changes g*

    @property
    def stick(self) -> Mask:
        """Cells of the stick zone."""
        return np.asarray(self.pressure > 0)


class Pressed(NamedTuple):
    """The contact under the whole load, and the condition on its reduced contact."""

    half_space: HalfSpace
    shape: Array  #: h, gap at zero load and zero approach, m
    pressure: Array  #: p, Pa
    gap: Array  #: g = h + K p − δ, m
    approach: float  #: δ, m
    sliding: Sliding
    tolerance: float = 1e-8  #: of the reduced contact, as in `solve_contact`


class SlipModel(Part):
    """How slip follows from the contact, and how wear follows from slip within a step.

    A model defines the reduced contact, and whether its shape is the worn one. If so, wear adds to
    g* and so to the slip, and plastic flow changes it. By default slip is constant within a step.
    """

    follows_shape: ClassVar[bool] = False
    #: Whether displacements along x and y are coupled, which breaks rotational symmetry.
    couples: ClassVar[bool] = False
    #: Whether tractions move the surface alike in all directions, by a single κ.
    is_isotropic: ClassVar[bool] = True

    def reduced(
        self, setup: Setup, pressed: Pressed, start: ReducedContact | None = None
    ) -> ReducedContact:
        """The reduced contact of a contact under the whole load, from a first guess."""
        raise NotImplementedError

    def sheared_bodies(self, setup: Setup, half_space: HalfSpace) -> HalfSpace:
        """The bodies under tractions, here as under a pressure."""
        return half_space

    def family(self, setup: Setup, pressed: Pressed) -> tuple[HalfSpace, Array]:
        """The bodies and the shape, m, of the contacts that a loading passes, from P to P*."""
        half_space, shape, law = pressed.half_space, pressed.shape, setup.friction_law
        bodies = self.sheared_bodies(setup, half_space)
        if bodies is not half_space or law.follows_slip:
            traction = law.ratio * pressed.pressure
            shape = pressed.gap + pressed.approach - _moved(bodies, traction, pressed.tolerance)
        if setup.tilt:
            shape = shape + setup.tilt * half_space.geometry.x[:, None]
        return bodies, shape

    def wear_layer(
        self,
        wear: Array,
        gap: Array,
        shift: Array | None,
        exponent: Array,
        rate: float | Array,
        withheld: float | Array = 0.0,
    ) -> Layer:
        """Wear depth at the end of a stage against pressure, all fields as in `WearLayer`.

        It grows exponentially with ∫p dN, or linearly if slip is constant.
        """
        if self.follows_shape:
            return WearLayer(wear, gap, shift, exponent, rate, withheld=withheld)
        mean = gap if shift is None else gap + 0.5 * shift
        return WinklerLayer(rate * mean, wear + exponent * mean - withheld, wear)

    def still_holds(self, reduced: ReducedContact, setup: Setup, load: float) -> bool:
        """Whether a reduced contact still meets the condition of a setup after wear.

        Wear outside the stick zone leaves the contact under a reduced load unchanged. A contact at
        a reduced approach follows the approach of the bodies, and changes with a load that is not
        held. ``load`` is the load P, N, of the full contact.
        """
        if not self.follows_shape:
            return True
        if reduced.follows_pressure:
            return False
        return setup.normal.holds_load and setup.reduced_condition(load, 0.0).load == reduced.load

    def limit(
        self, highest: float | Array, growth: float, pressure: Array, reduced: ReducedContact
    ) -> Array:
        """Pressure, Pa, at which each cell yields by p² + αq² = p_lim²; ``growth`` is αµ².

        In the stick zone q = µ (p − p*). Plastic flow there deepens the shape of both contacts
        alike and leaves q unchanged, so that p yields at √(p_lim² − αq²). If the reduced contact
        has another shape, p* stays instead, and p yields at the root of p² + αµ² (p − p*)² =
        p_lim². ``highest`` is p_lim, Pa, and ``pressure`` a guess of p. Friction in two directions
        changes the magnitude of q too little to matter here.
        """
        lowest, stuck = highest / sqrt(1.0 + growth), reduced.pressure
        if self.follows_shape:
            sheared = np.minimum(np.abs(pressure - stuck), lowest)
            limit = np.sqrt(highest**2 - growth * sheared**2)
        else:
            stuck = np.minimum(stuck, highest)
            root = np.sqrt((1.0 + growth) * highest**2 - growth * stuck**2)
            limit = (growth * stuck + root) / (1.0 + growth)
        return np.where(stuck > 0.0, limit, lowest)

    def gap_after(self, gap: Array, wear: Array) -> Array:
        """g*, m, after wear by ``wear``, m, outside the stick zone and no plastic flow.

        Such wear leaves p* and δ* unchanged.
        """
        return gap + wear if self.follows_shape else gap


@dataclass(frozen=True)
class Jaeger(SlipModel):
    """Slip of the worn shape as if tractions moved the surface alike in all directions."""

    kind: Literal["jaeger"] = "jaeger"
    caption: ClassVar[str] = "slip of the worn shape"
    follows_shape: ClassVar[bool] = True

    def sheared_bodies(self, setup: Setup, half_space: HalfSpace) -> HalfSpace:
        """The bodies under tractions: same as under a pressure unless the flat has a coating."""
        return half_space.alike(setup.coupling)

    def reduced(
        self, setup: Setup, pressed: Pressed, start: ReducedContact | None = None
    ) -> ReducedContact:
        """Solve the normal contact of the shape at the reduced load, or at the reduced approach.

        If the shape lies above the reduced approach, nothing sticks, and the slip follows from the
        gap.
        """
        half_space, law = pressed.half_space, setup.friction_law
        bodies, changed = self.family(setup, pressed)
        sliding = pressed.sliding
        if law.follows_slip:
            more = half_space.geometry.integral((law.ratio - 1.0) * pressed.pressure)
            sliding = sliding.with_more(more)
        result = self._solved(setup, bodies, changed, sliding, start, pressed)
        if setup.tilt and (result.pressure > 2.0 * law.ratio * pressed.pressure).any():
            raise ContactError(
                "the bulk stress moves the stick zone beyond the contact, where slip reverses: "
                "this is outside the model; give a lower bulk_stress or a larger tangential force"
            )
        follows_pressure = bodies is not half_space or law.follows_slip
        return replace(result, follows_pressure=True) if follows_pressure else result

    def _solved(
        self,
        setup: Setup,
        half_space: HalfSpace,
        shape: Array,
        sliding: Sliding,
        start: ReducedContact | None,
        pressed: Pressed,
    ) -> ReducedContact:
        tolerance, load = pressed.tolerance, sliding.load
        if start is not None and not start.pressure.any():
            start = None
        whole = half_space.geometry.integral(pressed.pressure)
        if load is not None:
            if load <= 0.0:
                # At a held approach the normal force falls as the bodies yield and wear.
                raise ContactError(
                    "µP has fallen below the tangential load, which slides the contact as a whole; "
                    "give tangential_ratio or a displacement instead, or fewer cycles"
                )
            guess = start.pressure if start else lowered(pressed.pressure, load / whole)
            return contact_under(half_space, shape, load, None, guess, tolerance)
        lowest, scale, flexibility = float(shape.min()), setup.hertz.approach, sliding.flexibility
        depth = sliding.level - lowest
        if depth <= _NO_DEPTH * scale:
            zeros, gap = np.zeros_like(shape), shape - sliding.level
            response = zeros - 1.0 if half_space.gives_stiffness else None
            return ReducedContact(zeros, gap, sliding.level, 0.0, response=response)
        # The solver's tolerance is relative to a displacement that vanishes with the stick zone.
        tolerance = min(tolerance * max(scale / depth, 1.0), _COARSE)
        # P* is at most P.
        low, high, convolutions = 0.0, depth + max(-flexibility, 0.0) * setup.hertz.load, 0
        power = 1.0 if isinstance(setup.hertz, LineContact) else 1.5
        of_smooth, tried = replace(sliding, level=depth).of_smooth(setup.hertz)
        guess = start.pressure if start else lowered(pressed.pressure, of_smooth / whole)
        if start and flexibility and low < start.approach - lowest < high:
            tried = start.approach - lowest
        tried = min(tried, high)
        previous: tuple[float, float] | None = None
        # The excess is continuous and the bracket halves at least every second time, so this ends.
        halves = True
        while True:
            contact = contact_under(
                half_space, shape, None, lowest + tried, guess, tolerance, flexibility
            )
            convolutions += contact.convolutions
            excess = tried + flexibility * contact.load - depth
            if abs(excess) <= tolerance * depth or high - low <= tolerance * depth:
                return replace(contact, convolutions=convolutions)
            width = high - low
            low, high = (low, tried) if excess > 0 else (tried, high)
            halved, halves = halves, high - low <= 0.5 * width
            stiffness = power * contact.load / tried
            if previous is not None:
                stiffness = (contact.load - previous[1]) / (tried - previous[0])
            previous = tried, contact.load
            guess = contact.pressure if contact.load > 0.0 else guess
            tried -= excess / (1.0 + flexibility * stiffness)
            if not (low < tried < high and (halves or halved)):
                tried = 0.5 * (low + high)


@dataclass(frozen=True)
class Cerruti(Jaeger):
    """Slip of the worn shape by friction along x, which moves the surface most along x.

    This motion changes with the pressure, and so do slip and stick zone.
    """

    kind: Literal["cerruti"] = "cerruti"  # type: ignore[assignment]
    caption: ClassVar[str] = "slip of the worn shape, along x"
    is_isotropic: ClassVar[bool] = False

    def sheared_bodies(self, setup: Setup, half_space: HalfSpace) -> HalfSpace:
        """The bodies under tractions along x."""
        return half_space.along_x(setup.bodies.coupling, setup.coupling)


@dataclass(frozen=True)
class Auto(Cerruti):
    """`Cerruti` on cells that distinguish directions, `Jaeger` on rings and strips."""

    kind: Literal["auto"] = "auto"  # type: ignore[assignment]
    caption: ClassVar[str] = "slip of the worn shape, along x where cells have directions"


@dataclass(frozen=True)
class Coupled(Jaeger):
    """Slip of the worn shape by friction as a vector: `fretwear.mechanics.slip.coupled`.

    Displacements along x and y are coupled, so that traction turns away from x. A line contact has
    a single direction; there this model equals `Jaeger`.
    """

    kind: Literal["coupled"] = "coupled"  # type: ignore[assignment]
    caption: ClassVar[str] = "slip of the worn shape, in two directions"
    couples: ClassVar[bool] = True
    is_isotropic: ClassVar[bool] = False

    def reduced(
        self, setup: Setup, pressed: Pressed, start: ReducedContact | None = None
    ) -> ReducedContact:
        """Solve the tangential contact under the force or displacement of a setup.

        Slip, unused friction, displacement and force are expressed as in a normal contact.
        """
        geometry, pressure = pressed.half_space.geometry, pressed.pressure
        if geometry.plane_strain:
            return super().reduced(setup, pressed, start)
        friction, compliance = setup.friction_law.coefficient, setup.coupling
        sliding, load = pressed.sliding, geometry.integral(pressure)
        force, displacement = None, 0.0
        if sliding.load is not None:
            force = friction * (load - sliding.load)
        else:
            displacement = setup.loading.displacement(friction, compliance, setup.hertz)
        previous, tilted = None if start is None else start.sheared, None
        if setup.tilt:
            # The flat becomes narrower as it is stretched.
            strain, nu = friction * compliance * setup.tilt, setup.bodies.contraction
            x, y = np.meshgrid(geometry.x, geometry.y, indexing="ij")
            tilted = strain * np.stack([x, -nu * y])
        bound = friction * pressure
        sheared = shear(
            bodies_under_shear(pressed.half_space, setup.bodies.coupling),
            bound,
            force,
            displacement,
            setup.flexibility,
            None if previous is None else previous.under(bound),
            min(max(_RESIDUAL * pressed.tolerance, 1e-9), 3e-3),
            tilted,
        )
        spare = np.where(sheared.stick, np.maximum(sheared.spare, _TINY * bound), 0.0)
        return ReducedContact(
            pressure=spare / friction,
            gap=sheared.amplitude / (friction * compliance) + np.maximum(pressed.gap, 0.0),
            approach=pressed.approach - sheared.displacement / (friction * compliance),
            load=load - sheared.force / friction,
            convolutions=2 * sheared.convolutions,
            sheared=sheared,
            follows_pressure=True,
        )


@dataclass(frozen=True)
class CattaneoMindlin(SlipModel):
    """Slip of the unworn smooth sphere or cylinder for every shape, as in simpler studies.

    The stick zone stays a disc of radius c = a (1 − Q/µP)^(1/3) or, for a cylinder, a strip of
    half-width c = a (1 − Q/µP)^(1/2), and slip has the closed form of the Hertzian contact. Both
    ignore wear and roughness, and so does the loop of force and displacement.
    """

    kind: Literal["cattaneo_mindlin"] = "cattaneo_mindlin"
    caption: ClassVar[str] = "slip of the unworn contact"

    def reduced(
        self,
        setup: Setup,
        pressed: Pressed,
        start: ReducedContact | None = None,
    ) -> ReducedContact:
        """Hertz pressure and gap of the contact whose radius or half-width is c."""
        geometry = pressed.half_space.geometry
        r = np.hypot(*np.meshgrid(geometry.x, geometry.y, indexing="ij"))
        load, approach = setup.unworn_sliding.of_smooth(setup.hertz)
        if not load > 0.0:
            gap = r**2 / (2.0 * setup.hertz.radius) - approach
            return ReducedContact(np.zeros_like(r), gap, approach, 0.0)
        hertz = setup.hertz.with_load(load)
        return ReducedContact(hertz.pressure(r), hertz.gap(r), hertz.approach, load)

    def still_holds(self, reduced: ReducedContact, setup: Setup, load: float) -> bool:
        """Whether the unworn contact, which alone determines slip, has the same reduced load."""
        return setup.unworn_sliding.of_smooth(setup.hertz)[0] == reduced.load


def lowered(pressure: Array, part: float) -> Array:
    """A guess of the pressure, Pa, under a part of the load: p² of a sphere falls evenly.

    Its sum falls with the power 4/3 of the load. It does not rise, which would press open cells.
    """
    squared = np.square(pressure)
    total = min(part, 1.0) ** (4.0 / 3.0) * float(squared.sum())
    return np.sqrt(projected(squared, np.inf, total)[0])


def contact_under(
    half_space: HalfSpace,
    shape: Array,
    load: float | None,
    approach: float | None,
    start: Array,
    tolerance: float,
    flexibility: float = 0.0,
) -> ReducedContact:
    """The normal contact of a shape, m, under a load, N, or at an approach, m.

    The stick zone is smaller than the contact, so the problem is solved on cells around the start
    with a margin, and again on more cells if the zone reaches their border. Each attempt adds cells
    that the last one missed, so this ends.
    """
    geometry, convolutions = half_space.geometry, 0
    held: Mask = start > 0
    while True:
        bodies = half_space.cropped(held)
        part = bodies.geometry
        solution = solve_contact(
            ContactProblem(bodies, geometry.resized(shape, part), load, approach=approach),
            geometry.resized(start, part),
            tolerance,
            verified=False,
        )
        pressure = part.resized(solution.pressure, geometry)
        # The gap on all cells comes from a convolution of its own.
        part_cells = geometry.where(part)
        gap = _moved(half_space, pressure, tolerance) + shape - solution.approach
        if tolerance >= _SINGLE_IS_ENOUGH:
            gap[part_cells] = solution.gap
        convolutions += solution.convolutions + 1
        missed = gap < 0
        missed[part_cells] = False
        if not missed.any():
            break
        held, start = held | missed, pressure
    # The gap in the stick zone is set to zero: noise would grow with wear like exp(β∫p dN).
    gap = np.where(pressure > 0, 0.0, np.maximum(gap, 0.0))
    carried, response = geometry.integral(pressure) if load is None else float(load), None
    if load is None and solution.stiffness is not None:
        response = half_space.displacement(solution.stiffness) - 1.0
        response[pressure > 0] = 0.0
        response /= 1.0 + flexibility * geometry.integral(solution.stiffness)
    return ReducedContact(pressure, gap, solution.approach, carried, convolutions, response)


def _moved(half_space: HalfSpace, pressure: Array, tolerance: float) -> Array:
    """The displacement, m, under a pressure; in single precision if a tolerance allows."""
    if tolerance < _SINGLE_IS_ENOUGH:
        return half_space.displacement(pressure)
    moved, unit = half_space.relative_displacement(pressure)
    return np.multiply(moved, unit, dtype=np.float64)


@dataclass(frozen=True)
class WinklerLayer(Layer):
    """A linear layer: displacement ``offset + compliance · p``, or its least value if larger."""

    compliance: Array  # m/Pa, shape of the geometry, not negative
    offset: Array  # m, same shape
    least: Array | float = -np.inf  # m

    def add_displacement(self, pressure: Array, result: Array) -> None:
        """Add the displacement, m, under a pressure, Pa, to a field."""
        result += np.maximum(self.offset + self.compliance * pressure, self.least)

    def scaled_tangent(self, unit: float, pressure: Array) -> Single:
        """Derivative of the displacement in some unit, m/Pa."""
        moves = self.offset + self.compliance * pressure >= self.least
        return (self.compliance / unit * moves).astype(np.float32)


@dataclass(frozen=True)
class WearLayer(Layer):
    """Wear depth at the end of an implicit stage as a function of the pressure there.

    With the gap g* of the reduced contact, dW/dN = β p g* and dg*/dN = β p g* + dG/dN, where G = g*
    − W changes by plastic flow only. For x = β∫p dN over the stage and G linear in x, both
    integrate in closed form::

        g* = eˣ g*₀ + ΔG φ(x),   W = W₀ + (eˣ − 1) g*₀ + ΔG (φ(x) − 1),   φ(x) = (eˣ − 1)/x

    and x = x₀ + τ p with the stage's pressure p. Written for g* alone, an implicit step diverges
    where τp > 1; written for x, every step is a convex problem.

    A threshold lowers dW/dN by a constant that would wear the depth w over the stage, as long as
    the cell wears at all: w φ(x) is then subtracted from both, down to W₀.

    Below an interface the coefficient is ρ times that above, so x grows by ρ dx there: from the
    exponent ξ on with which W reaches it, ξ + ρ (x − ξ) takes the place of x.
    """

    wear: Array  # W₀ at the start of the stage, m
    reduced_gap: Array  # g*₀ at the start of the stage, m, not negative
    shift: Array | None  # ΔG over the stage, m
    exponent: Array  # x₀, the part of the exponent that is already known
    rate: float | Array  # τ, 1/Pa, of all cells or of each
    # Derivative of ΔG by the approach of the bodies, and the approach, m, at which ΔG is given.
    response: Array | None = None
    level: float | None = None
    withheld: float | Array = 0.0  # w, m
    interface: Interface | None = None  # at a depth W, m

    def at(self, approach: float) -> WearLayer:
        """The layer at another approach, m."""
        if self.shift is None or self.response is None or self.level is None:
            return self
        shift = self.shift + (approach - self.level) * self.response
        return replace(self, shift=shift, level=approach)

    def per_approach(self, pressure: Array) -> Array:
        """Derivative of the wear depth by the approach; not positive, like the response."""
        zeros = np.zeros_like(pressure)
        falls = zeros if self.response is None else -self.response
        x = self.exponent_under(pressure)
        layer = WearLayer(zeros, zeros, falls, x, 0.0)
        return -layer.displacement(pressure) * self._wears(pressure)

    @property
    def _drift(self) -> Array | float | None:
        """ΔG − w, m, the factor of φ(x); None if it is zero everywhere."""
        if not np.any(self.withheld):
            return self.shift
        return -self.withheld if self.shift is None else self.shift - self.withheld

    def _wears(self, pressure: Array) -> Mask | float:
        """Cells that wear beyond the threshold; one number for all without a threshold."""
        if not np.any(self.withheld):
            return 1.0
        return np.asarray(self.displacement(pressure) > self.wear)

    def add_displacement(self, pressure: Array, result: Array) -> None:
        """Add the wear depth, m, to a field; never less than at the start of the stage."""
        x = self.exponent_under(pressure)
        growth, drift = np.expm1(x), self._drift
        worn = growth * self.reduced_gap
        if drift is not None:
            growth -= x
            growth /= np.maximum(x, 1e-12, out=x)
            growth *= drift
            worn += growth
            worn -= self.withheld
            np.maximum(worn, 0.0, out=worn)
        result += worn
        result += self.wear

    def exponent_under(self, pressure: Array) -> Array:
        """X = x₀ + τ p, bounded far above any real wear, and changed below an interface."""
        x = self.rate * pressure
        x += self.exponent
        if self._changes is not None:
            slowed = np.maximum(x - self.crossing, 0.0)
            x += (self._changes - 1.0) * slowed
        return np.minimum(x, _LARGEST_EXPONENT, out=x)

    @property
    def _changes(self) -> float | None:
        """ρ; None if nothing changes at an interface."""
        return (
            None if self.interface is None or self.interface.ratio == 1.0 else self.interface.ratio
        )

    @cached_property
    def crossing(self) -> Array:
        """ξ, by Newton's method on W(ξ), which is convex; zero in cells below the interface."""
        assert self.interface is not None
        left = np.where(self.interface.reached(self.wear), 0.0, self.interface.depth - self.wear)
        shift = np.zeros_like(left) if self.shift is None else self.shift
        gap = self.reduced_gap
        mean = np.maximum(gap + 0.5 * shift, 1e-9 * gap)
        moves = (left > 0.0) & (mean > np.finfo(np.float64).tiny) & np.isfinite(left)
        found = np.where(left > 0.0, np.inf, 0.0)
        left, shift, gap, mean = left[moves], shift[moves], gap[moves], mean[moves]
        x = np.minimum(np.log1p(left / mean), _LARGEST_EXPONENT)
        for _ in range(_CROSSINGS if self.shift is not None else 0):
            growth, above = np.expm1(x), np.maximum(x, _SMALL_EXPONENT)
            mean_growth = np.expm1(above) / above
            missed = growth * gap + shift * (mean_growth - 1.0) - left
            slope = (growth + 1.0) * gap + shift * (growth + 1.0 - mean_growth) / above
            # Where the stick zone widens, W first falls: from there on x begins at its bound.
            change = missed / np.maximum(slope, _CROSSED * left)
            x = np.clip(x - change, 0.0, _LARGEST_EXPONENT)
            if (np.abs(change) <= _CROSSED * (1.0 + x)).all():
                break
        found[moves] = x
        return found

    def scaled_tangent(self, unit: float, pressure: Array) -> Single:
        """Derivative of the wear depth in some unit, m/Pa; not negative.

        φ' = (eˣ − φ)/x loses its digits near zero; there it is a line of slope 1/3.
        """
        x, drift = self.exponent_under(pressure), self._drift
        exponent = x if drift is None else np.maximum(x, _SMALL_EXPONENT)
        growth = np.expm1(exponent)
        slope = (growth + 1.0) * self.reduced_gap
        if drift is not None:
            slope_of_flow = ((exponent - growth) / exponent + growth) / exponent
            slope_of_flow += np.minimum(x - _SMALL_EXPONENT, 0.0) / 3.0
            slope_of_flow *= drift
            slope += slope_of_flow
            np.maximum(slope, 0.0, out=slope)
            slope *= self._wears(pressure)
        slope *= self.rate / unit
        if self._changes is not None:
            below = self.rate * pressure + self.exponent > self.crossing
            slope *= np.where(below, self._changes, 1.0)
        return np.minimum(slope, _LARGEST_TANGENT, out=slope).astype(np.float32)
