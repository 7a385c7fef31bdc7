"""The page docs/performance.md: everything that is measured of the simulator's speed."""

import sys

from benchmarks.accuracy import costs, costs_figure, costs_text
from benchmarks.pages import Data, Page, Section, scientific, table
from benchmarks.peers import __main__ as peers
from benchmarks.peers.contacts import RESIDUAL, TUNING_CELLS
from benchmarks.scale import LARGEST, cases_curve, cases_figure, cells_curve, cells_figure
from benchmarks.speed.jobs import groups, measure
from benchmarks.speed.table import HEADER, Row, from_json, number, surroundings
from benchmarks.speed.table import cells as texts

INTRODUCTION = """\
# Performance

Every number on this page is measured by one command, from the repository's root, with the package
and its extra `bench` installed:

```
python -m benchmarks.performance
```

It keeps what it found in `performance.json` beside this page, and writes the page and its figures
from that file. Parts can be measured alone ({names}); `--render` only writes the page. For a
quick look without changing the page: `python -m benchmarks.speed` (the table, a minute or two),
`python -m benchmarks.peers`, `python -m benchmarks.scale`.

**1 CE** is the time of one bare convolution by scipy.fft on the same quarter window, on one thread:
cosine transform of the rows that are not zero, then of all columns, multiplication, inverse. It is
measured in the same process, in turn with the job: around each cold solve, after each step of a
run. The time of a run in CE is the sum over its steps, each in the unit of the window that it was
made on; a window grows with the contact, so units of the last window would give a smaller number,
which is noted too. All CE are ratios of medians of processor times, which other work on the machine
disturbs less than the clock; what the clock says is noted. Rows of the transforms' share count the
processor time inside the calls of transforms, of whichever library, as medians of some runs. Start
times are the shortest of nine on the clock: what else the machine does can only add. The time per
cell at half the spacing is a ratio of means of runs that take turns. scipy's convolution is dearer
per cell where the cells along an axis are a power of two, as in the cold solves: their numbers in
CE are smaller for it. What the same solves take on 250² cells is noted beside.

The table and the curves against cells are of the code as it is; other libraries were measured at
commit e2c2ba5, studies of many cases at d9bfad1, which compute the same.
"""


def _measure_table() -> Data:
    return {"rows": [row.as_json() for row in measure(groups(full=True).values())]}


def _measure_peers() -> Data:
    rows, found = peers.measure(peers.CELLS, peers.CELLS_ON_RADIUS)
    return {"rows": [row.as_json() for row in rows], **found}


def rows_text(rows: list[Row]) -> str:
    """The rows as a table, and below it what else was found of each."""
    lines = [texts(row) for row in rows]
    notes = "\n".join(f"- {row.job}: {row.note}." for row in rows if row.note)
    return f"{table(HEADER, lines)}\n\nAlso:\n\n{notes}"


def _table_text(data: Data) -> str:
    return rows_text([from_json(entry) for entry in data["rows"]])


def _peers_text(data: Data) -> str:
    loop, one, two = data["wear_loop"], data["cold"]["1"], data["cold"]["2"]
    fastest = one[0]["cpu"]
    solves = [
        [
            entry["name"],
            f"{entry['cpu']:.3g}",
            f"{entry['cpu'] / fastest:.3g}",
            f"{entry['wall']:.3g}",
            f"{both['wall']:.3g}",
            scientific(entry["residual"]),
        ]
        for entry, both in zip(one, two, strict=True)
    ]
    solve_header = [
        "",
        "processor, one thread, s",
        "times the first",
        "clock, one thread, s",
        "clock, two threads, s",
        "residual",
    ]
    loops = [
        [
            f"{entry['name']}, residual {scientific(entry['residual'])}",
            f"{entry[kind]['steps']:.0f}",
            f"{entry[kind]['seconds']:.0f}",
            number(entry[kind]["ratio"]),
        ]
        for kind in ("limit", "longer")
        for entry in loop["peers"]
    ]
    count = len(loop["peers"])
    own = loop["own"]
    loop_header = ["", "steps", "s", "times ours"]
    settings = "\n".join(f"- {entry['name']}: {entry['settings']}." for entry in one)
    return f"""\
{rows_text([from_json(entry) for entry in data["rows"]])}

### The same cold solve

The first loading of the smooth sphere on {data["cold_cells"]}² cells of the whole contact, from the
shape to the pressure, influence coefficients and Green's functions included. The residual is
computed by the same code for all, from the pressure alone. fretwear has the tolerance
{RESIDUAL:.0e}; each peer has the largest of a ladder of half powers of ten that gave at most this
residual on {TUNING_CELLS}² cells, made smaller where it did not on these. The runs take turns,
medians of three. The first line uses the symmetry of the contact; the second solves it as if it
had none.

{table(solve_header, solves)}

{settings}

The wheel of tamaas has the backend `cpp`, which has no threads, although it is given their number;
in ContactMechanics and its transforms we found no setting for it.

### A whole wear run

Smooth elastic, 30000 cycles, spacing a/{loop["cells_on_radius"]:g},
{loop["cells"][0]} × {loop["cells"][1]} cells of the whole contact, one thread. Ours:
{own["cpu"]:.2f} s of the processor, {own["steps"]} steps. The explicit loop solves the contacts at
P and at P* before each step, both from the pressure of the step before. Steps are timed at
{", ".join(f"{cycle:.0f}" for cycle in loop["at"])} cycles and summed over the run.

Steps at the stability limit, ΔN = 2 · 0.58 h / (β E* max g*) on the shape of the moment
({loop["limits"][0]:.1f} cycles at first, {loop["limits"][-1]:.1f} at last):

{table(loop_header, loops[:count])}

A loop that watches its error can take longer steps late in the run, where the slip zone carries
next to nothing (up to {max(loop["longer"]):.0f} cycles, found by comparing with steps half as
long on a coarser grid):

{table(loop_header, loops[count:])}
"""


def _cells_text(data: Data) -> str:
    rows = [
        [
            f"{point['shape'][0]} × {point['shape'][1]}",
            number(point["cpu"]),
            number(point["wall"]),
            number((point["peak_bytes"] - point["start_bytes"]) / 1e6),
            f"{point['arrays']:.1f}",
            str(point["steps"]),
            str(point["convolutions"]),
        ]
        for point in data["points"]
    ]
    header = [
        "quarter cells at the end",
        "processor, s",
        "clock, s",
        "memory, MB",
        "padded arrays",
        "steps",
        "convolutions",
    ]
    return f"""\
Smooth elastic, 30000 cycles, one thread, each run in a process of its own; memory is the most that
the process held above what it holds with everything imported, about
{data["points"][0]["start_bytes"] / 1e6:.0f} MB. Between the {LARGEST} largest, time grows
like cells^{data["time_exponent"]:.2f} and memory like cells^{data["memory_exponent"]:.2f}.

{table(header, rows)}

{{figure}}
"""


def _cases_text(data: Data) -> str:
    rows = [
        [
            str(point["cases"]),
            number(point["wall"]),
            number(point["cpu"]),
            f"{point['wall'] / point['cases']:.2g}",
            f"{point['peak_bytes'] / 1e6:.0f}",
            number(point["result_bytes"] / 1e6),
        ]
        for point in data["points"]
    ]
    header = [
        "cases",
        "clock, s",
        "processor, s",
        "clock, s per case",
        "process, MB",
        "results, MB",
    ]
    return f"""\
Studies of tiny cases (100 cycles on 10 µm cells, a fraction of a second each) through the whole
workflow, `snakemake --cores {data["cores"]}`: simulations, merged study, figures, report. From ten
cases on, the time by the clock grows like cases^{data["time_exponent"]:.2f}. Memory is what the
largest process so far took.

{table(header, rows)}

{{figure}}
"""


def footer(entry: Data) -> str:
    """Time, machine and versions."""
    versions = ", ".join(f"{name} {number}" for name, number in entry["versions"].items())
    return (
        f"{entry['seconds']} s on {entry['cores']} cores of {entry['processor']}, "
        f"load average {entry['load_average']} at the start; {versions}"
    )


SECTIONS = (
    Section("table", "What was asked, and what was measured", _measure_table, _table_text),
    Section("peers", "Other libraries", _measure_peers, _peers_text),
    Section(
        "cells",
        "Time and memory against cells",
        cells_curve,
        _cells_text,
        figures=lambda data: {"": cells_figure(data)},
    ),
    Section(
        "cases",
        "Time against the number of cases",
        cases_curve,
        _cases_text,
        figures=lambda data: {"": cases_figure(data)},
    ),
    Section(
        "accuracy",
        "Cost against error",
        costs,
        costs_text,
        figures=lambda data: {"": costs_figure(data)},
        on_request=True,
    ),
)
PAGE = Page("performance", INTRODUCTION, SECTIONS, surroundings, footer)

if __name__ == "__main__":
    sys.exit(PAGE.main())
