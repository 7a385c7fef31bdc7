"""A merged study as a table: what was varied, and the key results of every point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from fretwear.cli.tables import aligned, plain, quantity_text
from fretwear.vocabulary import PointStatus

_RESULTS = {
    "contact_half_width_x": "half-width x",
    "stick_half_width_x": "stick x",
    "peak_pressure": "peak pressure",
    "wear_volume": "wear volume",
}
_WORDS = {PointStatus.DONE: "done", PointStatus.FAILED: "failed", PointStatus.INVALID: "invalid"}
_LISTED = 100


@dataclass(frozen=True)
class StudySummary:
    """What is to be told of a merged study.

    Attributes
    ----------
    summary : xarray.Dataset
        From `fretwear.data.files.open_summary`.
    """

    summary: xr.Dataset

    def lines(self) -> Iterator[str]:
        """Yield the lines for people."""
        attributes, points = self.summary.attrs, self._points()
        states = [point.status for point in points]
        yield str(attributes["title"])
        yield f"study {attributes['study']}, {attributes['source']}"
        counts = ", ".join(f"{states.count(state)} {word}" for state, word in _WORDS.items())
        yield f"{len(points)} point{'s' * (len(points) != 1)}: {counts}"
        yield ""
        yield f"After the last cycle, {self.summary['cycle'].values.max():.0f}"
        header = ("id", *self._varied(), *_RESULTS.values())
        yield from aligned([header, *(self._row(point) for point in points[:_LISTED])])
        if len(points) > _LISTED:
            yield f"  and {len(points) - _LISTED} more points; --json prints all of them"

    def content(self) -> dict[str, Any]:
        """Return the points in SI units for JSON; what is infinite or not there is null."""
        attributes, units = self.summary.attrs, self._units()
        return {
            "study": attributes["study"],
            "title": attributes["title"],
            "source": attributes["source"],
            "units": dict(units),
            "points": [
                {
                    "case_id": point.case_id,
                    "status": _WORDS[point.status],
                    **{name: plain(value) for name, value in point.parameters.items()},
                    **{name: plain(value) for name, value in point.results.items()},
                }
                for point in self._points()
            ],
        }

    def _varied(self) -> list[str]:
        """Names of the coordinates that differ between the points."""
        dims = set(self.summary["status"].dims)
        return [
            str(name)
            for name, value in self.summary.coords.items()
            if value.dims and set(value.dims) <= dims and name != "case_id" and name != "point"
        ]

    def _units(self) -> Mapping[str, str]:
        names = [*self._varied(), *_RESULTS]
        return {name: str(self.summary[name].attrs.get("units", "")) for name in names}

    def _points(self) -> list[_Point]:
        status = self.summary["status"]
        # Arrays first: asking the dataset for each number would take a millisecond every time.
        shape = status.shape
        ids = np.broadcast_to(self.summary["case_id"].values, shape)
        varied = {
            name: self.summary[name].broadcast_like(status).transpose(*status.dims).values
            for name in self._varied()
        }
        results = {
            name: _last_known(self.summary[name].transpose(*status.dims, "cycle").values)
            for name in _RESULTS
        }
        states = status.values
        return [
            _Point(
                str(ids[index]),
                PointStatus(int(states[index])),
                {name: values[index].item() for name, values in varied.items()},
                {name: values[index].item() for name, values in results.items()},
            )
            for index in np.ndindex(shape)
        ]

    def _row(self, point: _Point) -> tuple[str, ...]:
        units = self._units()
        parameters = (_text(value, units[name]) for name, value in point.parameters.items())
        if point.status is not PointStatus.DONE:
            blank = ("",) * (len(_RESULTS) - 1)
            return (point.case_id, *parameters, _WORDS[point.status], *blank)
        results = (_text(value, units[name]) for name, value in point.results.items())
        return (point.case_id, *parameters, *results)


@dataclass(frozen=True)
class _Point:
    case_id: str
    status: PointStatus
    parameters: Mapping[str, Any]
    results: Mapping[str, float]


def _text(value: str | float, units: str) -> str:
    return value if isinstance(value, str) else quantity_text(value, units)


def _last_known(values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Last value along the last axis that is a number: cases may end at different cycles."""
    known = np.isfinite(values)
    last = values.shape[-1] - 1 - np.argmax(known[..., ::-1], axis=-1)
    return np.take_along_axis(values, last[..., np.newaxis], axis=-1)[..., 0]
