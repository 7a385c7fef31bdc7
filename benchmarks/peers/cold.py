"""The same cold contact by everyone: shape in, pressure out, equal residual."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from benchmarks.peers.solvers import PEERS, Peer, residual, unfolded
from benchmarks.speed.cases import MARGIN, study_case
from benchmarks.speed.units import Spent, Stopwatch, middle

from fretwear.mechanics.contact import ContactProblem, solve_contact
from fretwear.mechanics.geometry import Array
from fretwear.mechanics.geometry.grid import Grid
from fretwear.running import simulate

RESIDUAL = 1e-6
TUNING_CELLS = 128
_LADDER = tuple(10.0 ** (-0.5 * step) for step in range(8, 19))


@dataclass(frozen=True)
class Contestant:
    """Someone who can solve the contact from nothing.

    Parameters
    ----------
    name
        Of the library, with version and what it is given.
    settings
        How it is driven.
    solve
        Makes everything that it needs and returns the pressure, Pa, on the whole window.
    """

    name: str
    settings: str
    solve: Callable[[], Array]


def sphere(cells: int, *, quarter: bool = False, workers: int = 1) -> ContactProblem:
    """The smooth first loading on so many whole cells along x and y."""
    case = study_case()
    problem = simulate.wear_problem(case)
    width = MARGIN * case.hertz_radius
    count = cells // 2 if quarter else cells
    window = Grid((count, count), (2 * width / cells, 2 * width / cells), quarter)
    bodies = window.half_space(problem.bodies.composite_modulus, workers)
    return ContactProblem(bodies, problem.unworn(window), problem.load)


def own(cells: int, *, quarter: bool, workers: int) -> Contestant:
    """This simulator's solver, on the quarter or on the whole window."""

    def solve() -> Array:
        problem = sphere(cells, quarter=quarter, workers=workers)
        pressure = solve_contact(problem, tolerance=RESIDUAL).pressure
        return unfolded(pressure) if quarter else pressure

    part = "quarter" if quarter else "whole window"
    return Contestant(f"fretwear, {part}", f"solve_contact, tolerance {RESIDUAL:g}", solve)


def other(kind: type[Peer], cells: int, tolerance: float) -> Contestant:
    """A peer on the whole window."""
    problem = sphere(cells)
    modulus = simulate.wear_problem(study_case()).composite_modulus

    def solve() -> Array:
        peer = kind(problem.half_space.geometry, modulus, tolerance)
        return peer.solve(problem.shape, problem.load).pressure

    return Contestant(kind.title(), f"{kind.settings}, tolerance {tolerance:.1e}", solve)


def tuned(kind: type[Peer], cells: int, target: float = RESIDUAL) -> float:
    """The largest tolerance with which a peer reaches a residual, on so many cells."""
    problem = sphere(cells)
    for tolerance in _LADDER:
        if residual(problem, other(kind, cells, tolerance).solve()) <= target:
            return tolerance
    return _LADDER[-1]


@dataclass(frozen=True)
class Result:
    """Median times of one contestant, s, and the residual of its pressure."""

    name: str
    settings: str
    time: Spent
    residual: float

    def as_json(self) -> dict[str, Any]:
        times = {"cpu": self.time.cpu, "wall": self.time.wall}
        return {"name": self.name, "settings": self.settings, "residual": self.residual} | times


def compare(cells: int = 512, workers: int = 1, repeats: int = 3) -> list[Result]:
    """Everyone in turn, several times; the fastest of this simulator first.

    Each peer runs with the largest tolerance that gives the residual: found on fewer cells, made
    smaller here as long as it does not.
    """
    _threads(workers)
    problem = sphere(cells)
    contestants = [own(cells, quarter=quarter, workers=workers) for quarter in (True, False)]
    residuals = {}
    for kind in PEERS:
        tolerance = tuned(kind, min(cells, TUNING_CELLS))
        while True:
            peer = other(kind, cells, tolerance)
            residuals[peer.name] = residual(problem, peer.solve())
            if residuals[peer.name] <= RESIDUAL or tolerance < 1e-10:
                break
            tolerance /= math.sqrt(10.0)
        contestants.append(peer)
    for contestant in contestants[:2]:
        residuals[contestant.name] = residual(problem, contestant.solve())
    times: dict[str, list[Spent]] = {contestant.name: [] for contestant in contestants}
    for _ in range(repeats):
        for contestant in contestants:
            watch = Stopwatch()
            contestant.solve()
            times[contestant.name].append(watch.read())
    return [
        Result(one.name, one.settings, middle(times[one.name]), residuals[one.name])
        for one in contestants
    ]


def _threads(workers: int) -> None:
    """Tell tamaas how many threads to use; ContactMechanics has no such setting."""
    import tamaas

    tamaas.initialize(workers)
