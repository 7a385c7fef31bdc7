"""A small real study with a case that failed and a point that is invalid, and its report."""

import shutil
from pathlib import Path
from typing import NamedTuple

import pytest
import xarray as xr
import yaml

from fretwear.data.merge import merge_study
from fretwear.figures.index import INDEX_NAME
from fretwear.figures.study import write_study_figures
from fretwear.report import build_report
from fretwear.run.workflow import log_file, record
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
  roughness: {kind: wavy, slope_x: 1.8 deg, slope_y: 1 deg}
  cell: [3.9 um, 4 um]
  cycles: 1000
vary:
  load: [20 N, 40 N]
  friction: [0.2, 0.4]
  roughness.amplitude: [0 um, 0.3 um]
  plastic_limit: [none, 3000 MPa]
invalid: skip
output:
  cycles: [1, 10, 100]
# a comment with </code><script>alert(1)</script> in it
"""


REASON = "it did not converge in cycle 7 <of 1000>"


class Finished(NamedTuple):
    """A study that has been run, merged and drawn."""

    plan: Plan
    summary: xr.Dataset
    folder: Path
    failed: str

    @property
    def cases(self):
        return self.folder / "cases"

    def report(self, **more):
        return build_report(self.plan, self.summary, self.folder, **more)

    def derived(self, folder, vary, **base):
        """Make another study of cases that this one has: no simulation is needed."""
        content = yaml.safe_load(STUDY)
        content["base"].update(base)
        content["vary"] = yaml.safe_load(vary)
        content["design"] = content["vary"].pop("design", "grid")
        file = folder / "derived.yaml"
        file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        study = load_study(file)
        shutil.copytree(self.cases, folder / "cases")
        merge_study(study, folder / "cases", folder / "summary.nc")
        summary = xr.load_dataset(folder / "summary.nc")
        (folder / "figures").mkdir()
        (folder / "figures" / INDEX_NAME).write_text("[]")
        return Finished(Plan(study), summary, folder, "")


@pytest.fixture(scope="session")
def finished(made_once):
    def make(folder):
        study = load_study(write_study(folder / "small.yaml", STUDY))
        *rest, failed = study.cases()
        run_study(study, folder, rest)
        summary = xr.load_dataset(folder / "summary.nc")
        # Figures of one load and friction: fewer panels to draw.
        part = summary.isel(normal_load=[1], friction=[1])
        write_study_figures(part, folder / "cases", folder / "figures")
        record(folder, failed, REASON)
        log = "cycle 6 of 1000\n</pre><b>cycle 7</b>\n"
        log_file(folder, failed).write_text(log, encoding="utf-8")

    folder = made_once("small-report", make)
    study = load_study(folder / "small.yaml")
    *_, failed = study.cases()
    return Finished(Plan(study), xr.load_dataset(folder / "summary.nc"), folder, failed)


@pytest.fixture(scope="session")
def page(finished):
    return finished.report()
