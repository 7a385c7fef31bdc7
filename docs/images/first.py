"""Draw the first picture of README and documentation: a scar, its history, and measured scars.

    snakemake --cores 2
    python -m benchmarks.experiments
    PYTHONPATH=. python docs/images/first.py results/demo docs/images/first.png

Run in the repository's root. The scar is one of the default study; the histories are run here, and
compared with the limit of many cycles in closed form; measured points come from
`docs/experiments.json`.
"""

import json
import sys
from pathlib import Path

import numpy as np
import xarray as xr
from benchmarks.experiments.measurements import equality, mark
from matplotlib.axes import Axes
from PIL import Image

import fretwear
from fretwear.figures.axes import set_cycle_axis
from fretwear.figures.style import JournalFigure, sequential_colours
from fretwear.run.simulate import run
from fretwear.study.parameters import parameter
from fretwear.theory import HertzContact, LimitingState

RATIOS = (0.2, 0.5, 0.9)
STEEL = {"youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "wear_coefficient": "7e-13 / Pa"}
CONTACT = {"radius": "10 mm", "load": "50 N", "friction": 0.5, "cycles": 10**5, **STEEL}
CONTACT["slip_model"] = "jaeger"  # for which there are closed forms


def scar(axes: Axes, results: Path) -> None:
    """The wear of a rough contact that yields, from above."""
    summary = xr.open_dataset(results / "summary.nc")
    point = summary.sel(normal_load=28, friction=0.6, roughness_amplitude=3e-7, plastic_limit=1.2e9)
    case = fretwear.open_case(results / "cases" / f"{point['case_id'].item()}.nc")
    fretwear.figures.wear_map(case, ax=axes)
    axes.get_legend().remove()
    axes.set_title(f"Scar after {int(case['cycle'][-1])} cycles")


def histories(axes: Axes) -> None:
    """Wear volumes of smooth spheres, and the closed form that each tends to."""
    for ratio, color in zip(RATIOS, sequential_colours(len(RATIOS)), strict=True):
        case = fretwear.Case(tangential_ratio=ratio, **CONTACT)
        history = run(case).history
        volumes = 1e9 * history["wear_volume"]
        axes.plot(history["cycle"], volumes, color=color)
        sphere = HertzContact(case.indenter.radius, case.load, case.composite_modulus)
        limit = 1e9 * LimitingState(sphere, ratio).wear_volume
        axes.axhline(limit, color=color, ls=(0, (4, 2)), lw=0.8)
        axes.annotate(
            f"{parameter('tangential_ratio').symbol} = {ratio}",
            (CONTACT["cycles"], limit),
            color=color,
            ha="right",
            va="bottom",
        )
    set_cycle_axis(axes, history["cycle"])
    axes.set_xticks([0, 1, 100, 10**4], ["0", "1", "100", "10 000"])
    axes.set(yscale="log", ylim=(1e-7, 5e-4), ylabel="Wear volume (mm³)")
    axes.set_title("Simulated; dashed: closed forms")


def measured(axes: Axes) -> None:
    """Worn volumes of published experiments, measured and computed."""
    data = json.loads(Path("docs/experiments.json").read_text(encoding="utf-8"))["together"]["data"]
    points = [each for series in data.values() for each in series if each["unit"] == "mm³"]
    equality(axes, points)
    ratios = np.log([each["computed"] / each["measured"] for each in points])
    rms = 100.0 * np.expm1(np.sqrt(np.mean(ratios**2)))
    for is_fitted in (False, True):
        chosen = [each for each in points if (each.get("basis") == "fitted") is is_fitted]
        mark(axes, chosen, int(is_fitted), "fitted" if is_fitted else "not fitted")
    axes.set(xlabel="Measured volume (mm³)", ylabel="Computed volume (mm³)")
    axes.legend()
    axes.set_title(f"Experiments: rms {rms:.0f} %")


if __name__ == "__main__":
    with fretwear.figures.style_context():
        figure = JournalFigure(2, 66.0)
        left, middle, right = figure.subplots(1, 3, width_ratios=(1.25, 1.1, 1.0))
        scar(left, Path(sys.argv[1]))
        histories(middle)
        measured(right)
        figure.get_layout_engine().set(wspace=0.06)
    figure.savefig(sys.argv[2], dpi=225)
    picture = Image.open(sys.argv[2]).convert("RGB")
    picture.quantize(256, dither=Image.Dither.NONE).save(sys.argv[2], optimize=True)
