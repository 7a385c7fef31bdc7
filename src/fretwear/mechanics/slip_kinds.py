"""The slip models as parts of a case."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from fretwear.parts import Part


class SlipModel(Part):
    """How slip follows from the contact.

    Attributes
    ----------
    follows_shape
        Whether plastic flow of the shape changes the reduced contact.
    """

    follows_shape: ClassVar[bool] = True


@dataclass(frozen=True)
class Jaeger(SlipModel):
    """Slip of the worn shape, from its contact at the reduced load."""

    kind: Literal["jaeger"] = "jaeger"
    told_as: ClassVar[str] = "slip of the worn shape"


@dataclass(frozen=True)
class CattaneoMindlin(SlipModel):
    """Slip of the unworn smooth sphere, whatever the shape."""

    kind: Literal["cattaneo_mindlin"] = "cattaneo_mindlin"
    told_as: ClassVar[str] = "slip of the unworn sphere"
    follows_shape: ClassVar[bool] = False
