"""TR-BDF2: two implicit stages of one weight, second order, L-stable, and an embedded third order.

Due to Bank et al., "Transient simulation of silicon devices and circuits", IEEE Trans. Electron
Devices 32 (1985); coefficients and embedded weights as in Hosea and Shampine, "Analysis and
implementation of TR-BDF2", Appl. Numer. Math. 20 (1996).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import isfinite, sqrt
from typing import Any, TypeVar

import numpy as np

from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.state import WearProblem

# First stage at γ = 2 − √2; both stages are implicit with the same weight, which makes them alike.
GAMMA = 2.0 - sqrt(2.0)
DIAGONAL = 0.5 * GAMMA
WEIGHT = 0.25 * sqrt(2.0)
MAIN = (WEIGHT, WEIGHT, DIAGONAL)
EMBEDDED = ((1.0 - WEIGHT) / 3.0, (3.0 * WEIGHT + 1.0) / 3.0, DIAGONAL / 3.0)
# What the embedded formula has more of the rates at the start, in between and at the end.
DIFFERENCE = tuple(e - m for e, m in zip(EMBEDDED, MAIN, strict=True))
# The second stage over the first, to foretell what goes on as it did.
BEYOND = (1.0 - GAMMA) / GAMMA

TOLERANCE = 0.01
ACCEPTED = 1.2
LARGEST_FACTOR = 5.0
# The embedded formulas differ from the step by about ten times its error in wear volume, as runs
# with far smaller steps show; a third of the difference is still on the safe side.
OVERESTIMATE = 3.0
_SMALLEST_STEP, _SMALLEST_FACTOR, _SAFETY = 1e-6, 0.2, 0.85

_State = TypeVar("_State")


class WearError(RuntimeError):
    """The integration cannot continue; the last accepted state is valid."""


def assessed(error: float) -> tuple[float, bool]:
    """Factor for the next step from an error in units of the tolerance; whether to accept it."""
    if not isfinite(error):
        return _SMALLEST_FACTOR, False
    factor = _SAFETY * max(error, 1e-6) ** (-1.0 / 3.0)
    return min(max(factor, _SMALLEST_FACTOR), LARGEST_FACTOR), error <= ACCEPTED


class Integrator(ABC):
    """Produces the accepted states in turn.

    Attributes
    ----------
    tolerance
        Error of the wear of a step relative to the wear volume.
    state
        The last accepted one.
    """

    tolerance: float
    state: Any

    @abstractmethod
    def attempt(
        self, step: float, end: float, *, output_step: bool
    ) -> tuple[Any, float, bool] | None:
        """A step of so many cycles to one that may be requested; None to try again on more cells.

        It returns the state at its end, what to multiply the step by, and whether to keep it, and
        raises a ContactError or numpy.linalg.LinAlgError if it is too long to converge.
        """

    def advance(self, stop: float) -> Any:
        """The next accepted state, at ``stop`` or before; a `WearError` if no step is accurate."""
        wanted, trouble = self.state.next_step, "wear asks for shorter ones"
        while True:
            now, left = self.state.cycle, stop - self.state.cycle
            # Steps of one length up to a stop, rather than a short one at the end.
            step = left if wanted >= left else min(wanted, max(0.5 * left, 0.5 * wanted))
            if step < _SMALLEST_STEP:
                raise WearError(
                    f"no step after cycle {now:.6g} is accurate, down to {step:.1e} cycles: "
                    f"{trouble}; the contact at cycle {now:.6g} has a residual of "
                    f"{self.state.residual:.1e}"
                )
            end = stop if step == left else now + step
            try:
                found = self.attempt(step, end, output_step=step == left)
            except (ContactError, np.linalg.LinAlgError) as error:
                wanted, trouble = 0.5 * step, str(error)
                continue
            if found is None:
                continue
            state, factor, accepted = found
            if accepted:
                break
            wanted, estimate = step * factor, state.error_estimate
            trouble = f"the error is estimated as {estimate:.1e} instead of {self.tolerance:.1e}"
        following = step * factor
        if step < wanted and factor >= 1.0:
            # The step was cut short by a stop, which says nothing about the next one.
            following = max(following, wanted)
        self.state = replace(state, next_step=following)
        return self.state


def march(
    problem: WearProblem,
    stops: Sequence[float],
    start: _State | None,
    begin: Callable[[WearProblem, _State | None, bool], Integrator],
) -> Iterator[_State]:
    """Yield each accepted state of all blocks of a problem, up to the last of some stops.

    ``begin`` makes the integrator of a block from the state before, if there is one, and whether
    the bodies are to be loaded anew.
    """
    state: Any = start
    first = 0.0
    for block in problem.blocks:
        if state is None or state.cycle < block.end:
            integrator = begin(block, state, state is None or state.cycle == first > 0.0)
            if state is None:
                yield integrator.state
            # Neither a step nor its error estimate may span a kink.
            kinks = {kink for kink in (*block.friction.kinks, block.end) if kink < stops[-1]}
            for stop in sorted({*stops, *kinks}):
                while first <= integrator.state.cycle < min(stop, block.end):
                    yield integrator.advance(stop)
            state = integrator.state
        first = block.end
