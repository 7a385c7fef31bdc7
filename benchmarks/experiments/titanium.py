"""Ti-6Al-4V cylinders on flats: the laws fitted to seven volumes, and what they predict."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from benchmarks.experiments.measurements import (
    REPEATS,
    STUDIES,
    column,
    equality,
    mark,
    point,
    profile_figure,
    rms,
    rows,
    scar,
    solved,
    volumes,
    width_at,
)
from benchmarks.pages import Data, Section, percent, table
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

import fretwear
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.style import MUTED

SERIES = ("f_1", "f_2", "f_3", "f_5", "f_6", "f_7", "R_4")  # to which the laws are fitted
FALLING = "{slow: [%.4g mm^3/J, %.4g mm^3/J], fast: [%.4g mm^3/J, %.4g mm^3/J], decay: %.4g mm^2/W}"
RIM = (
    "{rim: [%.4g mm^3/J, %.4g mm^3/J], core: [%.4g mm^3/J, %.4g mm^3/J], rim_width: %.4g mm, "
    "width_exponent: -%.4g, reference_frequency: 1 Hz}"
)
# Fitted by the section `laws`: totals of both bodies, mm³/J; mm²/W; mm; exponent. How many of them
# are fitted, and the debris fraction.
FITTED = {
    "falling": ((4.47e-4, 6.0e-5, 7.63), 3, 0.94),
    "rim and core": ((4.27e-4, 7.14e-5, 1.56, 0.71), 2, 0.9),
}


def law(name: str, numbers: Sequence[float]) -> list[str]:
    """Changes of a study to a law of some numbers, half of each coefficient for each body."""
    first, second, *others = numbers
    each = (first / 2, first / 2, second / 2, second / 2, *others)
    text = (FALLING if name == "falling" else RIM) % each
    return [f"energy_wear_coefficient={text}", f"debris_fraction={FITTED[name][2]}"]


def measure_laws() -> Data:
    from scipy.optimize import least_squares

    measured = {row["test"]: float(row["V_mm3"]) for row in rows("fouvry2017")}
    tests = [row["test"] for row in rows("fouvry2017") if row["test"] not in ("P_1", "f_8")]
    kept = [tests.index(test) for test in SERIES]
    found: Data = {}
    for name, (numbers, free, debris) in FITTED.items():

        def of(logarithms: NDArray[np.float64]) -> list[float]:
            return [*np.exp(logarithms).tolist(), *numbers[free:]]  # noqa: B023

        def missing(logarithms: NDArray[np.float64]) -> NDArray[np.float64]:
            changes = law(name, of(logarithms))  # noqa: B023
            worn = []
            for index in kept:
                case = (
                    fretwear.load_study(STUDIES / "fouvry2017.yaml", changes).points()[index].case
                )
                assert case is not None
                worn.append(8e6 * float(fretwear.simulate(case, quarter=True)["wear_volume"][-1]))
            return np.log(worn) - np.log([measured[test] for test in SERIES])

        fit = least_squares(missing, np.log(numbers[:free]), diff_step=0.02, xtol=1e-3, ftol=1e-3)
        found[name] = {"numbers": of(fit.x), "rms": rms(fit.fun), "debris": debris}
    return found


def text_laws(data: Data) -> str:
    (slow, fast, decay), (rim, core, width, exponent) = (
        (f"{each:.3g}" for each in data[name]["numbers"]) for name in FITTED
    )
    return f"""\
Ti-6Al-4V wears seven times more per energy in slow than in fast motion. Two laws, fitted to seven volumes and [two
profiles](#u-and-w-scars-arnaud-2021), describe this:

- *falling* with the density of friction power: slow {slow}, fast {fast} mm³/J, decay {decay} mm²/W; debris fraction {data["falling"]["debris"]};
- *rim and core*: a rim that oxygen reaches wears {rim} mm³/J, the core {core} mm³/J; the rim is {width} mm wide at 1 Hz, with the exponent −{exponent}
  of the frequency; debris fraction {data["rim and core"]["debris"]}. The data determine these four numbers poorly.
"""


def measure_fouvry2017() -> Data:
    tests = [row for row in rows("fouvry2017") if row["test"] not in ("P_1", "f_8")]
    return _both_laws("fouvry2017", tests, column(tests, "L_mm"), column(tests, "V_mm3"))


def _both_laws(
    name: str, tests: Sequence[Mapping[str, str]], length: ArrayLike, measured: ArrayLike
) -> Data:
    found: Data = {}
    for of_law, (numbers, *_) in FITTED.items():
        computed = volumes(name, length, *law(of_law, numbers))
        found[of_law] = [
            point(
                row["test"],
                float(volume),
                float(worn),
                "mm³",
                scatter=REPEATS,
                basis="fitted" if row["test"] in SERIES else "predicted",
            )
            for row, volume, worn in zip(tests, np.asarray(measured), computed, strict=True)
        ]
    return {"laws": found, "points": found["rim and core"]}


def deviation(points: Iterable[Data], labels: Sequence[str] | str = "") -> float:
    """Relative rms deviation of the points whose labels are, or begin so."""
    kept = [
        each["computed"] / each["measured"] - 1.0
        for each in points
        if (
            each["label"].startswith(labels) if isinstance(labels, str) else each["label"] in labels
        )
    ]
    return rms(kept)


R_SERIES = ("R_1", "R_2", "R_3")  # R_4 is fitted
HELD_OUT = ("RP_f_15", "RP_f_20", "RP_f_23", "RP_f_26", "RP_f_31")


def text_fouvry2017(data: Data) -> str:
    authors = (
        f"{100 * rms([value for name, value in authors_law() if name[0] == one]):.0f} %"
        for one in "RP"
    )
    return f"""\
Fouvry, Arnaud, Mignot and Neubauer (Tribology International 113, 2017): cylinders on flats, ±75 µm, several frequencies (f), radii (R) and loads
(P). Repeats scatter by {100 * REPEATS:.0f} to 35 %. **Neither law describes the R and P series** of smaller radii and
loads: at equal power, 133 N/mm wear less per energy than 1066 N/mm. The authors' two coefficients deviate by {" and ".join(authors)} (rms).

{{figure}}
"""


def authors_law() -> list[tuple[str, float]]:
    """Deviations of the authors' two coefficients from the R and P series."""
    by_scar = {"U": 3.55e-4, "W": 1.16e-4, "I": (3.55e-4 + 1.16e-4) / 2}
    tests = [row for row in rows("fouvry2017") if row["test"][:2] in ("R_", "P_")]
    return [
        (row["test"], by_scar[row["scar"]] * float(row["SigmaEd_J"]) / float(row["V_mm3"]) - 1.0)
        for row in tests
    ]


def measure_vanpeteghem() -> Data:
    tests = [
        row
        for row in rows("vanpeteghem2011")
        if row["condition"] == "constant" and row["test"] != "7"
    ]
    return _both_laws("vanpeteghem2011", tests, 8.0, 1e-9 * column(tests, "V_um3"))


def text_vanpeteghem(_: Data) -> str:
    return """\
Van Peteghem, Fouvry and Petit (Wear 271, 2011): the same contact, ±35 to ±88 µm, 1000 to 15 000 cycles, 0.11 to 5 Hz, without test 7, which the
authors leave out.

{figure}
"""


def measure_pulsating() -> Data:
    tests = rows("pulsating")
    return _both_laws("pulsating", tests, 8.0, column(tests, "V_mm3"))


def text_pulsating(_: Data) -> str:
    return """\
In 23 tests of both campaigns the load pulsated in phase with the motion; in three the contact opened. RP_f_16 is farthest off.

{figure}
"""


def table_of_volumes(data: Data) -> str:
    """Deviations of all volumes by series and law."""
    series = {
        "f series, fitted": ("fouvry2017", SERIES),
        "repeats of 10 000 cycles": ("fouvry2017", HELD_OUT),
        "R series": ("fouvry2017", R_SERIES),
        "P series": ("fouvry2017", "P_"),
        "van Peteghem 2011": ("vanpeteghem2011", ""),
        "pulsating load": ("pulsating", ""),
    }
    lines = [
        [
            words,
            *(f"{100 * deviation(points, labels):.0f} %" for points in data[name]["laws"].values()),
        ]
        for words, (name, labels) in series.items()
    ]
    return table(["volumes of Ti-6Al-4V, rms deviation", *FITTED], lines)


def figure_volumes(data: Data) -> dict[str, Figure]:
    with fretwear.figures.style_context():
        figure = Figure(figsize=(5.6, 2.6), layout="constrained")
        panels = figure.subplots(1, 2, sharex=True, sharey=True)
        for axes, (name, points) in zip(panels, data["laws"].items(), strict=True):
            equality(axes, points)
            for index, basis in enumerate(("fitted", "predicted")):
                mark(axes, [each for each in points if each["basis"] == basis], index, basis)
            axes.set(title=name, xlabel="Measured (mm³)")
        panels[0].set_ylabel("Computed (mm³)")
        panels[0].legend(fontsize=6.5)
    return {"": figure}


def measure_arnaud() -> Data:
    shapes: Data = {}
    for which, name in (("U", "arnaud2021_u"), ("W", "arnaud2021_w")):
        measured = rows(name)
        x, depth = column(measured, "x_mm"), 1e3 * column(measured, "depth_mm")
        computed = {}
        for case in solved(name):
            position, worn = scar(case)
            deepest = int(worn.argmax())
            computed[f"{float(case['debris_fraction']):.2g}"] = {
                "x": position.tolist(),
                "depth": worn.tolist(),
                "centre": float(worn[0]),
                "deepest": float(worn[deepest]),
                "at": float(position[deepest]),
                "half_width": width_at(position, worn, 10.0),
            }
        right = x >= 0
        middle = float(depth[x == 0][0])
        half = width_at(x[x >= 0.8], depth[x >= 0.8], 10.0)
        shapes[which] = {
            "x": x[right].tolist(),
            "depth": depth[right].tolist(),
            "centre": middle,
            "deepest": float(depth.max()),
            "half_width": half,
            "computed": computed,
        }
    u, w = shapes["U"], shapes["W"]
    ours, both = u["computed"]["0.94"], w["computed"]["0.9"]
    known = {"scatter": 0.03, "unit": "mm"}
    return {
        "shapes": shapes,
        "points": [
            point("U, depth", u["deepest"], ours["deepest"], "µm", scatter=0.03, basis="fitted"),
            point("U, half-width", u["half_width"], ours["half_width"], **known, basis="fitted"),
            point("W, centre", w["centre"], both["centre"], "µm", scatter=0.1),
            point("W, deepest", w["deepest"], both["deepest"], "µm", scatter=0.07),
            point("W, half-width", w["half_width"], both["half_width"], **known),
        ],
    }


def text_arnaud(data: Data) -> str:
    u = data["shapes"]["U"]
    of_u = u["computed"]["0.9"]["deepest"] / u["deepest"] - 1.0
    return f"""\
Arnaud, Baydoun and Fouvry (Tribology International 161, 2021): two scars of this contact after 5000 cycles, sum of both bodies, digitised to ±5 µm.
The U is fitted, with a debris fraction of 0.94; rim and core of the W come from the volumes. Their debris fraction of 0.9 makes the U {percent(abs(of_u))[1:]} too
shallow. Half-widths are those at a depth of 10 µm.

{{figure:u}}

{{figure:w}}
"""


def figure_arnaud(data: Data) -> dict[str, Figure]:
    figures = {}
    for which, shape in data["shapes"].items():

        def draw(axes: Any, shape: Data = shape) -> None:
            axes.errorbar(
                shape["x"],
                shape["depth"],
                5.0,
                fmt="o",
                ms=3,
                elinewidth=0.6,
                color=MUTED,
                label="measured",
            )
            for index, (fraction, each) in enumerate(shape["computed"].items()):
                color, label = CATEGORICAL[index], f"debris fraction {fraction}"
                axes.plot(each["x"], each["depth"], color=color, label=label)
            axes.set(xlabel="x (mm)", ylabel="Wear depth of both (µm)", xlim=(0, 2.6))

        figures[which.lower()] = profile_figure(draw)
    return figures


SECTIONS = (
    Section(
        "laws",
        "Two laws for Ti-6Al-4V",
        measure_laws,
        text_laws,
        on_request=True,
    ),
    Section(
        "fouvry2017",
        "Ti-6Al-4V, Fouvry 2017",
        measure_fouvry2017,
        text_fouvry2017,
        figures=figure_volumes,
    ),
    Section(
        "vanpeteghem2011",
        "Ti-6Al-4V, van Peteghem 2011",
        measure_vanpeteghem,
        text_vanpeteghem,
        figures=figure_volumes,
    ),
    Section(
        "pulsating",
        "Ti-6Al-4V, pulsating and opening load",
        measure_pulsating,
        text_pulsating,
        figures=figure_volumes,
    ),
    Section(
        "arnaud2021",
        "U and W scars, Arnaud 2021",
        measure_arnaud,
        text_arnaud,
        figures=figure_arnaud,
    ),
)
