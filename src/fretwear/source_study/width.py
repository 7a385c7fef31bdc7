"""Claim about the width of the contact: how fast it grows and where it ends."""

from __future__ import annotations

from fretwear.source_study.evolution import Evolution
from fretwear.source_study.quartet import Pair, Quartet
from fretwear.source_study.verdict import Answer, Finding, Judgement, Measurement, percent

_EARLY = (100.0, 1000.0)
_SAME_LEVEL = 0.05
_STABLE = 0.05
_WIDTH = "contact_half_width_x"


def width_grows_faster_when_rough(quartet: Quartet) -> Judgement:
    """Claim 8: the rough contact widens faster and ends at almost the same width."""
    return Judgement(
        8,
        "Contact width grows faster for rough surfaces and stabilises at almost the same level.",
        "The rough half-width has grown more than the smooth one by cycle 100 and by cycle 1000; "
        "after the last cycle both are within 5 % of each other; in the second half of all cycles "
        "each grows by at most 5 % of its whole growth. In part: the last is not met.",
        tuple(_faster(pair) for pair in quartet.pairs()),
    )


def growth(case: Evolution, cycle: float) -> float:
    """Growth of the contact half-width since cycle 0, m."""
    return case.at(_WIDTH, cycle) - case.at(_WIDTH, 0.0)


def late_growth(case: Evolution) -> float:
    """Share of the whole growth that falls into the second half of the cycles."""
    whole = growth(case, case.last)
    return 1.0 - growth(case, 0.5 * case.last) / whole if whole > 0.0 else 0.0


def _faster(pair: Pair) -> Finding:
    smooth, rough = pair.smooth, pair.rough
    ratios = [growth(rough, cycle) / growth(smooth, cycle) for cycle in _EARLY]
    level = rough.at(_WIDTH, rough.last) / smooth.at(_WIDTH, smooth.last) - 1.0
    late = max(late_growth(smooth), late_growth(rough))
    numbers = (
        *(
            Measurement(f"growth by cycle {cycle:.0f}, rough to smooth", ratio)
            for cycle, ratio in zip(_EARLY, ratios, strict=True)
        ),
        Measurement("rough beyond smooth after the last cycle", 100.0 * level, "%"),
        Measurement("growth in the second half", 100.0 * late, "% of all"),
    )
    if min(ratios) <= 1.0 or abs(level) > _SAME_LEVEL:
        reasons = (
            ("the rough contact does not grow faster", min(ratios) <= 1.0),
            (f"the last widths are {percent(abs(level))} apart", abs(level) > _SAME_LEVEL),
        )
        remark = " and ".join(text for text, applies in reasons if applies)
        return Finding(pair.subject, Answer.NO, numbers, remark)
    if late > _STABLE:
        remark = (
            f"faster and at the same level, but still growing ({percent(late)} of the growth "
            "falls into the second half of the cycles)"
        )
        return Finding(pair.subject, Answer.PARTLY, numbers, remark)
    return Finding(pair.subject, Answer.YES, numbers)
