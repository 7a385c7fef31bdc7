"""Cold normal contacts in CE."""

from dataclasses import replace
from statistics import median

from benchmarks.speed.cases import first_contact
from benchmarks.speed.rows import Row
from benchmarks.speed.units import Spent, Stopwatch, Unit

from fretwear.mechanics.contact import Contact, solve_contact

RESIDUAL = 1e-6


def cold_contact(*, rough: bool, cells: int = 256, repeats: int = 5) -> Row:
    """The time from a shape to its pressure, influence coefficients included.

    Each solve stands between two samples of the unit; the row is the median of the ratios.
    """
    # What a process does once, such as imports, belongs to none of the solves.
    solve_contact(first_contact(16, rough=rough))
    unit = Unit((cells, cells))
    ratios: list[Spent] = []
    bare: list[float] = []
    before = unit.sample(5)
    for _ in range(repeats):
        watch = Stopwatch()
        problem = first_contact(cells, rough=rough)
        start = watch.read()
        contact = solve_contact(problem, tolerance=RESIDUAL)
        solve = watch.read()
        after = unit.sample(5)
        near = Spent(0.5 * (before.cpu + after.cpu), 0.5 * (before.wall + after.wall))
        ratios.append((start + solve).over(near))
        bare.append(solve.over(near).cpu)
        before = after
    kind, asked, aim = ("rough, 4500 MPa", 120, 70) if rough else ("smooth", 50, 30)
    return Row(
        name=f"cold_{'rough' if rough else 'smooth'}",
        job=f"cold normal contact, {kind}, {cells}² quarter cells",
        measured=median(ratio.cpu for ratio in ratios),
        unit="CE",
        asked=asked,
        aim=aim,
        note=_note(contact, median(bare), median(ratio.wall for ratio in ratios), unit),
    )


def beside_a_power_of_two(*, rough: bool, cells: int = 256, repeats: int = 5) -> Row:
    """The cold solve on so many cells, with a note of the same on a few cells less.

    Where the cells are a power of two the unit itself is dear, and the number small for that.
    """
    row = cold_contact(rough=rough, cells=cells, repeats=repeats)
    fewer = round(cells * 250 / 256)
    other = cold_contact(rough=rough, cells=fewer, repeats=repeats)
    return replace(row, note=f"{row.note}; on {fewer}² cells {other.measured:.0f} CE")


def _note(contact: Contact, bare: float, wall: float, unit: Unit) -> str:
    return (
        f"{contact.convolutions} convolutions, residual {contact.residual:.0e}; "
        f"{bare:.0f} CE without the influence coefficients; {wall:.0f} CE by the clock; "
        f"1 CE = {1e3 * unit.time.cpu:.2f} ms"
    )
