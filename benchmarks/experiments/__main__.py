"""The page docs/experiments.md: run ``python -m benchmarks.experiments``."""

import sys
from itertools import count

from benchmarks.experiments import coating, flat_on_flat, proposed, steel, titanium
from benchmarks.experiments.measurements import (
    comparison,
    equality,
    mark,
)
from benchmarks.pages import ROOT, Data, Page, Section
from matplotlib.figure import Figure

import fretwear


def measure_together() -> Data:
    entries = PAGE.load(ROOT / "docs")
    return {
        name: entry["data"]["points"]
        for name, entry in entries.items()
        if "points" in entry["data"]
    }


def in_mm(each: Data) -> Data:
    """The point in mm or mm³."""
    size = {"µm": 1e-3}.get(each["unit"], 1.0)
    return each | {key: size * each[key] for key in ("measured", "computed")}


def figures_together(data: Data) -> dict[str, Figure]:
    with fretwear.figures.style_context():
        figure = Figure(figsize=(4.6, 3.4), layout="constrained")
        axes = figure.subplots()
        equality(axes, [in_mm(each) for points in data.values() for each in points])
        for index, (name, points) in zip(count(), data.items(), strict=False):
            label = next(each.title for each in SECTIONS if each.name == name)
            mark(axes, [in_mm(each) for each in points], index, label)
        axes.set(xlabel="Measured: volumes (mm³), depths and widths (mm)", ylabel="Computed")
        figure.legend(loc="outside right center", fontsize=6.5)
    return {"": figure}


def lead(data: Data) -> str:
    together = data["together"]
    points = [each for of_one in together.values() for each in of_one]
    predicted = [each for each in points if each.get("basis") != "fitted"]
    ratios = [each["computed"] / each["measured"] for each in predicted]
    near = sum(1 / 1.3 <= ratio <= 1.3 for ratio in ratios)
    compared = {words: together[name] for name, words in COMPARED.items()}
    return f"""\
![All experiments](images/experiments/together.svg)

{near} of the {len(predicted)} predicted numbers lie within the band of ±30 %; error bars show the scatter of repeats.

{comparison(compared)}

{titanium.table_of_volumes(data)}
"""


COMPARED = {
    "cruzado2010": "block on ring",
    "mccoll2004": "steel cylinder",
    "arnaud2021": "Ti-6Al-4V",
    "fouvry2007": "coating",
}
"""The experiments whose numbers are few, in words."""

SECTIONS = (
    *steel.SECTIONS,
    *titanium.SECTIONS,
    *flat_on_flat.SECTIONS,
    *coating.SECTIONS,
    *proposed.SECTIONS,
    Section("together", "All experiments", measure_together, figures=figures_together),
)


INTRODUCTION = """\
# Published experiments

`python -m benchmarks.experiments` repeats the comparison in about {minutes} of one core ({versions}) from `studies/experiments/*.yaml` and the
measurements beside them, most of them digitised by others.
"""


PAGE = Page("experiments", INTRODUCTION, SECTIONS, lead)

if __name__ == "__main__":
    sys.exit(PAGE.main())
