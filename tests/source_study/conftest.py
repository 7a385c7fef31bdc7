"""The source study on a coarse grid and for few cycles: real runs that take seconds."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr

from fretwear.data.files import open_summary
from fretwear.study.reading import load_study
from fretwear_source_study.reference_cases import StudyCase, reference_cases

from ..studies import WAVES, base, run_study, write_study

STUDY = {
    "title": "The source study, coarse and short",
    "base": base(
        tangential_ratio=None,
        tangential_load="20 N",
        plastic_limit=None,
        roughness=WAVES,
        cell=["1 um", "4 um"],
        cycles=3500,
        error_estimate=False,
    ),
    "vary": {
        "roughness.amplitude": ["0 um", "0.2 um"],
        "plastic_limit": ["none", "4500 MPa"],
        "slip_model": ["jaeger", "cattaneo_mindlin", "cerruti"],
    },
    "output": {"cycles": [1, 10, 100, 300, 1000, 2000, 3500]},
}


class Merged(NamedTuple):
    """A study that has been run and merged, and its cases with the slip of the worn shape."""

    summary: xr.Dataset
    folder: Path
    cases: dict[str, StudyCase]


@pytest.fixture(scope="session")
def merged(made_once):
    def make(folder):
        run_study(load_study(write_study(folder / "source.yaml", STUDY)), folder)

    folder = made_once("source-study", make)
    with open_summary(folder / "summary.nc") as opened:
        summary = opened.load()
    groups = {model: cases for model, _, cases in reference_cases(summary, folder / "cases")}
    return Merged(summary, folder / "cases", groups["jaeger"])


@pytest.fixture(scope="session")
def cases(merged):
    return merged.cases


def doctored(case, **fields):
    """Replace fields of a case, each by a function of the cycle."""
    dataset = case.dataset.copy()
    for name, function in fields.items():
        values = np.stack([function(cycle) for cycle in case.cycles])
        dataset[name] = (("cycle", "x", "y"), values.astype(dataset[name].dtype))
    return replace(case, dataset=dataset)
