"""Contacts on which solvers have stalled, from seeds: rough and capped, on small windows."""

import numpy as np

from fretwear.mechanics.contact.cells import ContactProblem
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import solve_contact

from .problems import EVEN

RATIOS = np.linspace(0.015, 0.995, 60)


def hard_contact(seed):
    """Normal contact under a unit load, its pressure, and κ, which is one in most of them."""
    random = np.random.default_rng(seed)
    even = EVEN[seed % 4]
    cells = tuple(int(n) // (2 if one else 1) for n, one in zip((24, 20), even, strict=True))
    grid = Grid(cells, (0.11, 0.13), even)
    x, y = grid.x[:, None], grid.y
    shape = 0.5 * (x**2 + random.choice([0.6, 1.0]) * y**2)
    for wavenumber in 10 ** random.uniform(0.5, 1.2, 12):
        angle, *phases = random.uniform(0.0, 2.0 * np.pi, 3)
        k_x, k_y = wavenumber * np.cos(angle), wavenumber * np.sin(angle)
        waves = np.cos(k_x * x + phases[0] * (not even[0])) * np.cos(
            k_y * y + phases[1] * (not even[1])
        )
        shape = shape + random.choice([0.0, 0.02, 0.1]) * waves / wavenumber
    problem = ContactProblem(grid.half_space(1.0), shape, 1.0)
    pressure = solve_contact(problem, tolerance=1e-9).pressure
    if random.random() < 0.3:
        capped = ContactProblem(problem.half_space, shape, 1.0, 0.6 * float(pressure.max()))
        pressure = solve_contact(capped, tolerance=1e-8).pressure
    return problem, pressure, float(random.choice([1.0, 1.0, random.uniform(1.0, 1.4)]))
