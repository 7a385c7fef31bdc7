"""What a session shows of a case: parameters with units, and in a notebook a sketch as well."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from fretwear.study.parameters import value_text
from fretwear.units import in_unit

if TYPE_CHECKING:
    from fretwear.study.case import Case

_WIDTH, _HEIGHT, _SURFACE = 240, 150, 110  # of the sketch; ordinate of the flat
_LINE = 'fill="none" stroke="currentColor"'
_ARROW = "M0 0 l-4 -8 h8 z"


def text(case: Case) -> str:
    """Return the id and the parameters of a case, one a line."""
    rows = [*_parameters(case)]
    width = max(len(words) for words, _ in rows)
    return "\n".join([f"<Case {case.case_id}>", *(f"  {w:<{width}}  {v}" for w, v in rows)])


def html(case: Case) -> str:
    """Return a table of the parameters of a case beside a sketch of the unworn contact."""
    rows = "".join(
        f'<tr><td style="text-align:left">{escape(words)}</td>'
        f'<td style="text-align:left">{escape(value)}</td></tr>'
        for words, value in _parameters(case)
    )
    table = f"<table><caption><code>{escape(case.case_id)}</code></caption>{rows}</table>"
    return f'<div style="display:flex;gap:2em">{table}{_sketch(case)}</div>'


def _parameters(case: Case) -> Iterator[tuple[str, str]]:
    for name, (value, unit, words) in case.scalar_coordinates().items():
        yield words, value_text(name, in_unit(value, unit))


def _sketch(case: Case) -> str:
    """Draw the profile along x as SVG, with the contact, its load and the tangential motion."""
    half_width, _ = case.indenter.half_widths(case.hertz)
    shown = 2.5 * half_width
    x = np.linspace(-1.0, 1.0, 81)
    gap = case.indenter.gap(shown * x, np.zeros(1))
    across = 0.5 * _WIDTH * (1.0 + x)
    up = _SURFACE - 70.0 * (gap - gap.min()) / (float(np.ptp(gap[np.isfinite(gap)])) or 1.0)
    profile = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, up, strict=True) if b > 0.0)
    middle, reach = 0.5 * _WIDTH, 0.5 * _WIDTH * half_width / shown
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{_HEIGHT}">'
        f'<polyline points="{profile}" {_LINE}/>'
        f'<path d="M0 {_SURFACE} H{_WIDTH} M{middle} 5 v30" {_LINE}/>'
        f'<path d="M{middle - 25} 60 h50" {_LINE} stroke-dasharray="4 2"/>'
        f'<path d="M{middle - reach} {_SURFACE} H{middle + reach}" {_LINE} stroke-width="4"/>'
        f'<path transform="translate({middle} 40)" d="{_ARROW}" fill="currentColor"/>'
        f'<path transform="translate({middle + 30} 60) rotate(-90)" d="{_ARROW}" '
        f'fill="currentColor"/>'
        f'<text x="{middle + 8}" y="20" fill="currentColor">P</text>'
        f'<text x="{middle + 34}" y="64" fill="currentColor">Q</text>'
        f'<text x="{middle}" y="{_SURFACE + 22}" text-anchor="middle" fill="currentColor">'
        f"2 × {half_width * 1e6:.3g} µm</text></svg>"
    )
