"""The groups of rows that the table is made of."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial

from benchmarks.speed import contacts, resources, runs
from benchmarks.speed.rows import Row, header, line

Group = Callable[[], Iterator[Row]]


def groups(*, full: bool = False, coarser: float = 1.0, repeats: int = 5) -> dict[str, Group]:
    """What can be measured, by name.

    Parameters
    ----------
    full
        Whether to run at half the spacing too, which takes minutes.
    coarser
        Factor on the spacings, to try the command out.
    repeats
        Repetitions of the short jobs.
    """

    def contact() -> Iterator[Row]:
        for rough in (False, True):
            yield contacts.beside_a_power_of_two(
                rough=rough, cells=max(16, round(256 / coarser)), repeats=repeats
            )

    def memory() -> Iterator[Row]:
        yield resources.peak_memory(256 / coarser)

    return {
        "contact": contact,
        "smooth": partial(runs.smooth_rows, 128 / coarser),
        "rough": partial(runs.rough_rows, coarser, halved=full),
        "memory": memory,
        "start": partial(resources.start_times, 2 * repeats - 1),
    }


def measure(wanted: Iterable[Group]) -> list[Row]:
    """Measure some groups and print each line as it comes."""
    rows = []
    print(header(), flush=True)
    for group in wanted:
        for row in group():
            rows.append(row)
            print(line(row), flush=True)
    return rows
