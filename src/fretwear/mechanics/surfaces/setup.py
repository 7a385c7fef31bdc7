"""A setup: the parts of a fretting contact, and what follows from them at a cycle.

A case of a study and the problem of the integrator are setups; a setup knows neither cells nor
tolerances. It never changes, so it caches what a plan asks for again and again.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, sqrt
from typing import Annotated, Any, Self, TypeVar

from fretwear.arrays import Array, Even
from fretwear.mechanics.contact.film import Film
from fretwear.mechanics.surfaces.coating import Coating, Interface
from fretwear.mechanics.surfaces.indenters import Indenter
from fretwear.mechanics.surfaces.laws import Means, WearLaw
from fretwear.mechanics.surfaces.loading import SMALL_STROKE, Loading, Sliding
from fretwear.mechanics.surfaces.materials import Bodies, Friction
from fretwear.mechanics.surfaces.pressing import Normal
from fretwear.mechanics.surfaces.roughness import BothRough, Roughness
from fretwear.quantity import Inline, Part, PartOf, Quantity
from fretwear.theory import HertzContact
from fretwear.units import ContactFrame

Kind = TypeVar("Kind")
_Phase = TypeVar("_Phase", float, Array)

_SURFACES = Indenter, Roughness


def block_at(blocks: Sequence[tuple[float, Kind]], cycle: float) -> Kind:
    """The block in force at a cycle, of pairs of blocks and the cycles at which they end."""
    return next((block for end, block in blocks if cycle <= end), blocks[-1][1])


@dataclass(frozen=True, kw_only=True)
class Setup:
    """Two bodies pressed together that slip back and forth; all in SI units."""

    indenter: Annotated[
        Indenter,
        PartOf(Indenter, "indenter", short="sphere", like="{kind: sphere, radius: 10 mm}"),
        "Smooth shape of the bodies.",
    ]
    bodies: Annotated[Bodies, Inline(Bodies)]  #: their elasticity
    normal: Annotated[Normal, Inline(Normal)]  #: load or approach that presses them together
    loading: Annotated[Loading, Inline(Loading)]  #: what is imposed along x
    friction_law: Annotated[Friction, Inline(Friction)]  #: resistance to slip
    wear_law: Annotated[WearLaw, Inline(WearLaw)]  #: depth worn per pressure and path
    plastic_limit: Annotated[
        float,
        Quantity(
            "Pa",
            r"$p_\mathrm{lim}$",
            "plastic limit",
            "MPa",
            like="4500 MPa",
            gt=0.0,
            infinite="elastic",
        ),
        "Highest pressure, about three times the yield stress; none: elastic.",
    ] = inf
    junction_growth: Annotated[
        float,
        Quantity("1", "$α_q$", "junction growth", like="9", ge=0.0),
        "Factor α in p² + αq² ≤ p_lim², by which friction lowers the plastic limit.",
    ] = 0.0
    roughness: Annotated[
        Roughness | None,
        PartOf(
            Roughness,
            "roughness",
            none="smooth",
            like="{kind: wavy, amplitude: 0.2 um, slope_x: 5.7 deg, slope_y: 1 deg}",
        ),
        "Roughness of the surfaces; none: smooth.",
    ] = None
    counterface: Annotated[
        Roughness | None,
        PartOf(
            Roughness,
            "counterface",
            none="smooth",
            like="{kind: wavy, amplitude: 0.1 um, slope_x: 2 deg, slope_y: 1 deg}",
            is_second=True,
        ),
        "Roughness of the other body, if both are rough.",
    ] = None
    coating: Annotated[
        Coating | None,
        PartOf(
            Coating,
            "coating",
            none="uncoated",
            like="{thickness: 3 um, youngs_modulus: 400 GPa, poisson_ratio: 0.2}",
            is_second=True,
        ),
        "Elastic layer on the flat.",
    ] = None
    frequency: Annotated[
        float | None,
        Quantity("s-1", "$f$", "frequency", "Hz", like="5 Hz", gt=0.0),
        "Frequency, on which some laws of wear depend.",
    ] = None
    debris_fraction: Annotated[
        float,
        Quantity("1", "$γ$", "debris fraction", like="0.85", ge=0.0, le=1.0),
        "Fraction of the worn material that stays and carries load.",
    ] = 0.0
    wear_threshold: Annotated[
        float,
        Quantity("J m-2", "$e_t$", "wear threshold", "mJ/mm^2", like="2 mJ/mm^2", ge=0.0),
        "Energy per area and cycle that does not wear.",
    ] = 0.0
    bulk_stress: Annotated[
        float,
        Quantity("Pa", "$σ_b$", "bulk stress amplitude", "MPa", "80 MPa", ge=0.0),
        "Amplitude of a stress along x in the flat, in phase with the tangential force.",
    ] = 0.0

    @property
    def setup(self) -> Setup:
        """The setup alone, without what a case or a problem adds."""
        return Setup(**{name: getattr(self, name) for name in _MEMBERS})

    @cached_property
    def parts(self) -> dict[str, Part]:
        """The parts by member, without those that are missing."""
        names = (field.name for field in dataclasses.fields(self))
        return {n: part for n in names if isinstance(part := getattr(self, n, None), Part)}

    # What changes over the cycles.

    def at(self, cycle: float) -> Self:
        """The setup at a cycle, with each part as it is then; itself if none has changed."""
        changed = {
            name: new
            for name, part in self.parts.items()
            if type(part).at is not Part.at and (new := part.at(cycle)) is not part
        }
        return self.changed(**changed) if changed else self

    def changed(self, **parts: Part) -> Self:
        """The setup with other parts."""
        changes: dict[str, Any] = {**parts}
        return dataclasses.replace(self, **changes)

    def slipped(self, energy: Array | None) -> Self:
        """The setup with the friction of places that have dissipated an energy per area, J/m²."""
        law = self.friction_law.slipped(energy)
        return self if law is self.friction_law else self.changed(friction_law=law)

    @property
    def kinks(self) -> tuple[float, ...]:
        """Cycles at which a part does not change smoothly, in order."""
        return tuple(sorted({kink for part in self.parts.values() for kink in part.kinks}))

    # The unworn smooth contact.

    @property
    def frame(self) -> ContactFrame:
        """Axes, words and units of the contact."""
        return self.indenter.frame

    @property
    def composite_modulus(self) -> float:
        """E* in Pa."""
        return self.bodies.composite_modulus

    @cached_property
    def film(self) -> Film | None:
        """The elastic film on the flat; None if it has no coating."""
        return None if self.coating is None else self.bodies.covered(self.coating)

    @cached_property
    def coupling(self) -> float:
        """κ = E*/G*, tangential compliance of the bodies relative to the normal one."""
        return self.indenter.coupling(self.bodies)

    @cached_property
    def hertz(self) -> HertzContact:
        """Contact of the smooth elastic bodies, which sets the scales."""
        return self.indenter.hertz(self.normal, self.composite_modulus)

    @property
    def hertz_radius(self) -> Annotated[float, Quantity("m", "$a$", "Hertz contact radius", "um")]:
        """Contact radius a of the smooth elastic bodies, or half-width of the cylinder, in m.

        For an elliptical contact, it is the radius of a circle of the same area. It also sets the
        scale of contacts outside Hertz's theory, but is not one of their coordinates.
        """
        return self.hertz.contact_radius

    @property
    def hertz_pressure(self) -> Annotated[float, Quantity("Pa", "$p_0$", "Hertz pressure", "MPa")]:
        """Peak pressure p0 of the smooth elastic contact in Pa."""
        return self.hertz.peak_pressure

    @cached_property
    def small_stroke(self) -> float:
        """Sliding amplitude, m, up to which the motion of the bodies may be neglected.

        It is small against the contact, and against a rounded edge at which the pressure peaks.
        """
        half_width, _ = self.indenter.half_widths(self.hertz)
        return SMALL_STROKE * min(half_width, self.indenter.edge(self.hertz))

    @cached_property
    def rough(self) -> Roughness | None:
        """The roughness of the surfaces: of one body or of both together."""
        if self.roughness is not None and self.counterface is not None:
            return BothRough(self.roughness, self.counterface)
        return self.roughness or self.counterface

    @cached_property
    def surfaces(self) -> dict[str, Indenter | Roughness]:
        """The parts that make up the unworn gap, by member."""
        return {n: part for n, part in self.parts.items() if isinstance(part, _SURFACES)}

    @property
    def checksums(self) -> list[str]:
        """Checksums of heights that parts have read from files."""
        return [part.checksum for part in self.surfaces.values() if part.checksum]

    @property
    def packages(self) -> list[str]:
        """Packages beside the core that define parts of the case."""
        packages = {type(part).__module__.partition(".")[0] for part in self.parts.values()}
        return sorted(packages - {__name__.partition(".")[0]})

    @cached_property
    def even(self) -> Even:
        """Whether the unworn gap is exactly even along x and along y: one side then suffices."""
        x, y = zip(*(part.even for part in self.surfaces.values()), strict=True)
        return all(x) and not (self.wears_unevenly or self.bulk_stress), all(y)

    @property
    def wears_unevenly(self) -> bool:
        """Whether the load of a stroke differs between the two sides of its middle."""
        return self.normal.pulsating_load < 1.0 and self.loading.travel > 0.0

    @property
    def wavelengths(self) -> tuple[float, float] | None:
        """Distance to the next asperity tip along x and y, m; None if smooth."""
        if (rough := self.rough) is None:
            return None
        x, y = (length if isfinite(length) else 0.0 for length in rough.wavelengths)
        return x, y

    def load_at(self, phase: _Phase) -> _Phase:
        """The load, N, when the motion is at a fraction of its amplitude, from −1 to 1."""
        falls = 0.5 * (1.0 - self.normal.pulsating_load) * (1.0 - phase)
        return self.hertz.load * (1.0 - falls)

    # Friction and slip.

    def reduced_condition(self, load: float, approach: float) -> Sliding:
        """The condition on the reduced contact of a contact with a load, N, and an approach, m."""
        friction, series = self.friction_law.coefficient, self.flexibility
        sliding = self.loading.reduced_condition(friction, self.coupling, load, approach, series)
        if sliding.load is None:
            return sliding
        return dataclasses.replace(sliding, load=sliding.load - self.load_amplitude(load))

    def load_amplitude(self, load: float) -> float:
        """Amplitude, N, of the change of a largest load in phase with a force; else zero."""
        return 0.5 * (1.0 - self.normal.pulsating_load) * load * self.loading.is_force

    @property
    def flexibility(self) -> float:
        """Flexibility in series with the contact, m/N."""
        return self.loading.flexibility(self.hertz)

    @property
    def tangential_ratio(
        self,
    ) -> Annotated[float, Quantity("1", "$Q/µP$", "tangential load ratio")]:
        """X = Q/(µP); that of the unworn smooth contact if a displacement is imposed."""
        return self.loading.ratio(*self._unworn)

    @property
    def tangential_load(
        self,
    ) -> Annotated[float, Quantity("N", "$Q$", "tangential load amplitude", "N")]:
        """Amplitude Q of the tangential load in N, as for `tangential_ratio`."""
        return self.loading.amplitude(*self._unworn)

    @property
    def displacement_amplitude(
        self,
    ) -> Annotated[float, Quantity("m", "$U$", "displacement amplitude", "um")]:
        """Amplitude U of the imposed displacement, m, in whichever form it was given."""
        return self.loading.displacement(*self._unworn)

    @property
    def displacement_ratio(
        self,
    ) -> Annotated[float, Quantity("1", "$U/U_t$", "displacement ratio")]:
        """U over the displacement at which the unworn smooth contact begins to slide as a whole."""
        return self.displacement_amplitude / self.loading.transition(*self._unworn)

    @property
    def _unworn(self) -> tuple[float, float, HertzContact]:
        return self.friction_law.coefficient, self.coupling, self.hertz

    @property
    def unworn_sliding(self) -> Sliding:
        """The condition on the reduced contact of the unworn smooth contact."""
        return self.reduced_condition(self.hertz.load, self.hertz.approach)

    @cached_property
    def stick_load(self) -> float:
        """Reduced load P* = P − Q/µ, N, of the unworn smooth contact; it sets the stick zone."""
        stuck = self.loading.stick_load(self.friction_law.coefficient, self.coupling, self.hertz)
        return max(0.0, stuck - self.load_amplitude(self.hertz.load))

    @cached_property
    def tilt(self) -> float:
        """Slope of the reduced contact along x through which a bulk stress moves the stick zone.

        The stress stretches the flat by ε = µκ times the slope at the amplitude of the force.
        """
        strain = self.bulk_stress * self.bodies.stretch(plane_strain="y" not in self.frame.axes)
        return strain / (self.friction_law.coefficient * self.coupling)

    @cached_property
    def stick_radius(self) -> float:
        """Stick radius c, m, of the unworn smooth contact: the radius of a contact under P*."""
        load = self.stick_load
        return self.hertz.with_load(load).contact_radius if load > 0.0 else 0.0

    @property
    def plastic_limits(self) -> tuple[float, float]:
        """Plastic limits, Pa, of the surface and below a coating; equal without one."""
        coated = None if self.coating is None else self.coating.plastic_limit
        return self.plastic_limit if coated is None else coated, self.plastic_limit

    @cached_property
    def slip_limit(self) -> float:
        """Largest pressure where the bodies slip, Pa: the lower one of coating and substrate."""
        return self.shear_on_limit * min(self.plastic_limits)

    @cached_property
    def shear_on_limit(self) -> float:
        """Pressure limit where the bodies slip over p_lim: 1/√(1 + αµ²), as q = µp there."""
        return 1.0 / sqrt(1.0 + self.junction_growth * self.friction_law.coefficient**2)

    # Wear.

    @cached_property
    def surface_law(self) -> WearLaw:
        """The wear law of the surfaces before a coating is worn through."""
        coated = None if self.coating is None else self.coating.wear_coefficient
        return self.wear_law if coated is None else self.wear_law.with_flat(coated)

    @cached_property
    def interface(self) -> Interface | None:
        """The interface of coating and substrate; None where the wear of the flat is not known.

        A single wear coefficient counts as that of the flat.
        """
        laws = self.surface_law, self.wear_law
        pairs = [law.shares if law.is_of_each else (0.0, 1.0) for law in laws]
        if self.coating is None or None in pairs:
            return None
        above, below = (pair[1] for pair in pairs if pair is not None)
        surface, substrate = (law.coefficient(self.friction_law) for law in laws)
        ratio = substrate / surface if substrate != surface else 1.0
        return Interface(self.coating.thickness / above if above else inf, ratio, (above, below))

    @property
    def changes_below(self) -> bool:
        """Whether the wear coefficient changes at the interface of coating and substrate."""
        return self.interface is not None and self.interface.ratio != 1.0

    @cached_property
    def combined_wear_coefficient(self) -> float:
        """Worn depth of both bodies together per pressure and sliding distance, K, 1/Pa.

        It holds down to the `interface`, if there is one.
        """
        law = self.surface_law
        if law.follows_contact or law.needs_frequency:
            law = law.under(self.unworn_means, self.frequency)
        return law.coefficient(self.friction_law)

    @property
    def unworn_means(self) -> Means:
        """Means of the unworn smooth contact, to estimate wear; at low power.

        Mean slip of a sphere: 0.2 of the displacement U at the onset of gross sliding, in
        proportion to the squared load ratio before it; U less 0.8 of its value there afterwards.
        """
        friction, hertz = self.friction_law.coefficient, self.hertz
        stuck = self.stick_load
        moved = self.coupling * hertz.approach * friction
        ratio = 1.0 - stuck / hertz.load
        slip = max(
            self.loading.stroke,
            self.loading.displacement(friction, self.coupling, hertz) - 0.8 * moved,
            0.2 * ratio**2 * moved,
        )
        wide, high = self.indenter.half_widths(hertz)
        return Means(0.0, hertz.mean_pressure, slip, wide, high if "y" in self.frame.axes else inf)

    def under(self, means: Means) -> Self:
        """The setup with the constant wear coefficient of a contact of these means."""
        law = self.wear_law.under(means, self.frequency)
        return self if law is self.wear_law else self.changed(wear_law=law)

    @cached_property
    def wear_growth(self) -> float:
        """β = 4 K µκ, 1/Pa per cycle: a pressure p wears e-fold in 1/(β p) cycles."""
        return 4.0 * self.combined_wear_coefficient * self.friction_law.coefficient * self.coupling

    @property
    def faster_below(self) -> float:
        """How many times faster the bodies wear below a coating; 1 if they do not wear faster."""
        return 1.0 if self.interface is None else max(1.0, self.interface.ratio)

    @property
    def largest_wear_growth(self) -> float:
        """The largest β of coating and substrate, 1/Pa per cycle."""
        return self.wear_growth * self.faster_below

    @cached_property
    def withheld_depth(self) -> float | Array:
        """Depth per cycle, m, that the energy up to the threshold would wear: K e_t/µ."""
        law = self.friction_law
        threshold = self.wear_threshold / law.coefficient
        return self.combined_wear_coefficient * threshold * (self.wear_ratio / law.ratio)

    @property
    def wear_ratio(self) -> float | Array:
        """K of each place over `combined_wear_coefficient`, if friction follows slip."""
        return self.friction_law.ratio if self.wear_law.follows_friction else 1.0

    @property
    def local_wear_growth(self) -> float | Array:
        """β of each place, 1/Pa per cycle."""
        return self.wear_growth * self.wear_ratio


_MEMBERS = tuple(field.name for field in dataclasses.fields(Setup))
