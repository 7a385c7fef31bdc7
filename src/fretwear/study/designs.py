"""Designs: which combinations of the varied values make up a study."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

LISTED = ("grid", "zip")
SAMPLED = ("latin_hypercube", "sobol")
KINDS = (*LISTED, *SAMPLED)
MAX_POINTS = 200_000

_SAMPLE_DIGITS = 6


@dataclass(frozen=True)
class Design:
    """How the varied values are combined.

    Attributes
    ----------
    kind : str
        ``grid``: every combination.  ``zip``: first with first, second with second.
        ``latin_hypercube``, ``sobol``: points spread over ranges.
    points : int
        Number of points of a sampled design; 0 for the others.
    seed : int
        Seed of a sampled design: the same seed gives the same points.
    """

    kind: str = "grid"
    points: int = 0
    seed: int = 0

    @property
    def is_sampled(self) -> bool:
        """Whether values are drawn from ranges rather than listed."""
        return self.kind in SAMPLED

    def size(self, lengths: Sequence[int]) -> int:
        """Return the number of points for axes of these lengths."""
        if self.is_sampled:
            return self.points
        if self.kind == "zip":
            return lengths[0] if lengths else 1
        return math.prod(lengths)

    def indices(self, lengths: Sequence[int]) -> Iterator[tuple[int, ...]]:
        """Iterate over the points as positions along the axes, the last axis fastest."""
        if self.kind == "grid":
            return itertools.product(*(range(length) for length in lengths))
        return ((number,) * len(lengths) for number in range(self.size(lengths)))


@dataclass(frozen=True)
class Range:
    """An interval to sample, in SI units, evenly or evenly in the logarithm."""

    low: float
    high: float
    logarithmic: bool = False

    def at(self, fraction: float) -> float:
        """Return the value at a fraction of the way, rounded to six digits."""
        if self.logarithmic:
            value = math.exp(
                math.log(self.low) + fraction * (math.log(self.high) - math.log(self.low))
            )
        else:
            value = self.low + fraction * (self.high - self.low)
        # Few digits: the ids of the cases must not hang on the last bit of a logarithm.
        return float(f"{value:.{_SAMPLE_DIGITS}g}")


def sample(design: Design, axes: Sequence[Range | Sequence[Any]]) -> list[list[Any]]:
    """Draw the values of a sampled design.

    Parameters
    ----------
    design : Design
        A Latin hypercube or a scrambled Sobol sequence.
    axes : sequence of Range or of lists
        From a list each value is drawn equally often, as far as the number of points allows.

    Returns
    -------
    list of lists
        For each axis one value per point.
    """
    unit = _unit_sample(design, len(axes))
    return [
        [
            axis.at(fraction)
            if isinstance(axis, Range)
            else axis[min(int(fraction * len(axis)), len(axis) - 1)]
            for fraction in unit[:, position].tolist()
        ]
        for position, axis in enumerate(axes)
    ]


def _unit_sample(design: Design, dimensions: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    # scipy.stats takes half a second to import: only sampled designs pay for it.
    from scipy.stats import qmc

    engine = qmc.LatinHypercube if design.kind == "latin_hypercube" else qmc.Sobol
    with warnings.catch_warnings():
        # Numbers of points other than powers of two are the user's choice.
        warnings.simplefilter("ignore", UserWarning)
        drawn: np.ndarray[Any, np.dtype[np.float64]] = engine(
            d=dimensions, seed=design.seed
        ).random(design.points)
    return drawn
