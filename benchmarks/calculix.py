"""Loads of ``fretwear export --to abaqus`` on a block of CalculiX, whose stresses are compared.

    python -m benchmarks.calculix [worn.inp case.nc]

Without files it takes those of a steel sphere with 1000 cycles of wear.

The block has a mesh of its own, finer under the contact; the forces of the file go to the four
nodes around each. It is half of the contact, y > 0, held below and at its far sides.
"""

import math
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import fretwear
from fretwear.arrays import Array
from fretwear.data.export import write_abaqus
from fretwear.data.files import write_case
from fretwear.run.simulate import run

STRESSES = ("stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz", "stress_xz")
"""In the order of CalculiX."""

FINE, GROWTH, FAR = 1 / 7, 1.4, 9.0  # size of cells, their growth, and the end, in half-widths
AGREED = 0.05


def loads(path: Path) -> tuple[Array, Array]:
    """Positions (n, 3), m, and forces (n, 3), N, of the nodes of a file."""
    rows: dict[str, list[list[float]]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("*"):
            block = rows.setdefault(line.split(",")[0], [])
        elif line[:1].isdigit():
            block.append([float(number) for number in line.split(",")])
    positions = np.array(rows["*NODE"])[:, 1:]
    forces = np.zeros_like(positions)
    for node, direction, force in rows["*CLOAD"]:
        forces[int(node) - 1, int(direction) - 1] += force
    return positions, forces


def levels(size: float, near: float, far: float, growth: float, widest: float) -> Array:
    """Coordinates from 0: steps of a size up to `near`, then ever wider ones to beyond `far`."""
    steps = [size] * round(near / size)
    while sum(steps) < far:
        steps.append(min(growth * steps[-1], widest))
    return np.concatenate([[0.0], np.cumsum(steps)])


def solve(positions: Array, forces: Array, modulus: float, ratio: float) -> tuple[Array, Array]:
    """Nodes (n, 3), m, and their stresses (n, 6), Pa, of the block."""
    loaded = np.abs(forces).sum(axis=1) > 0.0
    half_width = float(positions[loaded, 0].max())
    y = levels(FINE, 1.2, FAR, GROWTH, math.inf) * half_width
    x, z = np.concatenate([-y[:0:-1], y]), -y
    number = np.arange(1, x.size * y.size * z.size + 1).reshape(x.size, y.size, z.size)
    nodes = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    low, high = slice(None, -1), slice(1, None)
    corners = [
        number[along, across, depth].ravel()
        for depth in (high, low)
        for along, across in ((low, low), (high, low), (high, high), (low, high))
    ]
    held = {*number[..., -1].flat, *number[[0, -1]].flat, *number[:, -1].flat}
    on_nodes = np.zeros((nodes.shape[0], 3))
    for place, force in zip(positions, forces, strict=True):
        if place[1] > 0.0 and force.any():
            i, j = np.searchsorted(x, place[0]) - 1, np.searchsorted(y, place[1]) - 1
            right = (place[0] - x[i]) / (x[i + 1] - x[i])
            back = (place[1] - y[j]) / (y[j + 1] - y[j])
            weights = np.outer([1.0 - right, right], [1.0 - back, back])
            on_nodes[number[i : i + 2, j : j + 2, 0] - 1] += weights[..., None] * force
    lines = ["*NODE, NSET=ALL", *rows_of(np.arange(1, len(nodes) + 1), *nodes.T)]
    lines += ["*ELEMENT, TYPE=C3D8I, ELSET=BLOCK"]
    lines += rows_of(np.arange(1, corners[0].size + 1), *corners)
    lines += ["*MATERIAL, NAME=FLAT", "*ELASTIC", f"{modulus:.9g}, {ratio:.9g}"]
    lines += ["*SOLID SECTION, ELSET=BLOCK, MATERIAL=FLAT", "*BOUNDARY"]
    lines += [f"{node}, 1, 3" for node in sorted(held)] + [
        f"{node}, 2" for node in number[:, 0].ravel()
    ]
    lines += ["*STEP", "*STATIC", "*CLOAD"]
    for node, direction in np.argwhere(on_nodes != 0.0):
        lines.append(f"{node + 1}, {direction + 1}, {on_nodes[node, direction]:.9g}")
    lines += ["*EL FILE", "S", "*END STEP", ""]
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "block.inp").write_text("\n".join(lines), encoding="ascii")
        subprocess.run(["ccx", "block"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        found = last_results(Path(folder, "block.frd"), "STRESS")
    return nodes, np.array([*found.values()])


def rows_of(*columns: Array) -> list[str]:
    """Lines of an input file of CalculiX, one for each row of some columns."""
    return [", ".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]


def last_results(path: Path, name: str) -> dict[int, list[float]]:
    """The last six results of a name of each node, from a file of columns of 12 characters."""
    found: dict[int, list[float]] = {}
    is_wanted = False
    for line in path.read_text(encoding="ascii").splitlines():
        if line.startswith(" -4"):
            is_wanted = line.split()[1] == name
            found = {} if is_wanted else found
        elif is_wanted and line.startswith(" -1"):
            numbers = [float(line[start : start + 12]) for start in range(13, 85, 12)]
            found[int(line[3:13])] = numbers
    return found


def example(folder: Path) -> list[str]:
    """Write the file of a case and its loads; return the names of loads and case."""
    steel = {"youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "wear_coefficient": "7e-13 / Pa"}
    contact = {"radius": "10 mm", "load": "50 N", "tangential_ratio": 0.8, "friction": 0.5}
    case = fretwear.Case(**steel, **contact, cell="4 um", cycles=1000, output_cycles=[0, 1000])
    results = run(case)
    write_case(results.dataset, results.history, folder / "case.nc")
    write_abaqus(results.dataset.fretwear.full(), folder / "worn.inp")
    return [str(folder / "worn.inp"), str(folder / "case.nc")]


def main(arguments: Sequence[str]) -> int:
    """Print the largest stresses of both at nodes on y = 0; 1 if they differ by more than agreed."""
    if not arguments:
        with tempfile.TemporaryDirectory() as folder:
            return main(example(Path(folder)))
    inp, file = map(Path, arguments)
    with fretwear.open_case(file) as case:
        bodies, a = case.fretwear.case, float(case["contact_half_width_x"][-1])
        nodes, found = solve(*loads(inp), bodies.youngs_modulus[1], bodies.poisson_ratio[1])
        depth, inside = -nodes[:, 2] / a, np.abs(nodes[:, 0]) < 1.1 * a
        chosen = (nodes[:, 1] == 0.0) & inside & (depth > 0.25) & (depth < 1.1)
        points = nodes[chosen] * [1.0, 1.0, -1.0]
        at_plus_q = fretwear.stress(case, float(case["cycle"][-1]), points=points).isel(phase=0)
    # The depth of fretwear points down, and so its shear has the other sign.
    theirs = found[chosen] * [1.0, 1.0, 1.0, 1.0, -1.0, -1.0]
    ours = np.stack([at_plus_q[name].values for name in STRESSES], axis=1)
    largest = float(np.abs(ours).max())
    for name, computed, reference in zip(STRESSES, ours.T, theirs.T, strict=True):
        apart = float(np.abs(computed - reference).max())
        ends = ", ".join(f"{np.abs(each).max() * 1e-6:.0f} MPa" for each in (computed, reference))
        print(f"{name}: {ends}; apart by {apart / largest:.1%} of the largest stress at most")
    return int(float(np.abs(ours - theirs).max()) > AGREED * largest)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
