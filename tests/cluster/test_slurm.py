"""The workflow on SLURM: its profile anywhere, real daemons and jobs where there is a cluster."""

import json
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import yaml

from fretwear.data.files import open_summary
from fretwear.run.case_files import simulate_to_file
from fretwear.run.workflow import StudyJobs
from fretwear.study.reading import load_study

from ..run.conftest import assert_same
from ..studies import TITANIUM, VOLUME, printed, write_study

pytest.importorskip("snakemake_executor_plugin_slurm", reason="needs the extra slurm")

REPOSITORY = Path(__file__).parents[2]
OFF = "needs a cluster made of this machine alone: .ci/with-slurm pytest tests/cluster"


@pytest.fixture
def snakemake(tmp_path):
    """Run Snakemake in a folder of its own; return its exit status and what it said."""
    shutil.copy(REPOSITORY / "Snakefile", tmp_path)
    for part in ("profiles", "studies"):
        shutil.copytree(REPOSITORY / part, tmp_path / part)

    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"

    def run(*options):
        command = [sys.executable, "-m", "snakemake", "--profile", "profiles/slurm", *options]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        pipes |= {"env": os.environ | {"PATH": path}, "timeout": 1800}
        done = subprocess.run(command, cwd=tmp_path, check=False, **pipes)
        return done.returncode, done.stdout

    return run


def test_the_profile_holds_settings_that_snakemake_and_its_plugin_know(snakemake, tmp_path):
    status, said = snakemake("--dry-run")
    assert status == 0, said
    assert "Using profiles profiles/slurm and workflow specific profile profiles/default" in said
    # A misspelt setting would not have been taken.
    file = tmp_path / "profiles/slurm/config.yaml"
    file.write_text(file.read_text().replace("slurm-status-command", "slurm-status-comand"))
    assert snakemake("--dry-run")[0] != 0


@pytest.mark.slow
@pytest.mark.skipif("FRETWEAR_TEST_SLURM" not in os.environ, reason=OFF)
def test_the_documented_command_takes_the_default_study_to_its_report(snakemake, tmp_path):
    file, results = tmp_path / "studies/demo.yaml", tmp_path / "results/demo"
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    cases = load_study(write_study(file, content | {"batch": 6})).cases()
    status, said = snakemake()
    assert status == 0, said
    with open_summary(results / "summary.nc") as summary:
        assert summary["status"].size == len(cases) == 24
        assert (summary["status"] == 0).all()
    page = (results / "report.html").read_text(encoding="utf-8")
    assert all(case_id in page for case_id in cases)
    case_id = next(case_id for case_id in cases if "-smooth-elastic-" in case_id)
    simulate_to_file(cases[case_id], tmp_path / "here.nc", tell=print, command="test")
    assert_same(results / f"cases/{case_id}.nc", tmp_path / "here.nc")


def jobs_of_slurm():
    """Names and values of each job that SLURM remembers, in their order."""
    said = printed("scontrol", "show", "--oneliner", "job")
    return [dict(re.findall(r"(\S+?)=(\S*)", line)) for line in said.splitlines() if "=" in line]


def cancel_the_first():
    while not (running := [job for job in jobs_of_slurm() if job["JobState"] == "RUNNING"]):
        time.sleep(1.0)
    subprocess.run(["scancel", running[0]["JobId"]], check=True)


@pytest.mark.slow
@pytest.mark.skipif("FRETWEAR_TEST_SLURM" not in os.environ, reason=OFF)
def test_a_fit_is_a_job_with_cores_memory_and_time_and_when_cancelled_has_twice_as_much(
    snakemake, tmp_path, monkeypatch
):
    """A volume of 4 K P δ N gives K."""
    monkeypatch.chdir(tmp_path)
    sought = {"free": {"wear_coefficient": ["1e-14 / Pa", "1e-12 / Pa"]}, "data": [VOLUME]}
    write_study(tmp_path / "studies/volume.yaml", {"base": TITANIUM, "fit": sought})
    others = {job["JobId"] for job in jobs_of_slurm()}
    watcher = threading.Thread(target=cancel_the_first, daemon=True)
    watcher.start()
    target = "results/volume/fit.json"
    status, said = snakemake("--config", "study=volume", "--set-threads", "fit=2", "--", target)
    assert status == 0, said
    fitted = json.loads((tmp_path / target).read_text(encoding="utf-8"))
    (found,) = fitted["parameters"].values()
    assert found["value"] == pytest.approx(2e-13, rel=0.01)
    ours = StudyJobs.of({"study": "volume"})
    keys = ("CPUs/Task", "MinMemoryNode", "TimeLimit")
    asked = [[job[key] for key in keys] for job in jobs_of_slurm() if job["JobId"] not in others]
    memory, minutes = ours.memory_mb_of_fit(2), ours.minutes_of_fit
    assert asked == [
        ["2", f"{memory}M", f"00:{minutes:02d}:00"],
        ["2", f"{2 * memory}M", f"00:{2 * minutes:02d}:00"],
    ]
