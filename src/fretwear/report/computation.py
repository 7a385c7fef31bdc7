"""How the cases of a study were computed: grids, steps, errors, versions."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
import yaml

from fretwear.data.store import open_case, open_history
from fretwear.figures.wording import MICROMETRE, number
from fretwear.report.results import PointResult
from fretwear.study.file import Study
from fretwear.study.plan import Plan

_LIBRARIES = ("numpy", "scipy", "xarray", "netCDF4", "matplotlib")
_MOST_CASES_READ = 200


@dataclass(frozen=True)
class CaseNumerics:
    """What one case took and reached."""

    cells: int
    spacing: tuple[float, float]
    tolerance: float
    steps: int
    convolutions: int
    largest_error: float
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
            source=str(case.attrs["source"]),
        )


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
