"""The page docs/performance.md: seconds of typical cases, and of other programs."""

import multiprocessing
import os
import resource
import sys
import time
from collections.abc import Callable
from typing import Any

from benchmarks.pages import Data, Page, Section, scientific, table
from benchmarks.peers import contacts
from benchmarks.study_contacts import STUDY, WAVES

from fretwear import Case, simulate

CELLS = 512
FASTEST = [("smooth", 512), ("smooth", 1024), ("wavy", 512), ("self-affine", 512)]
WARM = [("smooth", 512), ("wavy", 512)]
CYLINDER = {"kind": "cylinder", "radius": "10 mm"}
CASES: dict[str, dict[str, Any]] = {
    "smooth, elastic": {},
    "smooth, yielding": {"plastic_limit": "4500 MPa"},
    "rough, elastic": {"roughness": WAVES, "cycles": 7000},
    "rough, yielding": {"roughness": WAVES, "plastic_limit": "4500 MPa", "cycles": 7000},
    "cylinder, smooth": {"indenter": CYLINDER, "load": "400 N/mm", "tangential_load": "160 N/mm"},
}

INTRODUCTION = """\
# Performance

Processor seconds on one thread. `python -m benchmarks.performance` repeats the measurements in about {minutes} (extra `bench`;
{versions}).

"""


def case_of(name: str) -> Case:
    """One of the typical cases."""
    contact = STUDY | CASES[name]
    if "indenter" in contact:
        del contact["radius"]
    return Case(**contact)


def _run(name: str) -> Data:
    """Run a case in a process that has done nothing else."""
    case, before = case_of(name), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    started = time.process_time()
    dataset = simulate(case, quarter=True)
    seconds = time.process_time() - started
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    worst = max(
        float((dataset[f"{n}_error"] / abs(dataset[n])).isel(cycle=-1))
        for n in ("wear_volume", "contact_area")
    )
    steps = int(dataset.sizes["cycle"])
    return {
        "seconds": seconds, "memory": peak / 1024, "error": worst,
        "cycles": case.cycles, "steps": steps,
    }  # fmt: skip


def _alone(function: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """Call a function in a new process, whose libraries have one thread."""
    os.environ["OMP_NUM_THREADS"] = "1"
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, arguments, options)


def measure_cases() -> Data:
    """Each case in a new process."""
    found = {}
    for name in CASES:
        found[name] = _alone(_run, name)
        print(name, found[name], flush=True)
    return found


def cases_text(data: Data) -> str:
    """A table."""
    rows = [
        [name, f"{run['cycles']}", f"{float(format(run['seconds'], '.2g')):g}", f"{run['memory']:.0f}",
         f"{100 * run['error']:.1f} %"]
        for name, run in data.items()
    ]  # fmt: skip
    header = ["case", "cycles", "processor, s", "memory, MB", "largest printed error"]
    return f"""\
The contact of the [source study](paper.md) with default settings. Memory is without 90 MB of libraries; the error is that of wear volume or contact
area at the last cycle.

{table(header, rows)}
"""


def measure_peers() -> Data:
    """First loadings, in turn with other programs; more of them with the fastest."""
    fastest = [contacts.Aspher]
    return {
        "cold": _alone(contacts.compare, "smooth", CELLS, [*contacts.PEERS, *fastest]),
        "fastest": [_alone(contacts.compare, *contact, fastest) for contact in FASTEST],
        "warm": [_alone(contacts.compare, *contact, fastest, worn=True) for contact in WARM],
    }


def peers_text(data: Data) -> str:
    """A table, and what the fastest is good for."""
    solves = [
        [entry["name"], f"{entry['cpu']:.3g}", scientific(entry["residual"])]
        for entry in data["cold"]
    ]
    ratios: dict[bool, list[float]] = {False: [], True: []}
    for *own, peer in (*data["fastest"], *data["warm"]):
        for is_quarter, entry in enumerate(own):
            ratios[bool(is_quarter)].append(peer["cpu"] / entry["cpu"])
    whole, quarter = (f"{min(each):.1f} to {max(each):.1f}" for each in ratios.values())
    peer = data["fastest"][0][-1]["name"]
    return f"""\
The first loading of a smooth sphere on {CELLS}² cells. All residuals are computed by one code. Tolerances are the largest, in steps of
√10, that keep them below {scientific(contacts.RESIDUAL)}.

{table(["", "processor, s", "residual"], solves)}

In six contacts {peer} takes {whole} times the processor time of fretwear on the whole window and {quarter} times that on a quarter.
aspher has no wear and no pressure limit. Use it with `backend="fft"`: with `"h2"` peaks are 0.03 to 1.3 % too high. In partial slip it agrees with
`coupled` at ν = 0; at ν = 0.3 it reports convergence although the energy of a cycle is 4 % too low or 21 % too high.
"""


SECTIONS = (
    Section(
        "cases",
        "Typical cases",
        measure_cases,
        cases_text,
    ),
    Section(
        "peers",
        "Other programs",
        measure_peers,
        peers_text,
    ),
)


PAGE = Page("performance", INTRODUCTION, SECTIONS)

if __name__ == "__main__":
    sys.exit(PAGE.main())
