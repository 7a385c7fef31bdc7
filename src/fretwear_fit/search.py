"""The search: from a study with measurements to the best parameters and what they are worth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import xarray as xr

from fretwear.arrays import Array
from fretwear.study.case import Case
from fretwear.study.mistakes import StudyError
from fretwear.study.reading import assign, case_of_content, content_of, load_study
from fretwear.study.study import Study, as_mapping
from fretwear.units import QuantityError
from fretwear_fit.comparison import Comparison
from fretwear_fit.estimate import AROUND, ENDS, MOVES, SEARCH, Fitter
from fretwear_fit.fit import UNLIKELY, Fit
from fretwear_fit.posterior import sampled, why_to_sample
from fretwear_fit.request import FitRequest, Unknown
from fretwear_fit.runs import Runs

# Tolerance of steps where a coating wears through. The front of the bare substrate is steep, and
# usual steps misplace it by a cell: little of the volume, yet several times the noise there.
_AT_FRONTS = 0.001
# Tolerance of steps over a stroke: their number changes from run to run, and with it pressures at
# the rim of a scar, by more than second derivatives bear.
_OF_STROKES = 0.003


class FitError(ValueError):
    """A study cannot be fitted; the message says why and what to do."""


@dataclass(frozen=True)
class _Tests:
    """The tests of a study that were measured, and their cases with other parameters."""

    study: Study
    request: FitRequest
    unknowns: tuple[Unknown, ...]
    contents: Mapping[int, Mapping[str, object]]  # plain content of the study of each test

    @classmethod
    def of(cls, study: Study, request: FitRequest) -> _Tests:
        tests = sorted({datum.test for datum in request.data})
        unknowns = tuple(
            replace(free, test=test)
            for free in request.sought
            for test in (tests if free.each and len(tests) > 1 else [None])
        )
        points = study.points()
        return cls(study, request, unknowns, {t: content_of(points[t - 1]) for t in tests})

    def start(self) -> Array:
        """The parameters to begin with: the values of `base`, or the middle of their ranges."""
        base = as_mapping(self.study.content["base"])
        start = []
        for unknown in self.unknowns:
            value = unknown.given_in(base)
            if value is None or not unknown.low < value < unknown.high:
                value = unknown.middle
            start.append(unknown.inner(value))
        return np.array(start)

    def case(self, test: int, u: Array, *, errors: bool = False) -> Case:
        """The case of a test with some parameters; `StudyError` if it is invalid."""
        content = dict(self.contents[test])
        for unknown, inner in zip(self.unknowns, u, strict=True):
            if unknown.test in (None, test):
                value = float(f"{float(unknown.value(inner)):.12g}")
                assign(content, *unknown.placed(as_mapping(content["base"]), value))
        case = case_of_content(self.study.file, content)
        cycles = {of.cycle for of in self.request.data if of.test == test and of.cycle is not None}
        changes: dict[str, object] = {"output_cycles": sorted({0, *cycles})}
        if case.accuracy == Case.accuracy or not case.error_estimate:
            # On the same cells, predictions change smoothly from run to run.
            changes |= {"accuracy": "none", "error_estimate": case.error_estimate and errors}
        if case.changes_below or case.loading.stroke:
            finest = _AT_FRONTS if case.changes_below else _OF_STROKES
            changes["tolerance"] = min(case.tolerance, finest)
        return case.replace(**changes)


def fit(
    study: Study | str | Path,
    *,
    folder: str | Path | None = None,
    processes: int = 1,
    tell: Callable[[str], None] = lambda _: None,
    seed: int = 0,
) -> Fit:
    """Find parameters of a study from what was measured, with intervals.

    Parameters
    ----------
    study : Study or path
        A study with the section ``fit``: see its page of the documentation.
    folder : path, optional
        Keeps what the runs predict, so that another call resumes where this one stopped.
    processes : int
        How many runs are made side by side.
    tell : callable
        Takes a line of text about each step.
    seed : int
        Seed of the draws from the posterior.

    Raises
    ------
    FitError
        If the study has no section ``fit``, or its first run fails.
    """
    study = study if isinstance(study, Study) else load_study(study)
    request = study.added.get("fit")
    if not isinstance(request, FitRequest):
        raise FitError(f"{study.file}: needs a section fit, with free (what is sought) and data")
    tests = _Tests.of(study, request)
    for datum in request.data:
        if datum.file is not None:
            tell(f"{datum.file.name}: {datum.origin}")
    lines = {(datum.quantity, datum.along) for datum in request.data if datum.is_profile}
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        each = pool.map if processes > 1 else map
        runs = Runs(lines, None if folder is None else Path(folder), each)
        return _fitted(tests, runs, tell, seed)


def _fitted(tests: _Tests, runs: Runs, tell: Callable[[str], None], seed: int) -> Fit:
    start, unknowns = tests.start(), tests.unknowns

    def predictions(
        points: Sequence[Array], *, errors: bool = False
    ) -> list[dict[int, xr.Dataset] | None]:
        """What runs of some parameters predict for each test; None where they make no case."""
        cases: list[dict[int, Case] | None] = []
        for u in points:
            try:
                cases.append({t: tests.case(t, u, errors=errors) for t in tests.contents})
            except (StudyError, QuantityError):
                cases.append(None)
        flat = [case for point in cases if point is not None for case in point.values()]
        predicted = iter(runs(flat))
        return [
            None if point is None else {test: next(predicted) for test in point} for point in cases
        ]

    (first,) = predictions([start], errors=True)
    if first is None:
        raise FitError("the values to begin with make no valid case")
    comparisons = [Comparison.of(datum, first[datum.test]) for datum in tests.request.data]

    def signals(points: Sequence[Array]) -> list[list[Array] | None]:
        return [
            None
            if point is None
            else [c.signal(point[c.measurement.test]) for c in fitter.comparisons]
            for point in predictions(points)
        ]

    # The first and the best run are made with estimates of errors besides.
    fitter = Fitter(unknowns, comparisons, signals, tell, tests.request.runs - 2)
    fitter.keep(SEARCH)
    best = fitter.best(start)
    parts = fitter.parts(fitter.signal(best))
    fitter.compare([c.with_noise_beside(s, n) for c, s, n in parts])
    fitter.keep(MOVES)
    best = fitter.emulator(best)[0].best
    # Which readings lie beside the scar is known only now.
    parts = fitter.parts(fitter.signal(best))
    fitter.compare([c.with_noise_beside(s, n).with_place(s) for c, s, n in parts])
    degrees = sum(c.degrees for c in fitter.comparisons) - len(unknowns)
    if _probability(fitter, fitter.misfit(fitter.signal(best)), degrees) < UNLIKELY:
        fitter.keep(AROUND)
        best = fitter.elsewhere(best)
    warnings = [
        f"{c.measurement.quantity} has too few readings beside the scar to estimate its noise: "
        "the noise of the residuals is used"
        for c in fitter.comparisons
        if c.evidence is not None and not c.evidence.is_beside
    ]
    warnings += [
        f"{datum.file.name}: {missing}"
        for datum in tests.request.data
        if datum.file is not None and (missing := datum.origin.partition("; ")[2])
    ]
    warnings += [
        f"{c.measurement.quantity} shows no scar beyond its noise: if there is one, it is at x = 0"
        for c in fitter.comparisons
        if c.is_placed
    ]
    (exact,) = predictions([best], errors=True)
    assert exact is not None
    fitter.compare([c.with_errors(exact[c.measurement.test]) for c in fitter.comparisons])
    fitter.keep(AROUND)
    emulator, derivatives = fitter.emulator(best)
    spread = fitter.spread(fitter.signal(emulator.best), derivatives)
    if _probability(fitter, emulator.least, degrees) < UNLIKELY:
        # Birge's ratio: errors as large as the residuals.
        spread = spread * (emulator.least / max(degrees, 1))
    fitter.keep(ENDS)
    profiles, error = fitter.intervals(emulator, spread)
    signal, p_value = fitter.signal(emulator.best), _probability(fitter, emulator.least, degrees)
    covariance = fitter.covariance(fitter.projected(signal, derivatives))
    deviations = np.sqrt(np.diag(covariance))
    reason = why_to_sample(profiles, covariance / np.outer(deviations, deviations))
    fitter.keep(1.0)
    posterior = sampled(fitter, emulator, spread, seed, reason, error)
    if reason:
        warnings.append(f"{reason}: intervals are quantiles of draws from the posterior")
    most = tests.request.runs
    remedy = f"write runs: {2 * most} under fit, and fit again"
    if not posterior.is_checked:
        warnings.append(
            f"after {most} runs, rises of χ² between them are uncertain by "
            f"{100.0 * posterior.error:.2g} %: intervals are "
            f"{100.0 * (np.sqrt(1.0 + posterior.error) - 1.0):.2g} % wider; {remedy}"
        )
    return Fit(
        tests.study,
        unknowns,
        emulator,
        (*profiles,),
        covariance,
        (*fitter.parts(signal),),
        emulator.least,
        degrees,
        p_value,
        len(runs.done),
        runs.computed,
        (*warnings,),
        posterior,
        seed,
    )


def _probability(fitter: Fitter, misfit: float, degrees: int) -> float:
    """Probability of a χ² at least as large, if noise and model are right.

    The noise is scaled by the readings beside the scars, whose χ² is their degrees of freedom; the
    remaining residuals are compared with it by the distribution of Fisher and Snedecor. Without
    degrees of freedom, it is as if there was one.
    """
    from scipy.special import betainc, gammaincc

    beside = sum(
        c.evidence.degrees
        for c in fitter.comparisons
        if c.evidence is not None and c.evidence.size is None
    )
    if 0 < beside < degrees:
        of_scar, rest = degrees - beside, max(misfit - beside, 0.0)
        return float(betainc(0.5 * beside, 0.5 * of_scar, beside / (beside + rest)))
    return float(gammaincc(0.5 * max(degrees, 1), 0.5 * misfit))
