"""Problems that the tests of contact and wear share: the study's own, on coarse grids."""

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fretwear.arrays import Array, Even, Mask
from fretwear.mechanics.contact.cells import HalfSpace
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import Accuracy, ContactProblem, Layer
from fretwear.mechanics.contact.strips import Strips
from fretwear.mechanics.slip.models import Jaeger, Pressed, ReducedContact
from fretwear.mechanics.surfaces.indenters import Cylinder, Sphere
from fretwear.mechanics.surfaces.laws import Archard
from fretwear.mechanics.surfaces.loading import Sliding, TangentialRatio
from fretwear.mechanics.surfaces.materials import Bodies, Coulomb, ElasticBodies
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.surfaces.roughness import Roughness
from fretwear.mechanics.wear.state import WearProblem
from fretwear.theory import HertzContact, composite_modulus, coupling_ratio

STEEL = (208e9, 0.3)
MODULUS = composite_modulus(*STEEL, *STEEL)
COUPLING = coupling_ratio(*STEEL, *STEEL)
RADIUS, LOAD, FRICTION, WEAR = 10e-3, 50.0, 0.5, 7e-13
HERTZ = HertzContact(RADIUS, LOAD, MODULUS)
A, P0 = HERTZ.contact_radius, HERTZ.peak_pressure

DEPTH, VOLUME = A**2 / RADIUS, A**4 / RADIUS
STUDY_LIMIT = 4500e6 / P0

SPHERE, CYLINDER = Sphere(RADIUS), Cylinder(6e-3)
PER_LENGTH, CYLINDER_BODIES = 18.5e3, ElasticBodies(200e9, 0.3)
LINE = CYLINDER.hertz(NormalLoad(PER_LENGTH), CYLINDER_BODIES.composite_modulus)
EDGE = LINE.contact_radius


@dataclass(frozen=True)
class Elastic(Bodies):
    """Bodies by their composite modulus, Pa, and κ alone."""

    composite_modulus: float = MODULUS
    coupling: float = COUPLING


@dataclass(frozen=True)
class Waves(Roughness):
    """Height A cos(k_x x) cos(k_y y), m, of any steepness."""

    amplitude: float
    wavenumber_x: float
    wavenumber_y: float
    even: Even = (True, True)

    def height(self, x: Array, y: Array) -> Array:
        return self.amplitude * np.cos(self.wavenumber_x * x) * np.cos(self.wavenumber_y * y)

    @property
    def highest(self) -> float:
        return self.amplitude

    @property
    def wavelengths(self) -> tuple[float, float]:
        return 2 * np.pi / self.wavenumber_x, 2 * np.pi / self.wavenumber_y


# Long enough for a grid of a/16, of different lengths so that x and y cannot be mixed up.
ROUGH, SMOOTH = Waves(0.2e-6, 2 * np.pi / (0.7 * A), 2 * np.pi / A), None


# What a problem may be even in: computed on the quarter, on either half, on the whole.
EVEN: list[Even] = [(True, True), (True, False), (False, True), (False, False)]

# At the usual tolerance, two ways to the same result agree to that tolerance only.
CONVERGED = Accuracy(*[3e-12] * 6)


def fretting(
    cells: float = 16,
    *,
    load_ratio: float = 0.8,
    limit: float = np.inf,
    wear_coefficient: float = WEAR,
    **changes: object,
) -> WearProblem:
    """The study's contact at Q/µP = ``load_ratio`` with ``cells`` cells on the Hertz radius.

    ``limit`` is in units of the Hertz pressure p0; other changes are fields of `WearProblem`.
    """
    problem = WearProblem(
        indenter=SPHERE,
        roughness=SMOOTH,
        bodies=Elastic(),
        normal=NormalLoad(LOAD),
        loading=TangentialRatio(load_ratio),
        friction_law=Coulomb(FRICTION),
        wear_law=Archard(wear_coefficient),
        slip_model=Jaeger(),
        plastic_limit=limit * P0,
        spacing=(A / cells, A / cells),
        extent=(1.15 * A, 1.15 * A),
    )
    return replace(problem, **changes)


def on_strips(cells: float = 64, *, half_width: float = 1.15, **changes: object) -> WearProblem:
    """The cylinder on a flat of McColl, Ding and Leen (2004), with cells on its half-width."""
    usual = {
        "indenter": CYLINDER,
        "bodies": CYLINDER_BODIES,
        "normal": NormalLoad(PER_LENGTH),
        "geometry": Strips,
        "spacing": (EDGE / cells, EDGE / cells),
        "extent": (half_width * EDGE, half_width * EDGE),
    }
    return fretting(**{**usual, **changes})


def reduced(
    load: float,
    bodies: HalfSpace,
    shape: Array,
    guess: Array | None = None,
    tolerance: float = 1e-8,
) -> ReducedContact:
    """The reduced contact of a shape at a reduced load, N, as Jäger has it."""
    start = None if guess is None else ReducedContact(guess, guess, 0.0, load)
    # Its own fields have no effect.
    whole = Pressed(bodies, shape, shape, shape, 0.0, Sliding(load), tolerance)
    return Jaeger().reduced(fretting(), whole, start)


def unworn(geometry: Grid, roughness: Waves | None = SMOOTH) -> Array:
    """The unworn gap of the study's sphere, smooth or rough, m."""
    return fretting(roughness=roughness).unworn(geometry)


def window(
    cells: tuple[int, int], half_width: float = 1.15 * A, *, even: Even = (True, True)
) -> Grid:
    """A window of a half-width along x and y, divided into ``cells``."""
    x, y = (half_width * (2 - one) / n for n, one in zip(cells, even, strict=True))
    return Grid(cells, (x, y), even)


def uneven(roughness: Waves | None, even: Even = (False, False)) -> Waves:
    """The same surface, said to be even along some axes only."""
    return replace(roughness or Waves(0.0, 1 / A, 1 / A), even=even)


def pressed(
    window: Grid,
    *,
    roughness: Waves | None = SMOOTH,
    load: float = LOAD,
    limit: float = np.inf,
    layer: Layer | None = None,
) -> ContactProblem:
    """The normal contact of a surface on a window; ``limit`` in units of p0."""
    bodies = window.half_space(MODULUS)
    return ContactProblem(bodies, unworn(window, roughness), load, limit * P0, layer)


def unfolded(field: Array, even: Even = (True, True)) -> Array:
    """The whole of a field that is even along some axes, from its positive side."""
    for axis in np.flatnonzero(even):
        field = np.concatenate([np.flip(field, axis), field], axis)
    return field


def folded(field: Array, even: Even = (True, True)) -> Array:
    """The positive side of a whole field along some axes."""
    x, y = (n // 2 if one else 0 for n, one in zip(field.shape, even, strict=True))
    return field[x:, y:]


def covered(outer: Grid, inner: Grid) -> Mask:
    """Which cells of a window lie in a smaller one."""
    result = np.zeros(outer.shape, np.bool_)
    result[outer.where(inner)] = True
    return result


def independent(ratio: float, limit: float, growth: float = 0.0) -> dict[float, dict[str, float]]:
    """What the independent solver found at each τ, for a load ratio and a limit over p0.

    Friction lowers the limit by ``growth``, αµ².
    """
    table = Path(__file__).parent / "reference" / "smooth_wear.csv"
    with table.open(newline="", encoding="utf-8") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    return {
        row["tau"]: row
        for row in rows
        if (row["load_ratio"], row["growth"]) == (ratio, growth)
        and (row["limit_ratio"] == limit or math.isclose(row["limit_ratio"], limit, rel_tol=1e-6))
    }


WORN_BY_VECTOR_FRICTION = {
    0.25: (0.02410, 0.01907, 0.01475, 0.01907),
    0.5: (0.05010, 0.03690, 0.0290, 0.0369),
    1.0: (0.1074, 0.0702, 0.0563, 0.0702),
    3.0: (0.388, 0.184, 0.159, 0.184),
}
"""Volume, maximum depth and depths on the x and the y axis, in a⁴/R and a²/R, by β N p0.

Explicit steps on whole cells of a/36, each with projected gradients, took ν = 0.3 and X = 0.8.
"""
