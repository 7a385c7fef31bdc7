"""What presses the bodies together: a load, or an approach."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic.dataclasses import dataclass

from fretwear.quantity import Part, Quantity
from fretwear.theory import HertzContact
from fretwear.units import ContactFrame

# Units in the ids of cases, by SI unit: the number per SI unit, and its name.
_IN_IDS = {"N": (1.0, "N"), "N m-1": (1e-3, "N_mm"), "m": (1e6, "um"), "1": (1.0, "")}


class Imposed(Part):
    """An imposed quantity: the parameter with the name of its kind.

    Loads are forces or, in a line contact, forces per length.
    """

    letter: ClassVar[str] = ""  # symbol in the id of a case

    def slug_in(self, frame: ContactFrame) -> str:
        """Letter and value: ``P50N``, in a line contact ``P18.5N_mm``; ``d2.2um``, ``X0.8``."""
        if not self.letter:
            return self.kind
        size, unit = _IN_IDS[frame.unit(self.parameters()[self.kind].si_unit)]
        return f"{self.letter}{vars(self)[self.kind] * size:.4g}{unit}"


class Normal(Imposed):
    """The normal loading."""

    pulsating_load: float = 1.0  # least load over the largest, in phase with the motion

    @property
    def held(self) -> tuple[float | None, float | None]:
        """Load P, N, and approach d, m: one is held while the bodies wear, the other is None."""
        raise NotImplementedError

    @property
    def holds_load(self) -> bool:
        """Whether the load is held."""
        return self.held[0] is not None

    def hertz(self, smooth: HertzContact) -> HertzContact:
        """The unworn smooth contact, from the same contact under any load."""
        load, approach = self.held
        if load is not None:
            return smooth.with_load(load)
        assert approach is not None
        return smooth.with_approach(approach)


@dataclass(frozen=True)
class NormalLoad(Normal):
    """A load that is constant or changes in phase with the motion."""

    load: Annotated[
        float,
        Quantity("N", "$P$", "normal load", "N", gt=0.0),
        "Normal load; of a cylinder per length, 18.5 N/mm.",
    ]
    pulsating_load: Annotated[
        float,
        Quantity("1", "$R_P$", "load ratio", like="0.3", ge=0.0, le=1.0, omitted_value=1.0),
        "Least over largest load; the largest acts at +Q or at one end of the stroke; 0: the "
        "contact opens.",
    ] = 1.0
    kind: Literal["load"] = "load"
    letter: ClassVar[str] = "P"

    @property
    def held(self) -> tuple[float, None]:
        """The load P."""
        return self.load, None


@dataclass(frozen=True)
class Indentation(Normal):
    """A constant approach; the load falls as the bodies wear."""

    indentation: Annotated[
        float,
        Quantity("m", "$δ$", "indentation", "um", like="2.2 um", gt=0.0),
        "Constant approach of the bodies, instead of load.",
    ]
    kind: Literal["indentation"] = "indentation"
    letter: ClassVar[str] = "d"

    @property
    def held(self) -> tuple[None, float]:
        """The approach d."""
        return None, self.indentation
