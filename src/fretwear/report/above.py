"""What the explorer shows of surfaces: contacts that are not even from above, and bearing areas."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretwear.data.bearing import has_bearing_area, heights_in_contact
from fretwear.data.files import CaseFile, opened_case
from fretwear.study.case import Case
from fretwear.units import MICROMETRE, Unit
from fretwear.vocabulary import SYMMETRIES, ContactState

MAPS = ("pressure", "wear_depth")
"""Fields over x and y, a map of the explorer each."""

Array = NDArray[np.float64]

_BEYOND_CONTACT = 1.05
_MOST_CELLS = 64
MOST_SQUARES = len(MAPS) * _MOST_CELLS**2
"""Values of the maps of a snapshot at most."""

_POINTS = 101
_LEVELS = 255


@dataclass(frozen=True)
class View:
    """A contact from above at k snapshots; SI units."""

    x: Array  # shape (n,): middles of squares of cells, to a little beyond the contact
    y: Array  # shape (m,)
    fields: Mapping[str, Array]  # shape (k, n, m): means of the fields of `MAPS` over the squares

    def packed(self, units: Mapping[str, Unit]) -> dict[str, Any]:
        """Return what JSON has of it: each map in steps of a 255th of its largest value."""
        return {
            "x": _evenly_spaced(self.x),
            "y": _evenly_spaced(self.y),
            "fields": {
                name: [_bytes(units[name].of(each)) for each in maps]
                for name, maps in self.fields.items()
            },
        }


class Above(NamedTuple):
    """What is shown of the surfaces of a case beside its profiles."""

    view: View | None = None  # the contact from above, where it is not even along both axes
    # Heights, m, above which each per cent of a rough contact lies, before and after wear.
    heights: tuple[Array, Array] | None = None


def read_above(path: Path, case: Case, cycles: Array) -> Above:
    """Read from a case file what is shown of its surfaces at some snapshots.

    Nothing is read of smooth contacts that are even along both axes.

    Raises
    ------
    CaseFileError
        When the file is missing or damaged.
    """
    is_seen = not (case.indenter.is_line or all(case.even))
    if not is_seen and not has_bearing_area(case):
        return Above()
    with opened_case(path) as file:
        places = np.searchsorted(file.read("cycle"), cycles).tolist()
        return Above(
            _view(file, places) if is_seen else None,
            _heights(file, case) if has_bearing_area(case) else None,
        )


def _view(file: CaseFile, places: Sequence[int]) -> View:
    even = SYMMETRIES[file.attribute("symmetry")]
    axes: list[Array] = []
    kept: list[NDArray[np.intp]] = []
    touching = file.read("contact_state", places[-1]) > ContactState.OPEN
    for axis, is_even in zip(("x", "y"), even, strict=True):
        at = file.read(axis).astype(np.float64)
        reach = float(np.abs(at[touching.any(axis=1 - len(axes))]).max())
        inside = np.flatnonzero(np.abs(at) <= _BEYOND_CONTACT * reach)
        axes.append(np.r_[-at[inside][::-1], at[inside]] if is_even else at[inside])
        kept.append(np.r_[inside[::-1], inside] if is_even else inside)
    steps = [-(-at.size // _MOST_CELLS) for at in axes]

    def squares(field: NDArray[Any]) -> Array:
        found: Array = field.astype(np.float64)[np.ix_(*kept)]
        for step in steps:
            # Twice turned over, x is first again.
            found = _means(found, step).T
        return found

    x, y = (_means(at, step) for at, step in zip(axes, steps, strict=True))
    fields = {
        name: np.stack([squares(file.read(name, place)) for place in places]) for name in MAPS
    }
    return View(x, y, fields)


def _heights(file: CaseFile, case: Case) -> tuple[Array, Array]:
    axes = [file.read(axis).astype(np.float64) for axis in ("x", "y")[: 1 if file.is_line else 2]]
    half_widths = [
        float(file.read(f"contact_half_width_{axis}")[-1]) for axis in ("x", "y")[: len(axes)]
    ]
    lost = file.read("wear_depth", -1).astype(np.float64) + file.read("plastic_depth", -1)
    heights = heights_in_contact(case, axes, half_widths, np.stack([np.zeros_like(lost), lost]))
    places = np.rint(np.linspace(0, heights[0].size - 1, _POINTS)).astype(int)
    return heights[0][places], heights[1][places]


def _means(field: Array, step: int) -> Array:
    """Means of so many neighbours along the first axis; what is over at the ends is dropped."""
    count = len(field) // step
    first = (len(field) - count * step) // 2
    cut = field[first : first + count * step]
    result: Array = cut.reshape(count, step, *field.shape[1:]).mean(axis=1)
    return result


def _evenly_spaced(at: Array) -> list[float]:
    first, last = (float(each) for each in MICROMETRE.of(at[[0, -1]]))
    return [first, (last - first) / max(1, at.size - 1), at.size]


def _bytes(field: Array) -> dict[str, Any]:
    scale = float(field.max()) / _LEVELS
    levels = np.rint(np.maximum(field, 0.0) / (scale or 1.0)).astype(np.uint8)
    return {"scale": scale, "levels": base64.b64encode(levels.T.tobytes()).decode("ascii")}
