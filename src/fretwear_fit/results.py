"""A fit: from a study with measurements to values, intervals and what they are worth."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fretwear.arrays import Array
from fretwear.data.atomic import write_text
from fretwear.data.files import write_groups
from fretwear.data.labels import FORMAT, history_line, source
from fretwear.study.study import Study
from fretwear_fit.comparison import Comparison
from fretwear_fit.emulator import Emulator
from fretwear_fit.estimate import LEVELS, Fitter, Profile, Unknown
from fretwear_fit.posterior import CHAINS, DRAWS, Posterior

if TYPE_CHECKING:
    import xarray as xr

_PREDICTED = 200  # draws whose predictions are stored
_SHOWN = (LEVELS[0], LEVELS[-1])


@dataclass(frozen=True)
class FittedMeasurement:
    """A measurement beside the best run."""

    comparison: Comparison
    signal: Array  # what the run predicts on the grid
    nuisances: Array  # base line and numerical errors
    deviations: Array  # standard deviations of the nuisances
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
    derivatives: Array  # of all signals by the parameters, at the best ones, shape (g, p)
    profiles: tuple[Profile, ...]
    covariance: Array  # of the coordinates in which parameters are sought, with the noise taken
    spread: Array  # variances with noises that the readings allow, over it, shape (m, p)
    measurements: tuple[FittedMeasurement, ...]
    misfit: float  # χ²
    degrees: int  # of freedom
    p_value: float  # of a χ² as large, if noise and model are right
    runs: int  # runs that it needs
    computed: int  # runs that no folder had kept
    warnings: tuple[str, ...]
    posterior: Posterior
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
        """The interval of a parameter, in SI units; an end of its range where it is open.

        By the profile likelihood or, where that does not do, central among draws of the posterior.
        """
        place = self.names.index(name)
        low, high = self.profiles[place].interval(level)
        if self.posterior.reason and not any(self.profiles[place].is_open(level)):
            low, high = self.posterior.interval(place, level)
        unknown = self.unknowns[place]
        low = unknown.ends[0] if self.is_limit(name) else low
        return float(unknown.value(low)), float(unknown.value(high))

    @property
    def correlation(self) -> Array:
        """Correlations of the parameters, shape (p, p)."""
        deviations = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(deviations, deviations))

    def table(self) -> list[tuple[str, ...]]:
        """Rows of text about the parameters, below a row of words: value and intervals."""
        rows = [("parameter", "value", *(f"{100 * level:.0f} %" for level in _SHOWN))]
        for unknown, value in zip(self.unknowns, self.values.values(), strict=True):
            texts = [unknown.free.about.text(value)]
            for level in _SHOWN:
                open_ends = self.is_open(unknown.name, level)
                shown = [
                    word if is_open else unknown.free.about.text(_rounded(end))
                    for end, is_open, word in zip(
                        self.interval(unknown.name, level),
                        open_ends,
                        ("below range", "above range"),
                        strict=True,
                    )
                ]
                texts.append(" to ".join(shown))
            rows.append((unknown.name, *texts))
        return rows

    def is_open(self, name: str, level: float = LEVELS[-1]) -> tuple[bool, bool]:
        """Whether the range of a parameter ends its interval, below and above."""
        low, high = self.profiles[self.names.index(name)].is_open(level)
        return low or self.is_limit(name), high

    def is_limit(self, name: str) -> bool:
        """Whether the data give an upper limit only: of wear that no measured profile shows."""
        free = self.unknowns[self.names.index(name)].free
        return free.is_of_wear and all(datum.comparison.is_placed for datum in self.measurements)

    def as_dict(self, level: float = LEVELS[-1]) -> dict[str, Any]:
        """The content of ``fit.json``."""
        parameters, measurements = {}, []
        for unknown, (name, value) in zip(self.unknowns, self.values.items(), strict=True):
            low, high = self.interval(name, level)
            parameters[name] = {
                "value": value,
                "low": low,
                "high": high,
                "level": level,
                "unit": unknown.free.about.si_unit,
                "intervals": {f"{share:g}": [*self.interval(name, share)] for share in LEVELS},
            }
        for datum in self.measurements:
            of = datum.comparison
            record: dict[str, Any] = {"measurement": datum.title}
            rows = zip(of.names, datum.nuisances, datum.deviations, of.units, strict=True)
            for name, value, deviation, unit in rows:
                record[name] = {"value": float(value), "error": float(deviation), "unit": unit}
            if of.noise is not None:
                record |= {"noise": of.noise.size, "correlation_length": of.noise.length}
            measurements.append(record)
        correlation = zip(self.names, self.correlation.tolist(), strict=True)
        return {
            "study": self.study.name,
            "parameters": parameters,
            "correlation": {n: dict(zip(self.names, row, strict=True)) for n, row in correlation},
            "measurements": measurements,
            "chi_square": self.misfit,
            "degrees_of_freedom": self.degrees,
            "p_value": self.p_value,
            "runs": self.runs,
            "warnings": [*self.warnings],
        }

    def groups(self) -> dict[str, xr.Dataset]:
        """The groups of ``fit.nc``, in the conventions of ArviZ, by name."""
        import xarray as xr

        attributes = {
            **FORMAT,
            "source": source(),
            "history": history_line("fretwear fit"),
            "inference_library": "fretwear",
        }
        draw = ("chain", "draw")

        def of(draws: Array, **more: str) -> xr.Dataset:
            variables = {}
            for place, unknown in enumerate(self.unknowns):
                about = unknown.free.about
                words = {"units": about.si_unit, "long_name": about.words}
                variables[unknown.name] = draw, unknown.value(draws[..., place]), words
            chains = {name: np.arange(n) for name, n in zip(draw, draws.shape[:2], strict=True)}
            return xr.Dataset(variables, chains, attributes | more)

        lower, upper = np.array([unknown.ends for unknown in self.unknowns]).T
        prior = np.random.default_rng(self.seed + 1).uniform(
            lower, upper, (CHAINS, DRAWS, lower.size)
        )
        few = self.posterior.draws[:, :: DRAWS * CHAINS // _PREDICTED]
        observed = xr.Dataset(attrs=attributes)
        predicted = of(few)[[*draw]]
        for number, datum in enumerate(self.measurements, start=1):
            name, dim, measured = (
                f"data_{number}",
                f"reading_{number}",
                datum.comparison.measurement,
            )
            unit = getattr(measured.force_noise or measured.value, "si_unit", "m")
            words = {"long_name": datum.title, "units": unit}
            readings = np.array([measured.value])
            if measured.readings is not None:
                x, readings = measured.readings
                observed.coords[f"position_{number}"] = dim, x, {"units": "m"}
            observed[name] = dim, readings, words
            predicted[name] = (*draw, dim), self._predicted(number - 1, few), words
        return {
            "posterior": of(self.posterior.draws, fit=json.dumps(self.as_dict())),
            "prior": of(prior),
            "observed_data": observed,
            "posterior_predictive": predicted,
        }

    def _predicted(self, place: int, draws: Array) -> Array:
        """Readings of a measurement for draws, shape (chains, draws, n), noise included."""
        datum = self.measurements[place]
        generator = np.random.default_rng(self.seed + 2 + place)
        sizes = [one.signal.size for one in self.measurements]
        begin = sum(sizes[:place])
        part = slice(begin, begin + sizes[place])
        drawn = []
        for u in draws.reshape(-1, draws.shape[-1]):
            signal = self.emulator.signal(u)[part]
            # The base line goes with the parameters, of which it is almost a linear function.
            nuisances = datum.comparison.settled(signal, datum.nuisances, steps=1)
            drawn.append(datum.comparison.drawn(signal, nuisances, generator))
        return np.reshape(drawn, (*draws.shape[:2], -1))

    def write(self, path: Path) -> None:
        """Write ``fit.nc``: a netCDF file with a group for each part."""
        import xarray as xr

        write_groups(path, {"": xr.Dataset(), **self.groups()})

    def write_json(self, path: Path) -> None:
        """Write ``fit.json``."""
        write_text(path, json.dumps(self.as_dict(), indent=1, ensure_ascii=False) + "\n")


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")


def compared(fitter: Fitter, signal: Array, derivatives: Array) -> list[FittedMeasurement]:
    """Each measurement beside the best run, with errors of its base line."""
    from scipy.linalg import block_diag

    parts, count = fitter.parts(signal), derivatives.shape[1]
    columns = [
        c.derivatives(s, n, fitter.split_all(derivatives, place))
        for place, (c, s, n) in enumerate(parts)
    ]
    by_u = np.concatenate([each[:, :count] for each in columns])
    whole = np.hstack([by_u, block_diag(*(each[:, count:] for each in columns))])
    scales = np.maximum(np.abs(whole).max(axis=0), 1e-150)  # products of two are not 0
    covariance = np.linalg.pinv((whole / scales).T @ (whole / scales), rcond=1e-12)
    covariance = covariance / np.outer(scales, scales)
    fitted, column = [], count
    for comparison, part, nuisances in parts:
        places = np.r_[0:count, column : column + nuisances.size]
        block = covariance[np.ix_(places, places)]
        deviations = np.sqrt(np.maximum(np.diag(block)[count:], 0.0))
        spread = np.sqrt(np.maximum(np.diag(block), 1e-300))
        correlation = (block / np.outer(spread, spread))[:count, count:]
        fitted.append(FittedMeasurement(comparison, part, nuisances, deviations, correlation))
        column += nuisances.size
    return fitted
