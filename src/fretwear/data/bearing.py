"""The heights of rough surfaces within the contact, before and after wear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fretwear.study.case import Case

Array = NDArray[np.float64]


def has_bearing_area(case: Case) -> bool:
    """Whether a case has roughness whose heights are available."""
    return case.rough is not None and case.rough.is_known


def heights_in_contact(
    case: Case, axes: Sequence[Array], half_widths: Sequence[float], lost: Array
) -> list[Array]:
    """Return the heights of the surfaces within the contact, highest first.

    Parameters
    ----------
    case : Case
        A case with roughness whose heights are available.
    axes : sequence of array
        Cell centres along x and, except in a line contact, y, m; one side suffices along an even
        axis.
    half_widths : sequence of float
        Of the elliptical area considered, along these axes, m.
    lost : array of shape (k, nx, ny) or (k, nx)
        Wear and plastic depth at some cycles, m.

    Returns
    -------
    list of array
        For each of these cycles, m: the roughness minus what is lost; 0 is the mean of the
        roughness.
    """
    assert case.rough is not None
    x, y, cell = axes[0], np.zeros(1), None
    if len(axes) > 1:
        y = axes[1]
        cell = x[1] - x[0], y[1] - y[0]
    inside = np.hypot(x[:, None] / half_widths[0], y / half_widths[-1]) <= 1.0
    rough = -case.rough.on_cells(x, y, cell)[inside]
    rough -= rough.mean()
    return [np.sort(rough - depth.reshape(inside.shape)[inside])[::-1] for depth in lost]
