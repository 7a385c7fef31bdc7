"""Stresses of an elastic half-space under uniform tractions on a cell.

With the distance ρ from a point of the surface, the potentials 1/ρ, ln(ρ + z) and z ln(ρ + z) − ρ
of Boussinesq and Cerruti give the stresses of a point load: K. L. Johnson (1985), Contact
Mechanics, Cambridge University Press, chapter 3. On a rectangle each is the double difference of a
function of its corners: Love, "The stress produced in a semi-infinite solid by pressure on part of
the boundary", Phil. Trans. R. Soc. A 228 (1929); Ahmadi, Keer and Mura, "Non-Hertzian contact
stress analysis for an elastic half space", Int. J. Solids Struct. 23 (1987). Strips of infinite
length are the limit of long rectangles: plane strain, σ_yy = ν (σ_xx + σ_zz).

On the surface the functions have limits, of which those inside a cell hold at its centre; on an
edge across x, where the shear traction has a step, σ_xx grows like the logarithm of the distance.

Results have the shape (2, 6, …), the arguments' shape last: stresses of a unit of pressure and of a
unit of shear traction along x, in the order of `COMPONENTS`; `z` is the depth, m.
"""

from __future__ import annotations

import numpy as np

from fretwear.arrays import Array

COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")
"""Order of the components of a stress tensor."""

ODD = (
    ((0, 0), (0, 0), (0, 0), (1, 1), (1, 0), (0, 1)),
    ((1, 0), (1, 0), (1, 0), (0, 1), (0, 0), (1, 1)),
    ((0, 1), (0, 1), (0, 1), (1, 0), (1, 1), (0, 0)),
)
"""Whether the components are odd along x and along y, of pressure and of shear along x and y."""


TURNED = (1, 0, 2, 3, 5, 4)
"""The components after x and y are exchanged."""


def of_rectangles(x: Array, y: Array, z: Array | float, poisson_ratio: float) -> Array:
    """Stresses of cells between corners, seen from points.

    `x`, shape (..., nx + 1, 1), and `y`, shape (..., 1, ny + 1), are the positions of the points
    relative to the corners, m, where they grow; the result has the shape (2, 6, ..., nx, ny).
    """
    nu = poisson_ratio
    square_x, square_y = x * x + z * z, y * y + z * z
    distance = np.sqrt(square_x + y * y)
    xy = x * y
    # Terms that vanish in a difference along either axis are left out. On an edge, at the surface,
    # bounded functions have the mean of both sides.
    with np.errstate(divide="ignore", invalid="ignore"):
        over_x, over_y = (
            np.where(square > 0.0, z / (distance * square), 0.0) for square in (square_x, square_y)
        )
        along_x, along_y = np.arcsinh(x / np.sqrt(square_y)), np.arcsinh(y / np.sqrt(square_x))
        inverse = np.where(distance > 0.0, 1.0 / (distance + z), 0.0)
        near = np.where(distance > 0.0, z / distance, 0.0)
        logarithm = np.log(distance + z)
    solid_angle = np.arctan2(xy, z * distance)
    flat = xy * (x * x + y * y) * inverse
    # The integral of ∂²ln(ρ + z)/∂x² over the rectangle, and that along y.
    bent_x = np.arctan2(flat, x * x * distance + y * y * z)
    bent_y = np.arctan2(flat, y * y * distance + x * x * z)
    stress = np.empty((2, 6, *distance.shape))
    normal, shear = stress
    normal[0] = -2.0 * nu * solid_angle - (1.0 - 2.0 * nu) * bent_x + xy * over_x
    normal[1] = -2.0 * nu * solid_angle - (1.0 - 2.0 * nu) * bent_y + xy * over_y
    normal[2] = -solid_angle - xy * (over_x + over_y)
    normal[3] = -(1.0 - 2.0 * nu) * logarithm - near
    normal[4] = z * y * over_x
    normal[5] = z * x * over_y
    shear[0] = 2.0 * along_y + (2.0 * nu + near) * y * inverse - z * y * over_x
    shear[1] = 2.0 * nu * along_y - (2.0 * nu + near) * y * inverse
    shear[2] = z * y * over_x
    shear[3] = along_x - (2.0 * nu + near) * x * inverse
    shear[4] = xy * over_x - solid_angle
    shear[5] = -near
    with np.errstate(invalid="ignore"):
        return np.diff(np.diff(stress, axis=-2), axis=-1) / (2.0 * np.pi)


def of_strips(x: Array, z: Array | float, poisson_ratio: float) -> Array:
    """Stresses of strips between edges, as `of_rectangles`; `x` has the shape (..., nx + 1, 1)."""
    square = x * x + z * z
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(square > 0.0, z / square, 0.0)
        logarithm = np.log(square)
    angle = np.arctan2(x, z + 0.0 * x)
    stress = np.zeros((2, 6, *square.shape))
    normal, shear = stress
    normal[0] = x * share - angle
    normal[2] = -angle - x * share
    normal[4] = z * share
    shear[0] = -logarithm - z * share
    shear[2] = z * share
    shear[4] = x * share - angle
    stress[:, 1] = poisson_ratio * (stress[:, 0] + stress[:, 2])
    return np.diff(stress, axis=-2) / np.pi
