"""Cells and memory of a run, which limit how narrow its cells can be."""

from __future__ import annotations

import math
from typing import NamedTuple

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Row, Strips
from fretwear.study.case import Case
from fretwear.study.discretisation import LEAST_COARSENESS

WINDOW_MARGIN = 1.15
# Fitted to runs: actual memory is within half of this.
MEMORY_TO_START, MEMORY_OF_GRADED = 165_000_000, 72 * 500**2
MEMORY_PER_SQUARED_STRIP, MEMORY_PER_CELL_OF_SNAPSHOT = 72, 110
MEMORY_PER_CELL = 8 * 4 * 18  # arrays of a padded window

MOST_MEMORY = 2 * 1024**3
_WIDTHS = [LEAST_COARSENESS * 2.0 ** (n / 4.0) for n in range(13)]


class Window(NamedTuple):
    """Cells of the largest window of a run."""

    x: int  # along x and y, computed or, on rings, written
    y: int
    unworn: float  # cells of the window of the unworn contact
    places: float  # positions at which a stroke is computed
    matrix: float  # cells or strips that share a matrix; 0 without one

    @property
    def cells(self) -> int:
        """All cells."""
        return self.x * self.y


def window(case: Case, width: float) -> Window:
    """Return the largest window of a run on cells that are `width` times as wide as the case's.

    The window ends slightly outside the largest contact of the run, plus the reach of the
    roughness. Graded rings and strips become narrower or wider in proportion.
    """
    geometry, stroke = case.cells.geometry, case.loading.stroke
    dx, dy = (case.times_written(width) * spacing for spacing in case.grid_spacing)
    sides_x, sides_y = (2 - is_even for is_even in case.even)
    wider = WINDOW_MARGIN * case.cells.greatest_contact_radius / case.hertz_radius
    reach_x, reach_y = (wider * half for half in case.indenter.half_widths(case.hertz))
    cells_x = sides_x * math.ceil(reach_x / dx)
    cells_y = 1 if geometry in (Strips, Row) else sides_y * math.ceil(reach_y / dy)
    if stroke and geometry is Grid:
        cells_y = math.ceil(WINDOW_MARGIN * case.cells.scar_half_width / dy)
    places, matrix = 1.0, 0.0
    if case.loading.travel > case.small_stroke:
        of_ends = min(3.0 * stroke / dx, 36.0) if geometry in (Strips, Row) else 4.0
        places += sides_x * max(4.0, 2.0 * stroke / case.hertz_radius, of_ends)
    if geometry in (Strips, Row):
        # Strips over a stroke, and rough or uneven ones, have matrices and equal widths.
        matrix = cells_x if stroke or case.rough is not None or geometry is Row else 0
    elif stroke and geometry is Grid:
        matrix = 0.5 * math.pi * case.cells.scar_half_width**2 / (dx * dy)
    unworn = sides_x * sides_y * (WINDOW_MARGIN * case.hertz_radius) ** 2 / (dx * dy)
    return Window(cells_x, cells_y, unworn, places, matrix)


def memory_of(case: Case, width: float) -> int:
    """Return the memory, bytes, of a run on cells that are `width` times as wide as the case's."""
    cells = window(case, width)
    memory = 0 if issubclass(case.cells.geometry, Rings) else MEMORY_PER_CELL * cells.cells
    if case.loading.stroke and case.cells.geometry is Grid:
        memory = 8 * int(cells.places * cells.matrix**2 + 6 * cells.cells * cells.y)
    elif not case.loading.stroke:
        memory += MEMORY_PER_SQUARED_STRIP * int(cells.matrix) ** 2
    if case.cells.is_graded:
        memory += int(max((width * case.coarseness) ** -2 - 1.0, 0.0) * MEMORY_OF_GRADED)
    written = cells.cells * len(case.output_cycles)
    return MEMORY_TO_START + memory + MEMORY_PER_CELL_OF_SNAPSHOT * written


def affordable_width(case: Case) -> float:
    """Width of the narrowest cells over the default that fit into `MOST_MEMORY`."""
    return next((width for width in _WIDTHS if memory_of(case, width) <= MOST_MEMORY), 1.0)
