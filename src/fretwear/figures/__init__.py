"""Figures: one function per figure, a dataset in, a matplotlib Figure out.

>>> import fretwear
>>> case = fretwear.open_case("results/demo/cases/<id>.nc")  # doctest: +SKIP
>>> fretwear.figures.pressure_profiles(case)  # doctest: +SKIP
"""

# ruff: noqa: F403

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fretwear.figures.bearing import *
    from fretwear.figures.cases import *
    from fretwear.figures.film import *
    from fretwear.figures.history import *
    from fretwear.figures.maps import *
    from fretwear.figures.profiles import *
    from fretwear.figures.rig import *
    from fretwear.figures.style import *

_HOMES = {
    "CaseAnimation": "film",
    "STYLE_SHEET": "style",
    "animation": "film",
    "bearing_area": "bearing",
    "compare_cases": "cases",
    "compare_profiles": "profiles",
    "compare_wear_maps": "maps",
    "contact_half_width": "history",
    "dissipated_energy": "history",
    "fretting_loops": "rig",
    "fretting_map": "rig",
    "gap_profiles": "profiles",
    "overview": "cases",
    "pressure_profiles": "profiles",
    "save_as": "style",
    "save_figure": "style",
    "scars": "rig",
    "shear_profiles": "profiles",
    "stick_half_width": "history",
    "style_context": "style",
    "wear_map": "maps",
    "wear_profiles": "profiles",
    "wear_rate_profiles": "profiles",
    "wear_volume": "history",
}

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    # What only reads the index of figures does not wait for matplotlib.
    if name in _HOMES:
        return getattr(import_module(f"fretwear.figures.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'fretwear.figures' has no attribute {name!r}")
