"""The contacts of the comparisons and how to run them."""

from dataclasses import dataclass
from types import SimpleNamespace

from tests.mechanics.problems import COUPLING, FRICTION, P0, RADIUS, WEAR, A

from fretwear.mechanics.wear.integrator import evolve
from fretwear.mechanics.wear.measures import Measures
from fretwear.mechanics.wear.state import State, WearProblem

DEPTH = A**2 / RADIUS
VOLUME = A**4 / RADIUS
TIME_PER_CYCLE = 4 * WEAR * FRICTION * COUPLING * P0
"""τ of one cycle: τ = 4 K_w µ κ p0 N."""

STUDY_LIMIT = 4500e6 / P0


@dataclass(frozen=True)
class Snapshot:
    """A state and its scalars."""

    state: State
    measures: SimpleNamespace

    @property
    def deepest_wear(self) -> float:
        return float(self.state.wear.max())


def snapshots(
    problem: WearProblem, cycles: list[float], tolerance: float = 0.01
) -> dict[float, Snapshot]:
    """Run a contact and keep the states at some cycles, increasing and after 0."""
    kept = {}
    for state in evolve(problem, cycles, tolerance):
        if state.cycle in cycles:
            kept[state.cycle] = Snapshot(state, Measures(problem, state))
    return kept
