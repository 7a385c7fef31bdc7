"""The two lines of the table that need other libraries."""

from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

from benchmarks.peers import cold, wear_loop
from benchmarks.peers.cold import RESIDUAL
from benchmarks.speed.rows import Row, missing

COLD = ("cold_peers", "against the fastest peer, cold, {cells}² whole cells", 10.0, 20.0)
LOOP = ("wear_peers", "against a peer-driven explicit wear loop, a/{cells:g}", 200.0, 1000.0)
CELLS, CELLS_ON_RADIUS = 512, 128.0


def installed() -> bool:
    """Whether the extra ``bench`` is there."""
    return all(find_spec(name) is not None for name in ("tamaas", "ContactMechanics"))


def unmeasured(why: str) -> Iterator[Row]:
    """Both lines without a number."""
    for (name, job, asked, aim), cells in ((COLD, CELLS), (LOOP, CELLS_ON_RADIUS)):
        yield missing(name, job.format(cells=cells), "×", asked, aim, why)


def cold_row(cells: int, results: list[dict[str, Any]]) -> Row:
    """How many times faster than the fastest peer, on one thread."""
    ours, others = results[0], results[2:]
    fastest = min(others, key=lambda entry: entry["cpu"])
    name, job, asked, aim = COLD
    note = (
        f"{ours['cpu']:.2f} s ({results[1]['cpu']:.2f} s without symmetry) against "
        + ", ".join(f"{entry['cpu']:.2f} s {entry['name']}" for entry in others)
        + f"; {fastest['wall'] / ours['wall']:.1f} × by the clock"
    )
    ratio = fastest["cpu"] / ours["cpu"]
    return Row(name, job.format(cells=cells), ratio, "×", asked, aim, at_least=True, note=note)


def loop_row(found: dict[str, Any]) -> Row:
    """How many times faster than the fastest peer's loop at the same residual."""
    equal = [entry for entry in found["peers"] if entry["residual"] <= RESIDUAL]
    fastest = min(equal, key=lambda entry: entry["limit"]["seconds"])
    loop, favored = fastest["limit"], min(e["longer"]["ratio"] for e in found["peers"])
    name, job, asked, aim = LOOP
    note = (
        f"{found['own']['cpu']:.2f} s, {found['own']['steps']} steps against {fastest['name']}: "
        f"{loop['seconds']:.0f} s, {loop['steps']:.0f} steps; {favored:.0f} × where the loop may "
        "be a hundred times less exact and steps get longer late in the run"
    )
    job = job.format(cells=found["cells_on_radius"])
    return Row(name, job, loop["ratio"], "×", asked, aim, at_least=True, note=note)


def rows(coarser: float = 1.0) -> Iterator[Row]:
    """Both lines, measured where the libraries are installed."""
    if not installed():
        yield from unmeasured("the extra bench is not installed")
        return
    cells = max(32, round(CELLS / coarser))
    yield cold_row(cells, [result.as_json() for result in cold.compare(cells)])
    yield loop_row(wear_loop.compare(CELLS_ON_RADIUS / coarser))
