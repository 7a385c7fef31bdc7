"""The view of a case in a session: parameters with units, and in a notebook a sketch as well."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

import numpy as np

from fretwear.mechanics.surfaces.indenters import Indenter

_WIDTH, _HEIGHT, _SURFACE = 240, 150, 110  # of the sketch; ordinate of the flat
_LINE = 'fill="none" stroke="currentColor"'
_ARROW = "M0 0 l-4 -8 h8 z"


def case_text(case_id: str, rows: Mapping[str, str]) -> str:
    """Return the id and the parameters of a case in words, one a line."""
    width = max(map(len, rows))
    lines = (f"  {words:<{width}}  {value}" for words, value in rows.items())
    return "\n".join([f"<Case {case_id}>", *lines])


def case_html(case_id: str, rows: Mapping[str, str], indenter: Indenter, half_width: float) -> str:
    """Return a table of parameters beside a sketch of the unworn contact, half-width in m."""
    cells = "".join(
        f'<tr><td style="text-align:left">{escape(words)}</td>'
        f'<td style="text-align:left">{escape(value)}</td></tr>'
        for words, value in rows.items()
    )
    table = f"<table><caption><code>{escape(case_id)}</code></caption>{cells}</table>"
    return f'<div style="display:flex;gap:2em">{table}{_sketch(indenter, half_width)}</div>'


def _sketch(indenter: Indenter, half_width: float) -> str:
    """Draw the profile along x as SVG, with the contact, its load and the tangential motion."""
    shown = 2.5 * half_width
    x = np.linspace(-1.0, 1.0, 81)
    gap = indenter.gap(shown * x, np.zeros(1))
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
