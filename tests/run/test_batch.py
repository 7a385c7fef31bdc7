"""Several cases in one process, and what jobs leave beside the case files."""

import json
import os
import re
import shutil
import signal
from contextlib import chdir
from pathlib import Path

import pytest

import fretwear
from fretwear.data.files import open_summary
from fretwear.data.safe import Lock, Unfailing
from fretwear.run.workflow import (
    ENDED,
    failures,
    forget,
    log_end,
    log_file,
    record,
    spent_on_simulations,
)
from fretwear.study.reading import load_study

from ..cli.conftest import Desk
from ..studies import WAVES, flip, near
from .conftest import HOPELESS, TINY, assert_same, wait_for

STUDY = {**TINY, "vary": {"load": ["25 N", "50 N", "60 N"]}}
BEGAN = re.compile(r"^case \d of 3: (.*)$", re.MULTILINE)


class Bench(Desk):
    """A folder with one study, and the command that runs batches of it."""

    def __init__(self, folder):
        super().__init__(folder)
        self.results = folder / "results/tiny"
        self.write(STUDY)

    def batch(self, *arguments, command="batch", status=0):
        """Run a batch and return what it said; it must end with this status."""
        with chdir(self.folder):
            return self.call(command, "tiny.yaml", *arguments, status=status).stderr

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
        assert_same(apart, together)


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
    ((failed, reason),) = failures(bench.results).items()
    assert reason.startswith("no step after cycle 0")
    assert f"1 of 2 cases failed\n  {failed}: {reason}" in said
    assert reason in log_file(bench.results, failed).read_text()
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
    assert any("of memory for" in each for each in failures(bench.results).values())


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="only Linux tells of children")
def test_the_others_are_done_when_one_case_ends_its_process(bench, start):
    # The first case takes a second or two, the others a fraction of one.
    base = {**STUDY["base"], "cell": "1 um", "cycles": 7000}
    vary = {**STUDY["vary"], "roughness": [WAVES, "none", "none"]}
    bench.write({**STUDY, "base": base, "design": "zip", "vary": vary})
    first, *others = load_study(bench.folder / "tiny.yaml").cases()
    process = start("batch", "tiny.yaml", "--supervise", folder=bench.folder)
    wait_for(lambda: first in failures(bench.results), process)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    os.kill(int(children.read_text()), signal.SIGKILL)
    _, said = process.communicate()
    assert process.returncode == 0, said
    assert f"killed during {first}: out of memory?" in said
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


def test_cases_of_an_older_solver_are_computed_again_or_kept_on_request_and_told(
    bench, whole, monkeypatch
):
    shutil.copytree(whole.results, bench.results)
    first, *_ = bench.cases()
    first.unlink()
    for module in ("running.batch", "data.labels", "data.merge"):
        monkeypatch.setattr(f"fretwear.{module}.code_digest", lambda: "newer", raising=False)
    assert "2 of them by another version of the code: kept" in bench.batch("--keep-older")
    assert fretwear.open_case(first).attrs["code_digest"] == "newer"
    words = "2 of 3 cases were computed by another version of the code"
    assert words in bench.batch("--keep-older", command="merge")
    with open_summary(bench.results / "summary.nc") as summary:
        assert words in summary.attrs["warnings"]
        assert summary.attrs["code_digest"] == "newer"
        assert len(set(summary["code_digest"].values.tolist())) == 2
    assert "2 of them by another version of the code: computed again" in bench.batch()
    assert {fretwear.open_case(each).attrs["code_digest"] for each in bench.cases()} == {"newer"}


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


def test_cases_whose_logs_cannot_be_written_are_computed_all_the_same(bench, monkeypatch):
    def full(_):
        return Unfailing(Path("/dev/full").open("a", buffering=1))

    for module in ("batch", "workflow"):
        monkeypatch.setattr(f"fretwear.run.{module}.open_log", full)
    bench.batch("--points", "1-2")
    assert len(bench.cases()) == 2


def test_points_that_are_not_there_are_refused(bench):
    for points in ("0-2", "2-1", "1-4", "1", "a-b", "-1-2"):
        assert f"--points {points}: " in bench.batch(f"--points={points}", status=2)
    assert not bench.results.exists()


def test_failed_cases_are_told_with_reason_and_log_until_they_have_a_result(tmp_path):
    assert failures(tmp_path) == failures(tmp_path / "missing") == {}
    record(tmp_path, "first")
    assert failures(tmp_path)["first"] == ENDED, "its process vanished"
    record(tmp_path, "first", "no step after cycle 3 comes to an end")
    record(tmp_path, "second", "broken")
    assert failures(tmp_path)["first"] == "no step after cycle 3 comes to an end"
    for case_id in ("first", "never failed"):
        forget(tmp_path, case_id)
    # Records that are cut short or of something else are passed over.
    (file,) = (tmp_path / "logs/simulate").iterdir()
    text = file.read_text()
    odd = json.dumps({**json.loads(text), "reason": 3})
    for n, content in enumerate((text[:-20], text, odd, text + " " * 200_000, "[" * 50_000)):
        file.with_name(f"{n}.failed.json").write_text(content)
    assert list(failures(tmp_path)) == ["second"]


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
        file.write_bytes(b"s\th:m:s\tmax_rss\tcpu_time\n" + row + b"\n")
        return spent_on_simulations(tmp_path)

    assert write("batches/long.tsv", b"1\t0:01\t" + b"9" * 200_000) is None
    assert write("batches/odd.tsv", b"\xff\xfe not a table") is None
    spent = write("simulate/a.tsv", b"0.2\t0:00:00\t-\tNA")
    assert spent[:3] == (1, 0.2, 0.0)
    assert spent.memory_bytes != spent.memory_bytes
    write("simulate/a.tsv", b"2.0\t0:00:02\t100\t1.5")
    write("merge.tsv", b"9.0\t0:00:09\t900\t9.0")
    spent = write("simulate/b.tsv", b"3.0\t0:00:03\t200\t2.5")
    assert spent == (2, 5.0, 4.0, near(200 * 2**20))


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
    assert failures(tmp_path)["a"] == "broken"
    assert precious.read_text() == "mine"
