"""Figures: one function per figure, a dataset in, a matplotlib Figure out.

>>> import fretwear
>>> case = fretwear.open_case("results/demo/cases/<id>.nc")  # doctest: +SKIP
>>> fretwear.figures.pressure_profiles(case)  # doctest: +SKIP

Every field has a function of its profiles along x, such as ``shear_profiles``, and every scalar
result a function of its history, such as ``wear_volume``. Parameters mean the same in all of them:

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
from typing import TYPE_CHECKING, Any

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

__all__ = [*_HOME, *PROFILES, *HISTORIES]


def __getattr__(name: str) -> "Callable[..., Figure]":
    # Code that only reads the index of figures does not wait for matplotlib.
    if name in _HOME:
        draws = vars(import_module(f"fretwear.figures.{_HOME[name]}"))[name]
    elif name in PROFILES:
        draws = _of_quantity("field_profiles", name, PROFILES[name])
    elif name in HISTORIES:
        draws = _of_quantity("scalar_history", name, HISTORIES[name])
    else:
        raise AttributeError(f"module 'fretwear.figures' has no attribute {name!r}")
    globals()[name] = draws
    return draws  # type: ignore[no-any-return]


def _of_quantity(general: str, name: str, quantity: str) -> "Callable[..., Figure]":
    """Return the figure function of one result or field: the general one with its quantity."""
    from inspect import signature

    from fretwear.results import RESULTS

    draw = __getattr__(general)

    def figure(dataset: Any, *args: Any, **options: Any) -> "Figure":
        return draw(dataset, quantity, *args, **options)

    dataset, _, *others = signature(draw).parameters.values()
    figure.__signature__ = signature(draw).replace(parameters=[dataset, *others])  # type: ignore[attr-defined]
    figure.__name__ = figure.__qualname__ = name
    figure.__doc__ = f"Draw the {RESULTS[quantity].words} as `{general}` does."
    return figure


def __dir__() -> list[str]:
    return sorted(__all__)
