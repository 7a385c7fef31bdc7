"""Ti-6Al-4V cylinders on flats: the laws fitted to seven volumes, and what they predict."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from benchmarks.experiments.measurements import (
    REPEATS,
    STUDIES,
    column,
    comparison,
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
from fretwear.figures.style import CATEGORICAL, MUTED

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
    words = {"falling": "slow, fast (mm³/J), decay (mm²/W)"}
    words["rim and core"] = "rim, core (mm³/J), width (mm), −exponent"
    lines = [
        [
            name,
            words[name],
            ", ".join(f"{each:.3g}" for each in entry["numbers"]),
            f"{entry['debris']}",
            f"{100 * entry['rms']:.1f} %",
        ]
        for name, entry in data.items()
    ]
    titles = ["law", "numbers", "", "debris fraction", "rms of the seven"]
    return f"""\
Ti-6Al-4V wears seven times more per energy in slow than in fast motion. Two laws describe this: a coefficient that falls with the density of
friction power, or a rim that oxygen reaches. They are fitted to seven volumes of Fouvry et al. (2017), which poorly determine the four numbers
of rim and core, and to [two profiles](#u-and-w-scars-arnaud-2021).

{table(titles, lines)}
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
    lines = [
        [
            name,
            *(
                f"{100 * deviation(points, labels):.0f} %"
                for labels in (SERIES, HELD_OUT, R_SERIES, "P_")
            ),
        ]
        for name, points in data["laws"].items()
    ]
    authors = (rms([value for name, value in authors_law() if name[0] == one]) for one in "RP")
    lines.append(["two coefficients of the authors", "", "", *(f"{each:.0%}" for each in authors)])
    titles = [
        "rms of the law",
        "f series, fitted",
        "repeats, 10 000 cycles",
        "R series",
        "P series",
    ]
    return f"""\
Fouvry, Arnaud, Mignot and Neubauer (Tribology International 113, 2017): cylinders on flats, ±75 µm, several frequencies (f), radii (R) and loads
(P). Friction follows from the measured energy. Repeats scatter by {100 * REPEATS:.0f} to 35 %.

{table(titles, lines)}

**Neither law describes the R and P series** of smaller radii and loads: at equal power, 133 N/mm wear less per energy than 1066 N/mm.

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


def text_vanpeteghem(data: Data) -> str:
    lines = [[name, f"{100 * deviation(points):.0f} %"] for name, points in data["laws"].items()]
    return f"""\
Van Peteghem, Fouvry and Petit (Wear 271, 2011): the same contact, ±35 to ±88 µm, 1000 to 15 000 cycles, 0.11 to 5 Hz, without test 7, which the
authors leave out. All volumes are predicted.

{table(["law", "rms of nine volumes"], lines)}

{{figure}}
"""


def measure_pulsating() -> Data:
    tests = rows("pulsating")
    return _both_laws("pulsating", tests, 8.0, column(tests, "V_mm3"))


def outside(points: Iterable[Data]) -> float:
    """Share of the points that are more than 30 % off."""
    return float(np.mean([abs(each["computed"] / each["measured"] - 1.0) > 0.3 for each in points]))


def text_pulsating(data: Data) -> str:
    lines = [
        [
            name,
            f"{100 * deviation(points):.0f} %",
            f"{len(points) * (1 - outside(points)):.0f}",
            max(points, key=lambda each: abs(each["computed"] / each["measured"] - 1))["label"],
        ]
        for name, points in data["laws"].items()
    ]
    return f"""\
In 23 tests of both campaigns the load pulsated in phase with the motion; in three the contact opened. All volumes are predicted. RP_f_16 wore less
than a third of RP_f_21 in twice as many cycles.

{table(["law", "rms", "within 30 %", "farthest off"], lines)}

{{figure}}
"""


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
            at, worn = scar(case)
            deepest = int(worn.argmax())
            computed[f"{float(case['debris_fraction']):.2g}"] = {
                "x": at.tolist(),
                "depth": worn.tolist(),
                "centre": float(worn[0]),
                "deepest": float(worn[deepest]),
                "at": float(at[deepest]),
                "half_width": width_at(at, worn, 10.0),
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
Coefficients and debris fraction (0.94) of the U are fitted to its profile, rim and core of the W to volumes; its debris fraction (0.9) suits both
profiles. Half-widths are those at a depth of 10 µm.

{comparison(data["points"])}

With a debris fraction of 0.9 the depth of the U deviates by {percent(of_u)}.

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
