"""A small real study with a case that failed and a point that is invalid, and its report."""

import json
from pathlib import Path
from typing import NamedTuple

import pytest
import xarray as xr

from fretwear.figures import save_as, scalar_history
from fretwear.report import build_report
from fretwear.study.plan import Plan
from fretwear.study.reading import load_study

from ..studies import run_study, write_study

STUDY = """
title: "Loads & <b>friction</b>"
base:
  radius: 10 mm
  youngs_modulus: 208 GPa
  poisson_ratio: 0.3
  tangential_load: 5 N
  wear_coefficient: 7e-13 / Pa
  cell: 10 um
  cycles: 300
vary:
  load: [20 N, 40 N]
  friction: [0.2, 0.4]
  plastic_limit: [none, 3000 MPa]
invalid: skip
output:
  cycles: [10, 100]
# a comment with </code><script>alert(1)</script> in it
"""


REASON = "it did not converge in cycle 7 <of 300>"


class Finished(NamedTuple):
    """A study that has been run, merged and drawn."""

    plan: Plan
    summary: xr.Dataset
    folder: Path
    failed: str

    def report(self, **more):
        return build_report(self.plan, self.summary, self.folder, **more)[0]


@pytest.fixture(scope="session")
def finished(made_once):
    def make(folder):
        study = load_study(write_study(folder / "small.yaml", STUDY))
        *rest, failed = study.cases()
        run_study(study, folder, rest)
        summary = xr.load_dataset(folder / "summary.nc")
        figure = scalar_history(summary, "contact_half_width_x")
        save_as(figure, folder / "figures" / "contact_half_width.svg")
        entry = {"name": "contact_half_width", "caption": "Half-width < 1. All."}
        (folder / "figures/index.json").write_text(json.dumps([entry]))
        (folder / "cases" / f"{failed}.failed").write_text(REASON)

    folder = made_once("small-report", make)
    study = load_study(folder / "small.yaml")
    *_, failed = study.cases()
    return Finished(Plan(study), xr.load_dataset(folder / "summary.nc"), folder, failed)


@pytest.fixture(scope="session")
def page(finished):
    return finished.report()
