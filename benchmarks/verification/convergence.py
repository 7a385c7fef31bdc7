"""Changes of capped runs when tolerance or spacing is halved."""

from dataclasses import replace

from benchmarks.pages import Check, Data, Section, percent, table, worst
from benchmarks.verification.problems import snapshots, study_case

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.wear.state import WearProblem
from fretwear.run.simulate import wear_problem

CYCLES = (1000.0, 3000.0, 7000.0)
TOLERANCE = 0.01
REQUIRED = 0.01
FINER = ("tolerance", "spacing")
NAMES = {
    "wear_volume": "wear volume",
    "plastic_volume": "plastic volume",
    "stick_area": "stick area",
    "contact_half_width_x": "half-width, x",
    "contact_half_width_y": "half-width, y",
}
OTHERS = {"contact_area": "contact area", "dissipated_energy": "dissipated energy"}


def results(problem: WearProblem, tolerance: float) -> Data:
    """Scalars at some cycles, and the effort of the run."""
    found = snapshots(problem, list(CYCLES), tolerance)
    last = found[CYCLES[-1]].state
    return {
        "spacing": list(problem.spacing),
        "tolerance": tolerance,
        "steps": last.step,
        "convolutions": last.convolutions,
        "values": {
            name: [vars(found[cycle].measures)[name] for cycle in CYCLES]
            for name in (*NAMES, *OTHERS)
        },
    }


def halved(problem: WearProblem) -> WearProblem:
    dx, dy = problem.spacing
    return replace(problem, spacing=(dx / 2, dy / 2))


def compare(*, rough: bool) -> Data:
    problem = wear_problem(study_case(rough=rough), Grid)
    return {
        "default": results(problem, TOLERANCE),
        "tolerance": results(problem, TOLERANCE / 2),
        "spacing": results(halved(problem), TOLERANCE),
    }


def run() -> Data:
    return {"smooth": compare(rough=False), "rough": compare(rough=True)}


def changes(case: Data, finer: str, coarser: str, name: str) -> list[float]:
    """Coarser over finer minus one, at each cycle number."""
    pairs = zip(case[coarser]["values"][name], case[finer]["values"][name], strict=True)
    return [coarse / fine - 1 if fine else 0.0 for coarse, fine in pairs]


def checks(data: Data) -> list[Check]:
    found = []
    for change in FINER:
        for kind, name in ((kind, name) for kind in ("smooth", "rough") for name in NAMES):
            if kind == "smooth" and name == "contact_half_width_y":
                continue
            deviations = changes(data[kind], change, "default", name)
            largest = worst(deviations)
            cycle = CYCLES[deviations.index(largest)]
            label = f"{kind} capped, {NAMES[name]}, halved {change}, worst at N = {cycle:.0f}"
            found.append(Check(label, largest, REQUIRED))
    return found


def text(data: Data) -> str:
    rows = [
        [
            f"{label}, {kind}",
            *(percent(worst(changes(data[kind], finer, "default", name))) for finer in FINER),
        ]
        for kind in ("smooth", "rough")
        for name, label in {**NAMES, **OTHERS}.items()
        if (kind, name) != ("smooth", "contact_half_width_y")
    ]
    return f"""\
The study's contact at X = 0.8, capped at 4500 MPa, on a grid ({_size(data["smooth"]["default"])} smooth,
{_size(data["rough"]["default"])} rough), against half the tolerance and half the spacing. Largest change at {", ".join(f"{n:.0f}" for n in CYCLES)} cycles:

{table(["", *(f"half the {finer}" for finer in FINER)], rows)}
"""


def _size(run: Data) -> str:
    dx, dy = (1e6 * length for length in run["spacing"])
    return f"{dx:.2g} µm" if dx == dy else f"{dx:.2g} µm × {dy:.2g} µm"


SECTION = Section("convergence", "Capped runs: tolerance and spacing", run, text, checks)
