"""One case in a few lines of text: parameters, and key results beside the closed forms."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence

import xarray as xr

from fretwear.mechanics.theory import CattaneoMindlin, HertzContact
from fretwear.study.case import Case
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
_RESULTS = (
    "contact_half_width_x",
    "contact_half_width_y",
    "stick_half_width_x",
    "contact_area",
    "stick_area",
    "central_pressure",
    "peak_pressure",
    "approach",
    "tangential_displacement",
    "dissipated_energy",
    "wear_volume",
    "plastic_volume",
)


def summary_lines(case: xr.Dataset, history: xr.Dataset) -> Iterator[str]:
    """Yield the lines that tell of a case.

    Parameters
    ----------
    case : xarray.Dataset
        The dataset of the case.
    history : xarray.Dataset
        Its dense history.
    """
    cells = f"{case.sizes['x']} x {case.sizes['y']} cells"
    yield str(case.attrs["title"])
    yield f"{case.attrs['case_id']}, {case.attrs['source']}"
    yield (
        f"{cells} ({'a quarter' if case.attrs['symmetry'] != 'none' else 'all'} of the contact), "
        f"{history.sizes['step'] - 1} steps, {int(history['convolutions'].sum())} convolutions"
    )
    yield ""
    yield "Parameters"
    yield from _aligned([(_name(value), _text(value)) for value in _parameters(case)])
    yield ""
    yield "Results"
    yield from _aligned(list(_results(case)))
    yield ""
    yield (
        "Unworn: closed forms of a smooth elastic sphere with these parameters "
        "(Hertz, Cattaneo and Mindlin)."
    )


def _parameters(case: xr.Dataset) -> list[xr.DataArray]:
    return [value for value in case.coords.values() if value.ndim == 0]


def _results(case: xr.Dataset) -> Iterator[tuple[str, ...]]:
    first, last = case.isel(cycle=0), case.isel(cycle=-1)
    unworn = _unworn(Case(**json.loads(case.attrs["parameters"])))
    heads = (f"cycle {float(at['cycle']):.0f}" for at in (first, last))
    yield ("", *heads, "unworn")
    deepest = last["wear_depth"].max(keep_attrs=True)
    for name in _RESULTS:
        row = (_text(first[name]), _text(last[name]), _reference(case[name], unworn))
        yield (_name(case[name]), *row)
    yield (f"deepest {_name(deepest)}", "", _text(deepest), "")


def _unworn(case: Case) -> Mapping[str, float]:
    """Return what the closed forms say of the smooth elastic sphere."""
    hertz = HertzContact(case.radius, case.load, case.composite_modulus)
    sliding = CattaneoMindlin(hertz, case.friction, case.tangential_force, case.coupling)
    return {
        "contact_half_width_x": hertz.contact_radius,
        "contact_half_width_y": hertz.contact_radius,
        "stick_half_width_x": sliding.stick_radius,
        "contact_area": math.pi * hertz.contact_radius**2,
        "stick_area": math.pi * sliding.stick_radius**2,
        "central_pressure": hertz.peak_pressure,
        "peak_pressure": hertz.peak_pressure,
        "approach": hertz.approach,
        "tangential_displacement": sliding.tangential_displacement,
        "dissipated_energy": sliding.dissipated_energy,
    }


def _reference(result: xr.DataArray, unworn: Mapping[str, float]) -> str:
    name = str(result.name)
    return _quantity(unworn[name], result.attrs["units"]) if name in unworn else ""


def _name(value: xr.DataArray) -> str:
    return str(value.attrs["long_name"])


def _text(value: xr.DataArray) -> str:
    content = value.item()
    return content if isinstance(content, str) else _quantity(content, value.attrs["units"])


def _quantity(value: float, units: str) -> str:
    return format_quantity(value, _DIMENSIONS[units], _DIGITS)


def _aligned(rows: Sequence[tuple[str, ...]]) -> Iterator[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for first, *others in rows:
        cells = [text.rjust(width) for text, width in zip(others, widths[1:], strict=True)]
        yield "  ".join([f"  {first.ljust(widths[0])}", *cells]).rstrip()
