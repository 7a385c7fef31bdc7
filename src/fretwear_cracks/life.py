"""Fatigue against wear: lives from the stresses of snapshots, and their damage summed by Miner.

A point of the flat keeps its place in the material: wear brings the surface towards it, and the
stresses below the surface with it, until it is removed. What is removed counts no more.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fretwear.arrays import Array, Mask

# Steps between two snapshots, over which wear and parameters change linearly.
_STEPS = 16
# Corrections by which the logarithm of a life converges to rounding.
_CORRECTIONS = 30


@dataclass(frozen=True)
class StrainLife:
    """Lives by the constants of Basquin and of Manson and Coffin.

    σ_a = σ_f' (2N)^b and ε_a,p = ε_f' (2N)^c with the number of cycles N to a crack. The
    parameter of Smith, Watson and Topper, the largest normal stress times the amplitude of normal
    strain, is then P = σ_f'²/E (2N)^(2b) + σ_f' ε_f' (2N)^(b + c).
    """

    fatigue_strength: float  #: σ_f', Pa
    strength_exponent: float  #: b, negative
    fatigue_ductility: float = 0.0  #: ε_f'; 0: strains are elastic
    ductility_exponent: float = -1.0  #: c, negative

    def cycles(self, parameter: Array, youngs_modulus: float) -> Array:
        """Cycles N to a crack at values P of the parameter, Pa; infinite where P is 0."""
        strength, b = self.fatigue_strength, self.strength_exponent
        terms = [(strength**2 / youngs_modulus, 2.0 * b)]
        if self.fatigue_ductility > 0.0:
            slope = b + self.ductility_exponent
            terms.append((strength * self.fatigue_ductility, slope))
        sought = np.log(np.maximum(parameter, np.finfo(np.float64).tiny))
        # Each term alone gives too short a life; from there Newton's method ascends to the root.
        lives = np.max([(sought - np.log(size)) / slope for size, slope in terms], axis=0)
        for _ in range(_CORRECTIONS if len(terms) > 1 else 0):
            sizes = [np.log(size) + slope * lives for size, slope in terms]
            total = np.logaddexp(*sizes)
            pairs = zip(sizes, terms, strict=True)
            lives = lives - (total - sought) / sum(t[1] * np.exp(of - total) for of, t in pairs)
        with np.errstate(over="ignore"):
            return np.asarray(np.where(parameter > 0.0, 0.5 * np.exp(lives), np.inf))


class Damage(NamedTuple):
    """Damage of points of the material, by Miner's sum; at 1 a crack is expected."""

    sums: Array  #: at each snapshot, of removed points until they were, shape (k, nx, n)
    removed: Mask  #: whether wear has removed a point at each snapshot, shape (k, nx, n)
    first_crack: Array  #: cycle at which the damage of a point reaches 1, or infinity, (nx, n)


def summed_damage(
    cycles: Array,
    parameters: Array,
    depths: Array,
    worn: Array,
    points: Array,
    life: StrainLife,
    youngs_modulus: float,
) -> Damage:
    """Miner's sum from the first to the last snapshot, of points at depths below the unworn flat.

    `parameters`, Pa, shape (k, nx, nz), are Smith, Watson and Topper's at `depths`, m, below
    the surface of each of the k snapshots, and `worn`, m, shape (k, nx), is what wear has taken off
    the flat since cycle 0; `points`, m, shape (n,), are depths below the flat as it was then.
    Closer to the surface than the first of the depths the value there counts.
    """
    steps = (np.arange(_STEPS) + 0.5) / _STEPS
    shape = (*worn.shape, points.size)
    sums, removed = np.zeros(shape), points <= worn[..., None]
    first_crack, damage = np.full(shape[1:], np.inf), np.zeros(shape[1:])
    for now in range(cycles.size - 1):
        of_step = (cycles[now + 1] - cycles[now]) / _STEPS
        for part in steps:
            surface, parameter = (
                (1.0 - part) * field[now] + part * field[now + 1] for field in (worn, parameters)
            )
            below = points - surface[:, None]
            there = [np.interp(z, depths, p) for z, p in zip(below, parameter, strict=True)]
            rate = 1.0 / life.cycles(np.array(there), youngs_modulus)
            added = np.where(below > 0.0, rate * of_step, 0.0)
            cracks = (damage < 1.0) & (damage + added >= 1.0)
            began = cycles[now] + (part - 0.5 / _STEPS) * (cycles[now + 1] - cycles[now])
            first_crack[cracks] = began + (1.0 - damage[cracks]) / rate[cracks]
            damage += added
        sums[now + 1] = damage
    return Damage(sums, removed, first_crack)
