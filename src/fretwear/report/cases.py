"""What the report takes from the case files: curves for the explorer, and their numerics."""

from __future__ import annotations

import importlib.metadata
import math
import platform
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretwear.data.dataset import representative_cycles
from fretwear.data.files import HISTORY_GROUP, CaseFile, opened_case
from fretwear.report.above import View, read_bearing, read_view
from fretwear.study.case import Case
from fretwear.units import MICROMETRE, number_text, span
from fretwear.vocabulary import CONVOLUTIONS, CYCLE, ERROR_ESTIMATE, HEADLINES, SYMMETRIES

Array = NDArray[np.float64]

PROFILES = ("pressure", "shear_traction", "gap", "wear_depth")
"""Fields along x, a panel of the explorer each."""

READOUT = HEADLINES
"""Numbers at every snapshot."""

HISTORY = ("contact_half_width_x", "stick_half_width_x", "wear_volume")
"""Numbers at every step."""

_EXAMINED = ("pressure", "shear_traction", "gap")
_MOST_SNAPSHOTS = 60
_BEYOND_CONTACT = 1.3
_LIBRARIES = ("numpy", "scipy", "xarray", "netCDF4", "matplotlib")


class Residuals(NamedTuple):
    """How well stored fields meet the equations.

    Attributes
    ----------
    load, tangential_load : float
        By how much the integral of the pressure misses P, and that of the shear traction Q,
        relative to these.
    complementarity : float
        Largest product of pressure and gap in a cell, relative to the peak pressure times the
        Hertz approach a²/R: that of rough bodies may be zero.
    """

    load: float
    tangential_load: float
    complementarity: float


@dataclass(frozen=True)
class CaseRecord:
    """One case along x on the line nearest y = 0, and over the cycles; SI units.

    Attributes
    ----------
    id, source : str
        Case id, and the version of the program that wrote the file.
    parameters : mapping of str to float
        Parameters by name, those that are numbers.
    friction_changes : bool
        Whether friction may be another one in later cycles.
    x : array of shape (n,)
        Cell centres, to a little beyond the largest contact.
    cycles : array of shape (k,)
        Snapshots; of more than 60, representative ones.
    profiles : mapping of str to array of shape (k, n)
        The fields of `PROFILES`.
    states : array of int8 and shape (k, n)
        State of the contact in every cell.
    numbers : mapping of str to array of shape (k,)
        The results of `READOUT`.
    history : mapping of str to array of shape (m,)
        ``cycle``, the results of `HISTORY`, and the numerics of every step.
    cells : int
        Number of cells stored.
    residuals : Residuals
        Of the worst snapshot.
    view : View or None
        The contact from above; None where it is even.
    heights : pair of arrays or None
        Bearing area of a rough contact before and after wear, see `read_bearing`.
    """

    id: str
    source: str
    parameters: Mapping[str, float]
    friction_changes: bool
    x: Array
    cycles: Array
    profiles: Mapping[str, Array]
    states: NDArray[np.int8]
    numbers: Mapping[str, Array]
    history: Mapping[str, Array]
    cells: int
    residuals: Residuals
    view: View | None
    heights: tuple[Array, Array] | None


def read_case(path: Path, case: Case | None = None, *, examine: bool = True) -> CaseRecord:
    """Read a case file once.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    case : Case, optional
        The case as its study has it, which knows where measured surfaces are.
    examine : bool
        Whether to look at the residuals of all fields too, which takes longest; they are NaN
        otherwise.

    Raises
    ------
    CaseFileError
        When the file is missing or damaged.
    """
    with opened_case(path) as file:
        file.check_values()
        parameters = {
            name: float(variable[...])
            for name, variable in file.file.variables.items()
            if not variable.dimensions and variable.dtype.kind == "f"
        }
        cycles, x = file.read("cycle"), file.read("x")
        reach = _BEYOND_CONTACT * float(file.read("contact_half_width_x").max())
        inside = np.flatnonzero(np.abs(x) <= max(reach, 2.0 * float(np.abs(x).min())))
        columns, along = 1, np.s_[inside[0] : inside[-1] + 1]
        row: Any = np.s_[:, along]
        if not file.is_line:
            y = file.read("y")
            columns, row = y.size, np.s_[:, along, int(np.abs(y).argmin())]
        kept = np.isin(cycles, representative_cycles(cycles.astype(int).tolist(), _MOST_SNAPSHOTS))
        copies = 1 << sum(SYMMETRIES[file.attribute("symmetry")])
        profiles = {name: file.read(name, row)[kept] for name in (*PROFILES, "contact_state")}
        normal, tangential = (_floats(file, f"{name}_force") for name in ("normal", "tangential"))
        found = [Residuals(math.nan, math.nan, math.nan)]
        for place in range(cycles.size) if examine else ():
            fields = {name: file.read(name, place) for name in _EXAMINED}
            # A load that is not held, and a force that is not imposed, are results.
            now = {"load": normal[place], "tangential_load": tangential[place]}
            found.append(residuals(fields, parameters | now, copies))
        steps = (CYCLE.name, *HISTORY, ERROR_ESTIMATE.name, CONVOLUTIONS.name)
        return CaseRecord(
            id=file.attribute("case_id"),
            source=file.attribute("source"),
            parameters=parameters,
            friction_changes=bool({"friction_over_cycles", "blocks"} & {*file.file.variables}),
            x=x[inside],
            cycles=cycles[kept],
            states=profiles.pop("contact_state").astype(np.int8),
            profiles={name: lines.astype(np.float64) for name, lines in profiles.items()},
            numbers={name: _floats(file, name)[kept] for name in READOUT},
            history={name: _floats(file, f"{HISTORY_GROUP}/{name}") for name in steps},
            cells=x.size * columns,
            residuals=Residuals(*np.fmax.reduce(found).tolist()),
            view=read_view(file, np.flatnonzero(kept).tolist()),
            heights=read_bearing(file, case),
        )


def _floats(file: CaseFile, name: str) -> Array:
    return file.read(name).astype(np.float64)


def residuals(
    fields: Mapping[str, NDArray[np.floating]], parameters: Mapping[str, float], copies: int
) -> Residuals:
    """Integrate and multiply the fields of one snapshot.

    Parameters
    ----------
    fields : mapping of str to array of shape (nx, ny), or (nx,) in a line contact
        ``pressure``, ``shear_traction`` and ``gap`` in SI units.
    parameters : mapping of str to float
        Parameters of the case.
    copies : int
        How many of the stored part make the whole contact.
    """
    pressure, shear, gap = (fields[name].astype(np.float64) for name in _EXAMINED)
    area = copies * parameters["cell_x"] * (parameters["cell_y"] if pressure.ndim == 2 else 1.0)
    # Where the bodies came by a sphere's contact; else as far as they part in the window.
    radius = parameters.get("radius", parameters.get("indenter_radius", np.nan))
    approach = parameters.get("hertz_radius", np.nan) ** 2 / radius
    approach = approach if np.isfinite(approach) else float(gap.max())
    return Residuals(
        abs(float(pressure.sum()) * area / parameters["load"] - 1.0),
        abs(float(shear.sum()) * area / parameters["tangential_load"] - 1.0),
        float((pressure * gap).max() / (pressure.max() * approach)),
    )


def computation_facts(records: Sequence[CaseRecord], done: int) -> dict[str, str]:
    """Return what there is to say about the numerics of the cases read, of `done` in all."""

    def of(name: str, unit: float = 1.0) -> str:
        return _range(record.parameters[name] / unit for record in records)

    libraries = [f"{name} {importlib.metadata.version(name)}" for name in _LIBRARIES]
    versions = {"Report made with": ", ".join([*libraries, f"Python {platform.python_version()}"])}
    if not records:
        return versions
    errors = [record.history[ERROR_ESTIMATE.name] for record in records]
    examined = [r.residuals for r in records if math.isfinite(r.residuals.load)]
    worst = [number_text(value, 2) for value in np.max(examined, axis=0)]
    in_line = all("cell_y" not in record.parameters for record in records)
    normal, shear = ("∫p dx", "∫q dx") if in_line else ("∬p dA", "∬q dA")
    facts = {
        "Grid spacing along x": f"{of('cell_x', MICROMETRE.size)} µm",
        **({} if in_line else {"Grid spacing along y": f"{of('cell_y', MICROMETRE.size)} µm"}),
        "Cells stored": _range(record.cells for record in records),
        "Tolerance of the wear integration": of("tolerance"),
        "Largest error estimate of a step": _range(
            [float(error[np.isfinite(error)].max(initial=0.0)) for error in errors]
        ),
        "Residual of the load": f"{normal} as written equals P to within {worst[0]} P",
        "Residual of the tangential load": f"{shear} as written equals Q to within {worst[1]} Q",
        "Residual of the contact conditions": (
            f"p·g is at most {worst[2]} of the peak pressure times the Hertz approach"
        ),
        "Accepted steps": _range([max(0, error.size - 1) for error in errors]),
        "Convolutions": _range([record.history[CONVOLUTIONS.name].sum() for record in records]),
    }
    if len(records) < done:
        facts["Cases examined"] = f"{len(records)} of {done}, evenly spread"
    if len(examined) < len(records):
        facts["Residuals are those of"] = f"{len(examined)} of them"
    facts["Simulated with"] = "; ".join(dict.fromkeys(record.source for record in records))
    return facts | versions


def _range(values: Iterable[float]) -> str:
    return span(values, lambda value: number_text(value, 4))
