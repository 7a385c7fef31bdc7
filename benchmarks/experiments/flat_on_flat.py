"""Flat on flat of 35NCD16, by the authors' law."""

import math
from collections.abc import Iterable

import numpy as np
from benchmarks.experiments.measurements import (
    column,
    point,
    rms,
    rows,
    volumes,
)
from benchmarks.pages import Data, Section, percent
from matplotlib.figure import Figure

import fretwear
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.style import MUTED

SWEEPS = {
    "N": "cycles",
    "p_MPa": "mean pressure, MPa",
    "delta_um": "amplitude, µm",
    "f_Hz": "frequency, Hz",
}
REFERENCE = {"p_MPa": 100.0, "delta_um": 100.0, "f_Hz": 1.0, "N": 20000.0}


def measure_baydoun() -> Data:
    tests = rows("baydoun2019")
    conditions = [tuple((REFERENCE | {r["sweep"]: float(r["x"])}).values()) for r in tests]
    volume = dict(zip(dict.fromkeys(conditions), volumes("baydoun2019", 5.0), strict=True))
    repeats = column([r for r in tests if r["sweep"] == "N" and r["x"] == "20000"], "V_mm3")
    scatter = float(np.std(repeats, ddof=1) / repeats.mean())
    points = [
        point(r["sweep"], float(r["V_mm3"]), volume[condition], "mm³", scatter=scatter)
        | {"x": float(r["x"])}
        for r, condition in zip(tests, conditions, strict=True)
    ]
    # The law by hand: α µ P 4δ N at the pressure P/A of the whole block.
    ratios = np.array([tuple((REFERENCE | {p["label"]: p["x"]}).values()) for p in points])
    ratios /= [*REFERENCE.values()]
    worn = 4.383e-5 * 0.7 * 25.0 * 100.0 * 4e-6 * 100.0 * 20000.0 * ratios[:, :2].prod(axis=1)
    worn *= ratios[:, 3] * (ratios[:, :3] ** (0.6, 0.7, -0.3)).prod(axis=1)
    measured = np.array([each["measured"] for each in points])
    off = np.log(measured / worn)
    return {
        "points": points,
        "scatter": scatter,
        "by_hand": rms(off),
    }


def logarithm(points: Iterable[Data]) -> float:
    """Root mean square of the logarithm of computed over measured."""
    return rms([math.log(each["computed"] / each["measured"]) for each in points])


def sweeps(data: Data) -> dict[str, list[Data]]:
    """The points of each sweep, and all of them."""
    of_sweep = {name: [each for each in data["points"] if each["label"] == name] for name in SWEEPS}
    return of_sweep | {"": data["points"]}


def text_baydoun(data: Data) -> str:
    *single, every = ((name, logarithm(points)) for name, points in sweeps(data).items())
    (least, low), (most, high) = (choose(single, key=lambda one: one[1]) for choose in (min, max))

    def words(sweep: str) -> str:
        return SWEEPS[sweep].partition(",")[0]

    ratios = [math.log(each["computed"] / each["measured"]) for each in data["points"]]
    mean = percent(math.exp(np.mean(ratios)) - 1)
    return f"""\
Baydoun, Fouvry, Descartes and Arnaud (Wear 426–427, 2019): blocks of 35NCD16, 5 mm × 5 mm, about 20 000 cycles, 100 MPa, ±100 µm, 1 Hz.
Coefficient, exponents and friction are the authors', fitted to these tests. Three repeats scatter by {100 * data["scatter"]:.0f} %. Over {len(ratios)} tests the logarithm
deviates by {every[1]:.2f} (rms), from {low:.2f} ({words(least)}) to {high:.2f} ({words(most)}), the mean by {mean}. The law evaluated by hand deviates by {data["by_hand"]:.2f}.

{{figure}}
"""


def figure_baydoun(data: Data) -> dict[str, Figure]:
    with fretwear.figures.style_context():
        figure = Figure(figsize=(6.6, 2.2), layout="constrained")
        panels = figure.subplots(1, 4, sharey=True)
        for axes, (name, words) in zip(panels, SWEEPS.items(), strict=True):
            points = sorted(sweeps(data)[name], key=lambda each: float(each["x"]))
            x, measured = ([each[key] for each in points] for key in ("x", "measured"))
            spread = data["scatter"] * np.array(measured)
            axes.errorbar(
                x, measured, spread, ls="", marker="o", ms=3, color=MUTED, label="measured"
            )
            axes.plot(
                x, [each["computed"] for each in points], color=CATEGORICAL[0], label="computed"
            )
            axes.set(xlabel=words[:1].upper() + words[1:], xscale="log", yscale="log")
            axes.set_xlim(0.8 * float(x[0]), 1.25 * float(x[-1]))
            axes.set_xticks([float(x[0]), float(x[-1])], [f"{x[0]:g}", f"{x[-1]:g}"])
            axes.minorticks_off()
        panels[0].set_ylabel("Worn volume (mm³)")
        panels[0].legend(fontsize=6.5)
    return {"": figure}


SECTIONS = (
    Section(
        "baydoun2019",
        "Flat on flat, Baydoun 2019",
        measure_baydoun,
        text_baydoun,
        figures=figure_baydoun,
    ),
)
