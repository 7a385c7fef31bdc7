"""What the report says about numerics: how well case files meet the equations, and what it took."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretwear.data.files import HISTORY_GROUP, opened_case
from fretwear.units import MICROMETRE, number_text, span
from fretwear.vocabulary import CONVOLUTIONS, ERROR_ESTIMATE, SYMMETRIES

_EXAMINED = ("pressure", "shear_traction", "gap")
_LIBRARIES = ("numpy", "scipy", "xarray", "netCDF4", "matplotlib")


class Residuals(NamedTuple):
    """How well stored fields meet the equations."""

    load: float  # by how much the integral of the pressure misses P, relative to it
    tangential_load: float  # and that of the shear traction Q
    # Largest product of pressure and gap in a cell, relative to the peak pressure times the Hertz
    # approach a²/R: that of rough bodies may be zero.
    complementarity: float


@dataclass(frozen=True)
class Numerics:
    """How one case was computed."""

    source: str  # version of the program that wrote the file
    parameters: Mapping[str, float]  # those that are numbers
    cells: int  # that are stored
    steps: int  # that were accepted
    convolutions: int
    error: float  # largest estimate of the error of a step
    residuals: Residuals  # of the worst snapshot


def examine(path: Path) -> Numerics:
    """Read a case file once.

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
        copies = 1 << sum(SYMMETRIES[file.attribute("symmetry")])
        # A load that is not held, and a force that is not imposed, are results.
        forces = zip(file.read("normal_force"), file.read("tangential_force"), strict=True)
        found = []
        for place, (normal, tangential) in enumerate(forces):
            fields = {name: file.read(name, place) for name in _EXAMINED}
            now = {"load": float(normal), "tangential_load": float(tangential)}
            found.append(residuals(fields, parameters | now, copies))
        errors = file.read(f"{HISTORY_GROUP}/{ERROR_ESTIMATE.name}")
        return Numerics(
            source=file.attribute("source"),
            parameters=parameters,
            cells=fields["gap"].size,
            steps=max(0, errors.size - 1),
            convolutions=int(file.read(f"{HISTORY_GROUP}/{CONVOLUTIONS.name}").sum()),
            error=float(errors[np.isfinite(errors)].max(initial=0.0)),
            residuals=Residuals(*np.fmax.reduce(found).tolist()),
        )


def residuals(
    fields: Mapping[str, NDArray[np.floating]], parameters: Mapping[str, float], copies: int
) -> Residuals:
    """Integrate and multiply the fields of one snapshot: pressure, shear traction and gap.

    They are SI, of shape (nx, ny), or (nx,) in a line contact; so many `copies` of the stored part
    make the whole contact.
    """
    pressure, shear, gap = (fields[name].astype(np.float64) for name in _EXAMINED)
    area = copies * parameters["cell_x"] * (parameters["cell_y"] if pressure.ndim == 2 else 1.0)
    # For other bodies than a sphere: the largest gap in the window.
    radius = parameters.get("radius", parameters.get("indenter_radius", np.nan))
    approach = parameters.get("hertz_radius", np.nan) ** 2 / radius
    approach = approach if np.isfinite(approach) else float(gap.max())
    return Residuals(
        abs(float(pressure.sum()) * area / parameters["load"] - 1.0),
        abs(float(shear.sum()) * area / parameters["tangential_load"] - 1.0),
        float((pressure * gap).max() / (pressure.max() * approach)),
    )


def computation_facts(examined: Sequence[Numerics], done: int) -> dict[str, str]:
    """Return what there is to say about the numerics of the cases examined, of `done` in all."""

    def of(name: str, unit: float = 1.0) -> str:
        return _range(each.parameters[name] / unit for each in examined)

    libraries = [f"{name} {importlib.metadata.version(name)}" for name in _LIBRARIES]
    versions = {"Report made with": ", ".join([*libraries, f"Python {platform.python_version()}"])}
    if not examined:
        return versions
    worst = [number_text(v, 2) for v in np.max([each.residuals for each in examined], axis=0)]
    in_line = all("cell_y" not in each.parameters for each in examined)
    normal, shear = ("∫p dx", "∫q dx") if in_line else ("∬p dA", "∬q dA")
    facts = {
        "Grid spacing along x": f"{of('cell_x', MICROMETRE.size)} µm",
        **({} if in_line else {"Grid spacing along y": f"{of('cell_y', MICROMETRE.size)} µm"}),
        "Cells stored": _range(each.cells for each in examined),
        "Tolerance of the wear integration": of("tolerance"),
        "Largest error estimate of a step": _range(each.error for each in examined),
        "Residual of the load": f"{normal} as written equals P to within {worst[0]} P",
        "Residual of the tangential load": f"{shear} as written equals Q to within {worst[1]} Q",
        "Residual of the contact conditions": (
            f"p·g is at most {worst[2]} of the peak pressure times the Hertz approach"
        ),
        "Accepted steps": _range(each.steps for each in examined),
        "Convolutions": _range(each.convolutions for each in examined),
    }
    if len(examined) < done:
        facts["Cases examined"] = f"{len(examined)} of {done}, evenly spread"
    facts["Simulated with"] = "; ".join(dict.fromkeys(each.source for each in examined))
    return facts | versions


def _range(values: Iterable[float]) -> str:
    return span(values, lambda value: number_text(value, 4))
