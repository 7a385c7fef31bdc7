"""How figures name and print quantities: units for people, symbols, numbers."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

_SLIP_MODELS = {
    "jaeger": "slip of the worn shape",
    "cattaneo_mindlin": "slip of the unworn sphere",
}
_ROUGHNESS_PARTS = {"amplitude": "A", "slope_x": "θx", "slope_y": "θy"}


@dataclass(frozen=True)
class Unit:
    """A unit to show values in: its name and its size in SI units."""

    name: str
    size: float

    @property
    def is_power(self) -> bool:
        """Whether its name begins with a power of ten, by which numbers are multiplied."""
        return self.name.startswith("10")

    def of(self, values: ArrayLike) -> NDArray[np.float64]:
        """Return SI `values` in this unit."""
        return np.asarray(values, dtype=np.float64) / self.size


MICROMETRE = Unit("µm", 1e-6)
MEGAPASCAL = Unit("MPa", 1e6)

_PREFIXED = {
    "m": (Unit("pm", 1e-12), Unit("nm", 1e-9), MICROMETRE, Unit("mm", 1e-3)),
    "m3": (
        Unit("µm³", 1e-18),
        Unit("10³ µm³", 1e-15),
        Unit("10⁶ µm³", 1e-12),
        Unit("mm³", 1e-9),
    ),
    "J": (
        Unit("pJ", 1e-12),
        Unit("nJ", 1e-9),
        Unit("µJ", 1e-6),
        Unit("mJ", 1e-3),
        Unit("J", 1.0),
    ),
}


def readable_unit(values: ArrayLike, base: str) -> Unit:
    """Return the unit in which the largest of `values` is a number from 1 to 1000.

    Parameters
    ----------
    values : array_like
        Values in SI units; NaN and infinite ones are not looked at.
    base : {"m", "m3", "J"}
        Their SI unit.
    """
    units = _PREFIXED[base]
    magnitudes = np.abs(np.asarray(values, dtype=np.float64))
    magnitudes = magnitudes[np.isfinite(magnitudes)]
    largest = float(magnitudes.max(initial=0.0))
    fitting = [unit for unit in units if unit.size <= largest]
    return fitting[-1] if fitting else units[0]


def plain_unit(base: str) -> Unit:
    """Return the smallest unit for people of an SI unit, as `readable_unit` takes it."""
    return _PREFIXED[base][0]


def with_unit(text: str, unit: Unit) -> str:
    """Return a number with its unit for running text: ``4.1 µm``, ``4.1 × 10³ µm³``."""
    if unit.is_power:
        return f"{text} × {unit.name}"
    return f"{text} {unit.name}".rstrip()


@dataclass(frozen=True)
class Parameter:
    """How one case parameter is written: symbol (mathtext), words and unit for people."""

    symbol: str
    words: str
    unit: Unit = Unit("", 1.0)


PARAMETERS = {
    "radius": Parameter("$R$", "radius", Unit("mm", 1e-3)),
    "youngs_modulus": Parameter("$E$", "Young's modulus", Unit("GPa", 1e9)),
    "youngs_modulus_1": Parameter("$E_1$", "Young's modulus of body I", Unit("GPa", 1e9)),
    "youngs_modulus_2": Parameter("$E_2$", "Young's modulus of body II", Unit("GPa", 1e9)),
    "poisson_ratio": Parameter("$ν$", "Poisson's ratio"),
    "poisson_ratio_1": Parameter("$ν_1$", "Poisson's ratio of body I"),
    "poisson_ratio_2": Parameter("$ν_2$", "Poisson's ratio of body II"),
    "load": Parameter("$P$", "load", Unit("N", 1.0)),
    "tangential_ratio": Parameter("$Q/µP$", "tangential ratio"),
    "tangential_load": Parameter("$Q$", "tangential load", Unit("N", 1.0)),
    "friction": Parameter("$µ$", "friction"),
    "wear_coefficient": Parameter("$K_w$", "wear coefficient", Unit("Pa⁻¹", 1.0)),
    "plastic_limit": Parameter(r"$p_\mathrm{lim}$", "plastic limit", MEGAPASCAL),
    "roughness_amplitude": Parameter("$A$", "roughness amplitude", MICROMETRE),
    "roughness_slope_x": Parameter("$θ_x$", "roughness slope along x", Unit("°", math.pi / 180)),
    "roughness_slope_y": Parameter("$θ_y$", "roughness slope along y", Unit("°", math.pi / 180)),
    "cycles": Parameter("$N$", "cycles"),
    "cell_x": Parameter("$Δx$", "cell along x", MICROMETRE),
    "cell_y": Parameter("$Δy$", "cell along y", MICROMETRE),
    "tolerance": Parameter("tolerance", "tolerance"),
    "slip_model": Parameter("slip model", "slip model"),
    "hertz_radius": Parameter("$a$", "Hertz contact radius", MICROMETRE),
    "hertz_pressure": Parameter("$p_0$", "Hertz pressure", MEGAPASCAL),
}


def parameter(name: str) -> Parameter:
    """Return how the parameter called `name` in a study file is written."""
    return PARAMETERS.get(name, Parameter(name, name.replace("_", " ")))


def _number(name: str, value: Any) -> str:
    unit = parameter(name).unit
    text = number(float(value) / unit.size)
    separator = "" if unit.name in ("", "°") else " "
    return f"{text}{separator}{unit.name}"


def number(value: float) -> str:
    """Return `value` with up to five significant digits, as people write it."""
    rounded = float(f"{value:.5g}")
    if value == 0.0 or 1e-4 <= abs(rounded) < 1e6:
        return f"{rounded:.10g}".replace("-", "−")
    text = f"{value:.5g}"
    if "e" not in text:
        return text.replace("-", "−")
    mantissa, exponent = text.split("e")
    power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa}·10{power}".replace("-", "−")


def cycle_number(value: float) -> str:
    """Return a number of cycles with a thin space between thousands, from 10 000 on."""
    rounded = round(float(value))
    return f"{rounded:,}".replace(",", "\u2009") if rounded >= 10_000 else str(rounded)


def _special(name: str, value: Any) -> str | None:
    if name == "roughness" and isinstance(value, str):
        return _roughness(value)
    if name == "plastic_limit" and not isinstance(value, str) and math.isinf(float(value)):
        return "elastic"
    if name == "roughness_amplitude" and not isinstance(value, str) and float(value) == 0.0:
        return "smooth"
    return str(value) if isinstance(value, str) else None


def _roughness(text: str) -> str:
    """Return a roughness given as a whole, ``{kind: wavy, amplitude: 0.3 um, ...}``, in short."""
    if text == "none":
        return "smooth"
    parts = [
        f"{symbol} = {match[1]}"
        for key, symbol in _ROUGHNESS_PARTS.items()
        if (match := re.search(rf"{key}: ([^,}}]+)", text))
    ]
    return ", ".join(parts).replace(" um", " µm").replace(" deg", "°") or text


def value_text(name: str, value: Any) -> str:
    """Return the value alone, in units for people: ``25 N``, ``smooth``, ``elastic``."""
    return _special(name, value) or _number(name, value)


def _told(name: str, value: Any) -> str | None:
    """Return the words of a value that needs no name beside it."""
    return _SLIP_MODELS.get(str(value)) if name == "slip_model" else _special(name, value)


def symbol_text(name: str, value: Any) -> str:
    """Return symbol and value in mathtext, for labels inside figures: ``$P$ = 25 N``."""
    return _told(name, value) or f"{parameter(name).symbol} = {_number(name, value)}"


def words_text(name: str, value: Any) -> str:
    """Return words and value, for captions: ``load 25 N``, ``elastic``."""
    return _told(name, value) or f"{parameter(name).words} {_number(name, value)}"
