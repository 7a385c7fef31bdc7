"""Archard wear over many fretting cycles: implicit, adaptive steps.

One cycle wears Δw = β p g* with β = 4 K_w µκ, which makes dW/dN = β p g* over the cycles N.
The equation is stiff: pressure reacts at once to wear of a fraction of a micrometer. Each step is
TR-BDF2 (Bank et al. 1985; the coefficients, the embedded third-order weights and the reason why
it damps stiff parts are in Hosea and Shampine 1996) for the exponent x = β∫p dN, from which wear
follows in closed form (`fretwear.mechanics.layers.WearLayer`). Each of its two implicit stages is
one normal contact with that layer.

Plastic flow is rate-independent: where the pressure is at its limit, the surface sinks by the
penetration of the stage's contact. It changes the reduced-load problem, which is then solved on
the stage's own shape, in turn with the contact, until the wear of the stage is settled.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt

import numpy as np

from fretwear.mechanics.contact import Contact, ContactError, ContactProblem, solve_contact
from fretwear.mechanics.halfspace import Array, HalfSpace, Window, fast_shape, half_space
from fretwear.mechanics.slip import Friction, ReducedContact, SlipModel
from fretwear.mechanics.surfaces import Surface

# TR-BDF2 with γ = 2 − √2: first stage at γ, both stages implicit with the same weight.
_GAMMA = 2.0 - sqrt(2.0)
_DIAGONAL = 0.5 * _GAMMA
_WEIGHT = 0.25 * sqrt(2.0)
_EMBEDDED = ((1.0 - _WEIGHT) / 3.0, (3.0 * _WEIGHT + 1.0) / 3.0, _DIAGONAL / 3.0)

_CONTACT_TOLERANCE = 1e-6
_BORDER = 2
_GROWTH = 1.12
_SMALLEST_STEP = 1e-6
_LARGEST_SWEEPS = 12
_SWEEP_TOLERANCE = 0.02


class WearError(RuntimeError):
    """The integration cannot go on; the last accepted state is valid."""


@dataclass(frozen=True)
class WearProblem:
    """Two bodies under constant load and oscillating partial slip.

    Parameters
    ----------
    surface
        The unworn gap.
    composite_modulus
        E*, Pa.
    load
        Normal load P, N.
    friction
        Coulomb friction.
    slip_model
        How slip follows from the contact.
    wear_coefficient
        Archard's K_w, 1/Pa: worn depth per pressure and sliding distance.
    limit
        Largest pressure, Pa; infinite when elastic.
    spacing
        Cell size along x and y, m.
    extent
        Half-widths along x and y, m, of the first window.
    quarter
        Whether to compute the quarter x > 0, y > 0 only.
    workers
        Threads of one transform.
    """

    surface: Surface
    composite_modulus: float
    load: float
    friction: Friction
    slip_model: SlipModel
    wear_coefficient: float
    limit: float
    spacing: tuple[float, float]
    extent: tuple[float, float]
    quarter: bool = True
    workers: int = 1

    @property
    def growth_rate(self) -> float:
        """β = 4 K_w µκ, 1/Pa per cycle: relative growth of g* per unit pressure."""
        return 4.0 * self.wear_coefficient * self.friction.coefficient * self.friction.coupling

    def half_space(self, window: Window) -> HalfSpace:
        """The elastic bodies on a window."""
        return half_space(window, self.composite_modulus, self.workers)


@dataclass(frozen=True)
class State:
    """The contact after a number of cycles; all that a later step needs.

    Attributes
    ----------
    cycle
        Number of cycles N; between the requested ones not an integer.
    window
        Where the fields are given. Outside, nothing has touched yet.
    pressure, gap, wear, plastic
        p, Pa; gap, wear depth and plastic depth, m; shape of the window.
    approach
        δ, m.
    reduced
        The contact at the reduced load, from which slip follows.
    next_step
        Number of cycles that the next step should try.
    step
        How many steps were accepted so far.
    error_estimate
        Estimated error of the last step's wear relative to the wear volume.
    residual
        Largest violation of the gap conditions relative to the largest displacement.
    convolutions
        Half-space convolutions spent so far, rejected steps included.
    """

    cycle: float
    window: Window
    pressure: Array
    gap: Array
    wear: Array
    plastic: Array
    approach: float
    reduced: ReducedContact
    next_step: float
    step: int = 0
    error_estimate: float = 0.0
    residual: float = 0.0
    convolutions: int = 0

    def on(self, problem: WearProblem, window: Window) -> State:
        """The same state on a larger window; its gaps are computed where they were not known."""
        if window.shape == self.window.shape:
            return self
        old, shape = self.window, window.shape
        bodies, unworn = problem.half_space(window), problem.surface.shape(window)

        def gap(pressure: Array, approach: float, known: Array) -> Array:
            outer = bodies.displacement(old.resized(pressure, shape)) + unworn - approach
            inner = old.resized(np.ones(old.shape, dtype=np.bool_), shape, fill=False)
            outer[inner] = known.ravel()
            return outer

        reduced = replace(
            self.reduced,
            pressure=old.resized(self.reduced.pressure, shape),
            gap=gap(self.reduced.pressure, self.reduced.approach, self.reduced.gap),
        )
        return replace(
            self,
            window=window,
            pressure=old.resized(self.pressure, shape),
            gap=gap(self.pressure, self.approach, self.gap),
            wear=old.resized(self.wear, shape),
            plastic=old.resized(self.plastic, shape),
            reduced=reduced,
            convolutions=self.convolutions + 2,
        )


def evolve(
    problem: WearProblem,
    stops: Sequence[float],
    tolerance: float = 0.01,
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
    """
    if start is None:
        start = _unworn(problem)
        yield start
    stepper = _Stepper(problem, tolerance, start)
    for stop in stops:
        while stepper.state.cycle < stop:
            yield stepper.advance(stop)


def _unworn(problem: WearProblem) -> State:
    """The first loading: cycle 0."""
    extent = problem.extent
    spent = 0
    while True:
        shape = fast_shape(extent, problem.spacing, quarter=problem.quarter)
        window = Window(shape, problem.spacing, problem.quarter)
        bodies = problem.half_space(window)
        gap = problem.surface.shape(window)
        contact = solve_contact(
            ContactProblem(bodies, gap, problem.load, problem.limit), tolerance=_CONTACT_TOLERANCE
        )
        spent += contact.convolutions
        touched = _touched(window, contact.pressure)
        if not any(touched):
            break
        extent = _grown(extent, touched)
    plastic = contact.penetration
    reduced = problem.slip_model.reduced(bodies, gap + plastic)
    return State(
        cycle=0.0,
        window=window,
        pressure=contact.pressure,
        gap=np.maximum(contact.gap, 0.0),
        wear=np.zeros(shape),
        plastic=plastic,
        approach=contact.approach,
        reduced=reduced,
        next_step=0.2 / (problem.growth_rate * float(contact.pressure.max())),
        residual=contact.residual,
        convolutions=spent + reduced.convolutions,
    )


def _touched(window: Window, pressure: Array) -> tuple[bool, bool]:
    """Whether pressure comes near the window's border along x and along y."""
    along_x = bool(pressure[-_BORDER:].any())
    along_y = bool(pressure[:, -_BORDER:].any())
    if not window.quarter:
        along_x |= bool(pressure[:_BORDER].any())
        along_y |= bool(pressure[:, :_BORDER].any())
    return along_x, along_y


def _grown(extent: tuple[float, float], touched: tuple[bool, bool]) -> tuple[float, float]:
    return (
        extent[0] * (_GROWTH if touched[0] else 1.0),
        extent[1] * (_GROWTH if touched[1] else 1.0),
    )


@dataclass(frozen=True)
class _Stage:
    """A consistent state within a step: the contact, its wear, its reduced contact."""

    pressure: Array
    gap: Array
    approach: float
    residual: float
    wear: Array
    plastic: Array
    reduced: ReducedContact
    yielded: bool

    @property
    def shift(self) -> Array:
        """G = g* − W, m: what wear alone does not change."""
        result: Array = self.reduced.gap - self.wear
        return result


class _Stepper:
    """Makes accepted states one after the other."""

    def __init__(self, problem: WearProblem, tolerance: float, state: State) -> None:
        self.problem = problem
        self.tolerance = tolerance
        self.state = state
        self._move_to(state.window)

    def advance(self, stop: float) -> State:
        """The next accepted state, at ``stop`` or before."""
        wanted = self.state.next_step
        while True:
            left = stop - self.state.cycle
            step = left if wanted >= left else min(wanted, max(0.5 * left, 0.5 * wanted))
            if step < _SMALLEST_STEP:
                raise WearError(
                    f"no step of {step:.1e} cycles or more is accurate after cycle "
                    f"{self.state.cycle:.6g}: residual {self.state.residual:.1e}, error estimate "
                    f"{self.state.error_estimate:.1e}"
                )
            try:
                first, second = self._stages(step)
            except ContactError:
                wanted = 0.5 * step
                continue
            touched = _touched(self.state.window, second.pressure)
            if any(touched):
                self._grow(touched)
                continue
            error, factor = self._judge(step, first, second)
            if error > 1.2:
                wanted = step * factor
                continue
            self.state = replace(
                self.state,
                cycle=stop if step == left else self.state.cycle + step,
                pressure=second.pressure,
                gap=second.gap,
                wear=second.wear,
                plastic=second.plastic,
                approach=second.approach,
                reduced=second.reduced,
                # A step cut short by a stop says little about the one that follows.
                next_step=max(step * factor, wanted if step < wanted and factor >= 1 else 0.0),
                step=self.state.step + 1,
                error_estimate=error * self.tolerance,
                residual=second.residual,
            )
            return self.state

    def _stages(self, step: float) -> tuple[_Stage, _Stage]:
        """Both stages of TR-BDF2 over a step of so many cycles."""
        state = self.state
        rate = self.problem.growth_rate * step
        base = _Stage(
            pressure=state.pressure,
            gap=state.gap,
            approach=state.approach,
            residual=state.residual,
            wear=state.wear,
            plastic=state.plastic,
            reduced=state.reduced,
            yielded=False,
        )
        p0 = state.pressure
        first = self._stage(base, rate * _DIAGONAL * p0, rate * _DIAGONAL, None)
        p1 = first.pressure
        guess = (first.shift - base.shift) * ((1.0 - _GAMMA) / _GAMMA) if first.yielded else None
        known = rate * (_WEIGHT - _DIAGONAL) * (p0 + p1)
        return first, self._stage(first, known, rate * _DIAGONAL, guess)

    def _stage(self, base: _Stage, known: Array, rate: float, shift: Array | None) -> _Stage:
        """One implicit stage: from ``base`` by the exponent x = known + rate · p.

        ``shift`` is the first guess of how plastic flow changes G over the stage.
        """
        model = self.problem.slip_model
        window = self.state.window
        reduced = base.reduced
        start = base.pressure
        relaxation, before = 1.0, inf
        for _ in range(_LARGEST_SWEEPS):
            layer = model.wear_layer(base.wear, base.reduced.gap, shift, known, rate)
            contact = self._contact(base.plastic, layer, start)
            start = contact.pressure
            wear = layer.displacement(start)
            overshoot = _overshoot(contact, wear - base.wear)
            wear -= overshoot
            penetration = contact.penetration
            yielded = model.follows_shape and bool(penetration.any())
            if yielded:
                shape = self.shape + wear + base.plastic + penetration
                reduced = model.reduced(self.bodies, shape, start=reduced.pressure)
                self._spend(reduced.convolutions)
            else:
                gap = model.gap_after(base.reduced.gap, wear - base.wear)
                reduced = replace(base.reduced, gap=gap)
            stage = _Stage(
                pressure=start,
                gap=np.maximum(contact.gap, 0.0) - overshoot,
                approach=contact.approach,
                residual=contact.residual,
                wear=wear,
                plastic=base.plastic + penetration,
                reduced=reduced,
                yielded=yielded,
            )
            if not yielded and shift is None:
                break
            settled = stage.shift - base.shift
            missing = settled if shift is None else settled - shift
            change = window.integral(np.abs(missing) * np.expm1(known + rate * start))
            if change <= _SWEEP_TOLERANCE * self.tolerance * window.integral(wear):
                break
            if change > 0.5 * before:
                # Flow lets wear catch up, which stops the flow: meet in the middle.
                relaxation = max(0.5 * relaxation, 0.1)
            before = change
            shift = settled if shift is None else shift + relaxation * missing
        return stage

    def _contact(self, plastic: Array, layer: object, start: Array) -> Contact:
        contact = solve_contact(
            ContactProblem(
                self.bodies, self.shape + plastic, self.problem.load, self.problem.limit, layer
            ),
            start,
            _CONTACT_TOLERANCE,
        )
        self._spend(contact.convolutions)
        return contact

    def _judge(self, step: float, first: _Stage, second: _Stage) -> tuple[float, float]:
        """Error of a step in units of the tolerance, and the factor for the next step."""
        state, window = self.state, self.state.window
        p0, p1, p2 = state.pressure, first.pressure, second.pressure
        rate = self.problem.growth_rate * step
        exponent = rate * (_WEIGHT * (p0 + p1) + _DIAGONAL * p2)
        embedded = rate * (_EMBEDDED[0] * p0 + _EMBEDDED[1] * p1 + _EMBEDDED[2] * p2)
        volume = window.integral(second.wear)
        if not volume > 0:
            return 0.0, 5.0
        gap = second.reduced.gap
        error = window.integral(np.abs(gap * np.expm1(embedded - exponent)))
        if second.yielded:
            # G linear over the whole step instead of over each stage.
            single = self.problem.slip_model.wear_layer(
                state.wear,
                state.reduced.gap,
                second.shift - (state.reduced.gap - state.wear),
                exponent,
                0.0,
            ).displacement(p2)
            error = max(error, window.integral(np.abs(single - second.wear)))
        error /= volume * self.tolerance
        factor = min(5.0, max(0.2, 0.85 * max(error, 1e-6) ** (-1.0 / 3.0)))
        if first.yielded or second.yielded:
            # A cell at the limit wears free at the rate β p_lim; longer steps would miss its flow.
            longest = sqrt(self.tolerance / 0.01) / (self.problem.growth_rate * self.problem.limit)
            factor = min(factor, longest / step)
            if step > 1.25 * longest:
                error = inf
        return error, factor

    def _spend(self, convolutions: int) -> None:
        self.state = replace(self.state, convolutions=self.state.convolutions + convolutions)

    def _move_to(self, window: Window) -> None:
        self.bodies = self.problem.half_space(window)
        self.shape = self.problem.surface.shape(window)

    def _grow(self, touched: tuple[bool, bool]) -> None:
        """Put the state on a larger window: nothing has touched there before."""
        old = self.state.window
        shape = fast_shape(_grown(old.extent, touched), old.spacing, quarter=old.quarter)
        window = Window(
            (max(shape[0], old.shape[0]), max(shape[1], old.shape[1])), old.spacing, old.quarter
        )
        self.state = self.state.on(self.problem, window)
        self._move_to(window)


def _overshoot(contact: Contact, wear: Array) -> Array:
    """What a long step removes, m, after a cell has lost its pressure.

    Wear needs pressure, so it cannot open a gap: an open cell that wore in this stage touches.
    """
    result: Array = np.where(contact.pressure > 0, 0.0, np.minimum(contact.gap, wear))
    return np.maximum(result, 0.0, out=result)
