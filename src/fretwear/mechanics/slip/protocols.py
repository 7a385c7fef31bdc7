# ruff: noqa: D102 - units stand beside each attribute
"""What slip asks of a fretting contact; all numbers are in SI units."""

from __future__ import annotations

from typing import Protocol

from fretwear.mechanics.surfaces.loading import Loading, Sliding
from fretwear.mechanics.surfaces.materials import Bodies, Friction
from fretwear.mechanics.surfaces.pressing import Normal
from fretwear.theory import HertzContact


class FrettingProblem(Protocol):
    """A wear problem, as far as slip depends on it."""

    @property
    def hertz(self) -> HertzContact: ...  # the unworn smooth contact
    @property
    def normal(self) -> Normal: ...
    @property
    def friction_law(self) -> Friction: ...
    @property
    def bodies(self) -> Bodies: ...
    @property
    def loading(self) -> Loading: ...
    @property
    def unworn_sliding(self) -> Sliding: ...  # condition on the unworn reduced contact
    @property
    def coupling(self) -> float: ...  # κ of a single direction in this contact
    @property
    def tilt(self) -> float: ...  # slope along x of the reduced contact, due to a bulk stress
    @property
    def flexibility(self) -> float: ...  # in series with the contact, m/N
    # The condition on the reduced contact at a load, N, and an approach, m.
    def sliding(self, load: float, approach: float) -> Sliding: ...
