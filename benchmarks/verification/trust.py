"""The page that comes before the checks: theory, other programs, experiments, and ten rows."""

import json
from collections.abc import Iterable, Iterator

import numpy as np
from benchmarks.pages import ROOT, Check, Data, Front, Section, anchor, percent, table
from benchmarks.verification import (
    closed_forms,
    coverage,
    explicit,
    limiting_state,
    peers,
    rings,
    tangential,
)
from benchmarks.verification.problems import DEPTH
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tests.mechanics.problems import HERTZ, P0, A

from fretwear.figures.style import (
    CATEGORICAL,
    MUTED,
    JournalFigure,
    sequential_colours,
    styled,
)
from fretwear.theory import LimitingState

ROWS = {
    "Pressure, approach, slip and energy of the unworn sphere": closed_forms,
    "State after very many cycles": limiting_state,
    "Slip of rough surfaces": tangential,
    "Pressure of rough and yielding contacts": peers,
    "Wear over the cycles, on a grid": rings,
    "Wear over the cycles, step by step": explicit,
    "Estimated errors against true ones": coverage,
}
AGAINST = {
    closed_forms: "Hertz, Cattaneo and Mindlin",
    limiting_state: "closed forms of the limit",
    tangential: "an independent tangential solver",
    peers: "tamaas and ContactMechanics",
    rings: "a dense, explicit solver",
    explicit: "Archard's law cycle by cycle",
    coverage: "cells four times as fine",
}


def nearest(section: Section, data: Data) -> Check:
    """The check of a section that comes nearest to its bound, or exceeds it most."""
    return max(section.checks(data), key=lambda one: abs(one.measured) / (one.required or 1e-300))


def _measured(entries: Data) -> Iterator[tuple[str, Section, Data]]:
    for words, part in ROWS.items():
        if part.SECTION.name in entries:
            yield words, part, entries[part.SECTION.name]["data"]


def _number(check: Check) -> str:
    """What was compared and its deviation, with a minus sign and spaces that do not break."""
    number = percent(check.measured).replace(" ", "\u00a0").replace("-", "−")
    return f"{number} ({check.what})"


def text(entries: Data) -> str:
    rows = []
    for words, part, data in _measured(entries):
        link = f"[{words}](checks.md#{anchor(part.SECTION.title)})"
        rows.append([link, AGAINST[part], _number(nearest(part.SECTION, data))])
    return f"""\
# Verification

## Theory

After very many cycles a smooth elastic contact stops wearing: the stick zone carries the whole load, and pressure and scar have closed forms
(lines). Points are computed after 30000 cycles. At the edge of the stick zone the theoretical pressure is infinite.

![Pressure and wear depth along x: points on lines](images/verification/front_theory.svg)

## Other programs

Largest deviations from independent solutions of the same equations.

![Largest deviations from other programs](images/verification/front_programs.svg)

## Experiments

Volumes, depths and widths of scars in published experiments; the band is ±30 %. Numerical errors are far smaller: deviations come from wear laws,
friction and the scatter of wear. [Published experiments](experiments.md) lists fitted and predicted numbers, and experiments that the model
fails to describe.

![Measured against computed scars of published experiments](images/experiments/together.svg)

## Largest deviations

{table(["what", "against", "largest"], rows, left=2)}

[Verification in detail](checks.md) has all tables. These errors are numerical; [limits](explanation/limits.md) lists what the model leaves out.

```{{toctree}}
:hidden:

checks
```
"""


@styled
def _theory(data: Data) -> Figure:
    figure = JournalFigure(2, 66.0)
    left, right = figure.subplots(1, 2)
    radius = np.linspace(0.0, 1.7, 700)
    colors = sequential_colours(len(data["along_x"]))
    for points, color in zip(data["along_x"], colors, strict=True):
        state = LimitingState(HERTZ, points["ratio"])
        inside = radius * A < 0.999 * state.stick_radius
        pressure = np.where(inside, state.pressure(np.where(inside, radius * A, 0.0)), 0.0)
        left.plot(radius, pressure / P0, color=color, lw=0.9)
        label = f"$Q/µP$ = {points['ratio']}"
        right.plot(radius, state.wear_depth(radius * A) / DEPTH, color=color, lw=0.9, label=label)
        for axes, name in ((left, "pressure"), (right, "wear_depth")):
            axes.plot(points["x"], points[name], "o", ms=2.6, color=color)
    left.set(ylabel="Pressure over $p_0$", ylim=(0.0, 3.0))
    right.set(ylabel="Wear depth over $a^2/R$", ylim=(0.0, 0.75))
    for axes in (left, right):
        axes.set(xlabel="$x/a$", xlim=(0.0, 1.7))
    right.legend(loc="upper left")
    return figure


def _deviations(entries: Data) -> Iterable[tuple[str, float]]:
    """Largest deviations from what does not share fretwear's solver."""
    found = {part: data for _, part, data in _measured(entries)}
    if peers in found:
        for peer, number in found[peers]["versions"].items():
            rows = [row for row in found[peers]["rows"] if row["peer"] == peer]
            yield f"{peer} {number}: pressure", max(row["pressure"] for row in rows)
    if tangential in found:
        checks = tangential.SECTION.checks(found[tangential])
        yield "independent tangential solver: slip", max(abs(one.measured) for one in checks)
    if explicit in found:
        checks = explicit.SECTION.checks(found[explicit])
        yield "Archard's law cycle by cycle: wear", max(abs(one.measured) for one in checks)
    if rings in found:
        elastic = [one for one in rings.SECTION.checks(found[rings]) if "elastic" in one.what]
        yield (
            "dense, explicit solver on rings, elastic: wear",
            max(abs(one.measured) for one in elastic),
        )
    depths = _block_on_ring()["depth"]
    yield "finite elements, block on ring: depth", max(abs(one[1] / one[2] - 1) for one in depths)


def _block_on_ring() -> Data:
    """What docs/experiments.json has of a block on a ring, with finite elements of others."""
    experiments = json.loads((ROOT / "docs/experiments.json").read_text(encoding="utf-8"))
    found: Data = experiments["cruzado2010"]["data"]
    return found


@styled
def _programs(deviations: list[tuple[str, float]]) -> Figure:
    figure = JournalFigure(2, 10.0 + 7.5 * len(deviations))
    axes: Axes = figure.subplots()
    deviations.sort(key=lambda one: one[1])
    places = np.arange(len(deviations))[::-1]
    values = np.array([value for _, value in deviations])
    axes.hlines(places, 1e-12, values, color="#bbbbbb", lw=1.0)
    axes.plot(values, places, "o", color=CATEGORICAL[0], ms=4.5)
    for place, value in zip(places, values, strict=True):
        shown = percent(value).lstrip("+") if value > 1e-5 else f"{value:.0e}".replace("e-0", "e-")
        axes.annotate(
            shown,
            (value, place),
            (6, 0),
            textcoords="offset points",
            va="center",
        )
    axes.set(xscale="log", xlim=(1e-12, 1.0), ylim=(-0.6, len(values) - 0.4))
    axes.set_yticks(places, [words for words, _ in deviations])
    axes.axvline(0.01, color=MUTED, lw=0.6, ls=(0, (4, 2)))
    axes.set_xlabel("Largest relative deviation; dashed: 1 %")
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    return figure


def figures(entries: Data) -> dict[str, Figure]:
    drawn = {}
    if "limiting_state" in entries and "along_x" in entries["limiting_state"]["data"]:
        drawn["theory"] = _theory(entries["limiting_state"]["data"])
    if deviations := list(_deviations(entries)):
        drawn["programs"] = _programs(deviations)
    return drawn


FRONT = Front(text, figures)
