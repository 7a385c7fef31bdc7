"""A fit: from a study with measurements to values, intervals and what they are worth."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import netCDF4
import numpy as np

from fretwear.arrays import Array
from fretwear.data.files import check_group, new_netcdf, write_group
from fretwear.data.labels import CONVENTIONS, history_line, source
from fretwear.data.safe import atomic_path, uninterrupted, write_text
from fretwear.fitting.comparison import Comparison
from fretwear.fitting.estimate import LEVELS, Emulator, Fitter, Profile, Unknown
from fretwear.fitting.runs import Prediction, Runs
from fretwear.fitting.words import doubts_of
from fretwear.study.case import Case
from fretwear.study.fits import FitRequest
from fretwear.study.problems import StudyError
from fretwear.study.study import MAX_TITLE, Study, assign, case_of_content, content_of, load_study
from fretwear.units import QuantityError
from fretwear.vocabulary import RESULTS

if TYPE_CHECKING:
    import xarray as xr

_CHAINS, _DRAWS, _TRIALS, _WIDER = 4, 1000, 20000, 1.3
_PREDICTED = 200  # draws whose predictions are stored
_UNLIKELY = 0.01  # p value below which the noise does not explain the residuals
_ROUNDS = 3
_ADVISED = (
    *("wear_volume", "wear_volume_indenter", "wear_volume_flat", "maximum_wear_depth"),
    *("contact_half_width_x", "stick_half_width_x", "dissipated_energy", "tangential_force"),
)
_ADVISED_ERROR, _HARDLY, _EARLIEST = 0.05, 0.9, 0.05
_SHOWN = (LEVELS[0], LEVELS[-1])


class FitError(ValueError):
    """A study cannot be fitted; the message says why and what to do."""


@dataclass(frozen=True)
class FittedMeasurement:
    """A measurement beside the best run."""

    comparison: Comparison
    signal: Array  # what the run predicts on the grid
    nuisances: Array  # base line and numerical errors
    deviations: Array  # standard deviations of the nuisances
    band: Array  # standard deviation of the fitted readings, shape (n,)
    correlation: Array  # of parameters (rows) and nuisances (columns)

    @property
    def title(self) -> str:
        """Quantity, cycle and test."""
        of = self.comparison.measurement
        return f"{of.quantity} at cycle {self.comparison.cycle:.0f}, test {of.test}"

    @property
    def fitted(self) -> Array:
        """The readings that the best parameters would give, shape (n,)."""
        return self.comparison.modelled(self.signal, self.nuisances)


@dataclass(frozen=True)
class Fit:
    """The result of a fit."""

    study: Study
    unknowns: tuple[Unknown, ...]
    emulator: Emulator
    profiles: tuple[Profile, ...]
    covariance: Array  # of the coordinates in which parameters are sought, with the noise taken
    spread: Array  # variances with noises that the readings allow, over it, shape (m, p)
    measurements: tuple[FittedMeasurement, ...]
    misfit: float  # χ²
    degrees: int  # of freedom
    p_value: float  # of a χ² as large, if noise and model are right
    runs: int  # runs that it needs
    computed: int  # those of them that no folder had kept
    warnings: tuple[str, ...]
    advice: str  # which further measurement would narrow it most; may be empty
    fitted: Mapping[str, object]  # plain content of a study of the best values
    seed: int = 0

    @property
    def names(self) -> list[str]:
        """Names of the parameters."""
        return [unknown.name for unknown in self.unknowns]

    @property
    def values(self) -> dict[str, float]:
        """The best values, in SI units."""
        pairs = zip(self.unknowns, self.emulator.best, strict=True)
        return {unknown.name: float(unknown.value(u)) for unknown, u in pairs}

    def interval(self, name: str, level: float = LEVELS[-1]) -> tuple[float, float]:
        """The interval of a parameter, in SI units; an end of its range where it is open."""
        place = self.names.index(name)
        low, high = self.profiles[place].interval(level)
        unknown = self.unknowns[place]
        return float(unknown.value(low)), float(unknown.value(high))

    @property
    def correlation(self) -> Array:
        """Correlations of the parameters, shape (p, p)."""
        deviations = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(deviations, deviations))

    @cached_property
    def draws(self) -> Array:
        """Parameters drawn from the posterior, in their coordinates, shape (4, 1000, p).

        Importance resampling of the emulator; the prior is uniform in the coordinates in which
        parameters are sought, within their ranges.
        """
        generator = np.random.default_rng(self.seed)
        lower, upper = np.array([unknown.ends for unknown in self.unknowns]).T
        root = np.linalg.cholesky(self.covariance)
        scales = np.exp(np.log(self.spread).mean(axis=1))
        normal = generator.standard_normal((_TRIALS, lower.size))
        normal *= _WIDER * np.sqrt(generator.choice(scales, _TRIALS))[:, None]
        u = self.emulator.best + normal @ root.T
        inside = ((u > lower) & (u < upper)).all(axis=1)
        u, normal = u[inside], normal[inside]
        chunks = np.array_split(self.emulator.at(u), max(1, len(u) // 500))
        misfit = np.concatenate([self.emulator.misfit(chunk) for chunk in chunks])
        logarithm = log_mixture(misfit - self.misfit, scales, lower.size) - log_mixture(
            (normal**2).sum(axis=1), _WIDER**2 * scales, lower.size
        )
        weights = np.exp(logarithm - logarithm.max())
        count = _CHAINS * _DRAWS
        chosen = generator.choice(len(u), count, p=weights / weights.sum())
        return np.asarray(u[chosen].reshape(_CHAINS, _DRAWS, -1))

    def table(self) -> list[tuple[str, ...]]:
        """Rows of text about the parameters, below a row of words: value and intervals."""
        rows = [("parameter", "value", *(f"{100 * level:.0f} %" for level in _SHOWN))]
        for unknown, value in zip(self.unknowns, self.values.values(), strict=True):
            texts = [unknown.free.about.text(value)]
            for level in _SHOWN:
                ends = zip(
                    self.interval(unknown.name, level),
                    self.is_open(unknown.name, level),
                    ("below", "above"),
                    strict=True,
                )
                shown = [
                    f"{word} range" if is_open else unknown.free.about.text(_rounded(end))
                    for end, is_open, word in ends
                ]
                texts.append(" to ".join(shown))
            rows.append((unknown.name, *texts))
        return rows

    def is_open(self, name: str, level: float = LEVELS[-1]) -> tuple[bool, bool]:
        """Whether the range of a parameter ends its interval, below and above."""
        return self.profiles[self.names.index(name)].is_open(level)

    def as_dict(self, level: float = LEVELS[-1]) -> dict[str, Any]:
        """The content of ``fit.json``."""
        parameters = {}
        for unknown, value in zip(self.unknowns, self.values.values(), strict=True):
            low, high = self.interval(unknown.name, level)
            intervals = {f"{each:g}": [*self.interval(unknown.name, each)] for each in LEVELS}
            parameters[unknown.name] = {
                "value": value,
                "low": low,
                "high": high,
                "level": level,
                "unit": unknown.free.about.si_unit,
                "intervals": intervals,
            }
        baselines = [
            {
                "measurement": each.title,
                **{
                    name: {"value": float(value), "error": float(deviation)}
                    for name, value, deviation in zip(
                        each.comparison.names, each.nuisances, each.deviations, strict=True
                    )
                },
                **_noise_of(each),
            }
            for each in self.measurements
        ]
        return {
            "study": self.study.name,
            "parameters": parameters,
            "correlation": {
                name: dict(zip(self.names, row.tolist(), strict=True))
                for name, row in zip(self.names, self.correlation, strict=True)
            },
            "measurements": baselines,
            "chi_square": self.misfit,
            "degrees_of_freedom": self.degrees,
            "p_value": self.p_value,
            "runs": self.runs,
            "warnings": [*self.warnings],
            "advice": self.advice,
            "fitted_study": self.fitted,
        }

    def groups(self) -> dict[str, xr.Dataset]:
        """The groups of ``fit.nc``, in the conventions of ArviZ, by name."""
        import xarray as xr

        chains = {"chain": np.arange(_CHAINS), "draw": np.arange(_DRAWS)}
        attributes = {
            "Conventions": CONVENTIONS,
            "source": source(),
            "history": history_line("fretwear fit"),
            "inference_library": "fretwear",
        }

        def of(draws: Array) -> xr.Dataset:
            variables = {
                unknown.name: (
                    ("chain", "draw"),
                    unknown.value(draws[..., place]),
                    {"units": unknown.free.about.si_unit, "long_name": unknown.free.about.words},
                )
                for place, unknown in enumerate(self.unknowns)
            }
            return xr.Dataset(variables, chains, attributes)

        lower, upper = np.array([unknown.ends for unknown in self.unknowns]).T
        generator = np.random.default_rng(self.seed + 1)
        prior = generator.uniform(lower, upper, (_CHAINS, _DRAWS, lower.size))
        posterior = of(self.draws)
        posterior.attrs |= {
            "method": "importance resampling of an emulator of the runs",
            "fit": json.dumps(self.as_dict()),
        }
        observed, predicted = {}, {}
        generator = np.random.default_rng(self.seed + 2)
        few = self.draws[:, :: _DRAWS * _CHAINS // _PREDICTED]
        for number, each in enumerate(self.measurements, start=1):
            name, of_this = f"data_{number}", each.comparison.measurement
            readings = np.array([of_this.value])
            coordinates: dict[str, Any] = {}
            dim, label = f"reading_{number}", {"long_name": each.title}
            if of_this.readings is not None:
                readings = of_this.readings[1]
                axis = f"position_{number}"
                coordinates = {axis: (dim, of_this.readings[0], {"units": "m"})}
            observed[name] = (dim, readings, label)
            observed |= coordinates
            noise = np.zeros((*few.shape[:2], readings.size))
            noise += self._predicted(number - 1, few)
            predicted[name] = (("chain", "draw", dim), noise, label)
        few_chains = {"chain": np.arange(_CHAINS), "draw": np.arange(few.shape[1])}
        names = [name for name in observed if name.startswith("position")]
        data = xr.Dataset(observed, attrs=attributes).set_coords(names)
        return {
            "posterior": posterior,
            "prior": of(prior),
            "observed_data": data,
            "posterior_predictive": xr.Dataset(predicted, few_chains, attributes),
        }

    def _predicted(self, place: int, draws: Array) -> Array:
        """Readings of a measurement for draws, shape (chains, draws, n), noise included."""
        each = self.measurements[place]
        generator = np.random.default_rng(self.seed + 3 + place)
        sizes = [one.signal.size for one in self.measurements]
        begin = sum(sizes[:place])
        part = slice(begin, begin + sizes[place])
        found = []
        for u in draws.reshape(-1, draws.shape[-1]):
            signal = self.emulator.signal_at(self.emulator.at(u))[part]
            # The base line goes with the parameters.
            nuisances = each.comparison.settled(signal, each.nuisances)
            found.append(each.comparison.drawn(signal, nuisances, generator))
        return np.reshape(found, (*draws.shape[:2], -1))

    def write(self, path: Path) -> None:
        """Write ``fit.nc``: a netCDF file with a group for each part, and a checksum."""
        groups = self.groups()
        size = sum(content.nbytes for content in groups.values())
        with uninterrupted(), atomic_path(path) as temporary:
            with new_netcdf(temporary, size) as file:
                for name, content in groups.items():
                    write_group(file.createGroup(name), content)
            with netCDF4.Dataset(temporary) as file:
                for name, content in groups.items():
                    check_group(file[name], content)

    def write_json(self, path: Path) -> None:
        """Write ``fit.json``."""
        write_text(path, json.dumps(self.as_dict(), indent=1, ensure_ascii=False) + "\n")


def log_mixture(rises: Array, scales: Array, count: int) -> Array:
    """Logarithm of Σ s_j^(−p/2) exp(−Δχ²/2s_j): the likelihood, with the noise integrated out."""
    parts = -0.5 * rises[:, None] / scales - 0.5 * count * np.log(scales)
    return np.asarray(np.logaddexp.reduce(parts, axis=1))


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")


def _noise_of(each: FittedMeasurement) -> dict[str, float]:
    noise = each.comparison.noise
    return {} if noise is None else {"noise": noise.size, "correlation_length": noise.length}


@dataclass(frozen=True)
class _Tests:
    """The tests of a study that were measured, and their cases with other parameters."""

    study: Study
    request: FitRequest
    unknowns: tuple[Unknown, ...]
    contents: Mapping[int, Mapping[str, object]]  # plain content of the study of each test

    @classmethod
    def of(cls, study: Study, request: FitRequest) -> _Tests:
        tests = sorted({each.test for each in request.data})
        unknowns = tuple(
            Unknown(free, test)
            for free in request.free
            for test in (tests if free.each and len(tests) > 1 else [None])
        )
        points = study.points()
        return cls(study, request, unknowns, {t: content_of(points[t - 1]) for t in tests})

    def start(self) -> Array:
        """The parameters to begin with: the values of `base`, or the middle of their ranges."""
        base: Any = self.study.content["base"]
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
                base: Any = content["base"]
                sought = float(f"{float(unknown.value(inner)):.12g}")
                key, value = unknown.free.placed(base, sought)
                assign(content, key, value)
        return content

    def case(self, test: int, u: Array, *, errors: bool = False) -> Case:
        """The case of a test with some parameters; `StudyError` if it is invalid."""
        case = case_of_content(self.study.file, self.content(test, u))
        cycles = {
            self.cycle_of(case, each.cycle) for each in self.request.data if each.test == test
        }
        return case.replace(
            error_estimate=errors, output_cycles=sorted({*case.output_cycles, *cycles})
        )

    def fitted(self, u: Array) -> dict[str, object]:
        """The plain content of a study of the best values, or of the first test if they differ."""
        if any(unknown.test for unknown in self.unknowns):
            content = self.content(min(self.contents), u)
        else:
            content = {key: v for key, v in self.study.content.items() if key != "fit"}
            for unknown, inner in zip(self.unknowns, u, strict=True):
                base: Any = content["base"]
                sought = float(f"{float(unknown.value(inner)):.5g}")
                assign(content, *unknown.free.placed(base, sought))
        title = f"{self.study.title}: best values of a fit"[:MAX_TITLE]
        return json.loads(json.dumps({**content, "title": title}))  # type: ignore[no-any-return]

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
        Of the draws from the posterior.

    Raises
    ------
    FitError
        If the study has no section ``fit``, or its first run fails.
    """
    study = study if isinstance(study, Study) else load_study(study)
    if study.fit is None:
        raise FitError(f"{study.file}: has no section fit: what is sought, and what was measured")
    tests = _Tests.of(study, study.fit)
    lines = {(each.quantity, each.along) for each in study.fit.data if each.is_profile}
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
        flat = [case for each in cases if each is not None for case in each.values()]
        found = iter(runs(flat))
        return [None if each is None else {test: next(found) for test in each} for each in cases]

    def cycle(number: int) -> int:
        of = data[number]
        return tests.cycle_of(tests.case(of.test, start), of.cycle)

    (first,) = predictions([start], errors=True)
    if first is None:
        raise FitError("the values to begin with make no valid case")
    comparisons = [
        Comparison.of(each, cycle(number), first[each.test]) for number, each in enumerate(data)
    ]

    def signals(points: Sequence[Array]) -> list[list[Array] | None]:
        found = predictions(points)
        for u, each in zip(points, found, strict=True):
            values = ", ".join(
                f"{unknown.name} = {float(unknown.value(x)):.4g}"
                for unknown, x in zip(unknowns, u, strict=True)
            )
            tell(f"{values}{'' if each else ' (makes no case)'}")
        return [
            None
            if each is None
            else [c.signal(each[c.measurement.test]) for c in fitter.comparisons]
            for each in found
        ]

    fitter = Fitter(unknowns, comparisons, signals)
    best = fitter.best(start)
    warnings: list[str] = []
    fitter.comparisons, doubts = _with_noise(fitter, best)
    warnings += doubts
    best = fitter.best(best)
    (exact,) = predictions([best], errors=True)
    assert exact is not None
    fitter.comparisons = [c.with_errors(exact[c.measurement.test]) for c in fitter.comparisons]
    fitter.settled = [None] * len(comparisons)
    for _ in range(_ROUNDS):
        emulator = fitter.emulator(best)
        best, degrees = emulator.best, _degrees(fitter)
        p_value = _probability(fitter, emulator.least, degrees)
        if p_value >= _UNLIKELY or not any(c.measurement.is_profile for c in fitter.comparisons):
            break
        signal = fitter.signal(best)
        before, changes = [c.noise for c in fitter.comparisons], emulator.first
        parts = zip(fitter.comparisons, fitter.split(signal), fitter.settle(signal), strict=True)
        fitter.comparisons = [
            c.with_noise_of_residuals(s, n, fitter.split_all(changes, place))
            for place, (c, s, n) in enumerate(parts)
        ]
        for old, c in zip(before, fitter.comparisons, strict=True):
            if old is not None and c.noise is not None:
                warnings.append(
                    f"the noise of {c.measurement.quantity}, {old.size * 1e6:.3g} µm, does not "
                    f"explain its residuals (p = {p_value:.1g}): {c.noise.size * 1e6:.3g} µm, "
                    f"correlated over {c.noise.length * 1e6:.3g} µm, was taken instead, which "
                    "widens the intervals; see the residuals for what the model leaves out"
                )
    derivatives = emulator.first @ np.linalg.inv(emulator.directions)
    spread = fitter.spread(fitter.signal(emulator.best), derivatives)
    profiles = fitter.intervals(emulator, spread)
    signal, p_value = fitter.signal(emulator.best), _probability(fitter, emulator.least, degrees)
    covariance = fitter.covariance(signal, derivatives)
    compared = _compared(fitter, signal, derivatives)
    result = Fit(
        tests.study,
        unknowns,
        emulator,
        (*profiles,),
        covariance,
        spread,
        (*compared,),
        emulator.least,
        degrees,
        p_value,
        len(runs.done),
        runs.computed,
        (),
        _advice(tests, emulator, covariance, predictions),
        tests.fitted(emulator.best),
        seed,
    )
    vars(result)["warnings"] = (
        *dict.fromkeys([*warnings, *doubts_of(result, tests.case(data[0].test, emulator.best))]),
    )
    return result


def _advice(
    tests: _Tests,
    emulator: Emulator,
    covariance: Array,
    predictions: Callable[[Sequence[Array]], list[dict[int, Prediction] | None]],
) -> str:
    """Say which further number, known to 5 %, would narrow the widest interval most."""
    reach = emulator.directions
    points = [emulator.center, *(emulator.center + reach[:, place] for place in range(len(reach)))]
    known = [each for each in predictions(points) if each is not None]
    if len(known) < len(points):
        return ""
    deviations = np.sqrt(np.diag(covariance))
    widest = int(deviations.argmax())
    measured = {(each.quantity, each.test) for each in tests.request.data}
    best = (1.0, "")
    for test, first in known[0].items():
        for name in first.numbers:
            if name not in _ADVISED or (name, test) in measured:
                continue
            for row, cycle in enumerate(first.cycles):
                columns = [float(each[test].numbers[name][row]) for each in known]
                early = cycle < _EARLIEST * first.cycles[-1]
                if early or min(columns) <= 0.0 or not np.isfinite(columns).all():
                    continue
                slopes = np.log(np.array(columns[1:]) / columns[0]) @ np.linalg.inv(reach)
                moved = covariance @ slopes
                left = covariance[widest, widest] - moved[widest] ** 2 / (
                    slopes @ moved + _ADVISED_ERROR**2
                )
                share = float(np.sqrt(max(left, 0.0))) / deviations[widest]
                words = RESULTS[name].words
                best = min(best, (share, f"the {words} at cycle {cycle:.0f} of test {test}"))
    share, what = best
    if not what or share > _HARDLY:
        return ""
    return (
        f"Of the numbers that these tests could give, {what}, measured within "
        f"{100 * _ADVISED_ERROR:.0f} %, would narrow {tests.unknowns[widest].name} most: its "
        f"interval would be {100 * share:.0f} % as wide."
    )


def _with_noise(fitter: Fitter, best: Array) -> tuple[list[Comparison], list[str]]:
    """The comparisons with the noise beside their scars, and doubts about it."""
    signal, found, doubts = fitter.signal(best), [], []
    parts = zip(fitter.comparisons, fitter.split(signal), fitter.settle(signal), strict=True)
    for comparison, part, nuisances in parts:
        better, doubt = comparison.with_noise_beside(part, nuisances)
        found.append(better)
        if doubt:
            doubts.append(
                f"{comparison.measurement.quantity} {doubt}, too few to tell its noise, which was "
                "taken from the residuals of the fit: write noise and correlation_length"
            )
    return found, doubts


def _degrees(fitter: Fitter) -> int:
    """Degrees of freedom: readings less parameters and base lines."""
    of_baselines = sum(
        len(c.names) - sum(deviation > 0.0 for deviation in c.deviations)
        for c in fitter.comparisons
        if c.measurement.readings is not None
    )
    readings = sum(comparison.readings for comparison in fitter.comparisons)
    return readings - of_baselines - len(fitter.unknowns)


def _probability(fitter: Fitter, misfit: float, degrees: int) -> float:
    """Probability of a χ² at least as large, if noise and model are right.

    The noise is scaled by that of readings beside the scars, whose χ² is their degrees of freedom:
    what is left is compared with it by the distribution of Fisher and Snedecor. Without degrees of
    freedom, it is as if there was one.
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


def _compared(fitter: Fitter, signal: Array, derivatives: Array) -> list[FittedMeasurement]:
    """Each measurement beside the best run, with errors of its base line and of the curve."""
    settled = fitter.settle(signal)
    parts = [*zip(fitter.comparisons, fitter.split(signal), settled, strict=True)]
    blocks, by_u = [], []
    for place, (comparison, part, nuisances) in enumerate(parts):
        blocks.append(comparison.slopes(part, nuisances))
        changes = [fitter.split(column)[place] for column in derivatives.T]
        by_u.append(np.column_stack([comparison.by_signal(part, nuisances, c) for c in changes]))
    rows = sum(len(block) for block in blocks)
    count, nuisance_count = derivatives.shape[1], sum(block.shape[1] for block in blocks)
    whole = np.zeros((rows, count + nuisance_count))
    row, column = 0, count
    for block, of_u in zip(blocks, by_u, strict=True):
        whole[row : row + len(block), :count] = of_u
        whole[row : row + len(block), column : column + block.shape[1]] = block
        row, column = row + len(block), column + block.shape[1]
    scales = np.maximum(np.abs(whole).max(axis=0), 1e-300)
    covariance = np.linalg.pinv((whole / scales).T @ (whole / scales), rcond=1e-12)
    covariance = covariance / np.outer(scales, scales)
    found, column = [], count
    for place, (comparison, part, nuisances) in enumerate(parts):
        own = np.r_[0:count, column : column + nuisances.size]
        block = covariance[np.ix_(own, own)]
        changes = [fitter.split(each)[place] for each in derivatives.T]
        fitted = comparison.modelled(part, nuisances)
        of_curve = [comparison.modelled(part + c, nuisances) - fitted for c in changes]
        for index, step in enumerate(comparison.steps if nuisances.size else ()):
            ahead = nuisances.copy()
            ahead[index] += step
            of_curve.append((comparison.modelled(part, ahead) - fitted) / step)
        slopes = np.column_stack(of_curve)
        band = np.sqrt(np.maximum(((slopes @ block) * slopes).sum(axis=1), 0.0))
        deviations = np.sqrt(np.maximum(np.diag(block)[count:], 0.0))
        spread = np.sqrt(np.maximum(np.diag(block), 1e-300))
        correlation = (block / np.outer(spread, spread))[:count, count:]
        found.append(FittedMeasurement(comparison, part, nuisances, deviations, band, correlation))
        column += nuisances.size
    return found
