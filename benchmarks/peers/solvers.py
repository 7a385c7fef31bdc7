"""tamaas and ContactMechanics as contact solvers that keep what a next solve can use.

Both are driven as their documentation says for a contact that is not periodic: tamaas with its
operator for free surfaces, named to the solver; ContactMechanics with its free half-space. A
solver object keeps model and Green's function. A warm start is the pressure of the solve before:
tamaas goes on from the traction in its model, ContactMechanics from the forces it is given.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, ClassVar

import numpy as np

from fretwear.mechanics.contact import ContactProblem
from fretwear.mechanics.geometry import Array
from fretwear.mechanics.geometry.grid import Grid

_ITERATIONS = 20_000


@dataclass(frozen=True)
class Pressed:
    """What a peer finds: pressure, Pa, and displacement, m but for a constant, on the window."""

    pressure: Array
    displacement: Array

    def gap(self, shape: Array) -> Array:
        """The gap, m, zero on the mean of the contact."""
        separation = self.displacement + shape
        gap: Array = separation - separation[self.pressure > 0].mean()
        return gap


class Peer(ABC):
    """Another library's elastic contact on a whole window.

    Parameters
    ----------
    window
        The cells.
    modulus
        E*, Pa.
    tolerance
        Of the library's own measure of the error.
    """

    name: ClassVar[str]
    settings: ClassVar[str]

    def __init__(self, window: Grid, modulus: float, tolerance: float) -> None:
        if window.quarter:
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
        """What belongs to the bodies and the window, not to the shape."""

    @abstractmethod
    def solve(self, shape: Array, load: float, start: Array | None = None) -> Pressed:
        """Press a shape, m, with a load, N; ``start`` is a pressure, Pa, to start from."""


class Tamaas(Peer):
    """The solver of Polonsky, Keer and Rey."""

    name = "tamaas"
    settings = "PolonskyKeerRey, pressure as the variable, operator of registerNonPeriodic"

    def _make(self, modulus: float) -> None:
        import tamaas

        tamaas.set_log_level(tamaas.LogLevel.error)
        kind = tamaas.model_type.basic_2d
        self._model = tamaas.ModelFactory.createModel(kind, self.lengths, self.window.shape)
        # The operator keeps the modulus that the model has when it is registered.
        self._model.E, self._model.nu = modulus, 0.0
        tamaas.ModelFactory.registerNonPeriodic(self._model, "free")

    def solve(self, shape: Array, load: float, start: Array | None = None) -> Pressed:
        import tamaas

        self._model.traction[...] = 0.0 if start is None else start
        # The solver looks at this surface as long as it lives.
        surface = np.ascontiguousarray(-shape)
        solver = tamaas.PolonskyKeerRey(self._model, surface, self.tolerance)
        solver.setIntegralOperator("free")
        solver.max_iter = _ITERATIONS
        error = solver.solve(load / (self.lengths[0] * self.lengths[1]))
        if not error <= self.tolerance:
            raise RuntimeError(f"tamaas stopped at {error:.1e}, not {self.tolerance:.0e}")
        return Pressed(np.array(self._model.traction), np.array(self._model.displacement))


class ContactMechanics(Peer):
    """The constrained conjugate gradients of Polonsky and Keer."""

    name = "ContactMechanics"
    settings = "minimize_proxy of a NonSmoothContactSystem on a FreeFFTElasticHalfSpace"

    def _make(self, modulus: float) -> None:
        from ContactMechanics import FreeFFTElasticHalfSpace

        self._bodies: Any = FreeFFTElasticHalfSpace(self.window.shape, modulus, tuple(self.lengths))

    def solve(self, shape: Array, load: float, start: Array | None = None) -> Pressed:
        from ContactMechanics.Systems import NonSmoothContactSystem
        from SurfaceTopography import Topography

        nx, ny = self.window.shape
        surface = Topography(-shape, tuple(self.lengths), periodic=False)
        forces = None
        if start is not None:
            # Forces of cells, N, negative in contact, on the padded window.
            forces = np.zeros(self._bodies.nb_subdomain_grid_pts)
            forces[:nx, :ny] = -self.window.unit_area * start
        result = NonSmoothContactSystem(self._bodies, surface).minimize_proxy(
            external_force=load,
            initial_forces=forces,
            pentol=self.tolerance * float(np.ptp(shape)),
            forcetol=1e-9 * load,
            maxiter=_ITERATIONS,
        )
        if not result.success:
            raise RuntimeError(f"ContactMechanics did not converge: {result.message}")
        pressure = np.array(result.jac[:nx, :ny]) / self.window.unit_area
        return Pressed(pressure, np.array(result.x[:nx, :ny]))


PEERS: tuple[type[Peer], ...] = (Tamaas, ContactMechanics)


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


def unfolded(field: Array) -> Array:
    """The whole of a field that is even in x and y, from its quarter x > 0, y > 0."""
    half = np.concatenate([field[::-1], field], axis=0)
    return np.concatenate([half[:, ::-1], half], axis=1)
