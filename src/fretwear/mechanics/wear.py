"""Archard wear over many fretting cycles: implicit, adaptive steps.

One cycle wears Δw = 4 K_w p s = β p g* with β = 4 K_w µκ, so over the cycles dW/dN = β p g*. The
equation is stiff: pressure reacts at once to wear of a fraction of a micrometer. Each step is
TR-BDF2 for the exponent x = β∫p dN, from which wear follows in closed form; both its implicit
stages are normal contacts (`fretwear.mechanics.stages`).

TR-BDF2 is due to Bank et al., "Transient simulation of silicon devices and circuits", IEEE
Trans. Electron Devices 32 (1985); coefficients and embedded weights as in Hosea and Shampine,
"Analysis and implementation of TR-BDF2", Appl. Numer. Math. 20 (1996).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import isfinite, sqrt

import numpy as np

from fretwear.mechanics.arrays import Array
from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.first_loading import first_loading, first_window
from fretwear.mechanics.outlook import Outlook, larger_window, next_window
from fretwear.mechanics.stages import Stage, StageSolver
from fretwear.mechanics.state import State, WearProblem
from fretwear.mechanics.window import Window

# First stage at γ = 2 − √2; both stages are implicit with the same weight, which makes them alike.
_GAMMA = 2.0 - sqrt(2.0)
_DIAGONAL = 0.5 * _GAMMA
_WEIGHT = 0.25 * sqrt(2.0)
_MAIN = (_WEIGHT, _WEIGHT, _DIAGONAL)
_EMBEDDED = ((1.0 - _WEIGHT) / 3.0, (3.0 * _WEIGHT + 1.0) / 3.0, _DIAGONAL / 3.0)
_BEYOND = (1.0 - _GAMMA) / _GAMMA

_SMALLEST_STEP = 1e-6
_ACCEPTED = 1.2
_SAFETY = 0.85
_FACTORS = (0.2, 5.0)
_FLOW_EXPONENT = 1.0
# The embedded formulas differ from the step by about ten times its error in wear volume, as runs
# with far smaller steps show; a third of the difference is still on the safe side.
_OVERESTIMATE = 3.0
_DEFAULT_TOLERANCE = 0.01
# The first stage is never seen: its pressure enters the exponent, some parts in 10⁵ of which are
# far below any error of the step.
_FIRST_STAGE_SLACK = 30.0


class WearError(RuntimeError):
    """The integration cannot go on; the last accepted state is valid."""


def evolve(
    problem: WearProblem,
    stops: Sequence[float],
    tolerance: float = _DEFAULT_TOLERANCE,
    start: State | None = None,
) -> Iterator[State]:
    """Integrate wear over the cycles and yield each accepted state, cycle 0 included.

    Parameters
    ----------
    problem
        What to integrate.
    stops
        Increasing cycle numbers at which a step must end exactly; the last one ends the run.
    tolerance
        Error of one step's wear relative to the wear volume.
    start
        A state that `evolve` yielded before, to go on from there; it is not yielded again.

    Yields
    ------
    State

    Raises
    ------
    WearError
        If the step had to be cut to nothing.
    fretwear.mechanics.contact.ContactError
        If the first loading does not converge.
    """
    if start is None:
        # As long as it is held, the first step finds it and does not make it again.
        bodies = problem.half_space(first_window(problem))
        start = first_loading(problem)
        stepper = _Stepper(problem, tolerance, start)
        del bodies
        yield start
    else:
        stepper = _Stepper(problem, tolerance, start)
    for stop in stops:
        while stepper.state.cycle < stop:
            yield stepper.advance(stop)


@dataclass(frozen=True)
class _Judgement:
    """Error of a step in units of the tolerance, what to multiply it by, whether to keep it."""

    error: float
    factor: float
    accepted: bool


class _Stepper:
    """Makes accepted states one after the other."""

    def __init__(self, problem: WearProblem, tolerance: float, state: State) -> None:
        self.problem = problem
        self.tolerance = tolerance
        self.state = state
        self._solver = StageSolver(problem, state.window, tolerance)
        self._outlook = Outlook(problem, state.window)

    def advance(self, stop: float) -> State:
        """The next accepted state, at ``stop`` or before."""
        approached = self._outlook.approached(self.state.pressure)
        if any(approached):
            self._move_to(next_window(self.state.window, approached))
        wanted, trouble = self.state.next_step, "wear asks for shorter ones"
        while True:
            left = stop - self.state.cycle
            step = left if wanted >= left else min(wanted, max(0.5 * left, 0.5 * wanted))
            if step < _SMALLEST_STEP:
                raise WearError(
                    f"no step after cycle {self.state.cycle:.6g} is accurate, down to "
                    f"{step:.1e} cycles: {trouble}; the contact at cycle "
                    f"{self.state.cycle:.6g} has a residual of {self.state.residual:.1e}"
                )
            try:
                first, second = self._stages(step, seen=step == left)
            except ContactError as error:
                wanted, trouble = 0.5 * step, str(error)
                continue
            if any(self._outlook.touched(second.pressure, second.approach)):
                fitting = larger_window(
                    self.problem, self.state.window, second.pressure, second.approach
                )
                self._move_to(fitting)
                continue
            judgement = self._judge(step, first, second)
            if not judgement.accepted:
                wanted = step * judgement.factor
                trouble = (
                    f"the error is estimated as {judgement.error * self.tolerance:.1e} instead "
                    f"of {self.tolerance:.1e}"
                )
                continue
            following = step * judgement.factor
            if step < wanted and judgement.factor >= 1.0:
                # A stop cut this step short; that says nothing about the one that follows.
                following = max(following, wanted)
            reached = stop if step == left else self.state.cycle + step
            between = (1.0 - _GAMMA) * step
            self.state = State(
                cycle=reached,
                window=self.state.window,
                pressure=second.pressure,
                gap=second.gap,
                wear=second.wear,
                plastic=second.plastic,
                approach=second.approach,
                reduced=second.reduced,
                next_step=following,
                pressure_rate=(second.pressure - first.pressure) / between,
                source_rate=(second.source - first.source) / between,
                yielded=second.yielded,
                step=self.state.step + 1,
                error_estimate=judgement.error * self.tolerance,
                residual=second.residual,
                convolutions=self.state.convolutions + self._solver.convolutions,
            )
            self._solver.convolutions = 0
            return self.state

    def _stages(self, step: float, *, seen: bool) -> tuple[Stage, Stage]:
        """Both stages of TR-BDF2 over a step of so many cycles; whether its end was requested."""
        rate = self.problem.growth_rate * step
        own = rate * _DIAGONAL
        base = Stage.of(self.state)
        p0 = base.pressure
        first = self._solver.solve(
            base,
            own * p0,
            own,
            p0 + _GAMMA * step * self.state.pressure_rate,
            _GAMMA * step * self.state.source_rate,
            _FIRST_STAGE_SLACK,
            seen=False,
        )
        p1 = first.pressure
        second = self._solver.solve(
            first,
            rate * (_WEIGHT - _DIAGONAL) * (p0 + p1),
            own,
            p1 + _BEYOND * (p1 - p0),
            _BEYOND * (first.source - base.source),
            seen=seen,
        )
        return first, second

    def _judge(self, step: float, first: Stage, second: Stage) -> _Judgement:
        """Compare a step with embedded formulas of another order."""
        window = self.state.window
        volume = window.integral(second.wear)
        if volume == 0:
            return _Judgement(0.0, _FACTORS[1], True)
        error = self._exponent_error(step, first, second)
        if second.yielded:
            error = max(error, self._source_error(step, first, second))
        error /= _OVERESTIMATE * volume * self.tolerance
        if not isfinite(error):
            return _Judgement(error, _FACTORS[0], False)
        factor = _SAFETY * max(error, 1e-6) ** (-1.0 / 3.0)
        factor = min(max(factor, _FACTORS[0]), _FACTORS[1])
        accepted = error <= _ACCEPTED
        if first.yielded or second.yielded:
            longest = self._longest_while_yielding()
            factor = min(factor, longest / step)
            accepted &= step <= _ACCEPTED * longest
        return _Judgement(error, factor, accepted)

    def _exponent_error(self, step: float, first: Stage, second: Stage) -> float:
        """Wear volume, m³, between the step and its embedded third-order formula."""
        weights = [e - m for e, m in zip(_EMBEDDED, _MAIN, strict=True)]
        difference = self._exponent(step, first, second, weights)
        return self.state.window.integral(np.abs(second.reduced.gap * np.expm1(difference)))

    def _source_error(self, step: float, first: Stage, second: Stage) -> float:
        """Wear volume, m³, between plastic flow linear over each stage and over the whole step."""
        base = Stage.of(self.state)
        exponent = self._exponent(step, first, second, _MAIN)
        whole = self.problem.slip_model.wear_layer(
            base.wear, base.reduced.gap, second.source - base.source, exponent, 0.0
        )
        difference = whole.displacement(second.pressure) - second.wear
        return self.state.window.integral(np.abs(difference))

    def _exponent(
        self, step: float, first: Stage, second: Stage, weights: Sequence[float]
    ) -> Array:
        """Exponent x = β∫p dN over a step by weights of its three pressures."""
        start, middle, end = (self.problem.growth_rate * step * weight for weight in weights)
        exponent: Array = start * self.state.pressure
        exponent += middle * first.pressure
        exponent += end * second.pressure
        return exponent

    def _longest_while_yielding(self) -> float:
        """Longest step, cycles, in which plastic flow is resolved.

        A cell at the limit sinks until wear, at the rate β p_lim, has freed it. A step of many
        such times sees it before and after, not the flow in between.
        """
        exponent = _FLOW_EXPONENT * sqrt(self.tolerance / _DEFAULT_TOLERANCE)
        return exponent / (self.problem.growth_rate * self.problem.limit)

    def _move_to(self, window: Window) -> None:
        """Put the state on a larger window."""
        # First, so that the state finds the half-space in use and does not make it again.
        solver = StageSolver(self.problem, window, self.tolerance)
        solver.bodies.take_parts(self._solver.bodies)
        solver.convolutions = self._solver.convolutions
        self._solver = solver
        self.state = self.state.on(self.problem, window)
        self._outlook = Outlook(self.problem, window)
