"""Where the cells of a run lie: for its first loading, before a step, and around its contact.

Pressure exists only near the contact, so fields live on a window a little larger than it. A smooth
contact grows at its border, so pressure near the window's border announces growth. In a rough
contact the next asperity tip lies up to a wavelength away, with no contact in between, so the
surface outside the window is checked too. It is unworn there; its gap is the displacement by the
pressure inside plus the shape minus the approach.

A new kind of cells gets an entry in `FIRST_CELLS` and registers itself with the other functions.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import singledispatch

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.dense import DenseCells
from fretwear.mechanics.contact.grid import BORDER, Grid, fast_shape
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Row, Strips
from fretwear.mechanics.wear.grading import (
    WIDENED,
    first_rings,
    first_strips,
    next_rings,
    widened_strips,
)
from fretwear.mechanics.wear.state import Stage, WearProblem, Workspace
from fretwear.theory import LineContact

# Cells beside the border of a window, over all, that must be free before a step. A step seldom
# widens a contact by more; growing the window beforehand costs less than repeating the step.
_AHEAD = 0.02
# Fraction of a wavelength from a valley in the middle to beyond the tips beside it.
_TO_TIPS = 0.6
# Factor by which a row of strips exceeds the needed length.
_ROOM = 1.1


def first_grid(problem: WearProblem) -> Grid:
    """The window for the first loading of a problem."""
    extent = problem.extent
    if problem.wavelengths is not None:
        # Under a small load the middle may be a valley, and the tips beside it touch.
        (x, y), tips, reach = extent, problem.wavelengths, problem.reach(0.0)
        extent = (
            max(x, min(_TO_TIPS * tips[0], reach[0])),
            max(y, min(_TO_TIPS * tips[1], reach[1])),
        )
    return Grid(fast_shape(extent, problem.spacing, problem.even), problem.spacing, problem.even)


def first_row(problem: WearProblem) -> Row:
    """Equal strips on both sides for the first loading of a problem."""
    assert isinstance(problem.hertz, LineContact)
    row = Row((2, 1), problem.spacing, (False, True), problem.hertz.reference)
    return row.out_to(problem.extent[0] + _to_next_tip(problem))


FIRST_CELLS: dict[type[Geometry], Callable[[WearProblem], Geometry]] = {
    Grid: first_grid,
    Rings: first_rings,
    Strips: first_strips,
    Row: first_row,
}


def first_cells(problem: WearProblem) -> Geometry:
    """The cells for the first loading of a problem."""
    return FIRST_CELLS[problem.geometry](problem)


@singledispatch
def next_cells(cells: Geometry, problem: WearProblem, stage: Stage) -> Geometry:
    """Cells for the step after a stage: the same, or larger ones if it may need them."""
    raise TypeError(f"{type(cells).__name__} are not registered in {__name__}")


@next_cells.register
def _(cells: Grid, problem: WearProblem, stage: Stage) -> Geometry:
    nx, ny = cells.shape
    border = BORDER + math.ceil(_AHEAD * nx), BORDER + math.ceil(_AHEAD * ny)
    return cells.grown(cells.touched(stage.pressure, border))


@next_cells.register
def _(cells: Row, problem: WearProblem, stage: Stage) -> Geometry:
    return _row_holding(cells, problem, stage.pressure, WIDENED)


@next_cells.register
def _(cells: Strips, problem: WearProblem, stage: Stage) -> Geometry:
    reach = WIDENED * cells.radius_of(stage.pressure) + _to_next_tip(problem)
    return widened_strips(cells.reaching(reach), problem, stage)


@next_cells.register
def _(cells: Rings, problem: WearProblem, stage: Stage) -> Geometry:
    return next_rings(cells, problem, stage)


@singledispatch
def holding_cells(
    cells: Geometry, workspace: Workspace, pressure: Array, approach: float
) -> Geometry:
    """The same cells, or more if a contact under a pressure, Pa, at an approach, m, needs them."""
    raise TypeError(f"{type(cells).__name__} are not registered in {__name__}")


@holding_cells.register
def _(cells: Grid, workspace: Workspace, pressure: Array, approach: float) -> Geometry:
    grid = cells
    while True:
        held = cells.resized(pressure, grid)
        border, excess = grid.touched(held), _touches_beyond(grid, workspace, held, approach)
        larger = grid.grown((border[0] or excess[0], border[1] or excess[1]))
        if larger is grid:
            return grid
        grid = larger


@holding_cells.register
def _(cells: Row, workspace: Workspace, pressure: Array, approach: float) -> Geometry:
    return _row_holding(cells, workspace.problem, pressure)


@holding_cells.register
def _(cells: DenseCells, workspace: Workspace, pressure: Array, approach: float) -> Geometry:
    return cells.reaching(cells.radius_of(pressure) + _to_next_tip(workspace.problem))


def _row_holding(row: Row, problem: WearProblem, pressure: Array, widened: float = 1.0) -> Row:
    touched = np.abs(row.x[pressure[:, 0] > 0.0]).max(initial=0.0) + row.spacing[0]
    half = widened * touched + _to_next_tip(problem)
    return row if half <= row.extent[0] else row.out_to(_ROOM * half)


def _to_next_tip(problem: WearProblem) -> float:
    """Distance along x to the next asperity tip, m; zero if the bodies are smooth."""
    return 0.0 if problem.wavelengths is None else problem.wavelengths[0]


def _touches_beyond(
    grid: Grid, workspace: Workspace, pressure: Array, approach: float
) -> tuple[bool, bool]:
    """Whether the surfaces touch outside a window, along x and along y."""
    problem = workspace.problem
    if problem.wavelengths is None:
        return False, False
    # A wavelength outside, as far as the surface lies below the approach.
    x, y = (
        max(half, min(half + wavelength, far))
        for half, wavelength, far in zip(
            grid.extent, problem.wavelengths, problem.reach(approach), strict=True
        )
    )
    wide = grid.covering((x, y))
    if wide.shape == grid.shape:
        return False, False
    bodies = workspace.on(wide)
    outside = np.ones(wide.shape, dtype=np.bool_)
    outside[wide.where(grid)] = False
    # Displacement only opens the gap: where the surface lies above the approach it stays open.
    if not ((bodies.unworn < approach) & outside).any():
        return False, False
    moved, unit = bodies.half_space.relative_displacement(grid.resized(pressure, wide))
    gap = np.multiply(moved, unit, dtype=np.float64)
    gap += bodies.unworn
    closed = (gap < approach) & outside
    beyond_x, beyond_y = abs(wide.x) > grid.extent[0], abs(wide.y) > grid.extent[1]
    return bool(closed[beyond_x].any()), bool(closed[:, beyond_y].any())
