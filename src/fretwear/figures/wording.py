"""How case parameters are written: symbol, words, unit and values."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

from fretwear.units import (
    DEGREE,
    GIGAPASCAL,
    MEGAPASCAL,
    MICROMETRE,
    MILLIMETRE,
    NEWTON,
    NO_UNIT,
    PER_PASCAL,
    Unit,
    number_text,
    with_unit,
)

_SLIP_MODELS = {
    "jaeger": "slip of the worn shape",
    "cattaneo_mindlin": "slip of the unworn sphere",
}
_ROUGHNESS_PARTS = {"amplitude": "A", "slope_x": "θx", "slope_y": "θy"}


@dataclass(frozen=True)
class Parameter:
    """How one case parameter is written: symbol (mathtext), words and unit for people."""

    symbol: str
    words: str
    unit: Unit = NO_UNIT


PARAMETERS = {
    "radius": Parameter("$R$", "radius", MILLIMETRE),
    "youngs_modulus": Parameter("$E$", "Young's modulus", GIGAPASCAL),
    "youngs_modulus_1": Parameter("$E_1$", "Young's modulus of body I", GIGAPASCAL),
    "youngs_modulus_2": Parameter("$E_2$", "Young's modulus of body II", GIGAPASCAL),
    "poisson_ratio": Parameter("$ν$", "Poisson's ratio"),
    "poisson_ratio_1": Parameter("$ν_1$", "Poisson's ratio of body I"),
    "poisson_ratio_2": Parameter("$ν_2$", "Poisson's ratio of body II"),
    "load": Parameter("$P$", "load", NEWTON),
    "tangential_ratio": Parameter("$Q/µP$", "tangential ratio"),
    "tangential_load": Parameter("$Q$", "tangential load", NEWTON),
    "friction": Parameter("$µ$", "friction"),
    "wear_coefficient": Parameter("$K_w$", "wear coefficient", PER_PASCAL),
    "plastic_limit": Parameter(r"$p_\mathrm{lim}$", "plastic limit", MEGAPASCAL),
    "roughness_amplitude": Parameter("$A$", "roughness amplitude", MICROMETRE),
    "roughness_slope_x": Parameter("$θ_x$", "roughness slope along x", DEGREE),
    "roughness_slope_y": Parameter("$θ_y$", "roughness slope along y", DEGREE),
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
    return with_unit(number_text(unit.of(float(value))), unit)


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
