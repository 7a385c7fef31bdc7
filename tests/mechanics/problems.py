"""Problems that the tests of contact and wear share: the study's own, on coarse grids."""

from dataclasses import replace

import numpy as np
import pytest

from fretwear.mechanics.arrays import Array, Mask
from fretwear.mechanics.contact_problem import ContactProblem
from fretwear.mechanics.halfspace import half_space
from fretwear.mechanics.layers import Layer
from fretwear.mechanics.slip import Friction, JaegerSlip
from fretwear.mechanics.state import WearProblem
from fretwear.mechanics.surfaces import Surface, Waves
from fretwear.mechanics.window import Window
from fretwear.theory import HertzContact, composite_modulus, coupling_ratio

STEEL = (208e9, 0.3)
MODULUS = composite_modulus(*STEEL, *STEEL)
COUPLING = coupling_ratio(*STEEL, *STEEL)
RADIUS, LOAD, FRICTION, WEAR = 10e-3, 50.0, 0.5, 7e-13
HERTZ = HertzContact(RADIUS, LOAD, MODULUS)
A, P0 = HERTZ.contact_radius, HERTZ.peak_pressure

# Long enough for a grid of a/16, of different lengths so that x and y cannot be mixed up.
WAVES = Waves(0.2e-6, 2 * np.pi / (0.7 * A), 2 * np.pi / A)
ROUGH, SMOOTH = Surface(RADIUS, WAVES), Surface(RADIUS)


def fretting(
    cells: float = 16,
    *,
    load_ratio: float = 0.8,
    surface: Surface = SMOOTH,
    limit: float = np.inf,
    **changes: object,
) -> WearProblem:
    """The study's contact at Q/µP = ``load_ratio`` with ``cells`` cells on the Hertz radius.

    ``limit`` is in units of the Hertz pressure p0; other changes are those of `WearProblem`.
    """
    problem = WearProblem(
        surface=surface,
        composite_modulus=MODULUS,
        load=LOAD,
        friction=Friction(FRICTION, COUPLING),
        slip_model=JaegerSlip(LOAD * (1 - load_ratio)),
        wear_coefficient=WEAR,
        limit=limit * P0,
        spacing=(A / cells, A / cells),
        extent=(1.15 * A, 1.15 * A),
    )
    return replace(problem, **changes)


def window(cells: tuple[int, int], half_width: float = 1.15 * A, *, quarter: bool = True) -> Window:
    """A window of a half-width along x and y, divided into ``cells``."""
    width = half_width if quarter else 2 * half_width
    return Window(cells, (width / cells[0], width / cells[1]), quarter)


def pressed(
    window: Window,
    *,
    surface: Surface = SMOOTH,
    load: float = LOAD,
    limit: float = np.inf,
    layer: Layer | None = None,
) -> ContactProblem:
    """The normal contact of a surface on a window; ``limit`` in units of p0."""
    bodies = half_space(window, MODULUS)
    return ContactProblem(bodies, surface.shape(window), load, limit * P0, layer)


def unfolded(field: Array) -> Array:
    """The whole of a field that is even in x and y, from its quarter x > 0, y > 0."""
    half = np.concatenate([field[::-1], field], axis=0)
    return np.concatenate([half[:, ::-1], half], axis=1)


def folded(field: Array) -> Array:
    """The quarter x > 0, y > 0 of a whole field."""
    nx, ny = field.shape
    return field[nx // 2 :, ny // 2 :]


def matrix_of(apply, cells: Mask, precision: type = np.float64) -> Array:
    """The dense matrix of a linear map of fields that live on some cells."""
    columns = []
    for index in np.argwhere(cells):
        unit = np.zeros(cells.shape, precision)
        unit[tuple(index)] = 1.0
        columns.append(apply(unit)[cells])
    return np.stack(columns, axis=1)


def near(expected: float, rel: float = 1e-6) -> object:
    """Equal within a relative tolerance alone.

    The absolute one that `pytest.approx` adds, 1e-12, is more than many a value in SI units.
    """
    return pytest.approx(expected, rel=rel, abs=0.0)
