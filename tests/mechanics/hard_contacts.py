"""Contacts on which solvers have stalled, and their like, from seeds: on small windows."""

import numpy as np

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactProblem, solve_contact
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.contact.strips import Strips
from fretwear.mechanics.slip.models import WearLayer, WinklerLayer

from .problems import EVEN

RATIOS = np.linspace(0.015, 0.995, 60)
# At 1 to 6 of these ratios, Newton's method without a fallback has stalled on each of them.
SEEDS = [
    *(24, 28, 48, 56, 69, 72, 75, 76, 82, 83, 84, 92, 104, 122, 130, 137, 152, 172, 178, 180),
    *(184, 196, 200, 202, 206, 221, 250, 268, 284, 289, 291, 296, 298, 306, 312, 331, 332, 336),
    *(340, 341, 354, 378, 392),
]


def hard_contact(seed):
    """A rough normal contact on a grid, and its pressure, capped in some of them."""
    random = np.random.default_rng(seed)
    even = EVEN[seed % 4]
    whole = random.choice([10, 12, 14], 2)
    cells = tuple(int(n) // (2 if one else 1) for n, one in zip(whole, even, strict=True))
    grid = Grid(cells, tuple(2.4 / whole), even)
    x, y = grid.x[:, None], grid.y
    shape = 0.5 * (x**2 + random.choice([0.6, 1.0]) * y**2)
    roughness = random.choice([0.0, 0.02, 0.1])
    for wavenumber in 10 ** random.uniform(0.5, 1.2, 12):
        angle, *phases = random.uniform(0.0, 2.0 * np.pi, 3)
        k_x, k_y = wavenumber * np.cos(angle), wavenumber * np.sin(angle)
        waves = np.cos(k_x * x + phases[0] * (not even[0])) * np.cos(
            k_y * y + phases[1] * (not even[1])
        )
        shape = shape + roughness * waves / wavenumber
    problem = ContactProblem(grid.half_space(1.0), shape, random.uniform(0.3, 1.0))
    pressure = solve_contact(problem, tolerance=1e-9).pressure
    if random.random() < 0.3:
        limit = 0.6 * float(pressure.max())
        capped = ContactProblem(problem.half_space, shape, problem.load, limit)
        pressure = solve_contact(capped, tolerance=1e-8).pressure
    return problem, pressure


def hard_family(seed):
    """Normal contacts by their load or approach over the largest: rough, capped, with layers."""
    random = np.random.default_rng([seed, 1])
    if seed % 3:
        edges = tuple(np.append(0.0, np.cumsum(random.uniform(0.03, 0.1, 20))))
        cells = Rings(edges) if seed % 3 == 1 else Strips(edges, 1.0)
        half_space, load = cells.half_space(1.0), random.uniform(0.1, 0.5)
        x = cells.x[:, None]
        shape = 0.5 * x**2 + random.choice([0.0, 0.004, 0.02]) * random.standard_normal(x.shape)
    else:
        problem, _ = hard_contact(seed)
        half_space, shape, load = problem.half_space, problem.shape, problem.load
        x = half_space.geometry.x[:, None]
    elastic = solve_contact(ContactProblem(half_space, shape, load), tolerance=1e-9)
    top, zero = float(elastic.pressure.max()), np.zeros(shape.shape)
    gap, rate = random.uniform(0.0, 0.2, shape.shape), random.uniform(0.1, 2.0) / top
    outside = 1.0 * (np.abs(x) > 0.3) + zero
    layers = [
        None,
        WinklerLayer(random.uniform(0.0, 20.0, shape.shape) * half_space.self_influence, zero),
        WearLayer(zero, gap * outside, None, zero, rate),
        WearLayer(zero, gap, 0.3 * random.uniform(-0.1, 0.1, shape.shape), zero, rate),
    ]
    if seed % 3:
        level = elastic.approach
        layers.append(WearLayer(zero, gap * outside, zero, zero, rate, -outside, level))
    layer = layers[random.integers(len(layers))]
    limit = np.inf
    if random.random() < 0.6:
        limit = random.uniform(0.5, 0.9, shape.shape) * top
    held = layer is None or getattr(layer, "response", None) is None
    if held and random.random() < 0.4:
        depth = float(elastic.approach - shape.min())
        return lambda ratio: ContactProblem(
            half_space, shape, None, limit, layer, float(shape.min()) + ratio * depth
        )
    return lambda ratio: ContactProblem(half_space, shape, ratio * load, limit, layer)
