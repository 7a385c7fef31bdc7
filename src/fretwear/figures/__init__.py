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

from collections.abc import Callable
from importlib import import_module
from inspect import signature
from typing import TYPE_CHECKING, Any

from fretwear.figures.index import HISTORIES, PROFILES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HOMES = {
    "cases": "compare_cases overview",
    "history": "scalar_history",
    "maps": "compare_wear_maps fretting_map wear_map",
    "profiles": "bearing_area compare_profiles field_profiles fretting_loops scars",
    "style": "STYLE_SHEET save_as save_figure style_context",
}
_HOME = {name: home for home, names in _HOMES.items() for name in names.split()}

__all__ = [*_HOME, *PROFILES, *HISTORIES]


def __getattr__(name: str) -> Any:
    # Code that only reads the index of figures does not wait for matplotlib.
    if name in _HOME:
        found = vars(import_module(f"fretwear.figures.{_HOME[name]}"))[name]
    elif name in PROFILES:
        found = _of_quantity(__getattr__("field_profiles"), name, PROFILES[name])
    elif name in HISTORIES:
        found = _of_quantity(__getattr__("scalar_history"), name, HISTORIES[name])
    else:
        raise AttributeError(f"module 'fretwear.figures' has no attribute {name!r}")
    globals()[name] = found
    return found


def _of_quantity(
    draw: "Callable[..., Figure]", name: str, quantity: str
) -> "Callable[..., Figure]":
    """Return the figure function of one result or field: the general one with its quantity."""

    def figure(dataset: Any, *args: Any, **options: Any) -> "Figure":
        return draw(dataset, quantity, *args, **options)

    dataset, _, *others = signature(draw).parameters.values()
    figure.__signature__ = signature(draw).replace(parameters=[dataset, *others])  # type: ignore[attr-defined]
    figure.__name__ = figure.__qualname__ = name
    figure.__doc__ = f"Draw `{quantity}` as `{draw.__name__}` does."
    return figure


def __dir__() -> list[str]:
    return sorted(__all__)
