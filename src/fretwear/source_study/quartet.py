"""The four cases that the claims compare."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from fretwear.source_study.evolution import Evolution


@dataclass(frozen=True)
class Pair:
    """A smooth and a rough case that agree in all else.

    Parameters
    ----------
    subject : str
        What they have in common, ``elastic`` or ``plastic``.
    smooth, rough : Evolution
        The cases.
    """

    subject: str
    smooth: Evolution
    rough: Evolution


@dataclass(frozen=True)
class Quartet:
    """Smooth and rough, elastic and with a plastic limit, all else the same."""

    smooth_elastic: Evolution
    rough_elastic: Evolution
    smooth_plastic: Evolution
    rough_plastic: Evolution

    def each(self) -> Iterator[tuple[str, Evolution]]:
        """Iterate over the cases with their names."""
        yield "smooth elastic", self.smooth_elastic
        yield "rough elastic", self.rough_elastic
        yield "smooth plastic", self.smooth_plastic
        yield "rough plastic", self.rough_plastic

    def pairs(self) -> tuple[Pair, Pair]:
        """Return smooth against rough, elastic first."""
        return (
            Pair("elastic", self.smooth_elastic, self.rough_elastic),
            Pair("plastic", self.smooth_plastic, self.rough_plastic),
        )
