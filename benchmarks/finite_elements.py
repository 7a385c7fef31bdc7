"""The page docs/finite_elements.md: a cylinder in partial slip by CalculiX and by fretwear.

A cylinder and a flat of one material, plane strain: both are blocks of C3D8 elements, one layer
thick, the upper one with a parabolic face. The far face of the upper block moves down, then along
x; its reactions are the load and the tangential force, with which both programs are compared to
closed forms.
"""

import resource
import subprocess
import tempfile
import time
from math import log, pi, sqrt
from pathlib import Path

import numpy as np
from benchmarks.calculix import last_results, levels, rows_of
from benchmarks.pages import Data, Page, Section, table
from matplotlib.figure import Figure

import fretwear
from fretwear.arrays import Array
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.style import MUTED, JournalFigure, styled

RADIUS, MODULUS, RATIO, FRICTION = 20.0, 208e3, 0.3, 0.5  # mm, MPa
LOAD, SHARE = 600.0, 0.64  # N/mm and Q/µP that are aimed at
WIDTHS = (15.0, 10.0)  # of the elements, µm
STIFFNESS, STICK_STIFFNESS = 1e8, 1e8  # of the contact, N/mm³
FINE, DEEP, GROWTH, FAR = 1.15, 0.35, 1.3, 12.0  # in half-widths

COMPOSITE = MODULUS / (2.0 * (1.0 - RATIO**2))


def half_width(load: float) -> float:
    """Half-width a, mm, of the cylinder under a load, N/mm."""
    return sqrt(4.0 * load * RADIUS / (pi * COMPOSITE))


def slip(x: Array, stick: float) -> Array:
    """Slip, mm, at the distances x beside a stick zone of a half-width, mm."""
    t = np.maximum(np.abs(x) / stick, 1.0)
    return FRICTION * stick**2 / (2.0 * RADIUS) * (t * np.sqrt(t**2 - 1.0) - np.arccosh(t))


def _deck(size: float) -> tuple[str, Array]:
    """Input of CalculiX for elements of a size, mm, and the x of the nodes of the slave face."""
    a = half_width(LOAD)
    far = FAR * a
    side, down = (levels(size, near * a, far, GROWTH, 0.1 * far) for near in (FINE, DEEP))
    x = np.concatenate([-side[:0:-1], side])
    depth, shape = float(down[-1]), (x.size, 2, down.size)
    layers = np.array([0.0, size])
    lines, offset = ["*NODE, NSET=ALL"], 0
    corners_of = {}
    for name, sign in (("FLAT", -1.0), ("CYLINDER", 1.0)):
        grid = np.meshgrid(x, layers, down, indexing="ij")
        height = sign * grid[2]
        if sign > 0.0:
            height = height + grid[0] ** 2 / (2.0 * RADIUS) * (1.0 - grid[2] / depth)
        number = offset + np.arange(1, grid[0].size + 1).reshape(shape)
        lines += rows_of(number.ravel(), grid[0].ravel(), grid[1].ravel(), height.ravel())
        corners_of[name] = number
        offset += grid[0].size
    elements = 0
    faces = {}
    for name, number in corners_of.items():
        low, high = slice(None, -1), slice(1, None)
        # Node order from the lower to the upper face of an element.
        below, above = (high, low) if name == "FLAT" else (low, high)
        corners = [
            number[along, across, depths].ravel()
            for depths in (below, above)
            for along, across in ((low, low), (high, low), (high, high), (low, high))
        ]
        count = corners[0].size
        ids = elements + np.arange(1, count + 1).reshape(number.shape[0] - 1, number.shape[2] - 1)
        lines += [f"*ELEMENT, TYPE=C3D8, ELSET={name}", *rows_of(ids.ravel(), *corners)]
        centres = 0.5 * (x[1:] + x[:-1])
        near = np.abs(centres) < FINE * a
        faces[name] = ids[near, 0]
        elements += count
    for name, face in (("FLAT", "S2"), ("CYLINDER", "S1")):
        lines += [f"*SURFACE, NAME={name}_FACE, TYPE=ELEMENT"]
        lines += [f"{element}, {face}" for element in faces[name]]
    for name, label in (("FLAT", "BASE"), ("CYLINDER", "TOP")):
        lines += [f"*NSET, NSET={label}", *(f"{node}," for node in corners_of[name][:, :, -1].flat)]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{MODULUS}, {RATIO}"]
    for name in corners_of:
        lines.append(f"*SOLID SECTION, ELSET={name}, MATERIAL=STEEL")
    lines += ["*SURFACE INTERACTION, NAME=DRY", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
    lines += [f"{STIFFNESS:g}", "*FRICTION", f"{FRICTION}, {STICK_STIFFNESS:g}"]
    lines += ["*CONTACT PAIR, INTERACTION=DRY, TYPE=SURFACE TO SURFACE", "CYLINDER_FACE, FLAT_FACE"]
    lines += ["*BOUNDARY", "ALL, 2, 2", "BASE, 1, 3"]
    # Compression of two half-cylinders down to a depth (Johnson 1985, section 5.6).
    per_load = 2.0 * (1.0 - RATIO**2) / (pi * MODULUS)
    down_by = per_load * LOAD * (2.0 * log(2.0 * depth / a) - RATIO / (1.0 - RATIO))
    along_by = per_load * SHARE * FRICTION * LOAD * (2.0 * log(2.0 * depth / a) + 1.0)
    for first, move in ((0.1, f"TOP, 3, 3, {-down_by:.9g}\nTOP, 1, 1, 0."),
                        (0.05, f"TOP, 3, 3, {-down_by:.9g}\nTOP, 1, 1, {along_by:.9g}")):  # fmt: skip
        lines += ["*STEP, INC=400", "*STATIC", f"{first}, 1.", "*BOUNDARY", move]
        lines += ["*NODE PRINT, NSET=TOP, TOTALS=ONLY, FREQUENCY=400", "RF"]
        lines += ["*CONTACT FILE, FREQUENCY=400", "CDIS, CSTR", "*END STEP"]
    slave = corners_of["CYLINDER"][:, 0, 0]
    places = np.full(offset + 1, np.nan)
    places[slave] = x
    return "\n".join([*lines, ""]), places


def by_elements(size: float) -> Data:
    """Results of CalculiX with elements of a size, mm; lengths in mm, MPa."""
    text, places = _deck(size)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "contact.inp").write_text(text, encoding="ascii")
        start = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(["ccx", "contact"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
        printed = Path(folder, "contact.dat").read_text(encoding="ascii")
        # Opening, slips, pressure, shears.
        results = last_results(Path(folder, "contact.frd"), "CONTACT")
    found = sorted((places[node], values) for node, values in results.items())
    forces = [line.split() for line in printed.splitlines() if len(line.split()) == 3]
    along, _, down = (abs(float(number)) / size for number in forces[-1])
    kept = [(x, values) for x, values in found if not np.isnan(x)]
    x = np.array([each for each, _ in kept])
    _, slip1, slip2, pressure, shear1, shear2 = np.array([values for _, values in kept]).T
    seconds = end.ru_utime + end.ru_stime - start.ru_utime - start.ru_stime
    shear = np.hypot(shear1, shear2)
    # The elastic slip of the stick stiffness does not dissipate.
    slipped = np.maximum(np.hypot(slip1, slip2) - shear / STICK_STIFFNESS, 0.0)
    return {
        "size": size, "load": down, "force": along, "seconds": seconds, "x": x, "pressure": pressure,
        "slip": slipped, "shear": shear,
    }  # fmt: skip


def by_fretwear(load: float, force: float) -> Data:
    """Results of fretwear under a load and a tangential force, N/mm; lengths in mm, MPa."""
    steel = {"youngs_modulus": MODULUS * 1e6, "poisson_ratio": RATIO, "friction": FRICTION}
    cylinder = {"kind": "cylinder", "radius": RADIUS * 1e-3}
    loads = {"load": load * 1e3, "tangential_load": force * 1e3}
    rest = {"wear_coefficient": 1e-13, "cycles": 1, "accuracy": "none"}
    case = fretwear.Case(indenter=cylinder, **steel, **loads, **rest)
    started = time.process_time()
    first = fretwear.simulate(case).sel(cycle=0)
    seconds = time.process_time() - started
    lines = first.transpose("x", ...)
    fields = {name: lines[name].values.reshape(first.sizes["x"], -1)[:, 0] for name in FIELDS}
    return {
        "seconds": seconds, "x": first["x"].values * 1e3, "stick": float(first["stick_half_width_x"]) * 1e3,
        "pressure": fields["pressure"] * 1e-6, "shear": fields["shear_traction"] * 1e-6,
        "slip": fields["slip"] * 1e3, "energy": float(first["dissipated_energy"]),
    }  # fmt: skip


FIELDS = ("pressure", "shear_traction", "slip")


def measure() -> Data:
    """Deviations from closed forms and seconds of both programs."""
    rows, curves = [], {}
    by_fretwear(LOAD, SHARE * FRICTION * LOAD)  # what a process loads once is not timed
    for size in WIDTHS:
        found = by_elements(size * 1e-3)
        load, force = found["load"], found["force"]
        a = half_width(load)
        stick = a * sqrt(1.0 - force / (FRICTION * load))
        peak = COMPOSITE * a / (2.0 * RADIUS)
        fine = np.linspace(-a, a, 20001)
        exact = 4.0 * FRICTION * peak * np.sqrt(1.0 - (fine / a) ** 2) * slip(fine, stick)
        energy = float(np.trapezoid(exact, fine))
        bound = FRICTION * found["pressure"]
        sticks = found["x"][(found["shear"] < 0.995 * bound) & (bound > 0.0)]
        found["stick"] = 0.5 * (float(np.ptp(sticks)) + size * 1e-3)
        # Results at nodes are smoothed over the edge of the contact, so only what is inside counts.
        inner = [np.interp(fine, found["x"], each) for each in (bound, found["slip"])]
        found["energy"] = float(np.trapezoid(4.0 * inner[0] * inner[1], fine))
        for program, got in (
            (f"CalculiX, {size:.0f} µm", found),
            ("fretwear", by_fretwear(load, force)),
        ):
            x, inside = got["x"], np.abs(got["x"]) < 0.9 * stick
            both = np.interp([-0.9 * a, 0.9 * a], x, got["slip"])
            hertz = np.sqrt(np.maximum(1.0 - (x / a) ** 2, 0.0))
            reduced = np.sqrt(np.maximum(1.0 - (x / stick) ** 2, 0.0))
            shear = FRICTION * peak * (hertz - stick / a * reduced)
            off = np.abs(np.abs(got["shear"]) - shear)[inside] / (FRICTION * peak)
            rows.append([
                program,
                float(np.max(got["pressure"])) / peak - 1.0,
                got["stick"] / stick - 1.0,
                float(both.mean()) / float(slip(np.array([0.9 * a]), stick)[0]) - 1.0,
                got["energy"] / energy - 1.0,
                float(off.max()),
                got["seconds"],
            ])  # fmt: skip
            near = np.abs(x) < 1.05 * a
            curves[f"{program}, {size:.0f}"] = {
                "x": (x / a)[near].tolist(), "shear": (np.abs(got["shear"]) / peak / FRICTION)[near].tolist(),
                "exact": shear[near].tolist(),
            }  # fmt: skip
    return {
        "rows": rows,
        "curves": curves,
        "load": load,
        "share": force / FRICTION / load,
        "stick": stick / a,
    }


def text(data: Data) -> str:
    """The section below its heading."""
    titles = [
        "",
        "peak pressure",
        "stick half-width",
        "slip at 0.9 a",
        "energy",
        "shear in the stick zone",
        "processor, s",
    ]
    lines = [
        [
            name,
            *(f"{100 * each:+.2f} %" for each in numbers[:-2]),
            f"{100 * numbers[-2]:.1f} % of µp0",
            f"{numbers[-1]:.2f}",
        ]
        for name, *numbers in data["rows"][::2]
    ]
    ours = data["rows"][1::2]
    largest = 100 * max(abs(each) for _, *numbers in ours for each in numbers[:-1])
    seconds = [row[-1] for row in data["rows"]]
    ratios = [f"{seconds[n] / seconds[n + 1]:.0f}" for n in range(0, len(seconds), 2)]
    return f"""\
A steel cylinder, R = {RADIUS:.0f} mm, on a flat of the same steel in plane strain: P = {data["load"]:.0f} N/mm, µ = {FRICTION}, first loading to
Q/µP = {data["share"]:.2f} (10 µm; with 15 µm a little less). The table has deviations from the
closed forms of line contacts under the same forces; for shear, the largest one within nine tenths of the stick zone.

{table(titles, lines)}

fretwear deviates by {largest:.2f} % at most and takes {seconds[-1]:.2f} s: CalculiX needs {" and ".join(ratios)} times as much, for a contact without wear. CalculiX locates the
edge of the stick zone to within an element, and its shear traction oscillates inside. Its energy depends on what counts as slip: here the relative
displacement less its elastic part, the shear traction over the stick stiffness.

{{figure}}
"""


@styled
def draw(data: Data) -> Figure:
    """Shear traction over x by both programs."""
    figure = JournalFigure(1, 62.0)
    axes = figure.subplots()
    names = list(data["curves"])
    elements, ours = data["curves"][names[-2]], data["curves"][names[-1]]
    axes.plot(ours["x"], ours["shear"], color=CATEGORICAL[0], label="fretwear")
    axes.plot(
        elements["x"],
        elements["shear"],
        ".-",
        lw=0.6,
        ms=3,
        color=CATEGORICAL[1],
        label=names[-2].rpartition(",")[0],
    )
    for edge in (-data["stick"], data["stick"]):
        axes.axvline(edge, color=MUTED, lw=0.6)
    axes.set(xlabel="x/a", ylabel="Shear traction q/µp$_0$", ylim=(0.0, None))
    axes.legend(frameon=False)
    return figure


PAGE = Page(
    "finite_elements",
    """\
# Against finite elements

`python -m benchmarks.finite_elements` repeats the comparison in about {minutes} of one core (CalculiX 2.20 as `ccx`; {versions}).

""",
    (Section("cylinder", "A cylinder in partial slip", measure, text, figures=lambda data: {"": draw(data)}),),
)  # fmt: skip


if __name__ == "__main__":
    raise SystemExit(PAGE.main())
