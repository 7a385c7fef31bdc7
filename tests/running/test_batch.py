"""Several cases in one process, and what jobs leave beside the case files."""

import json
import os
import re
import shutil
import signal
from contextlib import chdir
from pathlib import Path

import pytest
from typer.testing import CliRunner

import fretwear
from fretwear.cli.program import app
from fretwear.data.safe import Lock, Unfailing
from fretwear.running.workflow import (
    ENDED,
    failures,
    forget,
    log_end,
    log_file,
    record,
    spent_on_simulations,
)
from fretwear.study.study import load_study

from ..studies import WAVES, flip, write_study
from .conftest import HOPELESS, TINY, contents, wait_for

STUDY = {**TINY, "vary": {"load": ["25 N", "50 N", "60 N"]}}
BEGAN = re.compile(r"^case \d of 3: (.*)$", re.MULTILINE)


def with_a_long_case(place):
    """Three cases, of which one takes a second or two, the others a fraction of one."""
    roughness = ["none"] * 3
    roughness[place] = WAVES
    base = {**STUDY["base"], "cell": "1 um", "cycles": 7000}
    vary = {**STUDY["vary"], "roughness": roughness}
    return {**STUDY, "base": base, "design": "zip", "vary": vary}


class Bench:
    """A folder with one study, and the command that runs batches of it."""

    def __init__(self, folder):
        self.folder = folder
        self.results = folder / "results/tiny"
        self.write(STUDY)

    def write(self, content):
        write_study(self.folder / "tiny.yaml", content)

    def batch(self, *arguments, status=0):
        """Run a batch and return what it said; it must end with this status."""
        with chdir(self.folder):
            done = CliRunner().invoke(app, ["batch", "tiny.yaml", *map(str, arguments)])
        assert done.exit_code == status, done.stderr
        return done.stderr

    def cases(self):
        return sorted((self.results / "cases").glob("*.nc"))

    def logs(self):
        return sorted((self.results / "logs/simulate").glob("*.log"))


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    bench = Bench(tmp_path_factory.mktemp("whole"))
    bench.batch("--finished", "results/tiny/batches/all.json")
    return bench


def test_each_case_of_a_batch_has_its_file_and_its_log(whole):
    names = [path.stem for path in whole.cases()]
    assert [name.split("-mu")[0] for name in names] == ["P25N-Q9N", "P50N-Q9N", "P60N-Q9N"]
    assert [path.stem for path in whole.logs()] == names
    for log in whole.logs():
        assert log.read_text().startswith(f"case {log.stem}\ncycle 0 of 100")
    assert failures(whole.results) == {}


def test_results_are_the_same_to_the_last_bit_whatever_the_batch(whole, bench):
    for points in ("3-3", "1-2"):
        bench.batch("--points", points)
    assert [path.name for path in bench.cases()] == [path.name for path in whole.cases()]
    for apart, together in zip(bench.cases(), whole.cases(), strict=True):
        assert contents(apart) == contents(together)


def test_a_damaged_file_and_one_of_other_snapshots_are_made_again(bench):
    bench.batch("--points", "1-2")
    first, second = bench.cases()
    flip(first)
    said = bench.batch("--points", "1-2")
    assert "1 of 2 cases were done before" in said
    assert f"case {first.stem}" in said
    bench.write({**STUDY, "output": {"cycles": [0, 30]}})
    bench.batch("--points", "2-2")
    with fretwear.open_case(second) as case:
        assert list(case["cycle"].values) == [0, 30, 100]


def test_a_failed_case_keeps_no_other_from_running(bench):
    bench.write(HOPELESS)
    finished = bench.results / "batches/all.json"
    said = bench.batch("--finished", finished, status=1)
    assert not finished.exists()
    (failed,) = failures(bench.results).values()
    assert failed.reason.startswith("no step after cycle 0")
    assert f"1 of 2 cases failed\n  {failed.case_id}: {failed.reason}" in said
    assert failed.reason in (bench.results / failed.log).read_text()
    (path,) = bench.cases()
    with fretwear.open_case(path) as case:
        assert float(case["wear_coefficient"]) == 7e-13
    # A rerun tries it again; once it has a result, nothing of the failure is left.
    bench.batch("--points", "1-1", status=1)
    bench.write({**HOPELESS, "vary": {"wear_coefficient": ["7e-13 / Pa"]}})
    record(bench.results, path.stem, "broken before")
    bench.batch()
    assert path.stem not in failures(bench.results)
    large = {**STUDY["base"], "cell": "0.002 um"}
    bench.write({**STUDY, "base": large, "vary": {"load": ["50 N"]}})
    bench.batch(status=1)
    assert any("of memory for" in each.reason for each in failures(bench.results).values())


def test_a_batch_that_is_killed_goes_on_after_the_cases_that_are_done(bench, start):
    bench.write(with_a_long_case(1))
    process = start("batch", "tiny.yaml", folder=bench.folder, start_new_session=True)
    wait_for(bench.cases, process)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    done = [path.stem for path in bench.cases()]
    assert len(done) < 3
    for failure in failures(bench.results).values():
        assert failure.reason == ENDED
    assert f"{len(done)} of 3 cases were done before" in bench.batch()
    assert len(bench.cases()) == 3
    assert failures(bench.results) == {}


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="only Linux tells of children")
@pytest.mark.parametrize(
    ("sent", "words"), [("SIGKILL", "killed"), ("SIGSEGV", "crashed (SIGSEGV)")]
)
def test_the_others_are_done_when_one_case_ends_its_process(bench, start, sent, words):
    bench.write(with_a_long_case(0))
    first, *others = load_study(bench.folder / "tiny.yaml").cases()
    process = start("batch", "tiny.yaml", "--supervise", folder=bench.folder)
    wait_for(lambda: first in failures(bench.results), process)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    os.kill(int(children.read_text()), getattr(signal, sent))
    _, said = process.communicate()
    assert process.returncode == 0, said
    assert f"{words} during {first}: out of memory?" in said
    assert BEGAN.findall(said)[-3:] == [*others, first]
    assert len(bench.cases()) == 3
    assert failures(bench.results) == {}


@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 143), (signal.SIGKILL, -9)])
def test_a_supervised_batch_can_be_stopped(bench, start, number, status):
    long = {**STUDY["base"], "cell": "0.5 um", "cycles": 7000, "roughness": WAVES}
    bench.write({**STUDY, "base": long, "vary": {"load": ["50 N"]}})
    process = start("batch", "tiny.yaml", "--supervise", folder=bench.folder)
    wait_for(lambda: failures(bench.results), process)
    os.kill(process.pid, number)
    # The pipe ends when the last process of the batch does.
    _, said = process.communicate(timeout=60)
    assert process.returncode == status
    assert "stopped: by SIGTERM" in said
    assert not bench.cases()


def test_what_a_killed_process_left_is_removed_and_its_case_comes_last(bench, whole):
    shutil.copytree(whole.results, bench.results)
    first, second, _ = bench.cases()
    left = [first.with_suffix(".checkpoint"), Lock(first).file]
    for file in left:
        file.touch()
    with Lock(second) as held:
        bench.batch()
        assert held.file.exists()
    assert not any(file.exists() for file in left)
    for case in bench.cases():
        case.unlink()
    first, *others = (path.stem for path in whole.cases())
    record(bench.results, first)
    assert BEGAN.findall(bench.batch()) == [*others, first]


@pytest.mark.parametrize("how", ["on a full disk", "without a folder"])
def test_cases_whose_logs_cannot_be_written_are_computed_all_the_same(bench, monkeypatch, how):
    def full(_):
        return Unfailing(Path("/dev/full").open("a", buffering=1))

    if how == "on a full disk":
        for module in ("batch", "workflow"):
            monkeypatch.setattr(f"fretwear.running.{module}.open_log", full)
    else:
        bench.results.mkdir(parents=True)
        (bench.results / "logs").write_text("")
    bench.batch("--points", "1-2")
    assert len(bench.cases()) == 2


def test_points_that_are_not_there_are_refused(bench):
    for points in ("0-2", "2-1", "1-4", "1", "a-b", "-1-2"):
        assert f"--points {points}: " in bench.batch(f"--points={points}", status=2)
    assert not bench.results.exists()


HEAD = "s\th:m:s\tmax_rss\tcpu_time\n"


def test_failed_cases_are_told_with_reason_and_log_until_they_have_a_result(tmp_path):
    assert failures(tmp_path) == failures(tmp_path / "missing") == {}
    record(tmp_path, "first")
    assert failures(tmp_path)["first"].reason == ENDED, "its process vanished"
    record(tmp_path, "first", "no step after cycle 3 comes to an end")
    record(tmp_path, "second", "broken")
    failure, _ = failures(tmp_path).values()
    assert tmp_path / failure.log == log_file(tmp_path, "first")
    assert str(failure) == "no step after cycle 3 comes to an end (log: logs/simulate/first.log)"
    forget(tmp_path, "first")
    forget(tmp_path, "never failed")
    assert list(failures(tmp_path)) == ["second"]


def test_records_that_are_cut_short_or_of_something_else_are_passed_over(tmp_path):
    record(tmp_path, "sound", "broken")
    (file,) = (tmp_path / "logs/simulate").iterdir()
    text = file.read_text()
    for name, content in {
        "cut": text[:-20],
        "other": text,
        "list": "[1, 2]",
        "odd": json.dumps({**json.loads(text), "reason": 3}),
        "large": text + " " * 200_000,
        "deep": "[" * 50_000,
    }.items():
        file.with_name(f"{name}.failed.json").write_text(content)
    assert list(failures(tmp_path)) == ["sound"]


def test_the_end_of_a_log_is_whole_lines(tmp_path):
    assert log_end(tmp_path, "P50N-1") == ""
    file = log_file(tmp_path, "P50N-1")
    file.parent.mkdir(parents=True)
    file.write_bytes(b"cycle 1\ncycle 2\n\xffcycle 3\n")
    assert log_end(tmp_path, "P50N-1") == "cycle 1\ncycle 2\n\ufffdcycle 3\n"
    assert log_end(tmp_path, "P50N-1", most=12) == "\ufffdcycle 3\n"


def test_simulations_are_added_up_and_what_was_not_measured_counts_for_nothing(tmp_path):
    def write(name, row):
        file = tmp_path / "benchmarks" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"{HEAD}{row}\n", encoding="utf-8")

    assert spent_on_simulations(tmp_path) is None
    write("batches/long.tsv", "1\t0:01\t" + "9" * 200_000)
    assert spent_on_simulations(tmp_path) is None
    write("simulate/a.tsv", "0.2\t0:00:00\t-\tNA")
    (tmp_path / "benchmarks/simulate/b.tsv").write_bytes(b"\xff\xfe not a table")
    spent = spent_on_simulations(tmp_path)
    assert (spent.jobs, spent.seconds, spent.processor_seconds) == (1, 0.2, 0.0)
    assert spent.memory_bytes != spent.memory_bytes
    write("simulate/a.tsv", "2.0\t0:00:02\t100\t1.5")
    write("simulate/b.tsv", "3.0\t0:00:03\t200\t2.5")
    write("merge.tsv", "9.0\t0:00:09\t900\t9.0")
    spent = spent_on_simulations(tmp_path)
    assert (spent.jobs, spent.seconds, spent.processor_seconds) == (2, 5.0, 4.0)
    assert spent.memory_bytes == pytest.approx(200 * 2**20)


def test_records_that_cannot_be_written_or_lead_elsewhere_end_nothing(tmp_path):
    (tmp_path / "logs").write_text("no folder")
    record(tmp_path, "a", "broken")
    forget(tmp_path, "a")
    assert failures(tmp_path) == {}
    precious = tmp_path / "precious"
    precious.write_text("mine")
    (tmp_path / "logs").unlink()
    for file in (log_file(tmp_path, "a"), tmp_path / "logs/simulate/a.failed.json"):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.symlink_to(precious)
    assert log_end(tmp_path, "a") == "", "nobody else's file is shown in a report"
    record(tmp_path, "a", "broken")
    assert failures(tmp_path)["a"].reason == "broken"
    assert precious.read_text() == "mine"
