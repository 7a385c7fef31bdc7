"""Runs of a fit: what measurements need of each, kept in a folder, so that a fit resumes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fretwear.arrays import Array
from fretwear.data.atomic import write_text
from fretwear.data.dataset import line_near_the_middle, mirrored
from fretwear.results import CYCLE, OPTIONAL_SCALARS, X, Y, scalars_of
from fretwear.run.simulate import run
from fretwear.study.case import Case
from fretwear.version import case_digest, code_digest

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor

# A process of its own takes this long to start, s.
_WORTH_A_PROCESS = 0.7


@dataclass(frozen=True)
class Prediction:
    """What measurements are compared with, of one run at its snapshots, in SI units."""

    cycles: Array
    numbers: Mapping[str, Array]  # scalars by name, over the cycles
    errors: Mapping[str, Array]  # their estimated errors, two standard deviations; may be empty
    profiles: Mapping[str, tuple[Array, Array]]  # by "field x": positions, depths over the cycles
    loops: tuple[Array, Array]  # displacement, force, shape (cycles, phases)

    def row(self, cycle: float) -> int:
        """The index of a snapshot."""
        return int(np.flatnonzero(self.cycles == cycle)[0])

    def number(self, name: str, cycle: float) -> float:
        """A scalar at a snapshot."""
        return float(self.numbers[name][self.row(cycle)])

    def deviation(self, name: str, cycle: float) -> float:
        """The standard deviation of a scalar by numerical errors; 0 if it was not estimated."""
        if name not in self.errors:
            return 0.0
        error = 0.5 * float(self.errors[name][self.row(cycle)])
        return error if np.isfinite(error) else 0.0

    @classmethod
    def of(cls, case: Case, profiles: Iterable[tuple[str, str]]) -> Prediction:
        """Run a case; `profiles` are the fields that are measured and their directions."""
        result = run(case)
        dataset, loops = result.dataset, result.loops
        fields = {name for name, _ in profiles}
        whole = mirrored(dataset[[*fields]]) if fields else dataset
        names = [scalar.name for scalar in (*scalars_of(case.frame), *OPTIONAL_SCALARS)]
        numbers = {name: dataset[name].values for name in names if name in dataset}
        estimates = {name: f"{name}_error" for name in numbers}
        errors = {n: dataset[error].values for n, error in estimates.items() if error in dataset}
        lines = {}
        for name, along in profiles:
            field = whole[name]
            if along == Y.name:
                field = field.sel({X.name: 0.0}, method="nearest").transpose(CYCLE.name, Y.name)
            else:
                field = line_near_the_middle(field)
            lines[f"{name} {along}"] = whole[along].values, field.values.astype(float)
        curves = loops["displacement"].values, loops["force"].values
        return cls(dataset[CYCLE.name].values, numbers, errors, lines, curves)

    def packed(self) -> dict[str, object]:
        """The prediction as lists, for JSON."""
        content = dict(vars(self))
        return json.loads(json.dumps(content, default=lambda array: array.tolist()))  # type: ignore[no-any-return]

    @classmethod
    def unpacked(cls, content: Mapping[str, Any]) -> Prediction:
        """The prediction from what `packed` returned."""

        def array(values: object) -> Array:
            return np.array(values, float)

        numbers, errors = (
            {name: array(values) for name, values in content[table].items()}
            for table in ("numbers", "errors")
        )
        lines = {n: (array(x), array(depths)) for n, (x, depths) in content["profiles"].items()}
        where, force = content["loops"]
        return cls(array(content["cycles"]), numbers, errors, lines, (array(where), array(force)))


class Runs:
    """Runs cases, each once; a folder keeps what they predict."""

    def __init__(
        self,
        profiles: Iterable[tuple[str, str]],
        folder: Path | None = None,
        processes: int = 1,
        tell: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.profiles = sorted(profiles)
        self.folder, self.processes, self.tell = folder, processes, tell
        self.done: dict[str, Prediction] = {}
        self.computed = 0  # runs that were made
        self.seconds = 0.0  # of the last run
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Runs:
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)

    def __call__(self, cases: Sequence[Case]) -> list[Prediction]:
        """Return what cases predict; those that are not known yet are run side by side."""
        names = [self._name(case) for case in cases]
        new = {n: c for n, c in zip(names, cases, strict=True) if not self._known(n)}
        for name, prediction in zip(new, self._run([*new.values()]), strict=True):
            self.done[name] = prediction
            self.computed += 1
            if self.folder is not None:
                write_text(self.folder / f"{name}.json", json.dumps(prediction.packed()))
        return [self.done[name] for name in names]

    def _name(self, case: Case) -> str:
        digests = code_digest("fretwear_fit"), case_digest(case)
        rest = [case.output_cycles, case.error_estimate, self.profiles, *digests]
        digest = hashlib.sha256(json.dumps(rest).encode()).hexdigest()[:8]
        return f"{case.case_id}-{digest}"

    def _known(self, name: str) -> bool:
        if name not in self.done and self.folder is not None:
            with suppress(OSError, ValueError, LookupError, TypeError):  # then it is run again
                stored = json.loads((self.folder / f"{name}.json").read_bytes())
                self.done[name] = Prediction.unpacked(stored)
        return name in self.done

    def _run(self, cases: Sequence[Case]) -> Iterable[Prediction]:
        from time import perf_counter

        if len(cases) < 2 or self.processes < 2 or 0.0 < self.seconds < _WORTH_A_PROCESS:
            for case in cases:
                started = perf_counter()
                prediction = Prediction.of(case, self.profiles)
                self.seconds = perf_counter() - started
                yield prediction
            return
        if self._pool is None:
            from concurrent.futures import ProcessPoolExecutor
            from multiprocessing import get_context

            self._pool = ProcessPoolExecutor(self.processes, get_context("spawn"))
        yield from self._pool.map(Prediction.of, cases, [self.profiles] * len(cases))
