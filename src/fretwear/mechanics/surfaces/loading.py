"""The tangential loading of a contact."""

from __future__ import annotations

import dataclasses
import math
from typing import Annotated, ClassVar, Literal

from pydantic.dataclasses import dataclass

from fretwear.mechanics.surfaces.pressing import Imposed
from fretwear.quantity import Quantity
from fretwear.theory import HertzContact, LineContact, find_root
from fretwear.units import ContactFrame

SMALL_STROKE = 0.05
"""Largest sliding amplitude, over a length of the contact, at which to neglect the motion."""


@dataclasses.dataclass(frozen=True)
class Sliding:
    """The condition on the reduced contact: a load P*, or d* + flexibility · P* = level."""

    load: float | None = None  # P*, N, if it is given
    level: float = 0.0  # approach d*, m, of a reduced contact without load
    # Flexibility of the rig in the units of the approach, 1/(κ S), m/N; zero for a rigid rig. It is
    # negative for bodies in line contact that are smaller than the distance to which their approach
    # refers.
    flexibility: float = 0.0

    def with_more(self, load: float) -> Sliding:
        """The condition if friction bears more, as under a load larger by so much, N."""
        if self.load is not None:
            return dataclasses.replace(self, load=self.load + load)
        return dataclasses.replace(self, level=self.level + self.flexibility * load)

    def of_smooth(self, hertz: HertzContact) -> tuple[float, float]:
        """P*, N, and d*, m, of the unworn smooth contact; no load where it slides as a whole."""
        if self.load is not None:
            return self.load, hertz.with_load(self.load).approach if self.load > 0 else 0.0
        if self.level <= 0.0:
            return 0.0, self.level

        def missing(load: float) -> float:
            approach = hertz.with_load(load).approach if load > 0.0 else 0.0
            return self.level - approach - self.flexibility * load

        most = hertz.load
        while missing(most) > 0.0:
            most *= 2.0
        load = find_root(missing, 0.0, most)
        return load, hertz.with_load(load).approach


class Loading(Imposed):
    """The tangential loading, which oscillates along x between an amplitude and its negative.

    It is a force unless a kind says otherwise, and then defined by `load_ratio`. ``friction`` is µ,
    ``coupling`` κ, and ``hertz`` the unworn smooth contact.
    """

    is_force: ClassVar[bool] = True  # if so, the load alone determines the reduced contact
    stroke: float = 0.0  # amplitude of sliding, m, if imposed: a quarter of the path of a cycle

    @property
    def travel(self) -> float:
        """Amplitude, m, of the imposed relative motion: the stroke in gross sliding."""
        return self.stroke

    def load_ratio(self, friction: float, load: float) -> float:
        """X = Q/(µP) under a load P, N; 1 if the contact slides as a whole."""
        raise NotImplementedError

    def reduced_condition(
        self, friction: float, coupling: float, load: float, approach: float, flexibility: float
    ) -> Sliding:
        """Condition on the reduced contact of a load P, N, and an approach d, m: P* = (1 − X) P.

        ``flexibility``, m/N, is in series with the contact.
        """
        del coupling, approach, flexibility  # only displacements need them
        return Sliding(load * (1.0 - self.load_ratio(friction, load)))

    def ratio(self, friction: float, coupling: float, hertz: HertzContact) -> float:
        """X = Q/(µP) of the unworn smooth contact; 1 where it slides as a whole."""
        return self.load_ratio(friction, hertz.load)

    def stick_load(self, friction: float, coupling: float, hertz: HertzContact) -> float:
        """Reduced load P* = P − Q/µ, N, of the unworn smooth contact; zero if it slides."""
        return max(0.0, hertz.load * (1.0 - self.ratio(friction, coupling, hertz)))

    def amplitude(self, friction: float, coupling: float, hertz: HertzContact) -> float:
        """Tangential load amplitude Q, N, of the unworn smooth contact."""
        return self.ratio(friction, coupling, hertz) * friction * hertz.load

    def displacement(self, friction: float, coupling: float, hertz: HertzContact) -> float:
        """Amplitude U, m, of an imposed displacement or sliding; zero for a force."""
        return self.stroke

    def plain(self, friction: float, coupling: float, hertz: HertzContact) -> Loading:
        """The same loading in SI units: one case, however it was written."""
        return TangentialLoad.unchecked(tangential_load=self.amplitude(friction, coupling, hertz))

    def flexibility(self, hertz: HertzContact) -> float:
        """Flexibility in series with the contact, m/N."""
        return 0.0

    def transition(self, friction: float, coupling: float, hertz: HertzContact) -> float:
        """U_t, m, at which the unworn smooth contact slides as a whole.

        It is µκ d, without the rig; in a line contact µ (κ d + F P), with the flexibility F in
        series.
        """
        flexibility = self.flexibility(hertz) if isinstance(hertz, LineContact) else 0.0
        return friction * (coupling * hertz.approach + flexibility * hertz.load)


@dataclass(frozen=True)
class TangentialRatio(Loading):
    """The tangential load as a fraction of the load of gross sliding."""

    tangential_ratio: Annotated[
        float,
        Quantity("1", "$Q/µP$", "tangential load ratio", like="0.8", gt=0.0),
        "Tangential load as Q/(µP), less than 1.",
    ]
    kind: Literal["tangential_ratio"] = "tangential_ratio"
    letter: ClassVar[str] = "X"

    def load_ratio(self, *_: float) -> float:
        """X = Q/(µP), as given."""
        return self.tangential_ratio


@dataclass(frozen=True)
class TangentialLoad(Loading):
    """The amplitude of the tangential load."""

    tangential_load: Annotated[
        float,
        Quantity("N", "$Q$", "tangential load amplitude", "N", like="20 N", gt=0.0),
        "Tangential load Q, less than µP.",
    ]
    kind: Literal["tangential_load"] = "tangential_load"
    letter: ClassVar[str] = "Q"

    def load_ratio(self, friction: float, load: float) -> float:
        """X = Q/(µP)."""
        return self.tangential_load / (friction * load)

    def amplitude(self, *_: object) -> float:
        """Q, N, as given."""
        return self.tangential_load


class GrossSliding(Loading):
    """A contact that slides as a whole."""

    is_force: ClassVar[bool] = False

    def load_ratio(self, *_: float) -> float:
        """X = 1: the contact slides as a whole."""
        return 1.0

    def plain(self, *_: object) -> Loading:
        """The same."""
        return self


@dataclass(frozen=True)
class SlidingAmplitude(GrossSliding):
    """The stroke of a contact that slides as a whole, imposed at the interface."""

    sliding_amplitude: Annotated[
        float,
        Quantity("m", "$s$", "sliding amplitude", "um", like="25 um", gt=0.0),
        "Half the stroke in gross slip, without elastic displacements.",
    ]
    kind: Literal["sliding_amplitude"] = "sliding_amplitude"
    letter: ClassVar[str] = "s"

    @property
    def stroke(self) -> float:  # type: ignore[override]
        """Amplitude of sliding, m."""
        return self.sliding_amplitude


@dataclass(frozen=True)
class SlidingDistance(GrossSliding):
    """A path in one direction, as of a block on a ring: the contact does not move.

    The cycles of such a run divide the path into equal parts.
    """

    sliding_distance: Annotated[
        float,
        Quantity("m", "$L$", "sliding distance", "m", like="3600 m", gt=0.0),
        "Path in one direction, as of a block on a ring; 1000 cycles by default.",
    ]
    kind: Literal["sliding_distance"] = "sliding_distance"
    travel: ClassVar[float] = 0.0
    parts: int = 1  # cycles of the run

    @property
    def stroke(self) -> float:  # type: ignore[override]
        """A quarter of the path of a cycle, m."""
        return self.sliding_distance / (4.0 * self.parts)

    def slug_in(self, frame: ContactFrame) -> str:
        """``L3600m``."""
        return f"L{self.sliding_distance:.4g}m"


@dataclass(frozen=True, kw_only=True)
class Displacement(Loading):
    """A relative tangential displacement of distant points, or of a rig of some stiffness."""

    rig_stiffness: Annotated[
        float,
        Quantity(
            "N m-1", "$S$", "rig stiffness", "N/um", like="28 N/um", gt=0.0, infinite="rigid rig"
        ),
        "Stiffness of the rig, on which the displacement is imposed; none: rigid.",
    ] = math.inf
    tangential_compliance: Annotated[
        float,
        Quantity(
            "Pa-1",
            "$C_t$",
            "tangential compliance",
            "um/(N/mm)",
            like="0.1 um/(N/mm)",
            ge=0.0,
            omitted_value=0.0,
        ),
        "Displacement per tangential load of a line contact, just after a reversal.",
    ] = 0.0

    is_force: ClassVar[bool] = False

    def ratio(self, friction: float, coupling: float, hertz: HertzContact) -> float:
        """X = Q/(µP) of the unworn smooth contact; 1 where it slides as a whole."""
        return 1.0 - self.stick_load(friction, coupling, hertz) / hertz.load

    def stick_load(self, friction: float, coupling: float, hertz: HertzContact) -> float:
        """Reduced load P* = P − Q/µ, N, of the unworn smooth contact; zero if it slides."""
        plain = self.plain(friction, coupling, hertz)
        flexibility = self.flexibility(hertz)
        load, approach = hertz.load, hertz.approach
        sliding = plain.reduced_condition(friction, coupling, load, approach, flexibility)
        return sliding.of_smooth(hertz)[0]

    def plain(self, friction: float, coupling: float, hertz: HertzContact) -> DisplacementAmplitude:
        """The amplitude in m."""
        return DisplacementAmplitude(
            displacement_amplitude=self.displacement(friction, coupling, hertz),
            rig_stiffness=self.rig_stiffness,
            tangential_compliance=self.tangential_compliance,
        )

    def flexibility(self, hertz: HertzContact) -> float:
        """1/S, m/N; in a line contact C_t less the compliance of the unworn contact.

        The approach, and so µκ (d − d*), is relative to a surface at some distance in the bodies.
        That distance changes dδ/dP and so this difference, but not U.
        """
        if isinstance(hertz, LineContact):
            return self.tangential_compliance - hertz.compliance
        return 1.0 / self.rig_stiffness


@dataclass(frozen=True, kw_only=True)
class DisplacementAmplitude(Displacement):
    """The amplitude of the displacement."""

    displacement_amplitude: Annotated[
        float,
        Quantity("m", "$U$", "displacement amplitude", "um", like="1 um", gt=0.0),
        "Amplitude of the displacement of distant points.",
    ]
    kind: Literal["displacement_amplitude"] = "displacement_amplitude"
    letter: ClassVar[str] = "U"

    def displacement(self, *_: object) -> float:
        """U, m, as given."""
        return self.displacement_amplitude

    def reduced_condition(
        self, friction: float, coupling: float, load: float, approach: float, flexibility: float
    ) -> Sliding:
        """U = µκ(d − d*) + µ(P − P*) F, with F = 1/S of a rig."""
        slip = self.displacement_amplitude / (friction * coupling)
        series = flexibility / coupling
        return Sliding(None, approach + series * load - slip, series)

    def slug_in(self, frame: ContactFrame) -> str:
        """``U1um``, and ``U1um-S28Npum`` over a rig."""
        rig = "" if math.isinf(self.rig_stiffness) else f"-S{self.rig_stiffness * 1e-6:.4g}Npum"
        return super().slug_in(frame) + rig


@dataclass(frozen=True, kw_only=True)
class DisplacementRatio(Displacement):
    """The displacement in units of U_t, which slides the unworn smooth contact as a whole."""

    displacement_ratio: Annotated[
        float,
        Quantity("1", "$U/U_t$", "displacement ratio", like="0.8", gt=0.0),
        "Displacement over that at the onset of gross slip of the unworn smooth contact without "
        "rig.",
    ]
    kind: Literal["displacement_ratio"] = "displacement_ratio"

    def displacement(self, friction: float, coupling: float, hertz: HertzContact) -> float:
        """U = u U_t, m."""
        return self.displacement_ratio * self.transition(friction, coupling, hertz)
