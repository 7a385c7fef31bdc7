"""TR-BDF2: two implicit stages of one weight, second order, L-stable, and an embedded third order.

Due to Bank et al., "Transient simulation of silicon devices and circuits", IEEE Trans. Electron
Devices 32 (1985); coefficients and embedded weights as in Hosea and Shampine, "Analysis and
implementation of TR-BDF2", Appl. Numer. Math. 20 (1996).
"""

from __future__ import annotations

from math import isfinite, sqrt

# First stage at γ = 2 − √2; both stages are implicit with the same weight, which makes them alike.
GAMMA = 2.0 - sqrt(2.0)
DIAGONAL = 0.5 * GAMMA
WEIGHT = 0.25 * sqrt(2.0)
MAIN = (WEIGHT, WEIGHT, DIAGONAL)
EMBEDDED = ((1.0 - WEIGHT) / 3.0, (3.0 * WEIGHT + 1.0) / 3.0, DIAGONAL / 3.0)

SMALLEST_STEP = 1e-6
ACCEPTED = 1.2
FACTORS = (0.2, 5.0)
# The embedded formulas differ from the step by about ten times its error in wear volume, as runs
# with far smaller steps show; a third of the difference is still on the safe side.
OVERESTIMATE = 3.0
_SAFETY = 0.85


def assessed(error: float) -> tuple[float, bool]:
    """What to multiply a step by for its error in units of the tolerance; whether to keep it."""
    if not isfinite(error):
        return FACTORS[0], False
    factor = _SAFETY * max(error, 1e-6) ** (-1.0 / 3.0)
    return min(max(factor, FACTORS[0]), FACTORS[1]), error <= ACCEPTED


def step_towards(left: float, wanted: float) -> float:
    """The step of the length wanted, or one that divides what is left to a stop evenly."""
    return left if wanted >= left else min(wanted, max(0.5 * left, 0.5 * wanted))


def step_after(step: float, factor: float, wanted: float) -> float:
    """The length wanted after an accepted step, by the factor of its error."""
    if step < wanted and factor >= 1.0:
        # A stop cut the step short; that says nothing about the one that follows.
        return max(step * factor, wanted)
    return step * factor
