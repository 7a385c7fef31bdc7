"""The section ``output.stress`` of a study: stresses and fatigue beside wear, for every case."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic.dataclasses import dataclass

from fretwear.arrays import Array
from fretwear.results import CYCLE
from fretwear.study.case import Case
from fretwear.study.cycles import Snapshots
from fretwear.study.sections import StudySection
from fretwear.variable import Variable
from fretwear_cracks import StressError
from fretwear_cracks.constants import StressConstants
from fretwear_cracks.variables import FATIGUE

if TYPE_CHECKING:
    import xarray as xr

# Stresses of a cycle below one snapshot.
_SECONDS_PER_SNAPSHOT, _SECONDS_PER_CELL = 0.45, 2.4e-5


@dataclass(frozen=True)
class StressOutput(StressConstants, StudySection):
    """What is asked for of the stresses of every case; see `fretwear.fatigue`."""

    #: the snapshots, which are kept; None: as in a case
    cycles: Snapshots = None

    def seconds(self, case: Case, cells: float) -> float:
        """The processor time of the stresses of a case, s."""
        snapshots = len({0, *(self.cycles or case.output_cycles)})
        return snapshots * (_SECONDS_PER_SNAPSHOT + _SECONDS_PER_CELL * cells)

    def stored(self, case: Path) -> xr.Dataset:
        """The fatigue of a case file, computed where it is missing."""
        from fretwear_cracks.fatigue import stored_fatigue

        return stored_fatigue(case, self.cycles, self.depth, self.constants)

    def after_case(self, case: Path) -> None:
        """Store the fatigue of a case that has just been finished; mistakes are told by `merge`."""
        with suppress(StressError):
            self.stored(case)

    def extra_results(
        self, case: Path, cycles: Array, tell: Callable[[str], None]
    ) -> Mapping[Variable, Array]:
        """The fatigue of a case over cycles, NaN between its snapshots."""
        try:
            fatigue = self.stored(case).reindex({CYCLE.name: cycles})
        except StressError as error:
            tell(f"{case.stem} has no stresses: {error}")
            return {}
        return {result: fatigue[result.name].values for result in FATIGUE if result.name in fatigue}
