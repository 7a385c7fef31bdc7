"""Figures: one function per figure, a dataset in, a matplotlib Figure out.

>>> import fretwear
>>> case = fretwear.open_case("results/demo/cases/<id>.nc")  # doctest: +SKIP
>>> fretwear.figures.pressure_profiles(case)  # doctest: +SKIP
"""

from fretwear.figures.animation import CaseAnimation, animation
from fretwear.figures.bearing import bearing_area
from fretwear.figures.history import (
    contact_half_width,
    dissipated_energy,
    stick_half_width,
    wear_volume,
)
from fretwear.figures.maps import compare_wear_maps, wear_map
from fretwear.figures.overview import compare_cases, overview
from fretwear.figures.profiles import (
    compare_profiles,
    gap_profiles,
    pressure_profiles,
    shear_profiles,
    wear_profiles,
    wear_rate_profiles,
)
from fretwear.figures.rig import fretting_loops, fretting_map, scars
from fretwear.figures.style import STYLE_SHEET, save_as, save_figure, style_context

__all__ = [
    "STYLE_SHEET",
    "CaseAnimation",
    "animation",
    "bearing_area",
    "compare_cases",
    "compare_profiles",
    "compare_wear_maps",
    "contact_half_width",
    "dissipated_energy",
    "fretting_loops",
    "fretting_map",
    "gap_profiles",
    "overview",
    "pressure_profiles",
    "save_as",
    "save_figure",
    "scars",
    "shear_profiles",
    "stick_half_width",
    "style_context",
    "wear_map",
    "wear_profiles",
    "wear_rate_profiles",
    "wear_volume",
]
