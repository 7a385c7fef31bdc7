"""What the model neglects of unlike bodies, and by how much: numbers of pages and of a warning."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest

from fretwear.arrays import Array

from ..studies import near
from .oracles import normal_contact, tangential_step

FRICTION = 0.3


@dataclass(frozen=True, eq=False)
class UnlikeCylinder:
    """A cylinder of E* = R = a = 1 on a flat of another material, with friction from the start.

    Pressure and traction on strips of the positions ``x`` move the surfaces by

        w(x) = −2/π ∫ p(ξ) ln|x − ξ| dξ − β ∫ q(ξ) sgn(x − ξ) dξ
        u(x) = −2/π ∫ q(ξ) ln|x − ξ| dξ + β ∫ p(ξ) sgn(x − ξ) dξ

    (Johnson 1985, chapter 2, with Dundurs' β). Every increment of load is a contact with Coulomb
    friction from the tractions of the increment before; nothing knows of a reduced load.
    """

    beta: float
    friction: float
    lifts: bool  # whether tractions move the surfaces normally too; pressure always drags them
    strips: int = 100

    @property
    def width(self) -> float:
        """Width of a strip."""
        return 2.5 / self.strips

    @property
    def x(self) -> Array:
        """Middles of the strips."""
        return (np.arange(self.strips) + 0.5) * self.width - 1.25

    @cached_property
    def influence(self) -> Array:
        """The logarithm, integrated over a strip."""
        ends = self.x[:, None] - self.x + np.array([0.5, -0.5])[:, None, None] * self.width
        high, low = ends * np.log(np.abs(ends)) - ends
        return -2 / np.pi * (high - low)

    @cached_property
    def drag(self) -> Array:
        """The sign, integrated over a strip, times β."""
        return self.beta * self.width * np.sign(self.x[:, None] - self.x)

    def moved(self, load: float, force: float, start: tuple[Array, Array]) -> tuple[Array, ...]:
        """Pressure, traction and slip after an increment; before it pressure and traction."""
        traction, last = start[1], None
        for _ in range(60):
            lift = self.drag @ traction if self.lifts else 0.0
            pressure, *_ = normal_contact(self.influence, self.x**2 / 2 - lift, self.width, load)
            bound, drag = self.friction * pressure, self.drag @ (pressure - start[0])
            step = tangential_step(self.influence, bound, start[1], self.width, force, drag=drag)
            traction, last = step.traction, traction
            if not self.lifts or np.abs(traction - last).max() < 1e-11:
                return pressure, traction, np.where(pressure > 0, step.slip, 0.0)
        raise RuntimeError("pressure and traction did not settle")

    def cycles(self, number: int, ratio: float, steps: int, loading: int) -> list[Array]:
        """∮p|ds| in each strip, and the mean of the tractions at +Q and −Q, of some cycles.

        The normal load is brought up in ``loading`` steps, the force ±``ratio`` µP in ``steps``
        each way.
        """
        load, state, found = np.pi / 4, np.zeros((2, self.strips)), []

        def go(parts, ratios):
            nonlocal state
            wear = np.zeros(self.strips)
            for part, ratio in np.broadcast(parts, ratios):
                *state, slip = self.moved(part * load, ratio * self.friction * load, state)
                wear += state[0] * np.abs(slip)
            return wear, state[1]

        go(np.arange(1, loading + 1) / loading, 0.0)
        go(1.0, ratio * np.linspace(0.0, 1.0, steps // 2 + 1)[1:])
        way = ratio * np.linspace(1.0, -1.0, steps + 1)[1:]
        for _ in range(number):
            (wear, low), (back, high) = go(1.0, way), go(1.0, -way)
            found.append(np.stack([wear + back, 0.5 * (low + high)]))
        return found


def test_cycles_forget_how_the_normal_load_dragged_unlike_bodies():
    """Wear and energy are as for β = 0 from the second cycle on; mean tractions stay."""
    alike, unlike = (
        UnlikeCylinder(beta, FRICTION, lifts=False).cycles(3, 0.9, steps=2, loading=40)
        for beta in (0.0, FRICTION)
    )
    assert unlike[0][0].sum() > 1.01 * alike[0][0].sum()
    for (wear, _), (same, _) in zip(unlike[1:], alike[1:], strict=True):
        np.testing.assert_allclose(wear, same, atol=1e-12 * same.max())
        assert wear.sum() == near(same.sum(), rel=1e-12)
    assert np.abs(alike[-1][1]).max() < 1e-12
    # p0 = 1/2: the traction that the normal load left where it sticks
    assert np.abs(unlike[-1][1]).max() > 0.1 * FRICTION / 2


@pytest.mark.slow
@pytest.mark.parametrize(("beta", "friction"), [(0.1, 0.1), (0.09, 0.9)])
def test_friction_lifts_unlike_bodies_by_the_estimates_of_the_warning(beta, friction):
    """Energy falls by up to 2β², and wear changes locally by up to β(µ + 2β)."""
    (alike, _), (unlike, _) = (
        UnlikeCylinder(each, friction, lifts=True, strips=64).cycles(2, 0.6, 8, loading=16)[-1]
        for each in (0.0, beta)
    )
    assert 0.7 * beta**2 < 1 - unlike.sum() / alike.sum() < 2 * beta**2
    change = np.abs(unlike - alike).sum() / alike.sum()
    estimate = beta * (friction + 2 * beta)
    assert estimate / 3 < change < estimate
