"""The twin of a run: the same case on wider cells, from which errors are estimated."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from fretwear.mechanics.contact.problem import ContactError
from fretwear.mechanics.wear.integrator import WearError
from fretwear.mechanics.wear.measures import Measures
from fretwear.mechanics.wear.state import Workspace
from fretwear.run.states import states, wear_problem
from fretwear.study.case import Case


class Twin:
    """A run of a case that advances beside another one, snapshot by snapshot."""

    def __init__(self, case: Case, coarseness: float) -> None:
        #: every scalar at each snapshot that the twin has reached
        self.rows: list[dict[str, float]] = []
        #: why the twin goes no further; empty if it does
        self.trouble = ""
        self._snapshots = _snapshots(case, coarseness)

    def advance(self, count: int) -> None:
        """Go on to a number of snapshots."""
        try:
            self.rows.extend(islice(self._snapshots, count - len(self.rows)))
        except (ContactError, WearError) as error:
            self.trouble = str(error) or type(error).__name__


def _snapshots(case: Case, coarseness: float) -> Iterator[dict[str, float]]:
    problem = wear_problem(case, None, coarseness)
    workspace = Workspace(problem)
    for state in states(case, problem, for_errors=True):
        if state.cycle in case.output_cycles:
            yield Measures(problem.of(state), state, workspace).scalars({})
