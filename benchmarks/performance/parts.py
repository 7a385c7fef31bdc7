"""What the page is made of: how each part is measured, and what it says."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from benchmarks.peers.cold import RESIDUAL, TUNING_CELLS
from benchmarks.scale import cases, cells
from benchmarks.scale.figures import cases_figure, cells_figure
from benchmarks.speed.rows import HEADER, Row, from_json, number
from benchmarks.speed.rows import cells as texts
from benchmarks.speed.table import groups, measure
from benchmarks.verification.tables import table
from matplotlib.figure import Figure

Data = dict[str, Any]


@dataclass(frozen=True)
class Part:
    """A part of the page.

    Parameters
    ----------
    name
        Key of its data.
    title
        Heading.
    measure
        Finds its data; numbers, texts, lists and dictionaries of them.
    text
        Markdown below the heading, with ``{figure}`` where the figure goes.
    figure
        Draws it, or None.
    """

    name: str
    title: str
    measure: Callable[[], Data]
    text: Callable[[Data], str]
    figure: Callable[[Data], Figure] | None = None


def _measure_table() -> Data:
    return {"rows": [row.as_json() for row in measure(groups(full=True).values())]}


def _measure_peers() -> Data:
    from benchmarks.peers.__main__ import measure as compare
    from benchmarks.peers.rows import CELLS, CELLS_ON_RADIUS

    rows, found = compare(CELLS, CELLS_ON_RADIUS)
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
            f"{entry['residual']:.0e}".replace("e-0", "e-"),
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
            f"{entry['name']}, residual {entry['residual']:.0e}".replace("e-0", "e-"),
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

The wheel of tamaas names `cpp` as its backend, which has no threads, but is told the number; in
ContactMechanics and its transforms we found no setting for it.

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
{data["points"][0]["start_bytes"] / 1e6:.0f} MB. Between the {cells.LARGEST} largest, time grows
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
cases on, the time by the clock grows like cases^{data["time_exponent"]:.2f}. Memory is that of the
largest process so far.

{table(header, rows)}

{{figure}}
"""


PARTS = (
    Part("table", "What was asked, and what was measured", _measure_table, _table_text),
    Part("peers", "Other libraries", _measure_peers, _peers_text),
    Part("cells", "Time and memory against cells", cells.curve, _cells_text, cells_figure),
    Part("cases", "Time against the number of cases", cases.curve, _cases_text, cases_figure),
)
