"""The workflow on SLURM: real daemons, real jobs."""

import os
import re
import subprocess
import sys

import pytest

from fretwear.data.files import open_summary
from fretwear.run.workflow import StudyJobs
from fretwear.study.reading import load_study

from ..run.conftest import assert_same
from .conftest import eventually

OFF = "needs a cluster made of this machine alone: .ci/with-slurm pytest tests/cluster"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif("FRETWEAR_TEST_SLURM" not in os.environ, reason=OFF),
]

COMMAND = "snakemake --profile profiles/slurm"
BATCH = 6  # cases of a job: starting a job takes as long as some of the cases
# For a machine that has much else to do; alone it takes a tenth of this.
LONG = 1800


def slurm(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def jobs_of(run, state=""):
    """What SLURM knows of the jobs that a run has submitted, by their ids."""
    known = {}
    for line in slurm("scontrol", "show", "job", "--oneliner").splitlines():
        job = dict(part.partition("=")[::2] for part in line.split() if "=" in part)
        is_own = f"SLURM run ID: {job.get('JobName')}" in run.output
        if is_own and state in ("", job["JobState"]):
            known[job["JobId"]] = job
    return known


def megabytes(text):
    return float(text[:-1]) * {"M": 1, "G": 1024, "T": 1024**2}[text[-1]]


def simulate_here(study, case_id, folder):
    """Run a case without Snakemake and SLURM; return its file."""
    file = folder / f"{case_id}.nc"
    call = [sys.executable, "-m", "fretwear", "run", study, "--case", case_id, "-o", file]
    subprocess.run(call, check=True, capture_output=True)
    return file


@pytest.fixture(scope="module")
def demo(checkout):
    """The default study."""
    checkout.write_study("demo", checkout.demo | {"batch": BATCH})
    run = checkout.start(COMMAND)
    assert run.end(LONG) == 0, run.output
    return run


def test_the_documented_command_takes_the_default_study_to_its_report(demo, tmp_path):
    results = demo.folder / "results/demo"
    study = demo.folder / "studies/demo.yaml"
    cases = load_study(study).cases()
    assert len(cases) == 24
    with open_summary(results / "summary.nc") as summary:
        assert (summary["status"] == 0).all()
    page = (results / "report.html").read_text(encoding="utf-8")
    assert all(case_id in page for case_id in cases)
    quick = [case_id for case_id in cases if "-smooth-elastic-" in case_id]
    for case_id in quick[1:3]:
        here = simulate_here(study, case_id, tmp_path)
        assert_same(results / f"cases/{case_id}.nc", here)


def test_slurm_gets_what_the_plan_says_a_job_takes(demo, monkeypatch):
    monkeypatch.chdir(demo.folder)
    planned = StudyJobs.of({})
    submitted = jobs_of(demo)
    assert len(submitted) == 24 / BATCH
    for job in submitted.values():
        rule, _, wildcard = job["Comment"].partition("_wildcards_")
        assert rule == "rule_simulate"
        hours, minutes, seconds = job["TimeLimit"].split(":")
        assert seconds == "00"
        assert 60 * int(hours) + int(minutes) == planned.minutes(wildcard)
        assert megabytes(job["MinMemoryNode"]) == planned.memory_mb(wildcard)
        assert job["NumCPUs"] == "1"
        assert job["JobState"] == "COMPLETED"


def test_a_study_goes_on_after_its_time_limit_and_after_ctrl_c(checkout, tmp_path):
    wavy = {"kind": "wavy", "amplitude": "0.1 um", "slope_x": "3 deg", "slope_y": "1 deg"}
    varied = {"load": "40 N", "friction": 0.6, "roughness": wavy, "plastic_limit": "4500 MPa"}
    varied |= {"cycles": 30_000, "budget": 10}
    content = {**checkout.demo, "title": "One case", "base": {**checkout.demo["base"], **varied}}
    study = checkout.write_study("stopped", {k: v for k, v in content.items() if k != "vary"})
    results = checkout.folder / "results/stopped"
    (case_id,) = load_study(study).cases()
    file = results / f"cases/{case_id}.nc"
    checkpoint = file.with_suffix(".checkpoint")

    def logs():
        return "".join(log.read_text() for log in results.glob("logs/**/*.log"))

    def halt(run, progress):
        """Halt the simulation soon after it says something; return its job."""

        def has_said_it():
            assert not file.exists(), "the case is too quick to be stopped: take a longer one"
            return re.search(progress, logs())

        eventually(has_said_it, LONG, f"the simulation says {progress!r}")
        for process in checkout.simulations():
            process.suspend()
        (job,) = jobs_of(run, "RUNNING")
        return job

    command = f"{COMMAND} --retries 1 --config study=stopped -- results/stopped/summary.nc"
    run = checkout.start(command)
    job = halt(run, r"step [1-9]")
    # Limits are whole minutes; the end can be any second, and is looked at every half a minute.
    slurm("scontrol", "update", f"JobId={job}", "EndTime=now+1")
    eventually(lambda: job in jobs_of(run, "TIMEOUT"), LONG, "SLURM ends the job")
    eventually(checkpoint.is_file, 60, "the simulation leaves a checkpoint")
    job = halt(run, "resuming after cycle")
    assert "SLURM status is: 'TIMEOUT'" in run.output

    run.press_ctrl_c()
    assert run.end(LONG) != 0
    eventually(lambda: job in jobs_of(run, "CANCELLED"), LONG, "SLURM cancels the job")
    eventually(lambda: not checkout.simulations(), LONG, "the simulation ends")
    assert checkpoint.is_file()

    run = checkout.start(command)
    assert run.end(LONG) == 0, run.output
    assert "resuming after cycle" in logs()
    assert_same(file, simulate_here(study, case_id, tmp_path))
