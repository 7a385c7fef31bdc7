"""Draw the sketch of a contact that README and documentation show.

    python docs/images/contact.py docs/images/contact.svg

Symbols come from the table of notation, zones and loop from the closed forms of an unworn sphere at
Q/µP = 0.8. Heights are not to scale.
"""

import sys

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle

from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.profiles import ZONE_COLORS
from fretwear.figures.style import INK, MUTED, JournalFigure, save_as, style_context
from fretwear.results import RESULTS
from fretwear.study.parameters import parameter
from fretwear.variable import ContactState

RATIO = 0.8
STICK = (1.0 - RATIO) ** (1.0 / 3.0)  # c over a
BODY, SCAR = "#dfe3e8", CATEGORICAL[1]
SIZE = 8.5


def symbol(name: str) -> str:
    """The symbol of a parameter or a result."""
    return (RESULTS[name] if name in RESULTS else parameter(name)).symbol


def arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], style: str) -> None:
    """An arrow, or with two heads a dimension."""
    look = {"arrowstyle": style, "color": INK, "lw": 0.9, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", end, start, arrowprops=look | {"mutation_scale": 7.0})


def say(axes: Axes, x: float, y: float, text: str, align: str = "center", **look: object) -> None:
    """A word or a symbol; letters are centred on their height."""
    look = {"fontsize": SIZE, "color": INK, "va": "center"} | look
    axes.text(x, y, text, ha=align, **look)


def drawing(axes: Axes, x: tuple[float, float], y: tuple[float, float], title: str) -> None:
    """Axes of a drawing, without a frame."""
    axes.set(xlim=x, ylim=y)
    axes.axis("off")
    axes.set_title(title, fontsize=SIZE)


def side(axes: Axes) -> None:
    """The bodies in section: loads, rig, and what wear has taken off the flat of the picture."""
    drawing(axes, (-3.9, 2.75), (-1.6, 2.9), "The contact in its rig")
    radius = 5.0
    x = np.linspace(-2.2, 2.2, 201)
    sphere = radius - np.sqrt(radius**2 - x**2)
    reach = 1.35
    worn = np.where(abs(x) < reach, np.maximum(0.16 * (1.0 - (x / reach) ** 2), 0.0), 0.0)
    # In the middle the bodies stick and nothing is worn; around it both touch what is left.
    depth = np.where(abs(x) < STICK, 0.0, worn * np.clip((abs(x) - STICK) / 0.25, 0.0, 1.0))
    surface = np.maximum(sphere - 0.13, -depth)
    top = [(2.2, 1.75), (-2.2, 1.75)]
    axes.add_patch(Polygon([*zip(x, surface, strict=True), *top], fc=BODY, ec=INK, lw=0.8))
    ends = [(2.65, 0.0), (2.65, -0.85), (-2.65, -0.85), (-2.65, 0.0)]
    flat = [*zip(x, -depth, strict=True), *ends]
    axes.add_patch(Polygon(flat, fc=BODY, ec=INK, lw=0.8))
    for side in (-1.0, 1.0):
        zone = (abs(x) >= STICK) & (side * x > 0) & (depth > 0.0)
        axes.fill_between(x[zone], -depth[zone], 0.0, color=SCAR, lw=0)
    axes.add_patch(Rectangle((-2.65, -0.98), 5.3, 0.13, fc="white", ec=MUTED, hatch="/////", lw=0))
    arrow(axes, (0.0, 2.75), (0.0, 1.78), "-|>")
    say(axes, 0.12, 2.5, f"{symbol('load')}  load", "left")
    arrow(axes, (-0.75, 1.15), (0.75, 1.15), "<|-|>")
    say(axes, 0.0, 1.38, f"±{symbol('tangential_load').strip()}")
    arrow(axes, (1.0, 0.95), (1.95, sphere[x.searchsorted(1.95)] - 0.1), "-|>")
    say(axes, 1.28, 0.98, symbol("radius"), "left")
    # The rig: a spring between the indenter and what is moved.
    turns = np.linspace(0.0, 1.0, 13)
    wire = 0.16 * np.array([0.0, 0.0, *([1.0, -1.0] * 4), 0.0, 0.0, 0.0])
    axes.plot(-3.35 + 1.15 * turns, 1.15 + wire, color=INK, lw=0.9)
    axes.plot([-3.35, -3.35], [0.75, 1.55], color=INK, lw=1.6)
    say(axes, -2.78, 1.55, symbol("rig_stiffness"))
    arrow(axes, (-3.75, 0.5), (-2.95, 0.5), "<|-|>")
    say(axes, -3.35, 0.24, f"±{symbol('displacement_amplitude')}")
    say(axes, -1.75, -1.3, f"scar, depth {symbol('wear_depth')}", color=SCAR)
    axes.plot([-1.35, -1.12], [-1.13, -0.05], color=SCAR, lw=0.6)
    say(axes, 1.5, -0.5, "flat")
    say(axes, -1.4, 1.5, "sphere")


def above(axes: Axes) -> None:
    """The zones from above, and their widths."""
    drawing(axes, (-1.75, 1.75), (-1.65, 1.67), "From above")
    slip, stick = (ZONE_COLORS[state] for state in (ContactState.SLIP, ContactState.STICK))
    axes.add_patch(Circle((0.0, 0.0), 1.0, fc=slip, ec=INK, lw=0.8))
    axes.add_patch(Circle((0.0, 0.0), STICK, fc=stick, ec=INK, lw=0.8))
    light = {"color": "white"}
    say(axes, 0.0, 0.3, "stick", **light)
    say(axes, 0.0, 0.79, "slip")
    axes.plot([-0.62, -0.95], [0.55, 1.05], color=MUTED, lw=0.5)
    say(axes, -1.0, 1.17, "worn")
    for y, reach, name in ((-1.2, 1.0, "hertz_radius"), (-0.18, STICK, "stick_radius")):
        look = INK if name == "hertz_radius" else "white"
        axes.annotate(
            "", (reach, y), (0.0, y),
            arrowprops={"arrowstyle": "<|-|>", "color": look, "lw": 0.9, "shrinkA": 0.0,
                        "shrinkB": 0.0, "mutation_scale": 7.0},
        )  # fmt: skip
        say(axes, 0.5 * reach, y - 0.16, symbol(name), color=look)
    for x in (0.0, 1.0):
        axes.plot([x, x], [-1.3, -0.9 if x == 0.0 else -0.05], color=MUTED, lw=0.5)
    arrow(axes, (1.1, 0.0), (1.6, 0.0), "-|>")
    say(axes, 1.5, -0.17, "$x$")
    arrow(axes, (0.0, 1.03), (0.0, 1.5), "-|>")
    say(axes, 0.14, 1.42, "$y$")


def loop(axes: Axes) -> None:
    """Force against displacement over a cycle (Mindlin and Deresiewicz), and its area."""
    loading = np.linspace(0.0, 1.0, 101)

    def displacement(ratio: np.ndarray) -> np.ndarray:
        return 1.0 - (1.0 - RATIO * ratio) ** (2.0 / 3.0)

    end = displacement(np.array(1.0))
    back = end - 2.0 * displacement(loading)
    force = 1.0 - 2.0 * loading
    x, y = np.concatenate([back, -back]) / end, np.concatenate([force, -force])
    axes.fill(x, y, fc="#f3e3d8", ec=CATEGORICAL[1], lw=1.2)
    axes.plot(displacement(loading) / end, loading, color=CATEGORICAL[1], lw=0.8, ls=(0, (3, 2)))
    drawing(axes, (-1.55, 1.55), (-1.5, 1.5), "One cycle")
    arrow(axes, (-1.5, 0.0), (1.5, 0.0), "-|>")
    arrow(axes, (0.0, -1.4), (0.0, 1.4), "-|>")
    say(axes, 1.42, -0.16, symbol("tangential_displacement"))
    say(axes, 0.1, 1.33, "force", "left")
    say(axes, -0.06, 1.0, f"+{symbol('tangential_load')}", "right")
    say(axes, 0.06, -1.0, f"−{symbol('tangential_load')}", "left")
    axes.plot([0.0, 1.0], [1.0, 1.0], color=MUTED, lw=0.5)
    axes.plot([0.0, -1.0], [-1.0, -1.0], color=MUTED, lw=0.5)
    axes.plot([0.42, 0.9], [0.3, -0.75], color=SCAR, lw=0.6)
    say(axes, 0.92, -0.87, f"area {symbol('dissipated_energy')}", color=SCAR)


def sketch() -> JournalFigure:
    """The three drawings side by side."""
    with style_context():
        figure = JournalFigure(2, 62.0)
        figure.set_layout_engine(None)
        # Widths that give all drawings equal scales along both axes.
        for draw, left, width in ((side, 0.0, 0.415), (above, 0.44, 0.296), (loop, 0.76, 0.235)):
            draw(figure.add_axes((left, 0.02, width, 0.86)))
    return figure


if __name__ == "__main__":
    save_as(sketch(), sys.argv[1])
