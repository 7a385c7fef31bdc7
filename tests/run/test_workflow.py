"""From a study file to its report, and what a change, a failure or a signal does to it."""

import json
import logging
import os
import shutil
import signal
from pathlib import Path

import numpy as np
import pytest

import fretwear
from fretwear.data.atomic import DataFileError
from fretwear.data.files import open_summary
from fretwear.run.resources import seconds_after
from fretwear.run.workflow import (
    Progress,
    StudyJobs,
    failures,
    is_news,
    record,
    study_file,
    write_finished,
)
from fretwear.study.plan import SECONDS_TO_START, Plan
from fretwear.study.problems import StudyError

from ..studies import WAVES, HandClock, near, write_study
from .conftest import BASE, HOPELESS, TINY, Checkout, wait_for, without

AFTERWARDS = {"Merging", "Drawing", "Writing", "Done:"}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    checkout = Checkout.make(tmp_path_factory.mktemp("finished"))
    checkout.said = checkout.snakemake(status=0)
    return checkout


@pytest.fixture
def copy(finished, tmp_path):
    """A copy of the finished study with everything that Snakemake remembers of it."""
    return Checkout(shutil.copytree(finished.folder, tmp_path / "copy"))


def written(checkout):
    """When each case file was written."""
    return {path: path.stat().st_mtime_ns for path in (checkout.results / "cases").glob("*.nc")}


@pytest.mark.slow
def test_a_study_ends_in_datasets_figures_and_a_report(finished):
    cases = sorted(path.stem for path in (finished.results / "cases").iterdir())
    assert [name.split("-mu")[0] for name in cases] == ["P25N-Q9N", "P50N-Q9N"]
    for name in cases:
        with fretwear.open_case(finished.results / "cases" / f"{name}.nc") as case:
            assert list(case["cycle"].values) == [0, 20, 100]
        log = (finished.results / "logs/simulate" / f"{name}.log").read_text()
        assert log.startswith(f"case {name}\n")
    benchmarks = list((finished.results / "benchmarks/batches").glob("*.tsv"))
    assert len(benchmarks) == 2
    assert benchmarks[0].read_text().startswith("s\th:m:s\tmax_rss")
    with open_summary(finished.results / "summary.nc") as summary:
        assert (summary["status"] == 0).all()
        assert (summary["wear_volume"].isel(cycle=-1) > 0).all()
    points = (finished.results / "points.csv").read_text(encoding="utf-8").splitlines()
    assert len(points) == 3
    figures = {path.suffix for path in (finished.results / "figures").glob("contact_half_width*")}
    assert figures == {".svg", ".png"}
    page = (finished.results / "report.html").read_text(encoding="utf-8")
    assert all(name in page for name in cases)
    claims = json.loads((finished.results / "answer.json").read_text(encoding="utf-8"))
    assert {(each["parameter"], each["from"], each["to"]) for each in claims} == {("load", 25, 50)}
    assert all(each["text"] in page for each in claims)


def test_each_case_is_told_once_it_is_done_with_the_time_left(load, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    told, clock = [], HandClock()
    study = load({**TINY, "vary": {"load": [f"{n} N" for n in (20, 30, 40)]}, "batch": 2})
    jobs = StudyJobs(Plan(study))
    first, second, third = jobs.study.cases()
    cases = tmp_path / "results/study/cases"
    cases.mkdir(parents=True)
    # A result of another version is not done until it is written again.
    (cases / f"{first}.nc").write_text("older")
    progress = Progress(jobs, 1, told.append, clock)
    clock.now = 30.0
    progress.look()
    assert told == []
    (cases / f"{first}.nc").write_text("as it should be")
    progress.look()
    progress.look()
    assert [line.partition(", about")[0] for line in told] == [f"case 1 of 3 done: {first}"]
    left = [told[0]]
    # A case that was kept is told with the record of its batch.
    write_finished(jobs_record(jobs, 1), cases, ())
    (cases / f"{second}.nc").write_text("new")
    progress.stop()
    assert {line.split()[5][:-1] for line in told} == {first, second, third}
    assert told[-1].startswith("case 3 of 3 done: ")
    assert left == told[:1]
    minutes = [float(line.split(" about ")[1].split()[0]) for line in told]
    assert minutes == sorted(minutes, reverse=True)
    assert minutes[-1] > 0, "figures and report follow"


def test_the_time_left_never_rises_while_a_last_job_keeps_one_core_of_two(
    load, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    told, clock, vary = [], HandClock(), {"load": [f"{n} N" for n in (20, 25, 30, 35, 40, 45)]}
    jobs = StudyJobs(Plan(load({**TINY, "vary": vary, "batch": 5})))
    cases = Path(jobs.folder, "cases")
    cases.mkdir(parents=True)
    progress = Progress(jobs, 2, told.append, clock)
    long, short = jobs.batches.values()
    assert [len(job.case_ids) for job in (long, short)] == [5, 1]
    seconds = {name: each.seconds - SECONDS_TO_START for name, each in jobs.plan.estimates.items()}
    events = []
    for number, job in enumerate((long, short)):
        ends = SECONDS_TO_START + np.cumsum([seconds[name] for name in job.case_ids])
        events += [
            (end, name, number, name == job.case_ids[-1])
            for end, name in zip(ends, job.case_ids, strict=True)
        ]
    predicted = []
    for end, name, number, is_last in sorted(events):
        clock.now = 3.0 * end  # a machine three times slower than planned
        (cases / f"{name}.nc").write_text("done")
        if is_last:
            write_finished(jobs_record(jobs, number), cases, ())
        progress.look()
        words = told[-1].split(" about ")[1].split()
        predicted.append(clock.now + float(words[0]) * {"s": 1, "min": 60}[words[1]])
    actual = clock.now + 3.0 * seconds_after(jobs.plan)
    assert predicted == [near(actual, rel=0.1)] * 6


def jobs_record(jobs, number):
    """The record that the job of a batch leaves at its end."""
    file = Path(jobs.folder, "batches", f"{jobs.targets[number]}.json")
    file.parent.mkdir(parents=True, exist_ok=True)
    return file


BOTH = {"P25N-Q9N", "P50N-Q9N"}


def test_the_start_of_a_simulation_and_of_a_job_without_a_message_is_no_news():
    def is_told(rule, message, level=logging.INFO):
        record = {"msg": "", "levelno": level, "rule_name": rule, "rule_msg": message}
        return is_news(logging.makeLogRecord(record))

    assert is_told("merge", "Merging demo")
    assert not is_told("simulate", "Simulating 2 cases")
    assert not is_told("study", None)
    assert is_told("simulate", "Simulating 2 cases", logging.ERROR)
    assert not is_news(logging.makeLogRecord({"msg": "Select jobs to execute..."}))


@pytest.mark.slow
def test_a_run_says_which_cases_are_done_and_what_follows_and_no_more(finished):
    # A hint of where Snakemake found its settings stands before everything.
    lines = [line for line in finished.said.splitlines() if line]
    begun = lines.index("cases to run: 2, in 2 jobs")
    assert all("profile" in line for line in lines[:begun])
    told = [line.partition(" done: ")[0].partition(": ") for line in lines[begun + 1 :]]
    assert [first for first, *_ in told[:2]] == ["case 1 of 2", "case 2 of 2"]
    steps = [first.split()[0] for first, *_ in told[2:]]
    assert steps[:4] == ["Merging", "Drawing", "Writing", "Done"]
    assert not any(first.startswith(("Job ", "[")) for first, *_ in told)
    log = max((finished.folder / ".snakemake/log").iterdir())
    assert "Select jobs to execute" in log.read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_change_reruns_what_it_touches(copy):
    def jobs_after(**changes):
        copy.write({**TINY, **changes})
        file = copy.folder / "studies/demo.yaml"
        file.write_text(f"# measured in spring\n{file.read_text()}")
        return copy.jobs()

    assert jobs_after() == (set(), set())
    assert jobs_after(title="Two loads") == (set(), AFTERWARDS)
    # Snapshots are no part of an id.
    assert jobs_after(output={"cycles": [0, 30]}) == (BOTH, AFTERWARDS)
    # Another solver computes everything again, and another report reports again.
    file, module = copy.folder / "Snakefile", "import fretwear.run.workflow as w\n"
    text = file.read_text()
    file.write_text(text.replace("try:", f"{module}w.code_digest = lambda: '0'\ntry:", 1))
    assert jobs_after() == (BOTH, AFTERWARDS)
    file.write_text(text.replace("try:", "__version__ = '0'\ntry:", 1))
    assert jobs_after() == (set(), AFTERWARDS)
    file.write_text(text)
    # An extended study computes what is new or was removed, and no other.
    min((copy.results / "cases").iterdir()).unlink()
    vary = {"load": ["25 N", "30 N", "50 N"]}
    assert jobs_after(vary=vary) == ({"P25N-Q9N", "P30N-Q9N"}, AFTERWARDS)


@pytest.mark.slow
def test_what_is_wrong_stops_the_study_before_any_job(checkout):
    checkout.write({**TINY, "vary": {"load": ["50 N", "15 N"]}})
    message = checkout.snakemake(status=2)
    assert "studies/demo.yaml: base.tangential_load = 9 N" in message
    assert "gross sliding" in message
    assert "load = 15 N" in message
    assert "Traceback" not in message
    assert not checkout.results.exists()
    checkout.write(TINY)
    checkout.results.parent.write_text("not a folder")
    message = checkout.snakemake(status=2)
    assert "results/demo: cannot be written to, because" in message
    assert "Traceback" not in message


@pytest.mark.slow
def test_another_study_is_chosen_by_its_name_and_an_old_lock_is_told(checkout):
    checkout.write({**TINY, "vary": {"load": ["40 N"]}}, "other")
    locks = checkout.folder / ".snakemake/locks"
    locks.mkdir(parents=True)
    (locks / "0.output.lock").touch()
    config = ("--config", "study=other", "keep_older=true")
    planned = checkout.snakemake("--dry-run", "-p", *config, status=0)
    assert "Simulating P40N-Q9N" in planned
    assert "--supervise --keep-older" in planned
    assert "merge studies/other.yaml --keep-older" in planned
    assert "if none is running: snakemake --unlock, then the same command again" in planned


@pytest.mark.slow
def test_a_failed_case_stops_what_follows_unless_told_to_keep_going(checkout):
    checkout.write({**HOPELESS, "batch": 2})
    message = checkout.snakemake(status=1)
    assert "1 of 2 cases failed" in message
    assert "no step after cycle 0" in message
    assert not (checkout.results / "summary.nc").exists()
    # The next run tries the failed one again, and what is done is left as it is.
    before = written(checkout)
    message = checkout.snakemake("--keep-going", status=1)
    assert "1 of 2 cases were done before" in message
    assert "fretwear: 1 of 2 cases failed\n" in message
    assert written(checkout) == before
    (failure,) = failures(checkout.results)
    with open_summary(checkout.results / "summary.nc") as summary:
        assert summary["status"].values.tolist() == [1, 0]
        volume = summary["wear_volume"].isel(cycle=-1).values
        assert np.isnan(volume[0])
        assert volume[1] > 0
    page = (checkout.results / "report.html").read_text(encoding="utf-8")
    assert "no step after cycle 0" in page
    assert f"logs/simulate/{failure}.log" in page
    assert list((checkout.results / "figures").glob("*.svg"))


@pytest.mark.slow
def test_the_report_of_the_workflow_itself_holds_the_figures_with_their_captions(copy):
    code = "{{ cycler.__init__.__globals__.os.popen('touch harm').read() }}"
    (copy.results / "figures/captions.rst").write_text(code)
    copy.snakemake("--report", "workflow.html", status=0)
    page = (copy.folder / "workflow.html").read_text(encoding="utf-8")
    entries = json.loads((copy.results / "figures/index.json").read_text(encoding="utf-8"))
    figures = entries
    assert len(figures) == 11
    assert not (copy.folder / "harm").exists()
    for figure in figures:
        assert f'"figure": "{figure["name"]}"' in page
        assert f'"{figure["category"]}"' in page
        assert json.dumps(f"<p>{figure['caption']}")[1:-1] in page


def test_a_study_is_given_by_name_or_by_path(checkout, monkeypatch):
    monkeypatch.chdir(checkout.folder)
    assert study_file("paper") == Path("studies/paper.yaml")
    assert study_file("loads-1.5") == Path("studies/loads-1.5.yaml")
    assert study_file("mine/own.yaml") == Path("mine/own.yaml")
    assert study_file("own.yaml") == Path("studies/own.yaml")
    Path("own.yaml").touch()
    assert study_file("own.yaml") == Path("own.yaml")
    # That of another folder has its results among the others.
    above = write_study(checkout.folder / "above.yaml", TINY)
    for name in ("../above", "studies/../above.yaml", str(above)):
        assert StudyJobs.of({"study": name}).folder == "results/above"


@pytest.fixture
def jobs(checkout, monkeypatch):
    monkeypatch.chdir(checkout.folder)

    def of(content, name="demo"):
        checkout.write(content, name)
        return StudyJobs.of({"study": name})

    return of


def test_a_job_depends_on_all_that_its_files_hold(jobs, monkeypatch):
    changes = ({}, {"base": {**TINY["base"], "friction": 0.6}}, {"output": {"cycles": [0, 30]}})
    names = [set(jobs({**TINY, **change}).batches) for change in changes]
    # What follows depends on the study but not on its batches.
    assert json.loads(jobs(TINY).content) == without(TINY, "batch")
    assert jobs({**TINY, "batch": 2}).content == jobs(TINY).content
    assert jobs({**TINY, "title": "Other"}).content != jobs(TINY).content
    monkeypatch.setattr("fretwear.run.workflow.code_digest", lambda: "other")
    names.append(set(jobs(TINY).batches))
    assert sum(map(len, names)) == len(set.union(*names)) == 8


def test_a_job_asks_for_more_than_the_plan_expects(jobs):
    small = jobs(TINY)
    waves = {"amplitude": "0.2 um", "slope_x": "2 deg", "slope_y": "1 deg"}
    large = {**TINY["base"], "cell": "0.5 um", "cycles": 30000, "roughness": waves}
    large = jobs({**TINY, "base": large}, "large")
    for first, second in zip(small.targets, large.targets, strict=True):
        less, more = small.job(first), large.job(second)
        assert 100 < less.memory_mb < more.memory_mb
        assert 5 < less.minutes <= more.minutes
        assert less.priority < more.priority
    # That of several cases asks for the memory of the largest and the time of all.
    both = jobs({**TINY, "batch": 2})
    (target,) = both.targets
    assert both.job(target).points == "1-2"
    assert both.job(target).memory_mb == max(small.job(each).memory_mb for each in small.targets)
    (batch,) = both.batches.values()
    assert batch.seconds == sum(each.seconds for each in small.batches.values())


def test_what_a_batch_has_left_holds_until_a_case_file_is_removed_or_changed(jobs):
    def targets():
        return jobs({**TINY, "batch": 2}).targets

    study = jobs({**TINY, "batch": 2})
    (first,) = study.targets
    name, ids = first.removesuffix("-0"), [*study.study.cases()]
    results = Path(study.folder)
    files = [results / "cases" / f"{case_id}.nc" for case_id in ids]
    files[0].parent.mkdir(parents=True)
    for file in files:
        file.write_bytes(b"whole")
    write_finished(results / f"batches/{first}.json", results / "cases", ids)
    assert targets() == (f"{name}-0",)
    files[1].write_bytes(b"another")
    assert targets() == (f"{name}-1",)
    write_finished(results / f"batches/{name}-1.json", results / "cases", ids)
    assert targets() == (f"{name}-1",)
    # A file of the same size that was changed at another time is another; so is an absurd time.
    left = results / f"batches/{name}-1.json"
    kept = json.loads(left.read_text())
    for modified in (0.0, 10**400):
        changed = {case_id: [size, modified] for case_id, (size, _) in kept["cases"].items()}
        left.write_text(json.dumps({"cases": changed}))
        assert targets() == (f"{name}-2",)
    left.write_text(json.dumps(kept))
    files[0].unlink()
    assert targets() == (f"{name}-2",)
    with pytest.raises(DataFileError, match="was removed while"):
        write_finished(results / f"batches/{name}-2.json", results / "cases", ids)


def test_the_verdict_names_what_failed_but_not_what_other_studies_left(jobs):
    study = jobs(TINY)
    first, _ = study.batches.values()
    (case_id,) = first.case_ids
    assert not study.verdict()
    record(study.folder, case_id, "the wheel came off")
    record(study.folder, "of-another-study", "broken")
    lines = study.verdict().splitlines()
    assert lines[0] == "fretwear: 1 of 2 cases failed"
    log = f"results/demo/logs/simulate/{case_id}.log"
    assert lines[1] == f"  {case_id}: the wheel came off (log: {log})"


def test_a_study_is_chosen_by_its_key_alone_and_a_misspelt_one_does_not_run_the_default(
    checkout, monkeypatch
):
    monkeypatch.chdir(checkout.folder)
    checkout.write(TINY, "paper")
    for config, expected in (
        ({}, ("demo", False)),
        ({"study": "paper"}, ("paper", False)),
        ({"keep_older": "True"}, ("demo", True)),
        ({"keep_older": False}, ("demo", False)),
    ):
        found = StudyJobs.of(config)
        assert (found.study.name, found.keep_older) == expected
    misspelt = ({"stdy": "a"}, {"study": "a", "cores": 2}, {"study": None}, {"keep_older": 1})
    for config in misspelt:
        with pytest.raises(StudyError, match="--config"):
            StudyJobs.of(config)


@pytest.mark.slow
def test_a_closed_terminal_keeps_a_checkpoint_of_every_case_that_runs_and_leaves_no_lock(
    checkout, start
):
    rough = {"cell": "0.5 um", "cycles": 20000, "roughness": WAVES}
    checkout.write({**TINY, "base": {**TINY["base"], **rough}})
    cases, logs = checkout.results / "cases", checkout.results / "logs/simulate"
    process = start("--cores", "2", module="snakemake", start_new_session=True)
    wait_for(
        lambda: sum("cycle 0 of" in log.read_text() for log in logs.glob("*.log")) == 2, process
    )
    # As a terminal does it, to all processes of the group; Ctrl-C takes the same path.
    os.killpg(process.pid, signal.SIGHUP)
    message = process.communicate(timeout=120)[1]
    assert process.returncode != 0
    assert "fretwear: stopped: because its terminal was closed" in message
    assert not list(checkout.folder.glob(".snakemake/locks/*"))
    assert {path.suffix for path in cases.iterdir()} == {".checkpoint"}
    assert len(list(cases.iterdir())) == 2
    for log in logs.glob("*.log"):
        assert "kept; the same command resumes after cycle" in log.read_text()


@pytest.mark.slow
def test_a_run_that_is_stopped_while_it_writes_ends_when_its_file_is_whole(tmp_path, start):
    # Enough snapshots that writing them takes a while.
    study = {"base": {**BASE, "cell": "1.5 um", "error_estimate": False}}
    study["output"] = {"cycles": [*range(1, 90)]}
    write_study(tmp_path / "one.yaml", study)
    (tmp_path / "out").mkdir()
    process = start("run", "one.yaml", "-o", "out/a.nc")
    wait_for(lambda: list((tmp_path / "out").glob(".a.nc.*.tmp")), process)
    process.send_signal(signal.SIGTERM)
    # Interrupted inside of the netCDF library, it would wait for itself for ever.
    message = process.communicate(timeout=120)[1]
    assert process.returncode == 143
    assert "fretwear: stopped: by SIGTERM" in message
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["a.nc"]
    with fretwear.open_case(tmp_path / "out/a.nc") as case:
        assert case.sizes["cycle"] == 91


HARMFUL = "my 'dir' $(touch harm) \"q\" {x} ;`touch harm`"


@pytest.mark.slow
def test_names_of_folders_and_titles_are_never_commands(checkout):
    title = "$(touch harm) `touch harm` {x} <b>'\""
    content = {**TINY, "title": title, "vary": {"load": ["50 N"]}}
    write_study(checkout.folder / HARMFUL / "study.yaml", content)
    config = f"study={HARMFUL}/study.yaml"
    checkout.snakemake("results/study/points.csv", "--config", config, status=0)
    assert (checkout.folder / "results/study/summary.nc").exists()
    assert not list(checkout.folder.rglob("harm"))
