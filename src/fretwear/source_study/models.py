"""What the slip of the unworn sphere costs against the slip of the worn shape."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretwear.source_study.evolution import Evolution
from fretwear.source_study.quartet import Quartet

_NOTHING = 1e-3


@dataclass(frozen=True)
class Quantity:
    """A quantity that both models give.

    Attributes
    ----------
    label : str
        What a table calls it.
    value : callable
        Takes a case and a snapshot of it; SI unit.
    """

    label: str
    value: Callable[[Evolution, int], float]


@dataclass(frozen=True)
class Cost:
    """One quantity of one case at one cycle by both models, SI unit.

    Attributes
    ----------
    subject : str
        Which case.
    cycle : int
        At which snapshot.
    label : str
        Which quantity.
    following, simple : float
        With the slip of the worn shape, and with that of the unworn sphere.
    """

    subject: str
    cycle: int
    label: str
    following: float
    simple: float

    @property
    def ratio(self) -> float:
        """Simple model to following one; NaN where there is nothing left to compare with."""
        comparable = self.following > _NOTHING * self.simple
        return self.simple / self.following if comparable else np.nan


def _scalar(label: str, name: str) -> Quantity:
    return Quantity(label, lambda case, cycle: case.scalar(name, cycle))


QUANTITIES = (
    _scalar("Wear volume", "wear_volume"),
    Quantity("Deepest wear", lambda case, cycle: float(case.field("wear_depth", cycle).max())),
    _scalar("Contact half-width", "contact_half_width_x"),
    _scalar("Stick half-width", "stick_half_width_x"),
    Quantity(
        "Mean pressure in the stick zone",
        lambda case, cycle: float(case.field("pressure", cycle)[case.zones(cycle).stick].mean()),
    ),
    _scalar("Energy dissipated in a cycle", "dissipated_energy"),
)


def costs(following: Quartet, simple: Quartet, cycle: int) -> list[Cost]:
    """Compare the models case by case.

    Parameters
    ----------
    following, simple : Quartet
        Cases with the slip of the worn shape, and with that of the unworn sphere.
    cycle : int
        The snapshot nearest this one is compared.
    """
    found = []
    for (subject, case), (_, other) in zip(following.each(), simple.each(), strict=True):
        nearest = case.nearest(cycle)
        for quantity in QUANTITIES:
            values = (quantity.value(one, nearest) for one in (case, other))
            found.append(Cost(subject, nearest, quantity.label, *values))
    return found


def excess_shear(case: Evolution, cycle: int) -> float:
    """Share of the tangential load that a case carries against Coulomb's law.

    Where the shear traction exceeds µp, valleys without pressure included, friction cannot
    carry it: the integral of that excess, as a share of Q. The slip of the worn shape has none.
    """
    shear = np.abs(case.field("shear_traction", cycle))
    excess = shear - case.parameter("friction") * case.field("pressure", cycle)
    sides = [float(np.diff(case.dataset[name].values).mean()) for name in ("x", "y")]
    quarters = 1.0 if case.dataset.attrs["symmetry"] == "none" else 4.0
    total = quarters * sides[0] * sides[1] * float(np.maximum(excess, 0.0).sum())
    return total / case.parameter("tangential_load")
