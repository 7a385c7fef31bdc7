"""The mechanical problem of a case, and the states of its run."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import Accuracy
from fretwear.mechanics.surfaces.setup import Setup
from fretwear.mechanics.wear.integrator import evolve
from fretwear.mechanics.wear.pulsating import evolve_pulsating
from fretwear.mechanics.wear.state import State, WearProblem
from fretwear.mechanics.wear.stroke import StrokeState, slide
from fretwear.study.case import Case
from fretwear.study.memory import WINDOW_MARGIN


def wear_problem(
    case: Case,
    geometry: type[Geometry] | None = None,
    coarseness: float | None = None,
) -> WearProblem:
    """The mechanical problem of a case, on its default cells or others; rings may be wider."""
    # A contact entirely at the limit is the smallest one that carries the load.
    spread = WINDOW_MARGIN * max(1.0, case.hertz.spread_radius(case.slip_limit) / case.hertz_radius)
    x, y = case.indenter.half_widths(case.hertz)
    blocks: list[tuple[float, Setup]] = []
    for end, block in case.in_blocks():
        assert block is not None
        loading = block.loading if block.loading.is_force else block.plain_loading
        setup = block.changed(loading=loading).setup
        if blocks and blocks[-1][1] == setup:
            blocks.pop()
        blocks.append((end, setup))
    blocks[-1] = math.inf, blocks[-1][1]
    return WearProblem(
        **vars(blocks[0][1]),
        slip_model=case.cells.solved_slip_model,
        spacing=case.grid_spacing,
        extent=(spread * x, spread * y),
        geometry=geometry or case.cells.geometry,
        coarseness=coarseness or case.coarseness,
        blocks=tuple(blocks) if len(blocks) > 1 else (),
    )


def states(
    case: Case, problem: WearProblem, start: State | None = None, *, for_errors: bool = False
) -> Iterator[State]:
    """Yield each accepted state of a case: cycle 0 and all others, or those after ``start``.

    Looser contacts suffice for a run that only tells the errors of another one.
    """
    stops = [*map(float, case.output_cycles)]
    if problem.loading.stroke:
        assert start is None or isinstance(start, StrokeState)
        return slide(problem, stops, case.tolerance, start)
    if problem.normal.pulsating_load < 1.0:
        return evolve_pulsating(problem, stops, case.tolerance, start)
    accuracy = Accuracy()
    if problem.geometry is Grid and math.isfinite(case.accuracy):
        accuracy = accuracy.loosened(case.accuracy)
    if for_errors:
        accuracy = accuracy.for_errors
    return evolve(problem, stops, case.tolerance, start, accuracy)
