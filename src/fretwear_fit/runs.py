"""Runs of a fit: what measurements need of each, kept in a folder, so that a fit resumes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import repeat
from pathlib import Path

import xarray as xr

from fretwear.data.atomic import DataFileError
from fretwear.data.dataset import line_near_the_middle
from fretwear.data.files import write_groups
from fretwear.data.groups import open_group
from fretwear.data.labels import mirrored
from fretwear.results import OPTIONAL_SCALARS, X, Y, scalars_of
from fretwear.run.simulate import run
from fretwear.study.case import Case
from fretwear.version import case_digest, code_digest


def predicted(case: Case, profiles: Iterable[tuple[str, str]]) -> xr.Dataset:
    """Run a case; `profiles` are the fields that are measured and their directions.

    The dataset has what measurements are compared with, at snapshots ``cycle``: scalars and their
    errors, fields along lines, such as ``wear_depth_x``, and force and displacement of loops.
    """
    result = run(case)
    dataset = result.dataset
    names = [scalar.name for scalar in (*scalars_of(case.frame), *OPTIONAL_SCALARS)]
    scalars = [n for name in names for n in (name, f"{name}_error") if n in dataset]
    parts = [dataset[scalars], result.loops]
    for name, along in profiles:
        field = mirrored(dataset[[name]])[name].astype(float)
        if along == Y.name:
            field = field.sel({X.name: 0.0}, method="nearest")
        else:
            field = line_near_the_middle(field)
        parts.append(field.to_dataset(name=f"{name}_{along}"))
    return xr.merge([part.reset_coords(drop=True).drop_attrs() for part in parts])


class Runs:
    """Runs cases, each once; a folder keeps what they predict."""

    def __init__(
        self,
        profiles: Iterable[tuple[str, str]],
        folder: Path | None = None,
        each: Callable[..., Iterator[xr.Dataset]] = map,
    ) -> None:
        """Begin; `each` maps a function to cases, such as the map of a pool of processes."""
        self.profiles, self.folder, self.each = sorted(profiles), folder, each
        self.done: dict[str, xr.Dataset] = {}
        self.computed = 0  # runs that were made

    def __call__(self, cases: Sequence[Case]) -> list[xr.Dataset]:
        """Return what cases predict; those that are not known yet are run side by side."""
        names = [self._name(case) for case in cases]
        new = {n: c for n, c in zip(names, cases, strict=True) if not self._known(n)}
        predictions = self.each(predicted, new.values(), repeat(self.profiles))
        for name, prediction in zip(new, predictions, strict=True):
            self.done[name] = prediction
            self.computed += 1
            if self.folder is not None:
                write_groups(self.folder / f"{name}.nc", {"": prediction})
        return [self.done[name] for name in names]

    def _name(self, case: Case) -> str:
        digests = code_digest("fretwear_fit"), case_digest(case)
        rest = [case.output_cycles, case.error_estimate, self.profiles, *digests]
        digest = hashlib.sha256(json.dumps(rest).encode()).hexdigest()[:8]
        return f"{case.case_id}-{digest}"

    def _known(self, name: str) -> bool:
        if name not in self.done and self.folder is not None:
            with suppress(DataFileError), open_group(self.folder / f"{name}.nc") as stored:
                self.done[name] = stored.load()
        return name in self.done
