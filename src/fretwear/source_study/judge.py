"""All claims of the source study, judged."""

from __future__ import annotations

from collections.abc import Callable

from fretwear.source_study.quartet import Quartet
from fretwear.source_study.roughness import asperities, rough_becomes_smooth
from fretwear.source_study.stick import stick_zone
from fretwear.source_study.tractions import (
    peak_at_stick_edge,
    pressure_moves_inward,
    shear_behaves_like_pressure,
)
from fretwear.source_study.verdict import Judgement
from fretwear.source_study.wear import deepest_in_the_middle, even_wear
from fretwear.source_study.width import width_grows_faster_when_rough

CLAIMS: tuple[Callable[[Quartet], Judgement], ...] = (
    pressure_moves_inward,
    peak_at_stick_edge,
    rough_becomes_smooth,
    stick_zone,
    deepest_in_the_middle,
    even_wear,
    asperities,
    width_grows_faster_when_rough,
    shear_behaves_like_pressure,
)
"""One function for each claim, in the order of their numbers."""


def judge(quartet: Quartet) -> tuple[Judgement, ...]:
    """Judge every claim by the four cases."""
    return tuple(claim(quartet) for claim in CLAIMS)
