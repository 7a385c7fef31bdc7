"""A ball of alumina on a coating of TiC."""

import numpy as np
from benchmarks.experiments.measurements import (
    column,
    point,
    rms,
    rows,
    solved,
)
from benchmarks.pages import Data, Section


def measure_fouvry2007() -> Data:
    measured = rows("fouvry2007")
    energy, volume = (column([r for r in measured if r["kind"] == "V"], key) for key in "xy")
    density, depth = (column([r for r in measured if r["kind"] == "h"], key)[:-2] for key in "xy")
    slope = float(density @ depth / (density @ density))
    scatter = rms(depth / (slope * density) - 1.0)
    curves, through = {}, {}
    for case in solved("fouvry2007"):
        worn = 1e18 * case["wear_volume_flat"].to_numpy()
        deepest = 1e6 * case["wear_depth_flat"].max(("x", "y")).to_numpy()
        label = f"±{1e6 * float(case['sliding_amplitude']):.0f} µm"
        curves[label] = [worn.tolist(), deepest.tolist()]
        path = 4.0 * float(case["friction"] * case["normal_load"] * case["sliding_amplitude"])
        through[label] = path * float(case["worn_through_cycle"][-1])
    largest = float(volume.max())
    energies = {name: float(np.interp(largest, *curve)) for name, curve in curves.items()}
    return {
        "curves": curves,
        "at": energies,
        "through": through,
        "density": 1.6 / 415.0,
        "spalled": [float(r["x"]) for r in measured if r["kind"] == "h"][-1],
        "volume": largest,
        "scatter": scatter,
        "rms": rms(volume / (415.0 * energy) - 1.0),
        "points": [
            point(f"depth, {name}", float(depth.max()), value, "µm", scatter=scatter)
            for name, value in energies.items()
        ],
    }


def text_fouvry2007(data: Data) -> str:
    through = " and ".join(f"{value:.0f} J ({name})" for name, value in data["through"].items())
    return f"""\
Fouvry, Paulin and Liskiewicz (Tribology International 40, 2007): a ball of alumina, 12.7 mm in radius, on 1.6 µm of TiC on steel, 100 N. Volumes
follow the authors' 415 µm³/J (rms {100 * data["rms"]:.0f} %). Depths scatter by {100 * data["scatter"]:.0f} %. Computed, the coating is worn through after {through}, at
{1e3 * data["density"]:.1f} mJ/µm² in the middle. **It spalled earlier**, at {1e3 * data["spalled"]:.1f} mJ/µm², which the program does not describe.
"""


SECTIONS = (
    Section(
        "fouvry2007",
        "Ball on a coating, Fouvry 2007",
        measure_fouvry2007,
        text_fouvry2007,
    ),
)
