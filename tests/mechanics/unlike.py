"""Bodies of different materials under loads that rise in steps, with friction from the start.

Pressure p drags such bodies over each other, and a traction q lifts them apart, in proportion to
Dundurs' β (Johnson 1985, section 5.4):

    u = β/(πE*) ∬ (x, y)/r² p dA,        w = −β/(πE*) ∬ (x, y)/r² · q dA.

Slip begins with the normal load alone (Spence 1975, "The Hertz contact problem with finite
friction", J. Elasticity 5), and depends on the way to it: each step of the load is a contact with
friction of its own, from the tractions of the step before. In a step, pressure and traction are
solved in turn until both agree.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.contact.cells import Contact, ContactError, ContactProblem
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import solve_contact
from fretwear.mechanics.slip.coupled import Sheared, shear
from fretwear.mechanics.slip.shear import bodies_under_shear

_LARGEST_SWEEPS = 60
_CONTACT, _SHEAR = 1e-8, 1e-6


class UnlikeContact:
    """The contact of two materials on a whole window, from no load on.

    ``modulus`` is E*, Pa, ``coupling`` κ, ``beta`` Dundurs' β, of which the sign decides whether
    pressure drags the surfaces inward or outward, and ``shape`` the gap at no load, m. Once loaded,
    ``contact`` and ``sheared`` are pressure and gap, and traction, slip and displacement of the
    last step.
    """

    contact: Contact
    sheared: Sheared

    def __init__(
        self,
        geometry: Grid,
        modulus: float,
        coupling: float,
        beta: float,
        friction: float,
        shape: Array,
    ) -> None:
        if any(geometry.even):
            raise ValueError("tractions of unlike bodies are even along no axis")
        self._geometry, self._modulus, self._beta = geometry, modulus, beta
        self._half_space, self._friction, self._shape = (
            geometry.half_space(modulus),
            friction,
            shape,
        )
        self._bodies = bodies_under_shear(self._half_space, coupling)
        self._pressure, self._traction = np.zeros_like(shape), np.zeros((2, *shape.shape))

    @cached_property
    def _spectra(self) -> Array:
        """Transforms of the displacement along x and y by a cell, on the window with zeros.

        The integral of x/r² over a cell has the primitive ½ y ln r² + x arctan(y/x).
        """
        (nx, ny), (dx, dy) = self._geometry.shape, self._geometry.spacing
        x = (np.arange(-nx, nx + 1) - 0.5)[:, None] * dx
        y = (np.arange(-ny, ny + 1) - 0.5)[None, :] * dy
        logarithm = np.log(x**2 + y**2)
        corners = (
            0.5 * y * logarithm + x * np.arctan(y / x),
            0.5 * x * logarithm + y * np.arctan(x / y),
        )
        cells = [np.diff(np.diff(corner, axis=0), axis=1) for corner in corners]
        cells = [np.fft.ifftshift(cell) * self._beta / (np.pi * self._modulus) for cell in cells]
        return np.asarray(np.fft.rfft2(np.stack(cells)))

    def _convolved(self, fields: Array) -> Array:
        """Pairs of fields with the displacements along x and y of a cell, shape (2, nx, ny)."""
        nx, ny = self._geometry.shape
        padded = 2 * nx, 2 * ny
        result = np.fft.irfft2(self._spectra * np.fft.rfft2(fields, padded), padded)
        return np.asarray(result[:, :nx, :ny])

    def load(self, load: float, force: float = 0.0, tolerance: float = 1e-5) -> None:
        """Bring the load, N, and the force along x, N, to values in one step.

        ``tolerance`` is the change of traction in the last sweep over the largest µp.
        """
        before, traction = self._traction, self._traction
        stored = self._bodies.displacement(before) + self._convolved(self._pressure[None])
        pressure = self._pressure
        for _ in range(_LARGEST_SWEEPS):
            lift = self._convolved(traction).sum(axis=0)
            problem = ContactProblem(self._half_space, self._shape - lift, load)
            start = pressure if pressure.any() else None
            self.contact = solve_contact(problem, start, _CONTACT)
            pressure, last = self.contact.pressure, traction
            bound = self._friction * pressure
            offset = stored - self._convolved(pressure[None])
            self.sheared = shear(
                self._bodies, bound, force, start=traction, tolerance=_SHEAR, offset=offset
            )
            traction = self.sheared.traction
            if np.abs(traction - last).max() <= tolerance * bound.max():
                self._pressure, self._traction = pressure, traction
                return
        raise ContactError("pressure and traction of unlike bodies did not settle")
