"""Write smooth_wear.csv: wear of a smooth sphere by the solver on rings, with its uncertainty.

    python -m benchmarks.verification.smooth_wear

takes about an hour on one core. Pressures are over p0, heights over a²/R, volumes over a⁴/R, radii
over a, and τ = 4 K_w µ κ p0 N. An uncertainty is what halving the rings changed plus what is left
of the steps. Rows of load ratio 0.8 include τ of N = 100 to 30000 cycles of the study (50 N, 20 N,
µ = 0.5, R = 10 mm, E = 208 GPa, ν = 0.3, K_w = 7e-13 / Pa, plastic limit 4500 MPa or none). Where
`growth`, αµ², is not zero, friction lowers that limit; the band that yields is then wider.
"""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from benchmarks.verification.reference_rings import UNIT_HERTZ, Resolution, dimensionless_history

from fretwear.theory import HertzContact, composite_modulus, coupling_ratio

STEEL = (208e9, 0.3)
HERTZ = HertzContact(10e-3, 50.0, composite_modulus(*STEEL, *STEEL))
LIMIT_RATIO = 4500e6 / HERTZ.peak_pressure
TIME_PER_CYCLE = 4 * 7e-13 * 0.5 * coupling_ratio(*STEEL, *STEEL) * HERTZ.peak_pressure
STUDY_CYCLES = (100, 1000, 3000, 7000, 15000, 30000)
TIMES = (0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0)
QUANTITIES = (
    "approach",
    "central_pressure",
    "deepest_wear",
    "wear_volume",
    "plastic_volume",
    "contact_radius",
    "stick_radius",
)
UNITS = np.ones((len(QUANTITIES), 1))
UNITS[1] = UNIT_HERTZ.peak_pressure
COARSE = Resolution(swept_width=1 / 320, edge_width=1e-4, widest=0.015, step=0.05)
FINE = replace(COARSE, swept_width=1 / 640, edge_width=5e-5, widest=0.0075)
# Friction of 0.5 and α = 9.
GROWTH = 2.25
COARSE_IF_GROWN = replace(COARSE, swept_width=1 / 160, edge_width=1e-3)
FINE_IF_GROWN = replace(COARSE_IF_GROWN, swept_width=1 / 320, edge_width=5e-4, widest=0.0075)
TARGET = Path(__file__).parents[2] / "tests/mechanics/reference/smooth_wear.csv"


def main() -> None:
    rows = []
    for load_ratio in (0.2, 0.5, 0.8, 0.9):
        for limit_ratio in (math.inf, LIMIT_RATIO):
            rows += computed(load_ratio, limit_ratio, 0.0, COARSE, FINE)
            write(rows)
    for load_ratio in (0.5, 0.8):
        rows += computed(load_ratio, LIMIT_RATIO, GROWTH, COARSE_IF_GROWN, FINE_IF_GROWN)
        write(rows)


def computed(
    load_ratio: float, limit_ratio: float, growth: float, coarse: Resolution, fine: Resolution
) -> list[list[object]]:
    """Rows of the table for one contact, on coarse and fine rings."""
    times = list(TIMES)
    if load_ratio == 0.8:
        times = sorted({*times, *(round(TIME_PER_CYCLE * n, 9) for n in STUDY_CYCLES)})
        times = times[: times.index(20.0)] if growth else times
    contact = load_ratio, limit_ratio, times
    coarse_values, _ = dimensionless_history(*contact, coarse, growth)
    values, steps = dimensionless_history(*contact, fine, growth)
    uncertainty = (steps + np.abs(values - coarse_values)) / UNITS
    rows: list[list[object]] = []
    for time, value, error in zip(times, (values / UNITS).T, uncertainty.T, strict=True):
        numbers = [f"{number:.6g}" for number in (*value, *error)]
        rows.append([load_ratio, f"{limit_ratio:.8g}", f"{growth:g}", f"{time:.9g}", *numbers])
    return rows


def write(rows: list[list[object]]) -> None:
    with TARGET.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        names = [f"{name}_uncertainty" for name in QUANTITIES]
        writer.writerow(["load_ratio", "limit_ratio", "growth", "tau", *QUANTITIES, *names])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
