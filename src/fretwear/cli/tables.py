"""Quantities as text for people, and rows of them as aligned lines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import xarray as xr

from fretwear.study.quantities import (
    ANGLE,
    COMPLIANCE,
    FORCE,
    LENGTH,
    NUMBER,
    PRESSURE,
    Dimension,
    format_quantity,
)

_AREA = Dimension("an area", "m2", "1 um2", ((1e-12, "um2"), (1e-6, "mm2")))
_VOLUME = Dimension("a volume", "m3", "1 um3", ((1e-18, "um3"), (1e-9, "mm3")))
_ENERGY = Dimension("an energy", "J", "1 uJ", ((1e-9, "nJ"), (1e-6, "uJ"), (1e-3, "mJ")))
_DIMENSIONS = {
    dimension.si_unit: dimension
    for dimension in (
        LENGTH,
        FORCE,
        PRESSURE,
        COMPLIANCE,
        ANGLE,
        NUMBER,
        _AREA,
        _VOLUME,
        _ENERGY,
    )
}
_DIGITS = 4


def name_of(value: xr.DataArray) -> str:
    """Return what a variable is, in words."""
    return str(value.attrs["long_name"])


def text_of(value: xr.DataArray) -> str:
    """Return a single value with its unit."""
    content = value.item()
    return content if isinstance(content, str) else quantity_text(content, value.attrs["units"])


def quantity_text(value: float, units: str) -> str:
    """Return a value in the SI unit `units` with a unit for people."""
    return format_quantity(value, _DIMENSIONS[units], _DIGITS)


def plain(value: Any) -> Any:
    """Return a value for JSON, which knows no number that is not finite."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def aligned(rows: Sequence[tuple[str, ...]]) -> Iterator[str]:
    """Yield rows as lines: the first column to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for first, *others in rows:
        cells = [text.rjust(width) for text, width in zip(others, widths[1:], strict=True)]
        yield "  ".join([f"  {first.ljust(widths[0])}", *cells]).rstrip()
