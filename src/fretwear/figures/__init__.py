"""Figures: one function per figure, a dataset in, a matplotlib Figure out.

>>> import fretwear
>>> case = fretwear.open_case("results/demo/cases/<id>.nc")  # doctest: +SKIP
>>> fretwear.figures.field_profiles(case, "pressure")  # doctest: +SKIP

Parameters mean the same in all of them:

- ``dataset``: one case, quarter or whole. Functions of a result over the cycles also take a merged
  study, a part of it, or a history.
- ``cases``: such a dataset, or several by the titles of their panels.
- ``cycles``: an int or a sequence of int, the snapshots to draw; by default at most six.
- ``columns``: 1 or 2, the journal columns that several panels span, 90 mm or 190 mm.
- ``ax``: matplotlib axes to draw into, in a figure of your own; ``columns`` then has no effect.

A dataset that lacks the variable or one of the snapshots raises a ``ValueError``.
"""

from importlib import import_module
from typing import Any

_HOMES = {
    "page": "overview",
    "history": "coating_life scalar_history",
    "maps": "fretting_map wear_map",
    "profiles": "field_profiles fretting_loops",
    "style": "STYLE_SHEET save_as style_context",
}
_HOME = {name: home for home, names in _HOMES.items() for name in names.split()}

__all__ = [*_HOME]


def __getattr__(name: str) -> Any:
    # Code that only reads the index of figures does not wait for matplotlib.
    if name in _HOME:
        return vars(import_module(f"fretwear.figures.{_HOME[name]}"))[name]
    known = "scalar_history draws any result over the cycles, field_profiles any field along x"
    raise AttributeError(f"module 'fretwear.figures' has no attribute {name!r}; {known}")


def __dir__() -> list[str]:
    return sorted(__all__)
