"""Wear over many fretting cycles: implicit, adaptive steps.

The steps follow TR-BDF2: two implicit stages of one weight, second order, L-stable, with an
embedded third order: Bank et al., "Transient simulation of silicon devices and circuits", IEEE
Trans. Electron Devices 32 (1985); coefficients and embedded weights as in Hosea and Shampine,
"Analysis and implementation of TR-BDF2", Appl. Numer. Math. 20 (1996).

One cycle wears Δw = 4 K_w p s = β p g* with β = 4 K_w µκ, so over the cycles dW/dN = β p g*. The
equation is stiff: pressure reacts at once to wear of a fraction of a micrometer. Steps are taken
for the exponent x = β∫p dN, from which wear follows in closed form.

Each stage is a contact of its own, `fretwear.mechanics.wear.stage`; contacts that slide as a
whole have theirs in `fretwear.mechanics.wear.stroke`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import inf, isfinite, isnan, nan, sqrt
from typing import Generic, TypeVar

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.contact.cells import Geometry
from fretwear.mechanics.contact.problem import Accuracy, ContactError, solve_contact
from fretwear.mechanics.slip.models import Pressed
from fretwear.mechanics.surfaces.coating import Interface
from fretwear.mechanics.wear.stage import Dissipation, Exposure, ImplicitStage, all_worn
from fretwear.mechanics.wear.state import Stage, State, WearProblem, Workspace, YieldLimit
from fretwear.mechanics.wear.window import first_cells, holding_cells, next_cells


class _Tableau:
    """The numbers of TR-BDF2, in fractions of a step; both stages have the same implicit weight."""

    middle = 2.0 - sqrt(2.0)  #: end of the first stage, γ
    implicit = 0.5 * (2.0 - sqrt(2.0))  #: weight of the rate at the end of either stage
    explicit = 0.25 * sqrt(2.0)  #: weight of the first two rates in the second stage
    #: Length of the second stage over the first, by which a change is extrapolated.
    ratio = (1.0 - middle) / middle
    #: Weights of the rates at the start, in between and at the end, of second and third order.
    weights = explicit, explicit, implicit
    embedded = (1.0 - explicit) / 3.0, (3.0 * explicit + 1.0) / 3.0, implicit / 3.0
    difference = tuple(e - w for e, w in zip(embedded, weights, strict=True))


TR_BDF2 = _Tableau

TOLERANCE = 0.01
# The embedded formulas differ from the step by about ten times its error in wear volume, as runs
# with far smaller steps show; a third of the difference is still on the safe side.
OVERESTIMATE = 3.0
_ACCEPTED, _SAFETY = 1.2, 0.85
_SMALLEST_STEP, _SMALLEST_FACTOR, _LARGEST_FACTOR = 1e-6, 0.2, 5.0

_FIRST_STEP = 0.09
# Each of the steps before a requested cycle leaves this part of the remaining way, until the way is
# so many settling times of the pressure of a cell, or this part of a usual step.
_LEFT, _SETTLED, _SHORTEST = 0.25, 1.5, 1e-3
# Shorter steps that locate wear through: how many at most, and the part of the way that they take.
_MOST_LOCATED, _BEFORE = 4, 0.9
# A step shorter than this part of the usual one does not tell how fields change over the next.
_SHORT = 0.5
# Largest number of contacts of a loading, and of repeated loadings on cells that suit the loaded
# bodies better.
_LARGEST_SWEEPS, _RELOADED = 60, 6
# Residual of a contact that shows which tips touch.
_TO_FIND_TIPS = 0.03
# Fraction of the tolerance for gross sliding, where the pressure has twenty times the error of the
# wear.
GLIDING = 0.25
# Weight of the error of friction over the weight of the error of wear.
_OF_FRICTION = 6.0
# The same for the energy that changes friction. Where the stick edge passes, rates have a kink;
# there the embedded weights differ from the step by no more than its error, and runs on other cells
# err alike. With a third of this weight, 8 of 20 line contacts wear a volume whose error is larger
# than estimated.
_OF_ENERGY = 30.0


StateT = TypeVar("StateT", bound=State)
Attempt = tuple[StateT, float, bool] | None


class WearError(RuntimeError):
    """The integration cannot continue; the last accepted state is valid."""


def assessed(error: float) -> tuple[float, bool]:
    """Factor for the next step, from an error over the tolerance; whether to accept this step."""
    if not isfinite(error):
        return _SMALLEST_FACTOR, False
    factor = _SAFETY * max(error, 1e-6) ** (-1.0 / 3.0)
    return min(max(factor, _SMALLEST_FACTOR), _LARGEST_FACTOR), error <= _ACCEPTED


class Integrator(ABC, Generic[StateT]):
    """Produces the accepted states of one block of loading.

    ``state`` is the last accepted one, None before the first loading. ``tolerance`` is the error of
    the wear of a step relative to the wear volume.
    """

    def __init__(self, problem: WearProblem, state: StateT | None, tolerance: float) -> None:
        self.problem, self.workspace = problem, Workspace(problem)
        self.previous, self.tolerance = state, tolerance

    @property
    def state(self) -> StateT:
        """The last accepted state, once the bodies are loaded."""
        assert self.previous is not None
        return self.previous

    @state.setter
    def state(self, state: StateT) -> None:
        self.previous = state

    @abstractmethod
    def load(self) -> None:
        """Load the bodies: unworn ones, or those of the last state."""

    @abstractmethod
    def attempt(self, step: float, end: float, *, output_step: bool) -> Attempt[StateT]:
        """Take a step of some cycles to an end that may be requested; None to repeat on more cells.

        It returns the state at the end, the factor for the next step, and whether to accept this
        one. Raises a ContactError or numpy.linalg.LinAlgError if it is too long to converge.
        """

    def settling(self) -> float:
        """Number of cycles in which the pressure of a cell that begins to touch settles."""
        return inf

    def advance(self, stop: float, *, requested: bool = True) -> StateT:
        """The next accepted state, at ``stop`` or before; a `WearError` if no step is accurate.

        A cell that first touches within a step has no pressure at its start. So a stage assumes too
        little exposure, and its pressure is up to twice the one at which the cell wears as fast as
        its gap closes. Later steps correct this. So ever shorter steps lead to a ``requested``
        stop, until hardly any cell first touches within the last one.
        """
        # The first length after a loading follows the peak pressure, where nothing may wear.
        length = max(self.state.next_step, _SMALLEST_STEP)
        trouble = "wear asks for shorter ones"
        settled = inf
        if requested:
            settled = max(_SETTLED * self.settling(), _SHORTEST * length, _SMALLEST_STEP / _LEFT)
        while True:
            now, left = self.state.cycle, stop - self.state.cycle
            # Steps of equal length up to a stop avoid a short one at the end.
            step = left if length >= left else min(length, max(0.5 * left, 0.5 * length))
            if length >= left > settled:
                step = (1.0 - _LEFT) * left
            if step < _SMALLEST_STEP:
                raise WearError(
                    f"no step after cycle {now:.6g} is accurate, down to {step:.1e} cycles: "
                    f"{trouble}; the contact at cycle {now:.6g} has a residual of "
                    f"{self.state.residual:.1e}"
                )
            end = stop if step == left else now + step
            try:
                attempted = self.attempt(step, end, output_step=step == left)
            except (ContactError, np.linalg.LinAlgError) as error:
                length, trouble = 0.5 * step, str(error)
                continue
            if attempted is None:
                continue
            state, factor, accepted = attempted
            if accepted:
                break
            length, estimate = step * factor, state.error_estimate
            trouble = f"the error is estimated as {estimate:.1e} instead of {self.tolerance:.1e}"
        following = step * factor
        if step < length and factor >= 1.0:
            # A stop shortened the step, which says nothing about the next one.
            following = max(following, length)
        through, spent = self.state.worn_through, 0
        if isnan(through) and not self.left_of_coating(state):
            through, spent = self._wear_through(state)
        self.state = replace(
            state,
            next_step=following,
            worn_through=through,
            convolutions=state.convolutions + spent,
        )
        return self.state

    def left_of_coating(self, state: StateT) -> float:
        """Cycles in which the rate of wear of a state makes the first place bare; 0 if one is."""
        del state
        return inf

    def _wear_through(self, state: StateT) -> tuple[float, int]:
        """The first cycle of wear through, in a step to a state, and convolutions spent on it.

        Pressure falls abruptly where a substrate is bare. So a shorter step ends just before, and
        the rest follows from the rate of wear at its end.
        """
        base, spent = self.state, 0
        longest = state.cycle - base.cycle
        left = min(self.left_of_coating(base), longest)
        for _ in range(_MOST_LOCATED):
            step = _BEFORE * left
            try:
                attempted = self.attempt(step, base.cycle + step, output_step=False)
            except (ContactError, np.linalg.LinAlgError):
                break
            if attempted is None:
                break
            shorter, *_ = attempted
            spent += shorter.convolutions - base.convolutions
            rest = self.left_of_coating(shorter)
            left, missed = min(step + rest, longest), left
            if rest and left <= missed * (2.0 - _BEFORE):
                break
        return base.cycle + left, spent


def march(
    problem: WearProblem,
    stops: Sequence[float],
    state: StateT | None,
    begin: Callable[[WearProblem, StateT | None], Integrator[StateT]],
) -> Iterator[StateT]:
    """Yield each accepted state of all blocks of a problem, up to the last stop.

    ``begin`` makes the integrator of a block from the last state, or None.
    """
    first = 0.0
    for last, setup in problem.blocks or ((inf, problem),):
        if state is None or state.cycle < last:
            integrator = begin(problem.with_setup(setup), state)
            if state is None or state.cycle == first > 0.0:
                integrator.load()
            if state is None:
                yield integrator.state
            # Neither a step nor its error estimate may span a kink.
            kinks = {kink for kink in (*setup.kinks, last) if kink < stops[-1]}
            for stop in sorted({*stops, *kinks}):
                while first <= integrator.state.cycle < min(stop, last):
                    yield integrator.advance(stop, requested=stop in stops)
            state = integrator.state
        first = last


def evolve(
    problem: WearProblem,
    stops: Sequence[float],
    tolerance: float = TOLERANCE,
    start: State | None = None,
    accuracy: Accuracy | None = None,
) -> Iterator[State]:
    """Integrate wear over the cycles and yield each accepted state, cycle 0 included.

    A step ends exactly at each of the increasing cycles ``stops``, the last of which ends the run.
    ``tolerance`` is the error of one step's wear relative to the wear volume, and ``accuracy`` has
    the tolerances of the contacts. A run resumes from ``start``, a state that was yielded before
    and is not yielded again. It raises a `WearError` if no step is accurate, however short, and a
    `fretwear.mechanics.contact.problem.ContactError` if the first loading does not converge.
    """
    return march(problem, stops, start, partial(Evolution, tolerance=tolerance, accuracy=accuracy))


def first_loading(
    problem: WearProblem,
    accuracy: Accuracy | None = None,
    workspace: Workspace | None = None,
    previous: State | None = None,
    cells: Geometry | None = None,
) -> State:
    """The state at the start of a loading; its cells yield at the plastic limit.

    ``previous`` is the state that an earlier loading has left; None for unworn bodies at cycle 0.
    It is on ``cells``, or else on those of ``previous`` or the first of the problem. Raises a
    `fretwear.mechanics.contact.problem.ContactError` if the contact does not converge, or if the
    pressure limit does not settle, for which no step can be halved.
    """
    workspace, accuracy = workspace or Workspace(problem), accuracy or Accuracy()
    geometry = cells or (first_cells(problem) if previous is None else previous.geometry)
    cycle, step, spent = (getattr(previous, name, 0) for name in ("cycle", "step", "convolutions"))
    now = problem.at(cycle)
    start = None if previous is None else previous.geometry.resized(previous.pressure, geometry)
    limit = reduced = None
    # Tips beyond the window of a rough contact are found before it is solved accurately.
    tolerance = accuracy.contact if problem.wavelengths is None else _TO_FIND_TIPS
    for _ in range(_LARGEST_SWEEPS):
        bodies, zeros = workspace.on(geometry), np.zeros(geometry.shape)
        energy = zeros if now.friction_law.follows_slip else None
        if previous is not None and previous.friction_energy is not None:
            energy = previous.geometry.resized(previous.friction_energy, geometry)
        now = now.slipped(energy)
        wear, opening, plastic = (
            zeros if not previous else previous.geometry.resized(getattr(previous, name), geometry)
            for name in ("wear", "opening", "plastic")
        )
        if limit is None:
            limit = YieldLimit(now, geometry, wear, now.limit_without_shear(wear))
        shape = bodies.unworn + opening + plastic
        contact = solve_contact(
            problem.contact(bodies.half_space, shape, limit=limit.value),
            start,
            tolerance,
        )
        spent += contact.convolutions
        larger = holding_cells(geometry, workspace, contact.pressure, contact.approach)
        if larger.shape != geometry.shape:
            start = geometry.resized(contact.pressure, larger)
            geometry, limit, reduced = larger, None, None
            continue
        start, tolerance = contact.pressure, accuracy.contact
        if contact.residual > tolerance:
            continue
        plastic = plastic + contact.penetration
        load = now.load_of(geometry, contact)
        pressed = Pressed(
            bodies.half_space,
            bodies.unworn + plastic + opening,
            contact.pressure,
            contact.gap + contact.penetration,
            contact.approach,
            now.reduced_condition(load, contact.approach),
            accuracy.first_reduced,
        )
        reduced = now.slip_model.reduced(now, pressed, reduced)
        spent += reduced.convolutions
        if limit.suits(contact, reduced, wear, accuracy.contact * load):
            break
    else:
        raise ContactError("the limit of pressure that friction lowers did not settle")
    gap = np.maximum(contact.gap, 0.0)
    growth = now.wear_growth * float(contact.pressure.max())
    first_step = _FIRST_STEP / growth if growth > 0.0 else inf
    if now.interface is not None and growth > 0.0:
        # The most slip under pressure wears through first.
        slipping = float(np.where(contact.pressure > 0.0, reduced.gap, 0.0).max())
        first_step = now.interface.exposure(_FIRST_STEP * slipping) / (slipping * growth or inf)
    return State(
        cycle=float(cycle),
        geometry=geometry,
        pressure=contact.pressure,
        gap=gap,
        wear=wear,
        opening=opening,
        plastic=plastic,
        load=load,
        approach=contact.approach,
        residual=contact.residual,
        reduced=reduced,
        friction_energy=energy,
        next_step=first_step,
        worn_through=getattr(previous, "worn_through", nan),
        pressure_rate=zeros,
        source_rate=zeros,
        step=step,
        convolutions=spent,
    )


def left_where_bare(interface: Interface, wear: Array, growth: Array) -> Array:
    """Part of the error of a step that the pressure leaves at each place; 1 where none is bare.

    ``wear`` is the depth, m, at the end of the step, and ``growth`` the depth that a pressure would
    wear over the step, divided by what it displaces the cell. Pressure soon corrects the depth of a
    place that has just become bare, a stiff part. Hosea and Shampine divide its estimate once;
    divided twice, it is 0.7 to 1.2 times the error of y′ = −λy at all λ.
    """
    bare = np.where(interface.reached(wear), interface.depth, 0.0)
    stiff = bare / np.maximum(wear, interface.depth) * growth
    return np.asarray((1.0 + TR_BDF2.implicit * stiff) ** -2.0)


class _FrictionOverStep:
    """The energy per area that friction follows, J/m², over the stages of a step.

    The weights of the step integrate it, as they do wear; first guesses extrapolate its rates.
    """

    def __init__(self, base: State, now: WearProblem, step: float) -> None:
        self._geometry, self._start, self._step = base.geometry, base.friction_energy, step
        self._rates = [] if self._start is None else [now.energy_rate(base)]

    def first(self) -> Dissipation | None:
        """The energy of the first stage; None if friction does not follow slip."""
        if self._start is None:
            return None
        cycles, (rate,) = TR_BDF2.implicit * self._step, self._rates
        known = self._start + cycles * rate
        return Dissipation(known, cycles, known + cycles * rate)

    def second(self, problem: WearProblem, stage: Stage) -> Dissipation | None:
        """The energy of the second stage, after the first one."""
        if self._start is None:
            return None
        first_rate, rate = self._rates[0], problem.energy_rate(stage)
        self._rates.append(rate)
        cycles = TR_BDF2.implicit * self._step
        known = self._start + TR_BDF2.explicit * self._step * (first_rate + rate)
        ahead = np.maximum(rate + TR_BDF2.ratio * (rate - first_rate), 0.0)
        return Dissipation(known, cycles, known + cycles * ahead)

    def error(self, problem: WearProblem, stage: Stage) -> float:
        """The error of friction in the slip zone, or of the energy, as an error of a step's wear.

        Both are relative and follow from the embedded weights.
        """
        energy = stage.friction_energy
        # Within a cycle friction does not change.
        if self._start is None or energy is None or not self._step > 1.0:
            return 0.0
        rates = *self._rates, problem.energy_rate(stage)
        missed = sum(w * rate for w, rate in zip(TR_BDF2.difference, rates, strict=True))
        embedded = np.maximum(energy + self._step * missed, self._start)
        law, integral = problem.friction_law, self._geometry.integral
        off = integral(np.abs(law.slipped(embedded).ratio - law.ratio) * stage.pressure)
        slipping = np.where(stage.reduced.stick, 0.0, law.ratio * stage.pressure)
        of_friction = off / integral(slipping) if off > 0.0 else 0.0
        of_energy = self._step * integral(np.abs(missed)) / integral(energy)
        return max(_OF_FRICTION * of_friction, _OF_ENERGY * of_energy)


class Evolution(Integrator[State]):
    """The steps of a block of loading, for a contact that neglects the motion of the bodies."""

    def __init__(
        self,
        problem: WearProblem,
        state: State | None,
        tolerance: float,
        accuracy: Accuracy | None = None,
    ) -> None:
        super().__init__(problem, state, tolerance * problem.geometry.of_tolerance)
        self.accuracy = accuracy or Accuracy()
        self._convolutions = 0  # spent since the state

    def load(self) -> None:
        """Load the bodies anew."""
        problem, previous, spent = self.problem, self.previous, 0
        self.state = first_loading(problem, self.accuracy, self.workspace, previous)
        # A state on any of these cells has converged; later cells only suit it better.
        for _ in range(_RELOADED):
            fitting = next_cells(self.state.geometry, problem, self.state)
            if self.state.geometry.where(fitting)[0].stop:
                self._move_to(fitting)
                break
            # The stick edge of bodies that yield is not where the cells expected it. Fields moved
            # to cells that suit it are out of equilibrium by more than a first step wears. A
            # plastic depth is moved before it grows: cubics at two times might let it fall.
            spent += self.state.convolutions - getattr(previous, "convolutions", 0)
            self.state = first_loading(problem, self.accuracy, self.workspace, previous, fitting)
        self.state = replace(self.state, convolutions=self.state.convolutions + spent)

    def settling(self) -> float:
        """Number of cycles in which the pressure of a cell that begins to touch settles.

        A pressure on a cell of width h displaces it by about h p/E*, and wear there opens a gap at
        the rate β p g*, so the pressure relaxes at the rate β g* E*/h.
        """
        state, problem = self.state, self.problem.of(self.state)
        opens = (1.0 - problem.debris_fraction) * float(np.max(problem.local_wear_growth))
        slipping = np.where(state.pressure > 0.0, state.reduced.gap, 0.0) / state.geometry.widths
        if problem.interface is not None:
            slipping = slipping * problem.interface.slope(state.wear)
        rate = opens * problem.composite_modulus * float(slipping.max())
        return 1.0 / rate if rate > 0.0 else inf

    def advance(self, stop: float, *, requested: bool = True) -> State:
        """The next accepted state, on cells that suit it."""
        # Fields moved to other cells are slightly out of equilibrium; short steps do not mend it.
        if stop - self.state.cycle > _SHORT * self.state.next_step:
            self._move_to(next_cells(self.state.geometry, self.problem, self.state))
        return super().advance(stop, requested=requested)

    def _move_to(self, geometry: Geometry) -> None:
        if geometry is not self.state.geometry:
            self.state = self.state.on(self.workspace, geometry)
            self.workspace.keep_only(geometry)

    def attempt(self, step: float, end: float, *, output_step: bool) -> Attempt[State]:
        """Take both stages, and compare them with the embedded formulas."""
        base, problem, numbers = self.state, self.problem, TR_BDF2
        geometry, implicit, weight = base.geometry, numbers.implicit, numbers.explicit
        model = problem.slip_model
        now, means = problem.worn_by(base, base.cycle, geometry)
        early, middle = numbers.middle * step, base.cycle + numbers.middle * step
        friction = _FrictionOverStep(base, now, step)
        # The means that the wear coefficient follows are those of the stage before.
        then, early_friction = problem.at(middle).under(means), friction.first()
        if early_friction is not None:
            then = then.slipped(early_friction.energy)
        p0, rate = base.pressure, now.local_wear_growth * step
        early_withheld = implicit * step * (now.withheld_depth + then.withheld_depth)
        first = self.stage(
            base,
            then,
            Exposure(
                (rate * implicit) * p0, then.local_wear_growth * step * implicit, early_withheld
            ),
            p0 + early * base.pressure_rate,
            early * base.source_rate,
            self.accuracy.first_stage,
            dissipation=early_friction,
        )
        then = then.slipped(first.friction_energy)
        p1 = first.pressure
        unloaded = (rate * (weight - implicit)) * (p0 + p1)
        midway, reached = problem.worn_by(first, middle, geometry)
        last = problem.at(end).under(reached.ahead(means, numbers.ratio))
        late_friction = friction.second(then, first)
        if late_friction is not None:
            last = last.slipped(late_friction.energy)
        r0, lagged, r1 = (setup.local_wear_growth * step for setup in (now, then, midway))
        if not (np.array_equal(r0, lagged) and np.array_equal(lagged, r1)):
            unloaded = weight * (r0 * p0 + r1 * p1) - implicit * (r0 * p0 + lagged * p1)
        early_withheld = implicit * step * (now.withheld_depth + then.withheld_depth)
        withheld = self._withheld(step, now, midway, last)
        second = self.stage(
            first,
            last,
            Exposure(unloaded, last.local_wear_growth * step * implicit, withheld - early_withheld),
            p1 + numbers.ratio * (p1 - p0),
            numbers.ratio * first.source_since(base, model),
            self.accuracy.contact if output_step else self.accuracy.contact_between,
            output_step=output_step,
            dissipation=late_friction,
        )
        last = last.slipped(second.friction_energy)
        fitting = holding_cells(geometry, self.workspace, second.pressure, second.approach)
        if fitting is not geometry:
            self._move_to(fitting)
            return None
        withheld = self._withheld(step, now, midway, last)
        friction_error = friction.error(last, second)
        error, factor, accepted = self._assess(
            step, (now, midway, last), first, second, withheld, friction_error
        )
        state = self._ended(step, end, first, second, error)
        if accepted:
            self._convolutions = 0
        return state, factor, accepted

    def _withheld(self, step: float, *setups: WearProblem) -> float | Array:
        """The depth, m, that a threshold withholds over a step with setups at its three times."""
        depths = (setup.withheld_depth for setup in setups)
        return step * sum(w * d for w, d in zip(TR_BDF2.weights, depths, strict=True))

    def left_of_coating(self, state: State) -> float:
        """As in the base class: the coating left over β p g*."""
        if (interface := self.problem.interface) is None:
            return inf
        problem = self.problem.of(state)
        rate = problem.local_wear_growth * state.pressure * state.reduced.gap
        return interface.cycles_left(state.wear, rate - problem.withheld_depth)

    def _ended(self, step: float, end: float, first: Stage, second: Stage, error: float) -> State:
        """The state after both stages, with rates that predict the next step."""
        base, model = self.state, self.problem.slip_model
        duration = (1.0 - TR_BDF2.middle) * step
        pressure_rate = (second.pressure - first.pressure) / duration
        source_rate = second.source_since(first, model) / duration
        if step < _SHORT * base.next_step:
            pressure_rate, source_rate = base.pressure_rate, base.source_rate
        return State(
            **vars(second),
            cycle=end,
            geometry=base.geometry,
            next_step=step,
            pressure_rate=pressure_rate,
            source_rate=source_rate,
            step=base.step + 1,
            error_estimate=error,
            convolutions=base.convolutions + self._convolutions,
        )

    def stage(
        self,
        base: Stage,
        problem: WearProblem,
        exposure: Exposure,
        pressure: Array,
        change: Array,
        tolerance: float,
        *,
        output_step: bool = False,
        dissipation: Dissipation | None = None,
    ) -> Stage:
        """One stage from a base, to the time at which a problem holds; see `ImplicitStage`."""
        bodies = self.workspace.on(self.state.geometry)
        accuracy, allowed = self.accuracy, self.tolerance
        stage = ImplicitStage(base, problem, bodies, accuracy, allowed, output_step, dissipation)
        try:
            return stage.solve(exposure, pressure, change, tolerance)
        finally:
            self._convolutions += stage.convolutions

    def _assess(
        self,
        step: float,
        setups: Sequence[WearProblem],
        first: Stage,
        second: Stage,
        withheld: float | Array,
        friction_error: float,
    ) -> tuple[float, float, bool]:
        """Relative error of the wear of a step, factor for the next one, whether to accept it.

        The setups hold at the start of the step and at the end of each stage. A threshold has
        withheld a depth, m, from the wear of the step. Friction may be in error by a fraction.
        """
        base, problem = self.state, setups[-1]
        rates = [setup.local_wear_growth for setup in setups]
        integral, gap, kept = base.geometry.integral, base.reduced.gap, problem.debris_fraction
        opens, volume = 1.0 - kept, integral(second.wear)
        slope: float | Array = 1.0
        if problem.interface is not None:
            slope = problem.interface.mean_slope(base.wear, second.wear)
        if problem.friction_law.follows_slip:
            # Friction may change suddenly, but the wear of a cycle remains the measure.
            volume /= min(base.cycle + step, 1.0)
        if volume == 0:
            return friction_error, *assessed(friction_error / self.tolerance)

        def exponent(weights: Sequence[float]) -> Array:
            """X = β∫p dN over the step, by weights of its three pressures."""
            start, middle, end = (b * step * w for b, w in zip(rates, weights, strict=True))
            return start * base.pressure + middle * first.pressure + end * second.pressure

        def lost(gap: Array, difference: Array) -> Array:
            # A far too long step overflows; its error is not finite, which rejects it.
            with np.errstate(over="ignore", invalid="ignore"):
                return np.abs(gap * (np.expm1(opens * difference) / opens if opens else difference))

        most: Array | float = inf
        if base.reduced.follows_pressure:
            # The pressure soon leaves a cell that begins to slip, which bounds its error.
            most = np.abs(second.opening - base.opening)
        elif problem.wear_threshold:
            most = np.abs(second.wear - base.wear)
        missed = slope * exponent(TR_BDF2.difference)
        if (interface := problem.interface) is not None and problem.changes_below:
            growth = opens * slope * rates[-1] * step * second.reduced.gap
            growth *= problem.composite_modulus / base.geometry.widths
            missed *= left_where_bare(interface, second.wear, growth)
        error = integral(np.minimum(lost(second.reduced.gap, missed), most))
        model = problem.slip_model
        if second.yielded or not model.still_holds(base.reduced, problem, base.load):
            # Slip that changes evenly over the whole step instead of over each stage.
            x, shift = exponent(TR_BDF2.weights), second.source_since(base, model)
            layer = model.wear_layer(base.opening, gap, shift, opens * x, 0.0, opens * withheld)
            worn = problem.over_substrate(layer).displacement(second.pressure)
            if kept:
                opened, final_gap = worn - base.opening, second.reduced.gap
                worn = base.wear + all_worn(kept, opened, gap, final_gap, x, withheld)
            error = max(error, integral(np.minimum(np.abs(worn - second.wear), most)))
        error = max(error / (OVERESTIMATE * volume), friction_error)
        allowed = self.tolerance
        if not second.reduced.load > 0.0:
            allowed *= min(1.0, GLIDING / base.geometry.of_tolerance)
        factor, accepted = assessed(error / allowed)
        if first.yielded or second.yielded:
            # A cell at the limit p sinks until wear, at the rate β p, has freed it. A much longer
            # step would miss the flow in between.
            limit = problem.limit_without_shear(second.wear)
            limit = slope * np.where(np.isfinite(limit), limit, 0.0)
            freed = max(np.max(rate * limit) for rate in rates) * problem.shear_on_limit
            longest = sqrt(self.tolerance / TOLERANCE) / freed
            factor = min(factor, longest / step)
            accepted &= bool(step <= _ACCEPTED * longest)
        return error, factor, accepted
