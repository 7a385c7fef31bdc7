"""A whole wear run driven by a peer's contact solver, as one would write it: explicit steps.

Before each step the contact under P and the one under P* = P − Q/µ are solved on the worn shape,
both from the pressure of the step before; wear grows by Archard's law with the slip of Ciavarella
and Jäger, over as many cycles as the method can jump without becoming unstable. Such a run takes
hours, so steps are timed at some cycles of the run, and the sum over the run is taken from these
and from the length that a step may have all along it. Shapes and pressures to start from are those
of this simulator's own run, whose time is what the sum is compared with.
"""

import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np
from benchmarks.cases import smooth_case
from benchmarks.peers.contacts import PEERS, TUNING_CELLS, Peer, Pressed, tuned, unfolded

from fretwear.arrays import Array
from fretwear.mechanics.contact.cells import ContactError, ContactProblem
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import solve_contact
from fretwear.mechanics.wear.integrator import evolve
from fretwear.mechanics.wear.state import State, WearProblem
from fretwear.run import simulate

_SOFTEST = 0.58
_DOUBLINGS = 8
_TRIAL_STEPS = 20
_DIFFERENT = 0.02
_TRIAL_CELLS = 32.0
_FIRST_CYCLES = 10.0
CYCLES = (0.0, 300.0, 1000.0, 3000.0, 10000.0, 20000.0, 30000.0)
"""Where in the run steps are timed."""

Solve = Callable[[Array, float, Array], Pressed]
"""Shape, m, load, N, and pressure to start from, Pa, to pressure and displacement."""


@dataclass
class Loop:
    """The explicit loop on one window.

    Parameters
    ----------
    problem
        What is worn.
    window
        Where.
    full, reduced
        Solvers of the contacts at P and at P*.
    wear
        Depth so far, m.
    pressure, reduced_pressure
        What the next solves start from, Pa.
    """

    problem: WearProblem
    window: Grid
    full: Solve
    reduced: Solve
    wear: Array
    pressure: Array
    reduced_pressure: Array

    def __post_init__(self) -> None:
        self._unworn = self.problem.unworn(self.window)

    def step(self, cycles: float) -> None:
        """Solve both contacts on the worn shape, then wear for some cycles."""
        shape = self._unworn + self.wear
        self.pressure = self.full(shape, self.problem.hertz.load, self.pressure).pressure
        load = self.problem.stick_load
        reduced = self.reduced(shape, load, self.reduced_pressure)
        self.reduced_pressure = reduced.pressure
        gap = np.where(reduced.pressure > 0, 0.0, np.maximum(reduced.gap(shape), 0.0))
        self.wear = self.wear + self.problem.wear_growth * cycles * self.pressure * gap


def estimated_step(problem: WearProblem, state: State) -> float:
    """Longest stable step of a linear analysis, cycles: 2 · 0.58 h / (β E* max g*).

    The softest answer of a square cell's surface to pressure is 0.58 h / E*.
    """
    softest = _SOFTEST * min(problem.spacing) / problem.bodies.composite_modulus
    touching = state.reduced.gap[state.in_contact]
    return 2.0 * softest / (problem.wear_growth * float(touching.max()))


def longest_step(problem: WearProblem, state: State) -> float:
    """The longest step, cycles, that a loop with an eye on its error could take.

    From the estimate on the length is doubled as long as steps half as long lead to the same
    pressure: late in a run the slip zone carries next to nothing, and cells that wear too much
    lose their pressure and stay as they are.
    """
    length = estimated_step(problem, state)
    for _ in range(_DOUBLINGS):
        if not _is_stable(problem, state, 2.0 * length):
            break
        length *= 2.0
    return length


def _is_stable(problem: WearProblem, state: State, cycles: float) -> bool:
    """Whether steps of so many cycles and steps half as long lead to the same pressure."""
    pressures = []
    for parts in (1, 2):
        loop = own_loop(problem, state)
        try:
            for _ in range(parts * _TRIAL_STEPS):
                loop.step(cycles / parts)
            loop.step(0.0)
        except ContactError:
            return False
        pressures.append(loop.pressure)
    return bool(np.abs(pressures[0] - pressures[1]).sum() < _DIFFERENT * pressures[1].sum())


def own_loop(problem: WearProblem, state: State) -> Loop:
    """The explicit loop with this simulator's own contact solver, from a state of its run."""
    bodies = problem.half_space(state.geometry)

    def solve(shape: Array, load: float, start: Array) -> Pressed:
        contact = solve_contact(ContactProblem(bodies, shape, load), start)
        return Pressed(contact.pressure, contact.gap + contact.approach - shape)

    return Loop(
        problem,
        state.geometry,
        solve,
        solve,
        state.wear,
        state.pressure,
        state.reduced.pressure,
    )


def peer_loop(peers: tuple[Peer, Peer], problem: WearProblem, state: State) -> Loop:
    """The loop with a peer, from a state of this simulator's run."""
    window = peers[0].window
    quarter = Grid((window.shape[0] // 2, window.shape[1] // 2), window.spacing)

    def whole(field: Array) -> Array:
        return unfolded(state.geometry.resized(field, quarter))

    return Loop(
        problem,
        window,
        peers[0].solve,
        peers[1].solve,
        whole(state.wear),
        whole(state.pressure),
        whole(state.reduced.pressure),
    )


def timed_steps(loop: Loop, cycles: float, count: int) -> float:
    """Median processor time, s, of warm steps; the first is not timed."""
    loop.step(cycles)
    times = []
    for _ in range(count):
        started = time.process_time()
        loop.step(cycles)
        times.append(time.process_time() - started)
    return median(times)


def along(cycles: Array, values: Sequence[float]) -> Array:
    """Values between those at `CYCLES`: a power law of the cycles from each to the next."""
    at, points = np.log(np.array(CYCLES) + _FIRST_CYCLES), np.log(cycles + _FIRST_CYCLES)
    result: Array = np.exp(np.interp(points, at, np.log(values)))
    return result


def whole_run(lengths: Sequence[float], seconds: Sequence[float]) -> tuple[float, float]:
    """Steps and seconds of an explicit run: ∫ dN / ΔN and ∫ t dN / ΔN by the trapezoidal rule."""
    cycles = np.geomspace(_FIRST_CYCLES, CYCLES[-1] + _FIRST_CYCLES, 2000) - _FIRST_CYCLES
    density = 1.0 / along(cycles, lengths)
    spent = density * along(cycles, seconds)
    return float(np.trapezoid(density, cycles)), float(np.trapezoid(spent, cycles))


def compare(cells_on_radius: float = 128.0, steps: int = 3) -> dict[str, Any]:
    """This simulator's whole run beside the extrapolated runs of the peers, one thread each."""
    case = smooth_case(cells_on_radius, slip_model="jaeger")  # as the loops have it
    problem = simulate.wear_problem(case, Grid)
    own = []
    for _ in range(3):
        started = time.process_time()
        state = deque(evolve(problem, [float(case.cycles)], case.tolerance), maxlen=1)[0]
        own.append(time.process_time() - started)
    coarse_case = smooth_case(min(cells_on_radius, _TRIAL_CELLS), slip_model="jaeger")
    trial = simulate.wear_problem(coarse_case, Grid)
    states, coarse = (
        [s for s in evolve(of, CYCLES[1:], case.tolerance) if s.cycle in CYCLES]
        for of in (problem, trial)
    )
    # The estimate goes with the spacing; how far beyond it a loop can go is found on fewer cells.
    lengths = [
        estimated_step(problem, state) * longest_step(trial, few) / estimated_step(trial, few)
        for state, few in zip(states, coarse, strict=True)
    ]
    nx, ny = states[-1].geometry.shape
    window = Grid((2 * nx, 2 * ny), problem.spacing, even=(False, False))
    rows = []
    for kind in PEERS:
        tolerance = tuned(kind, TUNING_CELLS)
        full, reduced = (
            kind(window, problem.bodies.composite_modulus, tolerance) for _ in range(2)
        )
        seconds = [
            timed_steps(peer_loop((full, reduced), problem, state), length, steps)
            for state, length in zip(states, lengths, strict=True)
        ]
        total, spent = whole_run(lengths, seconds)
        rows.append({"name": kind.title(), "steps": total, "seconds": spent})
    return {"own": {"steps": state.step, "cpu": median(own)}, "peers": rows}
