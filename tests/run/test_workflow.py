"""From a study file to its report, and what a change or a failure does to it."""

import json
import os
import platform
import shutil
from pathlib import Path

import numpy as np
import pytest

import fretwear
from fretwear.data.files import open_summary
from fretwear.run import workflow
from fretwear.run.workflow import StudyJobs, mark_start, release_locks, study_file
from fretwear.study.mistakes import StudyError

from .conftest import HOPELESS, TINY, Checkout, without


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    checkout = Checkout.make(tmp_path_factory.mktemp("finished"))
    checkout.snakemake(status=0)
    return checkout


@pytest.mark.slow
def test_a_study_ends_in_datasets_figures_and_a_report_and_a_second_start_has_nothing_to_do(
    finished,
):
    cases = sorted(path.stem for path in (finished.results / "cases").iterdir())
    assert [name.split("-mu")[0] for name in cases] == ["P25N-Q9N", "P50N-Q9N"]
    for name in cases:
        with fretwear.open_case(finished.results / "cases" / f"{name}.nc") as case:
            assert list(case["cycle"].values) == [0, 20, 100]
            assert f"--case {name}" in case.attrs["history"]
    with open_summary(finished.results / "summary.nc") as summary:
        assert summary["status"].values.tolist() == [0, 0]
    for name in ("points.csv", "results.csv", "report.html", "answer.json"):
        assert (finished.results / name).stat().st_size
    entries = json.loads((finished.results / "figures/index.json").read_text(encoding="utf-8"))
    drawn = {entry["name"] for entry in entries}
    assert drawn == {path.stem for path in (finished.results / "figures").glob("*.svg")}
    assert "Nothing to be done" in finished.snakemake("--dry-run", status=0)


@pytest.mark.slow
def test_a_failed_case_leaves_what_is_finished_to_be_reported_with_keep_going(tmp_path):
    checkout = Checkout.make(tmp_path)
    checkout.write(HOPELESS)
    message = checkout.snakemake("--keep-going", status=1)
    assert "no step after cycle 0" in message
    with open_summary(checkout.results / "summary.nc") as summary:
        assert summary["status"].values.tolist() == [0, 1]  # levels rise: the softer matter is last
        volume = summary["wear_volume"].isel(cycle=-1).values
        assert np.isnan(volume[1])
        assert volume[0] > 0
    page = (checkout.results / "report.html").read_text(encoding="utf-8")
    assert "no step after cycle 0" in page
    assert list((checkout.results / "figures").glob("*.svg"))


@pytest.mark.slow
def test_storage_that_would_lose_the_case_files_is_refused(tmp_path):
    pytest.importorskip("snakemake_storage_plugin_fs", reason="storage plug-in: every night")
    checkout = Checkout.make(tmp_path)
    said = checkout.snakemake("--default-storage-provider", "fs", status=2)
    assert "copy results/ when the study is done" in said


OUTER = """
module wear:
    snakefile: "inner/Snakefile"
    config: {"study": "demo"}
    prefix: "elsewhere"

use rule * from wear as wear_*

onstart:
    wear.onstart()

rule last:
    default_target: True
    input: "elsewhere/results/demo/summary.nc"
"""


def make_module(folder):
    (folder / "inner").mkdir()
    (folder / "Snakefile").rename(folder / "inner/Snakefile")
    (folder / "Snakefile").write_text(OUTER, encoding="utf-8")


@pytest.mark.slow
def test_the_workflow_is_a_module_of_another_one_and_writes_under_its_prefix(tmp_path):
    checkout = Checkout.make(tmp_path)
    make_module(tmp_path)
    checkout.snakemake(status=0)
    with open_summary(tmp_path / "elsewhere/results/demo/summary.nc") as summary:
        assert (summary["status"] == 0).all()
    assert not checkout.results.exists()
    # Also a case that has gone is missed there.
    gone = min((tmp_path / "elsewhere/results/demo/cases").iterdir())
    gone.unlink()
    checkout.snakemake("--", "wear_all", status=0)
    assert gone.exists()


@pytest.mark.slow
@pytest.mark.parametrize("prefix", ["", "elsewhere"])
def test_forced_jobs_compute_their_finished_cases_again_unless_it_is_a_dry_run(tmp_path, prefix):
    checkout, rule = Checkout.make(tmp_path), "simulate"
    if prefix:
        make_module(tmp_path)
        rule = "wear_simulate"
    results = Path(prefix, "results/demo")

    def run(*options):
        checkout.snakemake(*options, "--", str(results / "summary.nc"), status=0)
        cases = (tmp_path / results / "cases").iterdir()
        return {file: file.stat().st_mtime_ns for file in cases}

    first = run()
    assert run("--forcerun", rule, "--dry-run") == first
    forced = run("--forcerun", rule)
    assert forced.keys() == first.keys()
    assert all(stamp > first[file] for file, stamp in forced.items())


@pytest.mark.slow
def test_a_workflow_that_does_not_start_its_module_is_told_that_forced_cases_stay(tmp_path):
    checkout, words = Checkout.make(tmp_path), "keeps finished cases unless the onstart"
    assert words not in checkout.snakemake("--dry-run", status=0)
    make_module(tmp_path)
    assert words not in checkout.snakemake("--dry-run", status=0)
    (tmp_path / "Snakefile").write_text(OUTER.replace("wear.onstart()", "pass"), encoding="utf-8")
    assert checkout.snakemake("--dry-run", status=0).count(words) == 1


@pytest.fixture
def jobs(tmp_path, monkeypatch):
    """The jobs of a study whose cases are one job each."""
    monkeypatch.chdir(tmp_path)
    checkout = Checkout(tmp_path)

    def of(**changes):
        checkout.write({**TINY, **changes})
        return StudyJobs.of({})

    return of


def test_a_job_is_another_one_when_its_cases_snapshots_or_code_change(jobs, monkeypatch):
    names = list(jobs().jobs)
    assert list(jobs(title="Two loads").jobs) == names
    extended = jobs(vary={"load": ["25 N", "30 N", "50 N"]})
    assert set(names) < set(extended.jobs)
    assert not {*names} & {*jobs(output={"cycles": [0, 30]}).jobs}
    assert jobs().content != jobs(title="Two loads").content
    kept = StudyJobs(jobs().plan, keep_older=True)
    names_kept = list(kept.jobs)
    monkeypatch.setattr(workflow, "case_digest", lambda _: "newer")
    assert not {*names} & {*jobs().jobs}
    assert list(StudyJobs(jobs().plan, keep_older=True).jobs) == names_kept


@pytest.mark.slow
def test_removed_cases_are_computed_again_and_those_of_other_code_are_told_before(
    finished, jobs, monkeypatch
):
    ours = jobs()
    shutil.copytree(finished.results, "results/demo")
    assert list(ours.check(ours.results)) == []
    first, second = (ours.results / "jobs" / name for name in ours.jobs)
    min(Path("results/demo/cases").iterdir()).unlink()
    list(ours.check(ours.results))
    assert [first.exists(), second.exists()].count(True) == 1
    monkeypatch.setattr(workflow, "case_digest", lambda _: "newer")
    *_, told = jobs().check(ours.results)
    assert told == "1 finished case is of other code: computed again; keep_older=true keeps them"
    *_, told = StudyJobs(jobs().plan, keep_older=True).check(ours.results)
    assert told == "1 finished case is of other code: kept"


@pytest.fixture
def locked(tmp_path):
    """A folder of Snakemake with a lock, and the mark of a process that is given by its start."""
    lock = tmp_path / "locks/0.input.lock"
    lock.parent.mkdir()
    lock.touch()
    mark_start(tmp_path)
    mark = next(file for file in tmp_path.iterdir() if file.is_file())

    def by(node=None, pid=None, age=0.0):
        here, this, created = json.loads(mark.read_text())
        content = [node or here, pid or this, created - age]
        mark.write_text(json.dumps(content))
        release_locks(tmp_path)
        return lock.exists()

    by.folder, by.lock = tmp_path, lock
    return by


def test_locks_of_a_dead_process_of_this_machine_go_and_no_other_ones(locked):
    assert locked()  # this process lives
    assert locked(node="another login node", pid=2**22 + 1)  # and here nobody knows that one
    assert locked(node=platform.node(), pid=2**22 + 1) is False


def test_locks_of_a_process_whose_number_another_one_has_go(locked):
    assert locked(age=60.0) is False


def test_locks_newer_than_the_mark_or_without_one_stay(locked):
    later = locked.lock.stat().st_mtime + 60.0
    os.utime(locked.lock, (later, later))
    assert locked(pid=2**22 + 1)
    for file in locked.folder.glob("*started"):
        file.unlink()
    release_locks(locked.folder)
    assert locked.lock.exists()


def test_a_study_is_given_by_name_or_by_path_and_misspelt_keys_are_refused(jobs):
    assert study_file("paper") == Path("studies/paper.yaml")
    assert study_file("loads-1.5") == Path("studies/loads-1.5.yaml")
    assert study_file("mine/own.yaml") == Path("mine/own.yaml")
    assert study_file("own.yaml") == Path("studies/own.yaml")
    jobs()
    assert StudyJobs.of({"study": "studies/demo.yaml"}).results == Path("results/demo")
    for wrong in ({"stduy": "paper"}, {"keep_older": "perhaps"}, {"study": "missing"}):
        with pytest.raises(StudyError):
            StudyJobs.of(wrong)


def test_a_scheduler_reserves_more_than_the_plan_expects(jobs):
    ours = jobs()
    for name, job in ours.jobs.items():
        assert ours.memory_mb(name) * 1e6 > 2 * job.memory_bytes
        assert ours.minutes(name) * 60 > 300 + 5 * job.seconds - 60
        assert ours.options(name) == f"--case {job.case_ids[0]}"
    # A fit has as many processes where it is submitted as where it runs, each with a case.
    largest = max(job.memory_bytes for job in ours.jobs.values())
    assert 2 * 4 * largest < ours.memory_mb_of_fit(4) * 1e6 < ours.memory_mb_of_fit(8) * 1e6
    assert ours.minutes_of_fit > max(ours.minutes(name) for name in ours.jobs)
    assert ours.is_small
    many = {"load": {"from": "25 N", "to": "50 N"}}
    drawn = jobs(vary=many, design={"kind": "sobol", "points": 512, "seed": 1})
    assert not drawn.is_small
    assert drawn.memory_mb_after > ours.memory_mb_after
    assert drawn.minutes_after >= ours.minutes_after
    joined = jobs(**{**without(TINY, "batch"), "batch": 2})
    ((name, job),) = joined.jobs.items()
    assert len(job.case_ids) == 2
    assert ours.plan.study.cases().keys() == set(job.case_ids)
