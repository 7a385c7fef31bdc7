"""How a contact is loaded: the normal load held, the tangential load between +Q and −Q."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from fretwear.mechanics.materials import Friction
from fretwear.parts import Part, Quantity


@dataclass(frozen=True)
class Loading(Part):
    """A normal load, constant, and what is imposed along x."""

    load: Annotated[
        float,
        Quantity("N", "$P$", "normal load", "N", above=0.0, description="Constant normal load P."),
    ]

    def amplitude(self, friction: Friction) -> float:
        """Amplitude Q of the tangential load, N."""
        raise NotImplementedError

    def ratio(self, friction: Friction) -> float:
        """Tangential load over the load of gross sliding, X = Q/(µP)."""
        return self.amplitude(friction) / (friction.coefficient * self.load)

    def stick_load(self, friction: Friction) -> float:
        """Reduced load P* = P − Q/µ, N, whose contact is the stick zone."""
        return self.load * (1.0 - self.ratio(friction))

    def as_force(self, friction: Friction) -> TangentialLoad:
        """The same loading with Q in newtons: one loading, however it was written, is one case."""
        return TangentialLoad(self.load, self.amplitude(friction))

    @property
    def slug(self) -> str:
        """``P50N``; the tangential load depends on friction too."""
        return f"P{self.load:.4g}N".replace("+", "")


@dataclass(frozen=True)
class TangentialRatio(Loading):
    """The tangential load as a part of the load of gross sliding."""

    tangential_ratio: Annotated[
        float,
        Quantity(
            "1",
            "$Q/µP$",
            "tangential load ratio",
            like="0.8",
            above=0.0,
            description="Tangential load as Q/(µP), less than 1. Or give tangential_load.",
        ),
    ]
    kind: Literal["tangential_ratio"] = "tangential_ratio"

    def amplitude(self, friction: Friction) -> float:
        """Amplitude Q = X µ P, N."""
        return self.tangential_ratio * friction.coefficient * self.load

    def ratio(self, friction: Friction) -> float:
        """X = Q/(µP), as given."""
        del friction
        return self.tangential_ratio


@dataclass(frozen=True)
class TangentialLoad(Loading):
    """The amplitude of the tangential load."""

    tangential_load: Annotated[
        float,
        Quantity(
            "N",
            "$Q$",
            "tangential load amplitude",
            "N",
            like="20 N",
            above=0.0,
            description="Tangential load Q, less than µP. Or give tangential_ratio.",
        ),
    ]
    kind: Literal["tangential_load"] = "tangential_load"

    def amplitude(self, friction: Friction) -> float:
        """Amplitude Q, N, as given."""
        del friction
        return self.tangential_load
