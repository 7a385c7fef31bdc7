"""The key results of every point of a study for people, and how the cases were computed."""

from __future__ import annotations

import importlib.metadata
import math
import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretwear.data.effects import LEAST_SEEDS, SEED, final_results
from fretwear.data.files import HISTORY_GROUP, opened_case
from fretwear.data.merge import check_belongs
from fretwear.study.parameters import value_text, words_text
from fretwear.study.plan import Plan
from fretwear.study.points import Axis
from fretwear.units import (
    MICROMETRE,
    POINT_CONTACT,
    ContactFrame,
    Unit,
    number_text,
    readable_unit,
    span,
)
from fretwear.vocabulary import (
    CONVOLUTIONS,
    CYCLE,
    ERROR_ESTIMATE,
    HEADLINES,
    RESULTS,
    SYMMETRIES,
    PointStatus,
    Variable,
)

if TYPE_CHECKING:
    import xarray as xr

_LARGEST = sys.float_info.max
_UNKNOWN_REASON = "The simulation failed; its log says why."
_EXAMINED = ("pressure", "shear_traction", "gap")
_LIBRARIES = ("numpy", "scipy", "xarray", "netCDF4", "matplotlib")


class Level(NamedTuple):
    """A value of a varied parameter: alone, in words, and as a number that sorts the values."""

    label: str
    words: str
    sort_key: float


class Ensemble(NamedTuple):
    """Random surfaces of one spectrum."""

    levels: Mapping[str, Level]  # of their parameters except the seed
    seeds: int  # number of seeds
    spread: Mapping[str, tuple[float, float]]  # mean and standard deviation of each key result


@dataclass(frozen=True)
class PointResult:
    """The outcome of one point of a study."""

    number: int  # place in the study, from 1
    id: str  # of the case, empty if invalid
    status: PointStatus
    reason: str  # why it is not done
    levels: Mapping[str, Level]  # varied values by the name of their parameter
    # The `HEADLINES` after the last cycle in SI units, and their estimated relative errors; empty
    # if not done.
    values: Mapping[str, float]
    errors: Mapping[str, float]
    frame: ContactFrame  # of a line contact, volumes and energies are per length

    @property
    def done(self) -> bool:
        """Whether the point has results."""
        return self.status == PointStatus.DONE

    @property
    def title(self) -> str:
        """The varied values in one line."""
        return ", ".join(level.words for level in self.levels.values()) or self.id


def point_results(
    plan: Plan, summary: xr.Dataset, failures: Mapping[str, str]
) -> list[PointResult]:
    """Return the key results of every point, in the order of the study.

    `failures` are reasons by case id. Raises a `DataFileError` if the summary belongs to another
    study, or to an earlier state of the study of the plan.
    """
    study, status = plan.study, summary.variables["status"]
    check_belongs(summary, study)
    final = final_results(summary)
    columns = {name: final[name] for name in HEADLINES}
    # The energy of a contact that wears in is the rest of a larger one.
    largest = summary["dissipated_energy"].max(CYCLE.name).transpose(*study.sizes).values
    levels = {axis.coordinate: levels_of(axis) for axis in study.axes}
    results: list[PointResult] = []
    for point in study.points():
        place = point.place
        outcome = PointStatus(int(status.values[place])) if point.case else PointStatus.INVALID
        reason, values = point.problem, {}
        errors: dict[str, float] = {}
        if outcome == PointStatus.DONE:
            values = {name: float(column[place]) for name, column in columns.items()}
            for name, value in values.items():
                error = final.get(RESULTS[name].error.name)
                if value and error is not None and math.isfinite(error[place] / value):
                    size = abs(value) if name != "dissipated_energy" else largest[place]
                    errors[name] = float(error[place] / size)
        elif point.case:
            reason = failures.get(point.id, _UNKNOWN_REASON)
        of_point = {name: levels[name][i] for name, i in zip(levels, point.index, strict=True)}
        frame = point.case.frame if values and point.case else POINT_CONTACT
        number = len(results) + 1
        results.append(
            PointResult(number, point.id, outcome, reason, of_point, values, errors, frame)
        )
    return results


def over_seeds(results: Sequence[PointResult]) -> list[Ensemble]:
    """Return the key results over the seeds, for each combination of the other parameters."""
    groups: dict[tuple[str, ...], list[PointResult]] = {}
    for result in results:
        if result.done and SEED in result.levels:
            others = tuple(level.label for name, level in result.levels.items() if name != SEED)
            groups.setdefault(others, []).append(result)
    ensembles = []
    for group in groups.values():
        levels = {name: level for name, level in group[0].levels.items() if name != SEED}
        columns = {name: [point.values[name] for point in group] for name in group[0].values}
        if len(group) >= LEAST_SEEDS:
            # The mean of a result is NaN if a seed lacks it.
            spread = {n: (float(np.mean(v)), float(np.std(v, ddof=1))) for n, v in columns.items()}
            ensembles.append(Ensemble(levels, len(group), spread))
    return ensembles


def levels_of(axis: Axis) -> list[Level]:
    """Return the values of a varied parameter for people, in the order of the study."""
    levels = []
    for place, (value, written) in enumerate(zip(axis.values, axis.labels, strict=True)):
        # A value that is not a single number stays as in the study file.
        is_number = isinstance(value, float | int) and not isinstance(value, bool)
        shown = value if is_number else written
        texts = value_text(axis.coordinate, shown), words_text(axis.coordinate, shown)
        # JavaScript does not read inf.
        levels.append(Level(*texts, min(float(value if is_number else place), _LARGEST)))
    return levels


def display_units(results: Sequence[PointResult]) -> dict[str, Unit]:
    """Return the unit in which each key result is shown, the same for all points."""
    done = [result for result in results if result.done]
    units = {}
    for name in HEADLINES:
        about = result_variable(name, results)
        values = [result.values[name] for result in done]
        units[name] = about.unit or readable_unit(values, about.si_unit)
    return units


def result_variable(name: str, results: Sequence[PointResult]) -> Variable:
    """Return the variable of a key result, per length in a line contact where this applies."""
    frames = (result.frame for result in results if result.values)
    return RESULTS[name].in_frame(next(frames, POINT_CONTACT))


class Residuals(NamedTuple):
    """Residuals of the equations in stored fields."""

    load: float  # relative deviation of the integral of the pressure from P
    tangential_load: float  # relative deviation of the integral of the shear traction from Q
    # Largest product of pressure and gap in a cell, over the peak pressure times the Hertz approach
    # a²/R, since the approach of rough bodies may be zero.
    complementarity: float


class Examined(NamedTuple):
    """How a case was computed."""

    # Its parameters that are numbers, its `cells`, `steps` and `convolutions`, and the largest
    # `error` of a step.
    numbers: Mapping[str, float]
    source: str  # program and version
    residuals: Residuals  # of the worst snapshot


def examine(path: Path) -> Examined:
    """Read how a case was computed from its file; `DataFileError` if the file is damaged."""
    with opened_case(path) as file:
        parameters = {
            name: float(variable[...])
            for name, variable in file.variables.items()
            if not variable.dimensions and variable.dtype.kind == "f"
        }
        copies = 1 << sum(SYMMETRIES[file.getncattr("symmetry")])
        # The load is a result if it is not held, the force if it is not imposed.
        forces = zip(file["normal_force"][:], file["tangential_force"][:], strict=True)
        missed = []
        for place, (normal, tangential) in enumerate(forces):
            fields = {name: file[name][place] for name in _EXAMINED}
            now = {"normal_load": float(normal), "tangential_load": float(tangential)}
            missed.append(residuals(fields, parameters | now, copies))
        errors = file[HISTORY_GROUP][ERROR_ESTIMATE.name][:]
        numbers = {
            "cells": fields["gap"].size,
            "steps": max(0, errors.size - 1),
            "convolutions": int(file[HISTORY_GROUP][CONVOLUTIONS.name][:].sum()),
            "error": float(errors[np.isfinite(errors)].max(initial=0.0)),
        }
        worst = Residuals(*np.fmax.reduce(missed).tolist())
        return Examined(parameters | numbers, file.getncattr("source"), worst)


def residuals(
    fields: Mapping[str, NDArray[np.floating]], parameters: Mapping[str, float], copies: int
) -> Residuals:
    """Integrate and multiply the fields of one snapshot: pressure, shear traction and gap.

    Fields are in SI units, of shape (nx, ny), or (nx,) in a line contact; `copies` is the number of
    copies of the stored part in the whole contact.
    """
    pressure, shear, gap = (fields[name].astype(np.float64) for name in _EXAMINED)
    area = copies * parameters["cell_x"] * (parameters["cell_y"] if pressure.ndim == 2 else 1.0)
    # Bodies other than a sphere have the largest gap in the window instead of the approach.
    radius = parameters.get("radius", parameters.get("indenter_radius", np.nan))
    approach = parameters.get("hertz_radius", np.nan) ** 2 / radius
    approach = approach if np.isfinite(approach) else float(gap.max())
    return Residuals(
        abs(float(pressure.sum()) * area / parameters["normal_load"] - 1.0),
        abs(float(shear.sum()) * area / parameters["tangential_load"] - 1.0),
        float((pressure * gap).max() / (pressure.max() * approach)),
    )


def computation_facts(examined: Sequence[Examined], done: int) -> dict[str, str]:
    """Return facts on the numerics of the cases examined, out of `done` cases."""

    def of(name: str, size: float = 1.0) -> str:
        values = (case.numbers[name] / size for case in examined)
        return span(values, lambda value: number_text(value, 4))

    facts: dict[str, str] = {}
    if examined:
        worst = np.max([case.residuals for case in examined], axis=0)
        load, other, gap = (number_text(value, 2) for value in worst)
        axes = [axis for axis in "xy" if any(f"cell_{axis}" in case.numbers for case in examined)]
        normal, shear = ("∬p dA", "∬q dA") if "y" in axes else ("∫p dx", "∫q dx")
        for axis in axes:
            facts[f"Grid spacing along {axis}"] = f"{of(f'cell_{axis}', MICROMETRE.size)} µm"
        facts |= {
            "Cells stored": of("cells"),
            "Tolerance of the wear integration": of("tolerance"),
            "Largest error estimate of a step": of("error"),
            "Residual of the load": f"{normal} as written equals P to within {load} P",
            "Residual of the tangential load": f"{shear} as written equals Q to within {other} Q",
            "Residual of the contact conditions": (
                f"p·g is at most {gap} of the peak pressure times the Hertz approach"
            ),
            "Accepted steps": of("steps"),
            "Convolutions": of("convolutions"),
        }
        if len(examined) < done:
            facts["Cases examined"] = f"{len(examined)} of {done}, evenly spread"
        facts["Simulated with"] = "; ".join(dict.fromkeys(case.source for case in examined))
    programs = [f"{name} {importlib.metadata.version(name)}" for name in _LIBRARIES]
    programs.append(f"Python {platform.python_version()}")
    return facts | {"Report made with": ", ".join(programs)}
