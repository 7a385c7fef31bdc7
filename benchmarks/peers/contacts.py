"""tamaas, ContactMechanics and aspher as contact solvers.

They are driven as their documentation says for a contact that is not periodic: tamaas with its
operator for free surfaces, named to the solver; ContactMechanics with its free half-space; aspher
with nested grids, in double precision, by its exact convolution.

`compare` lets everyone solve the same cold contact: shape in, pressure out, equal residual. Each
peer has the largest tolerance with which it reaches the residual.
"""

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import version
from statistics import median
from typing import Any, ClassVar

import numpy as np
from benchmarks.study_contacts import SELF_AFFINE, WAVES, study_case
from tests.mechanics.problems import unfolded

from fretwear.arrays import Array
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactProblem, solve_contact
from fretwear.run import states

_ITERATIONS = 20_000


class Peer(ABC):
    """Another library's elastic contact on a whole window.

    Parameters
    ----------
    window
        The cells.
    modulus
        E*, Pa.
    tolerance
        Tolerance of the library's own measure of the error.
    """

    name: ClassVar[str]

    def __init__(self, window: Grid, modulus: float, tolerance: float) -> None:
        if any(window.even):
            raise ValueError("peers solve contacts on whole windows")
        self.window = window
        self.tolerance = tolerance
        self.lengths = [2 * extent for extent in window.extent]
        self._make(modulus)

    @classmethod
    def title(cls) -> str:
        """Name and version."""
        return f"{cls.name} {version(cls.name)}"

    @abstractmethod
    def _make(self, modulus: float) -> None:
        """The data of the bodies and the window, without the shape."""

    @abstractmethod
    def solve(self, shape: Array, load: float, limit: float = math.inf) -> Array:
        """The pressure, Pa, of a shape, m, under a load, N; the body bears no more than a limit."""


class Tamaas(Peer):
    """The solver of Polonsky, Keer and Rey."""

    name = "tamaas"

    def _make(self, modulus: float) -> None:
        import tamaas

        tamaas.set_log_level(tamaas.LogLevel.error)
        kind = tamaas.model_type.basic_2d
        self._model = tamaas.ModelFactory.createModel(kind, self.lengths, self.window.shape)
        # The operator keeps the modulus that the model has when it is registered.
        self._model.E, self._model.nu = modulus, 0.0
        tamaas.ModelFactory.registerNonPeriodic(self._model, "free")

    def solve(self, shape: Array, load: float, limit: float = math.inf) -> Array:
        import tamaas

        if limit < math.inf:
            raise ValueError("this driver of tamaas is for elastic contact")
        self._model.traction[...] = 0.0
        # The solver looks at this surface as long as it lives.
        surface = np.ascontiguousarray(-shape)
        solver = tamaas.PolonskyKeerRey(self._model, surface, self.tolerance)
        solver.setIntegralOperator("free")
        solver.max_iter = _ITERATIONS
        error = solver.solve(load / (self.lengths[0] * self.lengths[1]))
        if not error <= self.tolerance:
            raise RuntimeError(f"tamaas stopped at {error:.1e}, not {self.tolerance:.0e}")
        return np.array(self._model.traction)


class ContactMechanics(Peer):
    """The constrained conjugate gradients of Polonsky and Keer."""

    name = "ContactMechanics"

    def _make(self, modulus: float) -> None:
        from ContactMechanics import FreeFFTElasticHalfSpace

        self._bodies: Any = FreeFFTElasticHalfSpace(self.window.shape, modulus, tuple(self.lengths))

    def solve(self, shape: Array, load: float, limit: float = math.inf) -> Array:
        from ContactMechanics.Systems import NonSmoothContactSystem
        from SurfaceTopography import Topography

        nx, ny = self.window.shape
        surface = Topography(-shape, tuple(self.lengths), periodic=False)
        result = NonSmoothContactSystem(self._bodies, surface).minimize_proxy(
            external_force=load,
            # Of one cell, N, like the forces.
            hardness=limit * self.window.unit_area if limit < math.inf else None,
            pentol=self.tolerance * float(np.ptp(shape)),
            forcetol=1e-9 * load,
            maxiter=_ITERATIONS,
        )
        if not result.success:
            raise RuntimeError(f"ContactMechanics did not converge: {result.message}")
        return np.array(result.jac[:nx, :ny]) / self.window.unit_area


class Aspher(Peer):
    """The preconditioned conjugate gradients of Polonsky and Keer from coarse grids to fine ones."""

    name = "aspher"

    def _make(self, modulus: float) -> None:
        if len({*self.lengths}) > 1:
            raise ValueError("aspher has square windows")
        self._modulus = modulus

    def solve(
        self, shape: Array, load: float, limit: float = math.inf, start: Array | None = None
    ) -> Array:
        import aspher

        if limit < math.inf:
            raise ValueError("aspher solves elastic contacts")
        sizes = {"grid_size": len(shape), "domain_size": self.lengths[0], "E_star": self._modulus}
        contact = {
            "gap": np.ascontiguousarray(shape).ravel(),
            "p_nominal": load / (self.lengths[0] * self.lengths[1]),
            "tol": self.tolerance,
        }
        if start is None:
            result = aspher.solve_nested(**sizes, **contact, backend="fft")
        else:
            solver = aspher.ContactSolver(**sizes, backend="fft")
            result = solver.solve(**contact, p_init=start.ravel(), precond="fourier-fft")
        if not result.converged:
            raise RuntimeError("aspher did not converge")
        return np.array(result.pressure, np.float64).reshape(shape.shape)


PEERS: tuple[type[Peer], ...] = (Tamaas, ContactMechanics)


def pressed_by(kind: type[Peer], problem: ContactProblem, modulus: float) -> Array:
    """The pressure, Pa, with which a peer solves a contact without a layer."""
    peer = kind(problem.half_space.geometry, modulus, tolerance=1e-9)
    return peer.solve(problem.shape, problem.load, problem.limit)


def residual(problem: ContactProblem, pressure: Array) -> float:
    """Largest violation of the gap conditions relative to the largest displacement.

    Computed here from nothing but the pressure, by one convolution, for all solvers alike.
    """
    displacement = problem.half_space.displacement(pressure)
    loaded = pressure > 0
    separation = displacement + problem.shape
    gap = separation - separation[loaded].mean()
    worst = max(float(np.abs(gap[loaded]).max()), -float(gap[~loaded].min(initial=0.0)))
    missing = abs(float(pressure.sum()) / problem.total - 1.0)
    return max(worst / float(displacement.max()), missing)


RESIDUAL = 1e-6
TUNING_CELLS = 128
_WORN = 0.01  # depth of the wear step over the largest displacement
CONTACTS: dict[str, dict[str, Any]] = {
    "smooth": {},
    "wavy": {"roughness": WAVES},
    "self-affine": {"roughness": SELF_AFFINE},
}
_MARGIN = {"smooth": 1.15}  # half-width of the window over the Hertz radius
_ROUGH_MARGIN = 1.4
_LADDER = tuple(10.0 ** (-0.5 * step) for step in range(8, 21))

Solver = Callable[[], Array]
"""Makes everything that it needs and returns the pressure, Pa, on the whole window."""


def cold(kind: str, cells: int, *, quarter: bool) -> ContactProblem:
    """A first loading on so many whole cells along x and y."""
    case = study_case(**CONTACTS[kind])
    problem = states.wear_problem(case)
    width = _MARGIN.get(kind, _ROUGH_MARGIN) * case.hertz_radius
    count = cells // 2 if quarter else cells
    window = Grid((count, count), (2 * width / cells, 2 * width / cells), (quarter, quarter))
    bodies = window.half_space(problem.bodies.composite_modulus)
    return ContactProblem(bodies, problem.unworn(window), problem.hertz.load)


def warm(problem: ContactProblem) -> tuple[ContactProblem, dict[str, Array]]:
    """The contact after a wear step, with its former pressure as the start.

    The step wears the point of highest pressure by 1 % of the largest displacement.
    """
    contact = solve_contact(problem, tolerance=0.01 * RESIDUAL)
    deepest = _WORN * float(problem.half_space.displacement(contact.pressure).max())
    shape = problem.shape + deepest * contact.pressure / contact.pressure.max()
    return replace(problem, shape=shape), {"start": contact.pressure}


def own(problem: ContactProblem, start: dict[str, Array]) -> Solver:
    """This simulator's solver, on the quarter or on the whole window."""
    window, modulus = problem.half_space.geometry, problem.half_space.modulus

    def solve() -> Array:
        bodies = window.half_space(modulus)
        contact = solve_contact(replace(problem, half_space=bodies), **start, tolerance=RESIDUAL)
        return unfolded(contact.pressure, window.even)

    return solve


def other(
    peer: type[Peer], problem: ContactProblem, start: dict[str, Array], tolerance: float
) -> Solver:
    """A peer on the whole window."""
    bodies = problem.half_space

    def solve() -> Array:
        solver = peer(bodies.geometry, bodies.modulus, tolerance)
        return solver.solve(problem.shape, problem.load, **start)

    return solve


def tuned(
    peer: type[Peer], problem: ContactProblem, start: dict[str, Array], largest: float = 1.0
) -> float:
    """The largest tolerance, up to another one, with which a peer reaches the residual."""
    for tolerance in (each for each in _LADDER if each <= largest):
        if residual(problem, other(peer, problem, start, tolerance)()) <= RESIDUAL:
            return tolerance
    return _LADDER[-1]


def compare(
    kind: str, cells: int, peers: Sequence[type[Peer]], repeats: int = 3, *, worn: bool = False
) -> list[dict[str, Any]]:
    """Median processor seconds and residual of everyone, who solve in turn; ours first.

    They solve the first loading, or the contact a wear step later from its pressure.
    """
    if Tamaas in peers:
        import tamaas

        tamaas.initialize(1)

    def contact(cells: int, *, quarter: bool = False) -> tuple[ContactProblem, dict[str, Array]]:
        first = cold(kind, cells, quarter=quarter)
        return warm(first) if worn else (first, {})

    whole = problem, _ = contact(cells)
    solvers = {"fretwear, whole window": own(*whole)}
    if kind != "self-affine":
        solvers["fretwear, quarter"] = own(*contact(cells, quarter=True))
    for peer in peers:
        on_few = tuned(peer, *contact(min(cells, TUNING_CELLS)))
        solvers[peer.title()] = other(peer, *whole, tuned(peer, *whole, on_few))
    residuals = {name: residual(problem, solve()) for name, solve in solvers.items()}
    seconds: dict[str, list[float]] = {name: [] for name in solvers}
    for _ in range(repeats):
        for name, solve in solvers.items():
            started = time.process_time()
            solve()
            seconds[name].append(time.process_time() - started)
    return [
        {"name": name, "contact": kind, "cells": cells, "residual": residuals[name],
         "cpu": median(spent)}
        for name, spent in seconds.items()
    ]  # fmt: skip
