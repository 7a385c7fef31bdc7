"""One case in a few lines of text: parameters, and key results beside the closed forms."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import xarray as xr

from fretwear.cli.tables import aligned, name_of, plain, quantity_text, text_of
from fretwear.study.case import Case
from fretwear.theory import CattaneoMindlin, HertzContact

# In words that leave room for three columns of numbers on a line of 80.
_RESULTS = {
    "contact_half_width_x": "contact half-width along x",
    "contact_half_width_y": "contact half-width along y",
    "stick_half_width_x": "stick half-width along x",
    "contact_area": "contact area",
    "stick_area": "stick area",
    "central_pressure": "pressure in the middle",
    "peak_pressure": "highest pressure",
    "approach": "approach of the bodies",
    "tangential_displacement": "tangential displacement at +Q",
    "dissipated_energy": "energy dissipated per cycle",
    "wear_volume": "wear volume",
    "plastic_volume": "plastically displaced volume",
}


@dataclass(frozen=True)
class CaseSummary:
    """What is to be told of a case.

    Attributes
    ----------
    case : xarray.Dataset
        The dataset of the case.
    history : xarray.Dataset
        Its dense history.
    """

    case: xr.Dataset
    history: xr.Dataset

    def lines(self) -> Iterator[str]:
        """Yield the lines for people."""
        return _lines(self.case, self.history)

    def content(self) -> dict[str, Any]:
        """Return parameters and results in SI units for JSON; what is infinite is null."""
        case = self.case
        results = {name: case[name] for name in _RESULTS}
        results["greatest_wear_depth"] = case["wear_depth"].max(("x", "y"), keep_attrs=True)
        return {
            "case_id": case.attrs["case_id"],
            "title": case.attrs["title"],
            "source": case.attrs["source"],
            "steps": self.history.sizes["step"] - 1,
            "parameters": {
                str(value.name): {"value": plain(value.item()), "units": value.attrs.get("units")}
                for value in _parameters(case)
            },
            "cycle": case["cycle"].values.tolist(),
            "results": {
                name: {
                    "values": [plain(value) for value in result.values.tolist()],
                    "units": result.attrs["units"],
                }
                for name, result in results.items()
            },
            "unworn": dict(_unworn(Case(**json.loads(case.attrs["parameters"])))),
        }


def _lines(case: xr.Dataset, history: xr.Dataset) -> Iterator[str]:
    cells = f"{case.sizes['x']} x {case.sizes['y']} cells"
    yield str(case.attrs["title"])
    if case.attrs["case_id"] not in case.attrs["title"]:
        yield str(case.attrs["case_id"])
    yield str(case.attrs["source"])
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
    for name, label in _RESULTS.items():
        yield (label, text_of(first[name]), text_of(last[name]), _reference(case[name], unworn))
    yield ("greatest wear depth", "", text_of(last["wear_depth"].max(keep_attrs=True)), "")


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
