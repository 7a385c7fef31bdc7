"""One case in a few lines of text: parameters, and key results beside the closed forms."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping

import xarray as xr

from fretwear.cli.tables import aligned, name_of, quantity_text, text_of
from fretwear.mechanics.theory import CattaneoMindlin, HertzContact
from fretwear.study.case import Case

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
    yield from aligned([(name_of(value), text_of(value)) for value in _parameters(case)])
    yield ""
    yield "Results"
    yield from aligned(list(_results(case)))
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
        row = (text_of(first[name]), text_of(last[name]), _reference(case[name], unworn))
        yield (name_of(case[name]), *row)
    yield (f"deepest {name_of(deepest)}", "", text_of(deepest), "")


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
    return quantity_text(unworn[name], result.attrs["units"]) if name in unworn else ""
