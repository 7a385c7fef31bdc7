"""Elastic constants of two bodies in contact, combined into those of one half-space.

Every function takes Young's modulus E, Pa, and Poisson's ratio ν, in (-1, 0.5], of the bodies; a
rigid body is approximated by a large modulus. A modulus that is not positive, or a ratio out of
range, raises a ValueError.

References
----------
R. D. Mindlin (1949), Compliance of elastic bodies in contact, J. Appl. Mech. 16, 259–268.
K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, chapters 4 and 7.
"""

import math


def require_positive(**values: float) -> None:
    """Raise a ValueError naming the first value that is not a positive, finite number."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} is {value!r}, but must be a positive, finite number")


def composite_modulus(
    youngs_modulus_1: float, poisson_ratio_1: float, youngs_modulus_2: float, poisson_ratio_2: float
) -> float:
    """Modulus of normal contact, 1/E* = (1 - ν1²)/E1 + (1 - ν2²)/E2, in Pa: Johnson, eq. 4.31."""
    bodies = (youngs_modulus_1, poisson_ratio_1), (youngs_modulus_2, poisson_ratio_2)
    for number, (modulus, ratio) in enumerate(bodies, start=1):
        require_positive(**{f"youngs_modulus_{number}": modulus})
        if not -1.0 < ratio <= 0.5:
            raise ValueError(
                f"poisson_ratio_{number} is {ratio!r}, but a Poisson's ratio lies in (-1, 0.5]"
            )
    return 1.0 / sum((1.0 - ratio**2) / modulus for modulus, ratio in bodies)


def coupling_ratio(
    youngs_modulus_1: float,
    poisson_ratio_1: float,
    youngs_modulus_2: float,
    poisson_ratio_2: float,
    weight: float = 0.5,
) -> float:
    """Tangential over normal compliance, κ = E*/G*; (2 - ν)/(2 (1 - ν)) for equal bodies.

    The modulus of tangential contact is 1/G* = (2 - ν1)/4G1 + (2 - ν2)/4G2: Mindlin (1949). A
    traction q distributed like a normal pressure p moves the surfaces by the normal displacement
    times κ; exact for the circular contact of a sphere on its average over directions, and
    pointwise where the anisotropy of the tangential kernel is neglected. A traction moves what lies
    in its own direction more than what lies beside it, which in other contacts has another weight w
    than 1/2: 1/G* = (1 - ν1 + w ν1)/2G1 + …; see `EllipticContact.shear_weights`.
    """
    # (2 − ν)/4G with G = E/(2 (1 + ν)).
    bodies = (youngs_modulus_1, poisson_ratio_1), (youngs_modulus_2, poisson_ratio_2)
    normal, beside = composite_modulus(*bodies[0], *bodies[1]), 2.0 * (1.0 - weight)
    shear = 1.0 / sum(
        (2.0 - beside * ratio) * (1.0 + ratio) / (2.0 * modulus) for modulus, ratio in bodies
    )
    return normal / shear
