"""The workflow on SLURM: real daemons, real jobs."""

import os
import signal
import subprocess
import sys

import pytest
import xarray as xr

from fretwear.data.merge import open_summary
from fretwear.study.file import load_study
from fretwear.workflow import StudyJobs

from .checkout import documented_commands, eventually

OFF = "needs a cluster made of this machine alone: .ci/with-slurm pytest tests/cluster"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif("FRETWEAR_TEST_SLURM" not in os.environ, reason=OFF),
]

COMMAND = "snakemake --profile profiles/slurm"
DEMO_SECONDS = 600


def slurm(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def jobs_of(run):
    """What SLURM knows of the jobs that a run has submitted, by their ids."""
    known = {}
    for line in slurm("scontrol", "show", "job", "--oneliner").splitlines():
        job = dict(part.partition("=")[::2] for part in line.split() if "=" in part)
        if f"SLURM run ID: {job.get('JobName')}" in run.output:
            known[job["JobId"]] = job
    return known


def megabytes(text):
    return float(text[:-1]) * {"M": 1, "G": 1024, "T": 1024**2}[text[-1]]


def data_of(path, group=None):
    with xr.open_dataset(path, group=group, engine="netcdf4") as dataset:
        return dataset.load()


def assert_same_data(path, reference):
    for group in (None, "history"):
        found, expected = data_of(path, group), data_of(reference, group)
        assert found.sizes["cycle" if group is None else "step"] > 1
        xr.testing.assert_equal(found, expected)
        assert found.dtypes == expected.dtypes


@pytest.fixture(scope="module")
def demo(checkout):
    """The default study, run by the command of the documentation."""
    assert COMMAND in documented_commands()
    run = checkout.start(COMMAND)
    assert run.end(DEMO_SECONDS) == 0, run.output
    return run


def test_the_documented_command_takes_the_default_study_to_its_report(demo):
    results = demo.folder / "results/demo"
    cases = load_study(demo.folder / "studies/demo.yaml").cases()
    assert len(cases) == 24
    for case_id in cases:
        assert data_of(results / "cases" / f"{case_id}.nc").attrs["complete"] == 1
    with open_summary(results / "summary.nc") as summary:
        assert (summary["status"] == 0).all()
    page = (results / "report.html").read_text(encoding="utf-8")
    assert all(case_id in page for case_id in cases)


def test_the_cluster_computes_what_this_machine_computes(demo, tmp_path):
    study = demo.folder / "studies/demo.yaml"
    quick = [case_id for case_id in load_study(study).cases() if "-smooth-elastic-" in case_id]
    assert len(quick) == 4
    for case_id in quick[1:3]:
        here = tmp_path / f"{case_id}.nc"
        call = [sys.executable, "-m", "fretwear", "run", study, "--case", case_id, "-o", here]
        subprocess.run(call, check=True, capture_output=True)
        assert_same_data(demo.folder / f"results/demo/cases/{case_id}.nc", here)


def test_slurm_gets_what_the_plan_says_a_job_takes(demo, monkeypatch):
    monkeypatch.chdir(demo.folder)
    planned = StudyJobs.of("demo")
    submitted = jobs_of(demo)
    assert submitted
    for job in submitted.values():
        rule, _, wildcard = job["Comment"].partition("_wildcards_")
        assert rule == "rule_simulate"
        hours, minutes, seconds = job["TimeLimit"].split(":")
        assert seconds == "00"
        assert 60 * int(hours) + int(minutes) == planned.minutes(wildcard)
        assert megabytes(job["MinMemoryNode"]) == planned.memory_mb(wildcard)
        assert job["NumCPUs"] == "1"
        assert job["JobState"] == "COMPLETED"


def test_a_failed_job_is_reported_with_the_reason(checkout):
    # Matter this soft is gone before the shortest step ends, so this case really fails.
    soft = {"wear_coefficient": "1 / Pa", "roughness": "none", "cell": "10 um", "cycles": 50}
    checkout.write_one_case("soft", load="20 N", friction=0.3, plastic_limit="none", **soft)
    run = checkout.start(f"{COMMAND} --config study=soft")
    assert run.end(120) != 0
    (job,) = jobs_of(run).values()
    assert job["JobState"] == "FAILED"
    assert f"SLURM-job '{job['JobId']}' failed" in run.output
    assert "fretwear: error: no step after cycle 0" in run.output
    assert not (checkout.folder / "results/soft/summary.nc").exists()


def test_a_study_goes_on_after_its_time_limit_and_after_ctrl_c(demo, checkout):
    # A case of the default study, which has computed it without being stopped.
    wavy = {"kind": "wavy", "amplitude": "0.2 um", "slope_x": "3 deg", "slope_y": "1 deg"}
    varied = {"load": "40 N", "friction": 0.6, "roughness": wavy, "plastic_limit": "4500 MPa"}
    checkout.write_one_case("stopped", **varied)
    results = checkout.folder / "results/stopped"
    (case_id,) = load_study(checkout.folder / "studies/stopped.yaml").cases()
    checkpoint = results / f"cases/{case_id}.checkpoint"

    def logs():
        return "".join(log.read_text() for log in results.glob("logs/**/*.log"))

    def start_and_halt(progress):
        """Start the study and halt the simulation where it is, however fast it is."""
        run = checkout.start(f"{COMMAND} --config study=stopped")
        eventually(lambda: progress in logs(), 60, f"the simulation says {progress!r}")
        (simulation,) = checkout.simulations()
        os.kill(simulation, signal.SIGSTOP)
        (job,) = jobs_of(run)
        return run, job

    run, job = start_and_halt("step 1")
    # Limits are whole minutes; the end can be any second, and is looked at every half a minute.
    slurm("scontrol", "update", f"JobId={job}", "EndTime=now+1")
    assert run.end(150) != 0
    assert f"SLURM-job '{job}' failed, SLURM status is: 'TIMEOUT'" in run.output
    assert checkpoint.is_file()

    run, job = start_and_halt("going on after cycle")
    run.press_ctrl_c()
    assert run.end(60) != 0
    eventually(lambda: jobs_of(run)[job]["JobState"] == "CANCELLED", 30, "SLURM cancels the job")
    eventually(lambda: not checkout.simulations(), 30, "the simulation ends")
    assert checkpoint.is_file()

    run = checkout.start(f"{COMMAND} --config study=stopped")
    assert run.end(180) == 0, run.output
    assert "going on after cycle" in logs()
    assert_same_data(
        results / f"cases/{case_id}.nc", demo.folder / f"results/demo/cases/{case_id}.nc"
    )
