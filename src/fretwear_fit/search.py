"""The search: from a study with measurements to the best parameters and what they are worth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretwear.arrays import Array
from fretwear.study.case import Case
from fretwear.study.problems import StudyError
from fretwear.study.reading import assign, case_of_content, content_of, load_study
from fretwear.study.study import Study, as_mapping
from fretwear.units import QuantityError
from fretwear_fit.comparison import Comparison
from fretwear_fit.estimate import Fitter, Unknown
from fretwear_fit.posterior import sampled, why_to_sample
from fretwear_fit.request import FitRequest
from fretwear_fit.results import Fit, compared
from fretwear_fit.runs import Prediction, Runs
from fretwear_fit.warnings import warnings_of

_UNLIKELY = 0.01  # p value below which the noise does not explain the residuals
_ROUNDS = 3
# Minima of χ² this far apart, over the ranges, are two; one that is told is no higher than by this.
_APART, _RIVAL = 0.02, 9.0


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
            Unknown(free, test)
            for free in request.sought
            for test in (tests if free.each and len(tests) > 1 else [None])
        )
        points = study.points()
        return cls(study, request, unknowns, {t: content_of(points[t - 1]) for t in tests})

    def start(self) -> Array:
        """The parameters to begin with: the values of `base`, or the middle of their ranges."""
        base = as_mapping(self.study.content["base"])
        given = [unknown.free.given_in(base) for unknown in self.unknowns]
        inside = [
            unknown.inner(
                unknown.free.middle
                if value is None or not unknown.free.low < value < unknown.free.high
                else value
            )
            for unknown, value in zip(self.unknowns, given, strict=True)
        ]
        return np.array(inside)

    def content(self, test: int, u: Array) -> dict[str, object]:
        """The plain content of a test with some parameters."""
        content = dict(self.contents[test])
        for unknown, inner in zip(self.unknowns, u, strict=True):
            if unknown.test in (None, test):
                base = as_mapping(content["base"])
                sought = float(f"{float(unknown.value(inner)):.12g}")
                key, value = unknown.free.placed(base, sought)
                assign(content, key, value)
        return content

    def case(self, test: int, u: Array, *, errors: bool = False) -> Case:
        """The case of a test with some parameters; `StudyError` if it is invalid."""
        case = case_of_content(self.study.file, self.content(test, u))
        cycles = {self.cycle_of(case, of.cycle) for of in self.request.data if of.test == test}
        changes: dict[str, object] = {"output_cycles": sorted(cycles)}
        if case.accuracy == Case.accuracy or not case.error_estimate:
            # On the same cells, predictions change smoothly from run to run.
            changes |= {"accuracy": "none", "error_estimate": case.error_estimate and errors}
        return case.replace(**changes)

    @staticmethod
    def cycle_of(case: Case, cycle: int | None) -> int:
        return case.cycles if cycle is None else cycle


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
    lines = {(datum.quantity, datum.along) for datum in request.data if datum.is_profile}
    with Runs(lines, None if folder is None else Path(folder), processes) as runs:
        return _fitted(tests, runs, tell, seed)


def _fitted(tests: _Tests, runs: Runs, tell: Callable[[str], None], seed: int) -> Fit:
    data, unknowns = tests.request.data, tests.unknowns
    start = tests.start()

    def predictions(
        points: Sequence[Array], *, errors: bool = False
    ) -> list[dict[int, Prediction] | None]:
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

    def cycle(number: int) -> int:
        of = data[number]
        return tests.cycle_of(tests.case(of.test, start), of.cycle)

    (first,) = predictions([start], errors=True)
    if first is None:
        raise FitError("the values to begin with make no valid case")
    comparisons = [
        Comparison.of(datum, cycle(number), first[datum.test]) for number, datum in enumerate(data)
    ]

    def signals(points: Sequence[Array]) -> list[list[Array] | None]:
        found: list[list[Array] | None] = []
        for u, point in zip(points, predictions(points), strict=True):
            if point is None:
                found.append(None)
                tell(f"{fitter.text(u)}: makes no case")
            else:
                parts = [c.signal(point[c.measurement.test]) for c in fitter.comparisons]
                found.append(parts)
                tell(f"{fitter.text(u)}: χ² = {fitter.misfit_of(parts):.4g}")
        return found

    fitter = Fitter(unknowns, comparisons, signals)
    best = fitter.best(start)
    warnings: list[str] = []
    fitter.comparisons, doubts = _with_noise(fitter, best)
    warnings += doubts
    parts = zip(fitter.comparisons, fitter.split(fitter.signal(best)), strict=True)
    fitter.comparisons = [c.with_place(part) for c, part in parts]
    fitter.settled = [None] * len(comparisons)
    warnings += [
        f"{c.measurement.quantity} shows no scar beyond its noise: if there is one, it is at x = 0"
        for c in fitter.comparisons
        if c.is_placed
    ]
    best, doubts = _best_of_all(fitter, fitter.best(best))
    warnings += doubts
    (exact,) = predictions([best], errors=True)
    assert exact is not None
    fitter.comparisons = [c.with_errors(exact[c.measurement.test]) for c in fitter.comparisons]
    warnings += [
        f"test {test} has no estimate of its numerical error: intervals leave it out"
        for test, prediction in exact.items()
        if not prediction.errors
    ]
    fitter.settled = [None] * len(comparisons)
    for _ in range(_ROUNDS):
        emulator, derivatives = fitter.emulator(best)
        best, degrees = emulator.best, _degrees(fitter)
        p_value = _probability(fitter, emulator.least, degrees)
        if p_value >= _UNLIKELY or not any(c.measurement.is_profile for c in fitter.comparisons):
            break
        signal = fitter.signal(best)
        before = [c.noise for c in fitter.comparisons]
        fitter.comparisons = [
            c.with_noise_of_residuals(s, n, fitter.split_all(derivatives, place))
            for place, (c, s, n) in enumerate(fitter.parts(signal))
        ]
        for old, c in zip(before, fitter.comparisons, strict=True):
            if old is not None and c.noise is not None:
                warnings.append(
                    f"the noise of {c.measurement.quantity}, {old.size * 1e6:.3g} µm, does not "
                    f"explain its residuals (p = {p_value:.1g}); theirs, {c.noise.size * 1e6:.3g} "
                    f"µm over {c.noise.length * 1e6:.3g} µm, was taken"
                )
    spread = fitter.spread(fitter.signal(emulator.best), derivatives)
    profiles = fitter.intervals(emulator, spread)
    signal, p_value = fitter.signal(emulator.best), _probability(fitter, emulator.least, degrees)
    covariance = fitter.covariance(signal, derivatives)
    measurements = compared(fitter, signal, derivatives)
    deviations = np.sqrt(np.diag(covariance))
    reason = why_to_sample(profiles, covariance / np.outer(deviations, deviations))
    posterior = sampled(fitter, emulator, spread, seed, reason)
    if reason:
        warnings.append(f"{reason}: intervals are those of draws from the posterior")
    if not posterior.is_checked:
        warnings.append(f"the emulator of χ² misses runs at its draws by {posterior.missed:.2g}")
    result = Fit(
        tests.study,
        unknowns,
        emulator,
        derivatives,
        (*profiles,),
        covariance,
        spread,
        (*measurements,),
        emulator.least,
        degrees,
        p_value,
        len(runs.done),
        runs.computed,
        (),
        posterior,
        seed,
    )
    vars(result)["warnings"] = (
        *dict.fromkeys([*warnings, *warnings_of(result, tests.case(data[0].test, emulator.best))]),
    )
    return result


def _best_of_all(fitter: Fitter, best: Array) -> tuple[Array, list[str]]:
    """The best parameters; where they do not explain the data, also from elsewhere in the ranges.

    What other minima there are is told.
    """

    def misfit(u: Array) -> float:
        fitter.settled = [None] * len(fitter.comparisons)
        return fitter.misfit(fitter.signal(u))

    def text(u: Array) -> str:
        return f"χ² = {misfit(u):.4g} at {fitter.text(u)}"

    if _probability(fitter, misfit(best), _degrees(fitter)) >= _UNLIKELY:
        return best, []
    least, *others = sorted([best, *fitter.elsewhere()], key=misfit)
    most, width = misfit(least) + _RIVAL, fitter.upper - fitter.lower
    rivals = [
        f"χ² has several minima: {text(least)}, which was taken, and {text(u)}"
        for u in others
        if (np.abs(u - least) > _APART * width).any() and (u is best or misfit(u) < most)
    ]
    return least, rivals[:1]


def _with_noise(fitter: Fitter, best: Array) -> tuple[list[Comparison], list[str]]:
    """The comparisons with the noise beside their scars, and doubts about it."""
    comparisons, doubts = [], []
    for comparison, part, nuisances in fitter.parts(fitter.signal(best)):
        better, doubt = comparison.with_noise_beside(part, nuisances)
        comparisons.append(better)
        if doubt:
            doubts.append(
                f"{comparison.measurement.quantity} {doubt}, too few to estimate its noise: that "
                "of the residuals was taken"
            )
    return comparisons, doubts


def _degrees(fitter: Fitter) -> int:
    """Degrees of freedom: readings less parameters and base lines."""
    of_baselines = sum(
        sum(name not in ("depth", "width") for name in c.names)
        for c in fitter.comparisons
        if c.measurement.readings is not None
    )
    readings = sum(comparison.readings for comparison in fitter.comparisons)
    return readings - of_baselines - len(fitter.unknowns)


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
