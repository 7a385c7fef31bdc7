"""Draw the picture on the page of limits: the direction of slip, and the singular pressure.

Run ``python docs/images/limits.py docs/images/limits.png``.
"""

import sys
import warnings

import fretwear
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.style import INK, LINE_STYLES, JournalFigure, save_as, styled

CASE = fretwear.Case(
    radius="10 mm", youngs_modulus="208 GPa", poisson_ratio=0.3, load="30 N", friction=0.5,
    tangential_ratio=0.7, wear_coefficient=7e-13, cycles=6000, output_cycles=[300, 6000],
    error_estimate=False,
)  # fmt: skip
MODELS = {"cerruti": "along x (cerruti)", "jaeger": "alike in all directions (jaeger)"}


@styled
def figure() -> JournalFigure:
    """Wear beside both axes by two slip models, and the pressure on cells of three widths."""
    page = JournalFigure(1, 120.0)
    depths, peaks = page.subplots(2, 1)
    for (model, words), tint in zip(MODELS.items(), CATEGORICAL, strict=False):
        # An ellipsoid is computed on a grid whatever the model.
        shape = {"kind": "ellipsoid", "radius_x": "10 mm", "radius_y": "10.0001 mm"}
        case = CASE.replace(slip_model=model, cell="1 um", indenter=shape)
        worn = fretwear.simulate(case, quarter=True)["wear_depth"].sel(cycle=300)
        lines = {"x": worn.isel(y=0), "y": worn.isel(x=0)}
        for (axis, line), dashes in zip(lines.items(), LINE_STYLES, strict=False):
            if model == "jaeger" and axis == "y":
                continue
            label = words if model == "jaeger" else f"{words}, on the {axis} axis"
            depths.plot(1e6 * line[axis], 1e9 * line, color=tint, linestyle=dashes, label=label)
    depths.set(xlabel="Distance from the centre (µm)", ylabel="Wear depth (nm)", ylim=(0.0, None))
    depths.set_xlim(60.0, 130.0)
    depths.set_title("a  cycle 300")
    depths.legend(loc="upper right", bbox_to_anchor=(1.0, 1.25))
    for cells, dashes in zip((32, 64, 128), LINE_STYLES, strict=False):
        cell = float(CASE.hertz_radius / cells)
        case = CASE.replace(cell=cell, slip_model="cerruti")
        line = fretwear.simulate(case, quarter=True)["pressure"].isel(cycle=-1, y=0)
        peaks.plot(
            1e6 * line.x, 1e-6 * line, color=INK, linestyle=dashes, label=f"cells of a/{cells}"
        )
    peaks.set(xlabel="x (µm)", ylabel="Pressure (MPa)", ylim=(0.0, None))
    peaks.set_xlim(60.0, 110.0)
    peaks.set_title("b  cycle 6000")
    peaks.legend(loc="upper right", bbox_to_anchor=(1.0, 1.1))
    return page


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    save_as(figure(), sys.argv[1])
