"""Pressures of Hertz as means over cells, of the contact radius a = 1 and the peak p0 = 1."""

import numpy as np

from fretwear.arrays import Array


def sphere(cells: float, radius: float = 1.0, count: int | None = None, divided: int = 4) -> Array:
    """Means over ``count`` x ``count`` cells of a quarter, ``cells`` on a, of peak ``radius``.

    Each is that of ``divided`` x ``divided`` places.
    """
    count = int(1.1 * cells) if count is None else count
    fine = (np.arange(count * divided) + 0.5) / divided / cells
    pressure = np.sqrt(np.maximum(radius**2 - fine[:, None] ** 2 - fine**2, 0.0))
    return pressure.reshape(count, divided, count, divided).mean(axis=(1, 3))


def cylinder(cells: float, radius: float = 1.0, count: int | None = None) -> Array:
    """Exact means over ``count`` strips of one side, shape (n, 1), of peak ``radius``."""
    count = int(cells) if count is None else count
    edges = np.minimum(np.arange(count + 1) / cells / radius, 1.0)
    integral = 0.5 * (edges * np.sqrt(1 - edges**2) + np.arcsin(edges))
    return radius**2 * np.diff(integral)[:, None] * cells
