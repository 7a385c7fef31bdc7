"""The same contact by other libraries: tamaas and ContactMechanics, free half-space, no period.

Each is driven as its documentation says for a contact that is not periodic. Both press a rigid
surface on an elastic half-space with the composite modulus, on the same grid.
"""

import numpy as np

from fretwear.mechanics.contact import ContactProblem
from fretwear.mechanics.geometry import Array
from fretwear.mechanics.geometry.grid import Grid

_ITERATIONS = 20_000


def tamaas_pressure(problem: ContactProblem, modulus: float, tolerance: float = 1e-10) -> Array:
    """Pressure, Pa, by the Polonsky-Keer-Rey solver of tamaas.

    Parameters
    ----------
    problem
        An elastic contact on a whole window.
    modulus
        Composite modulus E*, Pa.
    tolerance
        Of the solver's own relative error.
    """
    import tamaas

    if np.isfinite(problem.limit):
        raise ValueError("this driver of tamaas is for elastic contact")
    tamaas.set_log_level(tamaas.LogLevel.error)
    window = _whole(problem)
    lengths = [2 * extent for extent in window.extent]
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, lengths, window.shape)
    # The operator keeps the modulus that the model has when it is registered.
    model.E, model.nu = modulus, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "free")
    surface = -problem.shape
    solver = tamaas.PolonskyKeerRey(model, surface, tolerance)
    # Registered alone it is not used: the problem would be solved with periodic images.
    solver.setIntegralOperator("free")
    solver.max_iter = _ITERATIONS
    error = solver.solve(problem.load / (lengths[0] * lengths[1]))
    if not error <= tolerance:
        raise RuntimeError(f"tamaas stopped at an error of {error:.1e}, not {tolerance:.0e}")
    return np.array(model.traction)


def contact_mechanics_pressure(
    problem: ContactProblem, modulus: float, tolerance: float = 1e-9
) -> Array:
    """Pressure, Pa, by the Polonsky-Keer solver of ContactMechanics.

    Parameters
    ----------
    problem
        A contact on a whole window; its limit is the hardness of the substrate.
    modulus
        Composite modulus E*, Pa.
    tolerance
        Largest penetration, relative to the height of the surface.
    """
    from ContactMechanics import make_system
    from SurfaceTopography import Topography

    window = _whole(problem)
    lengths = tuple(2 * extent for extent in window.extent)
    system = make_system(Topography(-problem.shape, lengths, periodic=False), young=modulus)
    # Hardness and forces are those of one cell, N.
    hardness = problem.limit * window.unit_area if np.isfinite(problem.limit) else None
    result = system.minimize_proxy(
        external_force=problem.load,
        hardness=hardness,
        pentol=tolerance * float(np.ptp(problem.shape)),
        forcetol=1e-12 * problem.load,
        maxiter=_ITERATIONS,
    )
    if not result.success:
        raise RuntimeError(f"ContactMechanics did not converge: {result.message}")
    nx, ny = window.shape
    return np.array(result.jac[:nx, :ny]) / window.unit_area


def _whole(problem: ContactProblem) -> Grid:
    window = problem.half_space.geometry
    if window.quarter or problem.layer is not None:
        raise ValueError("peers solve contacts on whole windows, without a layer")
    return window
