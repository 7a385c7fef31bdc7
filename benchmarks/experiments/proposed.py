"""What no published experiment tells, and the test that would."""

from benchmarks.experiments.measurements import (
    solved,
)
from benchmarks.pages import Data, Section, table

COEFFICIENT = "1e-13 / Pa"  # the other one of the study has the same scars ten times later


def measure_proposed() -> Data:
    found = []
    for case in solved("partial_slip", f"wear_coefficient={COEFFICIENT}"):
        for cycle in (1000, 10_000, 30_000):
            now = case.sel(cycle=cycle)
            values = [
                1e6 * float(now[f"{name}{end}"])
                for name in ("maximum_wear_depth", "contact_radius", "stick_radius")
                for end in ("", "_error")
            ]
            found.append([cycle, *values])
    return {"rows": found}


def text_proposed(data: Data) -> str:
    lines = [
        [
            f"{cycle}",
            f"{depth:.4f} ± {depth_error:.4f}",
            f"{radius:.1f} ± {radius_error:.1f}",
            f"{stick:.1f} ± {stick_error:.1f}",
        ]
        for cycle, depth, depth_error, radius, radius_error, stick, stick_error in data["rows"]
    ]
    titles = ["cycles", "depth of both, µm", "contact radius, µm", "stick radius, µm"]
    return f"""\
No published experiment in partial slip states geometry, load, friction, cycles and a scar in numbers, as far as we know. A suitable test: a ball of
52100, R = 10 mm, on a polished flat (Ra below 20 nm) of the same steel, dry, 50 N, ±20 N. Predictions at µ = 0.5 and {COEFFICIENT}:

{table(titles, lines)}

The coefficient determines when a depth is reached, not the profile at that depth.
"""


SECTIONS = (
    Section("proposed", "A proposed test in partial slip", measure_proposed, text_proposed),
)
