"""A small real study with a case that failed and a point that is invalid, and its report."""

from pathlib import Path
from typing import NamedTuple

import pytest
import xarray as xr

from fretwear.data.merge import merge_study
from fretwear.data.store import write_case
from fretwear.figures.study import write_study_figures
from fretwear.report import build_report
from fretwear.simulation import run
from fretwear.study.file import load_study
from fretwear.study.plan import Plan, plan_study

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


class Finished(NamedTuple):
    """A study that has been run, merged and drawn."""

    plan: Plan
    summary: xr.Dataset
    cases: Path
    figures: Path
    failed: str

    def report(self, **more: object) -> str:
        """Build its report."""
        return build_report(self.plan, self.summary, self.cases, self.figures, **more)


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Finished:
    folder = tmp_path_factory.mktemp("results")
    file = folder / "small.yaml"
    file.write_text(STUDY, encoding="utf-8")
    study = load_study(file)
    *rest, failed = study.cases()
    for case_id in rest:
        result = run(study.cases()[case_id])
        write_case(result.dataset, result.history, folder / "cases" / f"{case_id}.nc")
    merge_study(study, folder / "cases", folder / "summary.nc")
    summary = xr.load_dataset(folder / "summary.nc")
    write_study_figures(summary, folder / "cases", folder / "figures")
    return Finished(plan_study(study), summary, folder / "cases", folder / "figures", failed)


@pytest.fixture(scope="session")
def page(finished: Finished) -> str:
    return finished.report(failures={finished.failed: "it did not converge in cycle 7 <of 1000>"})
