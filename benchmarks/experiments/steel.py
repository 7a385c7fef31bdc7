"""Steel: a block on a ring, a cylinder on a flat."""

import time
from typing import Any

import numpy as np
from benchmarks.experiments.measurements import (
    MARKERS,
    column,
    point,
    profile_figure,
    rms,
    rows,
    scar,
    solved,
)
from benchmarks.pages import Data, Section
from matplotlib.figure import Figure

from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.style import MUTED


def measure_cruzado() -> Data:
    profiles = rows("cruzado2010")
    x = column(profiles, "x_mm")
    tests = [-column(profiles, f"test{number}_um") for number in (1, 2, 3)]
    started = time.process_time()
    (case,) = solved("cruzado2010")
    seconds = time.process_time() - started
    half, computed = scar(case)
    predicted = np.interp(np.abs(x), half, computed, right=0.0)
    mean = np.mean(tests, axis=0)
    finite = {800: (16.166, 0.76), 1600: (25.555, 1.01), 2400: (33.417, 1.16), 3600: (43.707, 1.32)}
    depth = {n: 1e6 * float(case["wear_depth"].sel(cycle=n).max()) for n in finite}
    wide = {n: 1e3 * float(case["contact_half_width_x"].sel(cycle=n)) for n in finite}
    return {
        "seconds": seconds,
        "x": x.tolist(),
        "tests": [test.tolist() for test in tests],
        "half": half.tolist(),
        "computed": computed.tolist(),
        "rms": [rms(predicted - test) for test in tests],
        "depth": [[n, depth[n], finite[n][0], wide[n], finite[n][1]] for n in finite],
        "points": [
            point(
                "depth",
                float(mean[15]),
                depth[3600],
                "µm",
                basis="fitted",
                scatter=float(np.std([test[15] for test in tests], ddof=1) / mean[15]),
            ),
            point("half-width", 1.345, wide[3600], "mm", scatter=0.02),
        ],
    }


def text_cruzado(data: Data) -> str:
    off = ", ".join(f"{each:.1f}" for each in data["rms"])
    deeper, wider = (
        max(abs(row[own] / row[own + 1] - 1.0) for row in data["depth"]) for own in (1, 3)
    )
    return f"""\
Cruzado, Zabala, Urchegui and Gomez (Revista de Metalurgia 46, 2010): a block on a steel ring of 20 mm radius, 65 N over 6 mm, 3600 m. The
coefficient, 2e-15 / Pa, is fitted to the mean worn area. The shape deviates by {off} µm (rms) from three tests. Finite elements (adaptive mesh,
LevelSetWear) took 89 854 s, fretwear {data["seconds"]:.1f} s on another machine; depths differ by up to {100.0 * deeper:.1f} %, half-widths by up to {100.0 * wider:.0f} %.

{{figure}}
"""


def figure_cruzado(data: Data) -> dict[str, Figure]:
    def draw(axes: Any) -> None:
        for number, test in enumerate(data["tests"]):
            label = f"measured, test {number + 1}"
            axes.plot(data["x"], test, MARKERS[number], ms=3, color=MUTED, label=label)
        both = [-each for each in data["half"][::-1]] + data["half"]
        depth = data["computed"][::-1] + data["computed"]
        axes.plot(both, depth, color=CATEGORICAL[0], label="computed")
        axes.set(xlabel="x (mm)", ylabel="Wear depth of the block (µm)", xlim=(-1.6, 1.6))

    return {"": profile_figure(draw)}


def measure_mccoll() -> Data:
    started = time.process_time()
    (case,) = solved("mccoll2004")
    seconds = time.process_time() - started
    depth = {n: 1e6 * float(case["wear_depth_flat"].sel(cycle=n).max()) for n in (5000, 18000)}
    x, flat = scar(case, "wear_depth_flat")
    profile = rows("mccoll2004")
    position, measured = column(profile, "x_mm"), -column(profile, "height_um")
    outside = np.abs(position) > 0.32
    base, rough = float(measured[outside].mean()), float(measured[outside].std())
    computed = np.interp(np.abs(position), x, flat, right=0.0)
    middle = np.abs(position) < 0.05
    return {
        "seconds": seconds,
        "depth": [depth[5000], depth[18000]],
        "x": position.tolist(),
        "measured": (measured - base).tolist(),
        "computed": computed.tolist(),
        "rough": rough,
        "off": rms(computed[~outside] - measured[~outside] + base),
        "points": [
            point(
                "depth of the flat",
                float(measured[middle].mean()) - base,
                float(computed[middle].mean()),
                "µm",
                scatter=rough / 2.7,
                basis="authors' coefficient",
            )
        ],
    }


def text_mccoll(data: Data) -> str:
    return f"""\
McColl, Ding and Leen (Wear 256, 2004): a cylinder of 6 mm radius on a flat of the same steel, 18.5 N/mm, ±24.24 µm in the contact, 18 000
cycles. The coefficients are the authors', assigned to the bodies by inference. The profile deviates by {data["off"]:.2f} µm (rms), the roughness is {data["rough"]:.2f} µm.
The depth of {data["depth"][1]:.3f} µm takes {data["seconds"]:.1f} s of processor time; finite elements gave 2.713 µm in 20 573 s and 2.706 µm in 16 993 s.

{{figure}}
"""


def figure_mccoll(data: Data) -> dict[str, Figure]:
    def draw(axes: Any) -> None:
        axes.plot(data["x"], data["measured"], "o", ms=2.5, color=MUTED, label="measured")
        axes.plot(data["x"], data["computed"], color=CATEGORICAL[0], label="computed")
        axes.set(xlabel="x (mm)", ylabel="Wear depth of the flat (µm)")

    return {"": profile_figure(draw)}


SECTIONS = (
    Section(
        "cruzado2010",
        "Block on ring, Cruzado 2010",
        measure_cruzado,
        text_cruzado,
        figures=figure_cruzado,
    ),
    Section(
        "mccoll2004",
        "Steel cylinder, McColl 2004",
        measure_mccoll,
        text_mccoll,
        figures=figure_mccoll,
    ),
)
