"""How the cases of a study were computed: grids, steps, errors, versions."""

from __future__ import annotations

import importlib.metadata
import math
import platform
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
import yaml

from fretwear.data.files import open_case, open_history
from fretwear.figures.wording import MICROMETRE, number
from fretwear.report.results import PointResult
from fretwear.running.records import spent_on_simulations
from fretwear.study.file import Study
from fretwear.study.plan import Plan, duration, size

_LIBRARIES = ("numpy", "scipy", "xarray", "netCDF4", "matplotlib")
_MOST_CASES_READ = 200


@dataclass(frozen=True)
class Residuals:
    """How well the stored fields of one case meet the equations, at the worst snapshot.

    Parameters
    ----------
    load, tangential_load : float
        By how much the integral of the pressure misses P, and that of the shear traction Q,
        relative to these.
    complementarity : float
        Largest product of pressure and gap in a cell, relative to the highest pressure times the
        Hertz approach a²/R: that of rough bodies may be zero.
    """

    load: float
    tangential_load: float
    complementarity: float


@dataclass(frozen=True)
class CaseNumerics:
    """What one case took and reached."""

    cells: int
    spacing: tuple[float, float]
    tolerance: float
    steps: int
    convolutions: int
    largest_error: float
    residuals: Residuals
    source: str


@dataclass(frozen=True)
class Fact:
    """One line of a table of facts."""

    name: str
    value: str


def computation_facts(plan: Plan, results: Sequence[PointResult], cases: Path) -> list[Fact]:
    """Return what is to be said of the numerics of all cases that are done.

    Parameters
    ----------
    plan : Plan
        The study's plan.
    results : sequence of PointResult
        What became of its points.
    cases : pathlib.Path
        Folder of the case files; at most 200 of them are read.
    """
    ids = list(dict.fromkeys(result.id for result in results if result.done))
    numerics = [_numerics(cases / f"{case_id}.nc") for case_id in ids[:_MOST_CASES_READ]]
    models = sorted({case.slip_model for case in plan.study.cases().values()})
    facts = [Fact("Slip model", ", ".join(models)), *_numeric_facts(numerics)]
    if len(ids) > _MOST_CASES_READ:
        facts.append(Fact("Cases looked at", f"the first {_MOST_CASES_READ} of {len(ids)}"))
    return [*facts, *_version_facts(numerics)]


def time_facts(folder: Path) -> list[Fact]:
    """Return what the simulations took, as far as it was measured.

    Parameters
    ----------
    folder : pathlib.Path
        Folder of the study's results.
    """
    spent = spent_on_simulations(folder)
    if spent is None:
        return []
    jobs = f"{spent.jobs} job{'s' if spent.jobs > 1 else ''}"
    facts = [
        Fact("Time of all simulations", f"{_time(spent.seconds)}, in {jobs}, added up"),
        Fact("Processor time of these", _time(spent.processor_seconds)),
    ]
    if math.isfinite(spent.memory_bytes):
        facts.append(Fact("Memory of the largest job", size(round(spent.memory_bytes))))
    return facts


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 600.0 else duration(seconds)


def study_text(study: Study) -> str:
    """Return the study file as it stands, or its content where that was changed when loaded."""
    try:
        text = study.file.read_text(encoding="utf-8")
        unchanged = yaml.safe_load(text) == study.content
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        text, unchanged = "", False
    return text if unchanged else yaml.safe_dump(dict(study.content), sort_keys=False)


def _numerics(path: Path) -> CaseNumerics:
    with open_case(path) as case, open_history(path) as history:
        return CaseNumerics(
            cells=case.sizes["x"] * case.sizes["y"],
            spacing=(float(case["cell_x"]), float(case["cell_y"])),
            tolerance=float(case["tolerance"]),
            steps=max(0, history.sizes["step"] - 1),
            convolutions=int(history["convolutions"].sum()),
            largest_error=_largest(history["error_estimate"]),
            residuals=residuals(case),
            source=str(case.attrs["source"]),
        )


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
        scale = float(pressure.max()) * approach
        found = [
            abs(pressure.sum() * area / float(case["load"]) - 1.0),
            abs(shear.sum() * area / float(case["tangential_load"]) - 1.0),
            float((pressure * gap).max()) / scale,
        ]
        worst = np.maximum(worst, found)
    return Residuals(*worst.tolist())


def _largest(values: xr.DataArray) -> float:
    finite = values.values[np.isfinite(values.values)]
    return float(finite.max(initial=0.0))


def _numeric_facts(numerics: Sequence[CaseNumerics]) -> Iterator[Fact]:
    if not numerics:
        return
    along = [MICROMETRE.of(case.spacing) for case in numerics]
    yield Fact("Grid spacing along x", f"{_span([float(pair[0]) for pair in along])} µm")
    yield Fact("Grid spacing along y", f"{_span([float(pair[1]) for pair in along])} µm")
    yield Fact("Cells stored", _span([case.cells for case in numerics]))
    yield Fact("Tolerance of the wear integration", _span([case.tolerance for case in numerics]))
    yield Fact("Largest error estimate of a step", _span([case.largest_error for case in numerics]))
    worst = [
        max(getattr(case.residuals, name) for case in numerics)
        for name in ("load", "tangential_load", "complementarity")
    ]
    load, tangential_load, complementarity = (number(float(f"{value:.2g}")) for value in worst)
    yield Fact("Residual of the load", f"∬p dA is P to within {load} of P")
    yield Fact("Residual of the tangential load", f"∬q dA is Q to within {tangential_load} of Q")
    yield Fact(
        "Residual of the contact conditions",
        f"p·g is at most {complementarity} of the highest pressure times the Hertz approach",
    )
    yield Fact("Accepted steps", _span([case.steps for case in numerics]))
    yield Fact("Convolutions", _span([case.convolutions for case in numerics]))


def _version_facts(numerics: Sequence[CaseNumerics]) -> Iterator[Fact]:
    sources = list(dict.fromkeys(case.source for case in numerics))
    if sources:
        yield Fact("Simulated with", "; ".join(sources))
    libraries = [f"{name} {importlib.metadata.version(name)}" for name in _LIBRARIES]
    yield Fact("Report made with", ", ".join([*libraries, f"Python {platform.python_version()}"]))


def _span(values: Sequence[float]) -> str:
    low, high = number(float(f"{min(values):.4g}")), number(float(f"{max(values):.4g}"))
    return low if low == high else f"{low} to {high}"
