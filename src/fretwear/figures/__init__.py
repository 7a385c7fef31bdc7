"""Figures: one function per figure, a dataset in, a matplotlib Figure out.

>>> import fretwear
>>> case = fretwear.open_case("results/demo/cases/<id>.nc")  # doctest: +SKIP
>>> fretwear.figures.pressure_profiles(case)  # doctest: +SKIP

Parameters mean the same in all functions:

- ``dataset``: one case, quarter or whole. Functions of a field also take one point of a merged
  study; functions of a result over the cycles take a merged study, a part of it, or a history.
- ``cycles``: an int or a sequence of int, the snapshots to draw; by default at most six.
- ``columns``: 1 or 2, the journal columns that the figure spans, 90 mm or 190 mm.
- ``ax``: matplotlib axes to draw into, in a figure of your own; ``columns`` then has no effect.

Anything but a dataset raises a ``TypeError``; a dataset that lacks the variable or one of the
snapshots raises a ``ValueError``.
"""

# ruff: noqa: F403

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING

from fretwear.figures.index import HISTORIES, PROFILES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fretwear.figures.cases import *
    from fretwear.figures.effects import *
    from fretwear.figures.history import *
    from fretwear.figures.maps import *
    from fretwear.figures.profiles import *
    from fretwear.figures.style import *

_HOMES = {
    "cases": "CaseAnimation animation compare_cases overview",
    "effects": "fretting_map",
    "history": "scalar_history",
    "maps": "compare_wear_maps wear_map",
    "profiles": "bearing_area compare_profiles field_profiles fretting_loops scars",
    "style": "STYLE_SHEET save_as save_figure style_context",
}
_HOME = {name: home for home, names in _HOMES.items() for name in names.split()}
# Every field and every scalar result has a figure under its own name.
_DRAWN = {
    **dict.fromkeys(PROFILES, "field_profiles"),
    **dict.fromkeys(HISTORIES, "scalar_history"),
}

__all__ = [*_HOME, *_DRAWN]


def __getattr__(name: str) -> "Callable[..., Figure]":
    # Code that only reads the index of figures does not wait for matplotlib.
    if name in _HOME:
        draws = vars(import_module(f"fretwear.figures.{_HOME[name]}"))[name]
    elif name in _DRAWN:
        from fretwear.figures.style import of_quantity

        draw = __getattr__(_DRAWN[name])
        draws = of_quantity(draw, name, {**PROFILES, **HISTORIES}[name])
    else:
        raise AttributeError(f"module 'fretwear.figures' has no attribute {name!r}")
    globals()[name] = draws
    return draws  # type: ignore[no-any-return]


def __dir__() -> list[str]:
    return sorted(__all__)
