"""A fit: from a study with measurements to values, intervals and what they are worth."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
import xarray as xr

from fretwear.arrays import Array
from fretwear.data.atomic import write_text
from fretwear.data.files import write_groups
from fretwear.data.labels import FORMAT, history_line, source
from fretwear.study.study import Study
from fretwear.units import BY_SI_UNIT, format_quantity, number_text
from fretwear_fit.comparison import Comparison
from fretwear_fit.emulator import Emulator
from fretwear_fit.estimate import LEVELS, Profile
from fretwear_fit.posterior import CHAINS, DRAWS, TOGETHER, Posterior
from fretwear_fit.request import Unknown

_PREDICTED = 200  # draws whose predictions are stored
UNLIKELY = 0.01
"""p value below which the noise does not explain the residuals."""

Record: TypeAlias = Mapping[str, Any]  # the content of fit.json


@dataclass(frozen=True)
class Fit:
    """The result of a fit."""

    study: Study
    unknowns: tuple[Unknown, ...]
    emulator: Emulator
    profiles: tuple[Profile, ...]
    covariance: Array  # of the coordinates in which parameters are sought, with the noise taken
    measurements: tuple[tuple[Comparison, Array, Array], ...]  # with best signals and nuisances
    misfit: float  # χ²
    degrees: int  # of freedom
    p_value: float  # of a χ² as large, if noise and model are right
    runs: int  # runs that it needs
    computed: int  # runs that no folder had kept
    search_warnings: tuple[str, ...]
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

        By the profile likelihood or, where that does not do, of draws from the posterior.
        """
        place = self.names.index(name)
        low, high = self.profiles[place].interval(level)
        if self.posterior.reason and not any(self.profiles[place].is_open(level)):
            best = float(self.emulator.best[place])
            low, high = self.posterior.interval(place, level, best)
        unknown = self.unknowns[place]
        low = unknown.ends[0] if self.is_limit(name) else low
        return float(unknown.value(low)), float(unknown.value(high))

    @property
    def correlation(self) -> Array:
        """Correlations of the parameters, shape (p, p)."""
        deviations = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(deviations, deviations))

    def is_open(self, name: str, level: float = LEVELS[-1]) -> tuple[bool, bool]:
        """Whether the range of a parameter ends its interval, below and above."""
        low, high = self.profiles[self.names.index(name)].is_open(level)
        return low or self.is_limit(name), high

    def is_limit(self, name: str) -> bool:
        """Whether the data give an upper limit only: of wear that no measured profile shows."""
        unknown = self.unknowns[self.names.index(name)]
        return unknown.is_of_wear and all(of.is_placed for of, *_ in self.measurements)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What the search met, and what the data leave open."""
        return (*dict.fromkeys([*self.search_warnings, *self._left_open()]),)

    def _left_open(self) -> Iterator[str]:
        if self.p_value < UNLIKELY:
            yield (
                "the model does not explain the data within their errors: "
                f"χ² = {self.misfit:.4g} with {self.degrees} degrees of freedom, "
                f"p = {self.p_value:.1g}; intervals are wider by the root of their ratio"
            )
        words = {
            (True, True): "the data do not determine {}",
            (True, False): "{} has an upper bound only",
            (False, True): "{} has a lower bound only",
        }
        for name in self.names:
            if (ends := self.is_open(name)) in words:
                yield words[ends].format(name)
        names, deviations = self.names, np.sqrt(np.diag(self.covariance))
        for i, j in zip(*np.triu_indices(len(names), 1), strict=True):
            if abs(correlation := self.correlation[i, j]) > TOGETHER:
                product = ""
                if all(self.unknowns[place].logarithmic for place in (i, j)):
                    ratio = -np.sign(correlation) * deviations[i] / deviations[j]
                    product = f": {names[i]} · {names[j]}^{ratio:.2g}"
                yield f"the data determine {names[i]} and {names[j]} together only{product}"

    def as_dict(self) -> dict[str, object]:
        """The content of ``fit.json``."""
        parameters, level = {}, LEVELS[-1]
        for unknown, (name, value) in zip(self.unknowns, self.values.items(), strict=True):
            low, high = self.interval(name)
            parameters[name] = {
                "value": value,
                "low": low,
                "high": high,
                "level": level,
                "unit": unknown.quantity.si_unit,
                "intervals": {f"{share:g}": [*self.interval(name, share)] for share in LEVELS},
            }
        correlation = zip(self.names, self.correlation.tolist(), strict=True)
        return {
            "study": self.study.name,
            "parameters": parameters,
            "correlation": {n: dict(zip(self.names, row, strict=True)) for n, row in correlation},
            "chi_square": self.misfit,
            "degrees_of_freedom": self.degrees,
            "p_value": self.p_value,
            "runs": self.runs,
            "warnings": [*self.warnings],
        }

    def write(self, path: Path) -> None:
        """Write ``fit.nc``, with groups in the conventions of ArviZ."""
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
                quantity = unknown.quantity
                words = {"units": quantity.si_unit, "long_name": quantity.words}
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
        fitted = xr.Dataset(attrs=attributes)
        for number, (comparison, *best) in enumerate(self.measurements, start=1):
            name, dim, measured = f"data_{number}", f"reading_{number}", comparison.measurement
            unit = getattr(measured.force_noise or measured.value, "si_unit", "m")
            words = {"long_name": comparison.title, "units": unit}
            x, readings = measured.readings
            if measured.file is not None:
                observed.coords[f"position_{number}"] = dim, x, {"units": "m"}
            observed[name] = dim, readings, words
            predicted[name] = (*draw, dim), self._predicted(number - 1, few), words
            fitted[name] = dim, comparison.modelled(*best), words
        groups = {
            "": xr.Dataset(),
            "posterior": of(self.posterior.draws, fit=json.dumps(self.as_dict())),
            "prior": of(prior),
            "observed_data": observed,
            "posterior_predictive": predicted,
            # What the best run predicts, with the base line that suits it.
            "constant_data": fitted,
        }
        write_groups(path, groups)

    def _predicted(self, place: int, draws: Array) -> Array:
        """Readings of a measurement for draws, shape (chains, draws, n), noise included."""
        comparison, _, settled = self.measurements[place]
        generator = np.random.default_rng(self.seed + 2 + place)
        ends = np.cumsum([signal.size for _, signal, _ in self.measurements])[:-1]
        drawn = []
        for u in draws.reshape(-1, draws.shape[-1]):
            signal = np.split(self.emulator.signal(u), ends)[place]
            nuisances = comparison.settled(signal, settled)
            drawn.append(comparison.drawn(signal, nuisances, generator))
        return np.reshape(drawn, (*draws.shape[:2], -1))

    def write_json(self, path: Path) -> None:
        """Write ``fit.json``."""
        write_text(path, json.dumps(self.as_dict(), indent=1, ensure_ascii=False) + "\n")


def parameter_table(record: Record) -> pd.DataFrame:
    """Value and intervals of each parameter as texts, from the content of ``fit.json``."""
    rows = {}
    for name, entry in record["parameters"].items():
        rows[name] = {"value": quantity_text(entry["value"], entry["unit"])}
        for level, ends in entry["intervals"].items():
            # Two digits of the width of an interval, and three of each end or more.
            narrow = abs(entry["value"]) / ((ends[1] - ends[0]) or 1.0)
            digits = max(3, 2 + math.floor(math.log10(narrow or 1.0)))
            texts = [quantity_text(end, entry["unit"], digits) for end in ends]
            rows[name][f"{100 * float(level):.0f} %"] = " to ".join(texts)
    return pd.DataFrame.from_dict(rows, "index")


def quantity_text(value: float, unit: str, digits: int = 4) -> str:
    """A value in SI units as people read it."""
    if unit in BY_SI_UNIT and unit not in ("1", "Pa-1"):
        return format_quantity(value, BY_SI_UNIT[unit], digits)
    return f"{number_text(value, digits)} {'' if unit == '1' else unit.replace('-1', '⁻¹')}".strip()
