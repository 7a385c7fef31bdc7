"""Solutions of the effects that the model neglects: unlike bodies, friction in two directions.

Dense matrices, Coulomb's law in every cell or strip, no reduced load.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretwear.arrays import Array

from .oracles import love, normal_contact, tangential_step


@dataclass(frozen=True, eq=False)
class Cycle:
    """A cycle ±Q in each strip: path of slip, ∮p|ds|, mean of the tractions at +Q and −Q; µ∬p|ds|.

    Lengths are in units of the half-width a, tractions in units of E*.
    """

    path: Array
    wear: Array
    mean_traction: Array
    energy: float


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
        distance, half = self.x[:, None] - self.x, self.width / 2

        def primitive(t: Array) -> Array:
            return t * np.log(np.abs(t)) - t

        return -2 / np.pi * (primitive(distance + half) - primitive(distance - half))

    @cached_property
    def drag(self) -> Array:
        """The sign, integrated over a strip, times β."""
        return self.beta * self.width * np.sign(self.x[:, None] - self.x)

    def moved(self, load: float, force: float, before: tuple[Array, Array]) -> tuple[Array, ...]:
        """Pressure, traction and slip after an increment; before it pressure and traction."""
        traction, last = before[1], None
        for _ in range(60):
            lift = self.drag @ traction if self.lifts else 0.0
            pressure, *_ = normal_contact(self.influence, self.x**2 / 2 - lift, self.width, load)
            step = tangential_step(
                self.influence,
                self.friction * pressure,
                before[1],
                self.width,
                force,
                drag=self.drag @ (pressure - before[0]),
            )
            traction, last = step.traction, traction
            if not self.lifts or np.abs(traction - last).max() < 1e-11:
                return pressure, traction, np.where(pressure > 0, step.slip, 0.0)
        raise RuntimeError("pressure and traction did not settle")

    def loaded(self, steps: int) -> tuple[Array, Array]:
        """Pressure and traction after the normal loading, which has no tangential force."""
        state = np.zeros(self.strips), np.zeros(self.strips)
        for part in np.arange(1, steps + 1) / steps:
            pressure, traction, _ = self.moved(part * np.pi / 4, 0.0, state)
            state = pressure, traction
        return state

    def cycles(self, ratio: float, number: int, steps: int = 2, loading: int = 40) -> list[Cycle]:
        """Cycles of the force ±``ratio`` µP, each way in some steps, after the normal loading."""
        load, found = np.pi / 4, []
        force = ratio * self.friction * load
        state = self.loaded(loading)

        def go(ends: Array) -> Iterator[tuple[Array, Array]]:
            nonlocal state
            for end in ends:
                pressure, traction, slip = self.moved(load, end * force, state)
                state = pressure, traction
                yield pressure, np.abs(slip)

        ways = [np.linspace(-end, end, steps + 1)[1:] for end in (-1, 1)]
        list(go(ways[1][ways[1] > 0]))
        for _ in range(number):
            tractions, moves = [], []
            for way in ways:
                moves += [*go(way)]
                tractions.append(state[1])
            wear = sum(pressure * slip for pressure, slip in moves)
            energy = self.friction * self.width * float(wear.sum())
            path, mean = sum(slip for _, slip in moves), sum(tractions) / 2
            found.append(Cycle(path, wear, mean, energy))
        return found


@dataclass(frozen=True, eq=False)
class VectorFriction:
    """A smooth sphere, E* = R = a = 1, whose friction acts along x and y (a quarter, equal bodies).

    A traction on both bodies moves the surfaces relative to each other by (Cerruti)

        u_x = 1/πG ∬ [(1 − ν)/r + ν x²/r³] q_x + ν xy/r³ q_y,    u_y likewise

    Under Q the traction minimises ½ q·Kq in |q| ≤ µp with ∬q = (Q, 0), and the slip is δ − Kq. With
    ``directions`` 1 there is q_x alone, by the mean of the kernel over all directions: the model.
    """

    poisson_ratio: float
    ratio: float  # X = Q/µP
    cells: int  # on the contact radius
    directions: int = 2
    friction = 0.3  # without effect on wear in units of τ

    @property
    def side(self) -> float:
        """Side of a cell."""
        return 1.0 / self.cells

    @cached_property
    def places(self) -> tuple[Array, Array]:
        """Positions x and y of the cells, shape (n,)."""
        line = (np.arange(int(1.35 * self.cells)) + 0.5) * self.side
        x, y = (each.ravel() for each in np.meshgrid(line, line, indexing="ij"))
        near = np.hypot(x, y) < 1.33
        return x[near], y[near]

    def _images(self, kernel: Callable[[Array, Array], Array], sign: int) -> Array:
        """Influence of each cell with its images; −1 stands for a traction that is odd."""
        x, y = self.places
        return sum(
            (sign if i < 0 else 1)
            * (sign if j < 0 else 1)
            * kernel(x[:, None] - i * x, y[:, None] - j * y)
            for i in (1, -1)
            for j in (1, -1)
        )

    def _cell(self, primitive: Callable[[Array, Array], Array]) -> Callable[[Array, Array], Array]:
        """The integral over a cell of the kernel with a primitive in x and y."""
        half = self.side / 2
        return lambda x, y: (
            primitive(x + half, y + half)
            - primitive(x - half, y + half)
            - primitive(x + half, y - half)
            + primitive(x - half, y - half)
        )

    def _inverse_distance(self, x: Array, y: Array) -> Array:
        return love(x, y, (self.side, self.side), 1.0 / np.pi)

    @cached_property
    def normal(self) -> Array:
        """w = Kp, shape (n, n)."""
        return self._images(self._inverse_distance, 1) / np.pi

    @cached_property
    def tangential(self) -> Array:
        """u = Kq, shape (2n, 2n), or (n, n) for a single direction; G = 1 − ν as E* = 1."""
        nu = self.poisson_ratio
        even, odd = (self._images(self._inverse_distance, sign) for sign in (1, -1))
        if self.directions == 1:
            return (1.0 - nu / 2) * even / (np.pi * (1.0 - nu))
        along_x = self._images(self._cell(lambda x, y: y * np.log(x + np.hypot(x, y))), 1)
        along_y = self._images(self._cell(lambda x, y: x * np.log(y + np.hypot(x, y))), -1)
        cross = self._images(self._cell(lambda x, y: -np.hypot(x, y)), -1)
        matrix = np.block(
            [
                [(1.0 - nu) * even + nu * along_x, nu * cross],
                [nu * cross.T, (1.0 - nu) * odd + nu * along_y],
            ]
        )
        return matrix / (np.pi * (1.0 - nu))

    @cached_property
    def _largest(self) -> float:
        return float(np.linalg.eigvalsh(self.tangential)[-1])

    def slip(self, pressure: Array, start: Array | None = None) -> tuple[Array, Array]:
        """Slip in each cell at Q, and the traction, by accelerated projected gradients."""
        size, bound = pressure.size, self.friction * pressure
        total = self.ratio * bound.sum()

        def within(traction: Array) -> Array:
            """The nearest traction within the discs that carries Q, which shifts it along x."""
            x, *y = np.split(traction, self.directions)

            def shifted(by: float) -> Array:
                radius = np.sqrt((x + by) ** 2 + sum(each**2 for each in y))
                factor = np.minimum(1.0, bound / np.maximum(radius, 1e-300))
                return np.concatenate([factor * (x + by), *(factor * each for each in y)])

            low, high = -(most := np.abs(x).max() + 4.0 * bound.max()), most
            for _ in range(50):
                middle = (low + high) / 2
                enough = shifted(middle)[:size].sum() >= total
                low, high = (low, middle) if enough else (middle, high)
            return shifted(high)

        traction = within(np.zeros(self.directions * size) if start is None else start)
        ahead, momentum = traction, 1.0
        for _ in range(5000):
            following = within(ahead - self.tangential @ ahead / self._largest)
            if (ahead - following) @ (following - traction) > 0.0:
                momentum = 1.0
            gained = (1.0 + np.sqrt(1.0 + 4.0 * momentum**2)) / 2
            change, traction = following - traction, following
            ahead, momentum = traction + (momentum - 1.0) / gained * change, gained
            if np.abs(change).max() < 3e-8 * bound.max():
                break
        else:
            raise RuntimeError("the traction did not settle")
        x, *y = np.split(traction, self.directions)
        sticks = (np.sqrt(x**2 + sum(each**2 for each in y)) < (1 - 1e-5) * bound) & (bound > 0)
        x, *y = np.split(self.tangential @ traction, self.directions)
        slip = np.sqrt((x[sticks].mean() - x) ** 2 + sum(each**2 for each in y))
        return np.where(sticks | (pressure == 0.0), 0.0, slip), traction

    def pressed(self, wear: Array | float = 0.0) -> Array:
        """The pressure on the worn sphere."""
        x, y = self.places
        return normal_contact(self.normal, (x**2 + y**2) / 2 + wear, 4 * self.side**2, 4 / 3)[0]

    def worn(self, times: Sequence[float]) -> list[Array]:
        """Wear at some τ = 4KµκN p0 by Heun's steps; ν of one direction is in τ as well."""
        kappa = (2.0 - self.poisson_ratio) / (2.0 * (1.0 - self.poisson_ratio))
        unit = self.friction * kappa * 2.0 / np.pi
        wear, now, traction = np.zeros_like(self.places[0]), 0.0, None
        found = []
        while len(found) < len(times):
            pressure = self.pressed(wear)
            slip, traction = self.slip(pressure, traction)
            # half of the stable explicit step on cells of this side, and short at first
            stable = 0.58 * self.side * 2.0 / np.pi / (slip.max() / (self.friction * kappa))
            step = min(0.4 * stable, 0.12 * max(now, 0.02), times[len(found)] - now)
            rate = pressure * slip / unit
            pressure = self.pressed(wear + step * rate)
            slip, traction = self.slip(pressure, traction)
            wear, now = wear + step * (rate + pressure * slip / unit) / 2, now + step
            if now > times[len(found)] - 1e-9:
                found.append(wear)
        return found

    def along(self, field: Array) -> tuple[Array, Array]:
        """A field on the cells beside the x axis and beside the y axis."""
        x, y = self.places
        return field[y < self.side], field[x < self.side]
