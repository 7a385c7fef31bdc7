"""Fields of the dataset of a case, from the states of its run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fretwear.mechanics.wear.measures import fractions
from fretwear.mechanics.wear.state import State, Workspace
from fretwear.mechanics.wear.stroke import StrokeState
from fretwear.results import BODY_FIELDS, FIELDS, FRICTION_FIELD, VECTOR_FIELDS
from fretwear.variable import ContactState


def snapshot_fields(
    workspace: Workspace, snapshots: Sequence[State]
) -> dict[str, NDArray[np.generic]]:
    """The fields of a dataset over all snapshots on one plane, in the stored precision.

    Fields in double precision, listed and then stacked, would take most of a run's memory.
    """
    last = snapshots[-1].geometry
    plane = last.plane(workspace.problem.spacing)
    shape = plane.shape[: len(workspace.problem.frame.axes)]
    fields = [*FIELDS]
    fields += BODY_FIELDS if snapshots[-1].wear_of_each(workspace.problem) else ()
    fields += VECTOR_FIELDS if snapshots[-1].reduced.sheared is not None else ()
    fields += (FRICTION_FIELD,) if workspace.problem.friction_law.follows_slip else ()
    stored = {field.name: np.empty((len(snapshots), *shape), field.dtype) for field in fields}
    for row, snapshot in enumerate(snapshots):
        state = snapshot.on(workspace, snapshot.geometry.extended(last))
        problem = workspace.problem.of(state)
        reduced, closed = state.reduced, state.in_contact
        slip = problem.slip(reduced)
        contact_state = np.where(closed, ContactState.SLIP, ContactState.OPEN)
        contact_state[reduced.stick & closed] = ContactState.STICK
        law = problem.friction_law
        path = 4.0 * state.pressure * slip
        worn = problem.combined_wear_coefficient * problem.wear_ratio * path
        if problem.interface is not None:
            worn = worn * problem.interface.slope(state.wear)
        rate = np.maximum(worn - problem.withheld_depth, 0.0)
        shearing = law.ratio * state.pressure
        if isinstance(state, StrokeState):
            rate = state.rate(problem.interface)
        elif state.pulse is not None:
            rate = problem.combined_wear_coefficient * state.pulse.path
            slip = slip * state.pulse.share
            shearing = 0.5 * (state.pressure + state.pulse.least)
        bodies = state.wear_of_each(problem).values()
        values_of = {
            "pressure": state.pressure,
            "reduced": reduced.pressure,
            "shearing": shearing,
            "slip": slip,
            "wear_depth": state.wear,
            "wear_rate": rate,
            "path": path,
            "plastic_depth": state.plastic,
            "gap": state.gap,
            "contact_state": contact_state,
            **{field.name: wear for field, wear in zip(BODY_FIELDS, bodies, strict=False)},
        }
        if reduced.sheared is not None:
            ways = reduced.sheared.ways * slip
            values_of |= {"slip_x": ways[0], "slip_y": ways[1]}
            traction = reduced.sheared.traction
            values_of |= {"shear_traction": traction[0], "shear_traction_y": traction[1]}
        if law.follows_slip:
            values_of[FRICTION_FIELD.name] = law.coefficient * np.asarray(law.ratio)
        written = state.geometry.written(values_of, plane)
        if law.follows_slip:
            # This makes it a bound of the mean traction by the mean pressure.
            sheared, carried = (
                law.coefficient * np.asarray(written["shearing"]),
                written["pressure"],
            )
            np.divide(sheared, carried, out=written[FRICTION_FIELD.name], where=carried > 0.0)
        if reduced.sheared is None:
            # Means over a cell that slips in part obey Coulomb's law by mean pressures.
            sticking = replace(reduced, pressure=written["reduced"])
            written["shear_traction"] = problem.shear_traction(written["shearing"], sticking)
        written["contact_fraction"], written["stick_fraction"] = fractions(problem, state, plane)
        cells: object = state.geometry
        if plane != cells:
            # Cells cut by an edge touch if they carry load, and slip or stick like most of their
            # pressure.
            loaded, touch = written["pressure"] > 0.0, written["contact_state"]
            written["gap"][loaded] = 0.0
            touch[loaded] = np.maximum(touch[loaded], ContactState.SLIP)
            if not (problem.loading.stroke or state.pulse):
                carried = 4.0 * written["pressure"][loaded]
                written["slip"][loaded] = written["path"][loaded] / carried
            if reduced.sheared is not None:
                _obey_friction(written, problem.friction_law.coefficient)
        off_punch = np.hypot(plane.x[:, None], plane.y) > problem.indenter.end
        for name, value in (("gap", np.nan), ("slip", 0.0)):
            written[name][off_punch & (written["pressure"] == 0.0)] = value
        for name, values in stored.items():
            values[row] = written[name].reshape(shape)
    return stored


def _obey_friction(written: dict[str, NDArray[np.generic]], friction: float) -> None:
    """Give means of vectors over cells the lengths and directions of friction.

    The traction is at most µp. In cells that slip as a whole it is µp along the slip, as the mean
    of vectors that turn would be slightly shorter. The slip is as long as its mean amplitude.
    """
    least = np.finfo(np.float64).tiny
    traction, slip = (
        np.stack([written[name], written[partner]])
        for name, partner in (("shear_traction", "shear_traction_y"), ("slip_x", "slip_y"))
    )
    bound = friction * np.asarray(written["pressure"])
    slips = (written["stick_fraction"] == 0.0) & (bound > 0.0)
    of_traction, of_slip = (
        vector / np.maximum(np.hypot(*vector), least) for vector in (traction, slip)
    )
    length = np.where(slips, bound, np.minimum(np.hypot(*traction), bound))
    written["shear_traction"], written["shear_traction_y"] = of_traction * length
    way = np.where(slips, of_traction, of_slip)
    written["slip_x"], written["slip_y"] = way * written["slip"]
