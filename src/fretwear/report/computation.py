"""How the cases of a study were computed: grids, steps, errors, residuals, times and versions."""

from __future__ import annotations

import importlib.metadata
import math
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
import yaml

from fretwear.data.files import open_case, open_history
from fretwear.report.results import PointResult
from fretwear.running.records import spent_on_simulations
from fretwear.study.plan import Plan
from fretwear.study.study import Study
from fretwear.units import MICROMETRE, duration_text, number_text, size_text

_LIBRARIES = ("numpy", "scipy", "xarray", "netCDF4", "matplotlib")
_MOST_CASES_READ = 200


@dataclass(frozen=True)
class Residuals:
    """How well the stored fields of one case meet the equations, at the worst snapshot.

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
class CaseNumerics:
    """What one case took and reached; grid spacings in m."""

    cells: int
    cell_x: float
    cell_y: float
    tolerance: float
    steps: int
    convolutions: int
    largest_error: float
    residuals: Residuals
    source: str


def computation_facts(plan: Plan, results: Sequence[PointResult], folder: Path) -> dict[str, str]:
    """Return what there is to say about the numerics of all cases that are done, by name.

    Parameters
    ----------
    plan : Plan
        The study's plan.
    results : sequence of PointResult
        What became of its points.
    folder : pathlib.Path
        Folder of the study's results; at most 200 of its case files are read.
    """
    ids = list(dict.fromkeys(result.id for result in results if result.done))
    read = [_numerics(folder / "cases" / f"{case_id}.nc") for case_id in ids[:_MOST_CASES_READ]]
    models = sorted({case.slip_model.kind for case in plan.study.cases().values()})
    facts = {"Slip model": ", ".join(models)}
    if read:
        facts |= _numeric_facts(read)
    if len(ids) > len(read):
        facts["Cases examined"] = f"the first {len(read)} of {len(ids)}"
    if read:
        facts["Simulated with"] = "; ".join(dict.fromkeys(case.source for case in read))
    libraries = [f"{name} {importlib.metadata.version(name)}" for name in _LIBRARIES]
    facts["Report made with"] = ", ".join([*libraries, f"Python {platform.python_version()}"])
    return facts | _time_facts(folder)


def study_text(study: Study) -> str:
    """Return the study file as it stands, or its content where that was changed when loaded."""
    try:
        text = study.file.read_text(encoding="utf-8")
        unchanged = yaml.safe_load(text) == study.content
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        text, unchanged = "", False
    return text if unchanged else yaml.safe_dump(dict(study.content), sort_keys=False)


def residuals(case: xr.Dataset) -> Residuals:
    """Integrate and multiply the stored fields of a case, one snapshot at a time.

    Parameters
    ----------
    case : xarray.Dataset
        Quarter or whole contact.
    """
    copies = 1 if case.attrs["symmetry"] == "none" else 4
    area = copies * float(case["cell_x"]) * float(case["cell_y"])
    approach = float(case["hertz_radius"]) ** 2 / float(case["radius"])
    worst = np.zeros(3)
    for cycle in range(case.sizes["cycle"]):
        now = case.isel(cycle=cycle)
        pressure, shear, gap = (
            now[name].values.astype(np.float64) for name in ("pressure", "shear_traction", "gap")
        )
        found = [
            abs(pressure.sum() * area / float(case["load"]) - 1.0),
            abs(shear.sum() * area / float(case["tangential_load"]) - 1.0),
            float((pressure * gap).max()) / (float(pressure.max()) * approach),
        ]
        worst = np.maximum(worst, found)
    return Residuals(*worst.tolist())


def _numerics(path: Path) -> CaseNumerics:
    with open_case(path) as case, open_history(path) as history:
        errors = history["error_estimate"].values
        return CaseNumerics(
            cells=case.sizes["x"] * case.sizes["y"],
            cell_x=float(case["cell_x"]),
            cell_y=float(case["cell_y"]),
            tolerance=float(case["tolerance"]),
            steps=max(0, history.sizes["step"] - 1),
            convolutions=int(history["convolutions"].sum()),
            largest_error=float(errors[np.isfinite(errors)].max(initial=0.0)),
            residuals=residuals(case),
            source=str(case.attrs["source"]),
        )


def _numeric_facts(cases: Sequence[CaseNumerics]) -> dict[str, str]:
    def worst(name: str) -> str:
        return number_text(max(getattr(case.residuals, name) for case in cases), 2)

    return {
        "Grid spacing along x": f"{_span([MICROMETRE.of(case.cell_x) for case in cases])} µm",
        "Grid spacing along y": f"{_span([MICROMETRE.of(case.cell_y) for case in cases])} µm",
        "Cells stored": _span([case.cells for case in cases]),
        "Tolerance of the wear integration": _span([case.tolerance for case in cases]),
        "Largest error estimate of a step": _span([case.largest_error for case in cases]),
        "Residual of the load": f"∬p dA equals P to within {worst('load')} P",
        "Residual of the tangential load": f"∬q dA equals Q to within {worst('tangential_load')} Q",
        "Residual of the contact conditions": (
            f"p·g is at most {worst('complementarity')} of the peak pressure times the Hertz "
            "approach"
        ),
        "Accepted steps": _span([case.steps for case in cases]),
        "Convolutions": _span([case.convolutions for case in cases]),
    }


def _span(values: Sequence[float]) -> str:
    low, high = number_text(min(values), 4), number_text(max(values), 4)
    return low if low == high else f"{low} to {high}"


def _time_facts(folder: Path) -> dict[str, str]:
    """Return what the simulations took, as far as it was measured."""
    spent = spent_on_simulations(folder)
    if spent is None:
        return {}
    jobs = f"{spent.jobs} job{'s' if spent.jobs > 1 else ''}"
    facts = {
        "Time of all simulations": f"{_time(spent.seconds)}, the sum over {jobs}",
        "Their processor time": _time(spent.processor_seconds),
    }
    if math.isfinite(spent.memory_bytes):
        facts["Memory of the largest job"] = size_text(round(spent.memory_bytes))
    return facts


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 600.0 else duration_text(seconds)
