"""Cases to files: finished ones stay, an interrupted one resumes, a failed one says why."""

import signal

import pytest

from fretwear.data.files import open_case
from fretwear.run import case_files
from fretwear.run.case_files import failures, simulate_to_file
from fretwear.study.reading import load_study

from ..cli.conftest import Desk
from ..studies import WAVES, write_study
from .conftest import BASE, HOPELESS, TINY, assert_same, read_until

pytestmark = pytest.mark.slow

STUDY = {**TINY, "vary": {"load": ["25 N", "50 N", "60 N"]}}


class Bench(Desk):
    """A folder with one study, and the command that runs its cases."""

    def run(self, *arguments, status=0):
        return self.call("run", "tiny.yaml", "-o", "cases", *arguments, status=status).stderr

    def cases(self):
        return sorted((self.folder / "cases").glob("*.nc"))


@pytest.fixture
def bench(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bench = Bench(tmp_path)
    bench.write(STUDY)
    return bench


def written(bench):
    return {path: path.stat().st_mtime_ns for path in bench.cases()}


def test_finished_cases_stay_until_their_snapshots_change(bench):
    first, *_ = load_study("tiny.yaml").cases()
    bench.run("--case", first)
    files = written(bench)
    bench.run()
    assert files.items() < written(bench).items()
    assert len(bench.cases()) == 3
    alone = bench.folder / "alone.nc"
    bench.call("run", "tiny.yaml", "--case", first, "-o", alone)
    assert_same(alone, bench.cases()[0])
    bench.write({**STUDY, "output": {"cycles": [0, 30]}})
    bench.run("--case", first)
    with open_case(bench.cases()[0]) as case:
        assert list(case["cycle"].values) == [0, 30, 100]


def test_a_folder_counts_the_cases_of_the_whole_study_that_are_done(bench, monkeypatch):
    monkeypatch.setattr(case_files, "SECONDS_BETWEEN_LINES", 0.0)
    first, *rest = load_study("tiny.yaml").cases()
    run = ("run", "tiny.yaml", "-o", "cases")
    alone = bench.call(*run, "--case", first).stdout
    assert alone == "cases: 1 of 3 cases done\n"
    both = bench.call(*run, *(word for name in rest for word in ("--case", name))).stdout
    assert both.splitlines() == ["cases: 2 of 3 cases done", "cases: 3 of 3 cases done"]
    monkeypatch.setattr(case_files, "SECONDS_BETWEEN_LINES", 3600.0)
    assert bench.call(*run).stdout == "cases: 3 of 3 cases done\n" * 2
    # Points that are not the study's own are counted by themselves.
    assert (
        "cases: 1 of 1 cases done" in bench.call(*run, "--case", first, "--set", "cycles=30").stdout
    )


def test_cases_of_other_code_are_computed_again_or_kept_on_request(bench, monkeypatch):
    bench.run()
    files = written(bench)
    monkeypatch.setattr(case_files, "case_digest", lambda _: "newer")
    bench.run("--keep-older")
    assert written(bench) == files
    bench.run()
    assert not files.items() & written(bench).items()


def test_a_failed_case_stops_no_other_and_says_why_until_it_has_a_result(bench):
    bench.write(HOPELESS)
    said = bench.run(status=1)
    ((failed, reason),) = failures(bench.folder / "cases").items()
    assert reason.startswith("no step after cycle 0")
    assert f"1 of 2 cases failed\n  {failed}: {reason}" in said
    (path,) = bench.cases()
    path.with_suffix(".failed").write_text("broken before")
    bench.run(status=1)
    assert list(failures(bench.folder / "cases")) == [failed]


LONG = {
    "base": {**BASE, "cycles": 7000, "cell": "1 um", "roughness": WAVES, "error_estimate": False}
}


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The file of a long case that runs without a stop."""
    folder = tmp_path_factory.mktemp("undisturbed")
    (case,) = load_study(write_study(folder / "one.yaml", LONG)).cases().values()
    simulate_to_file(case, folder / "one.nc", tell=print, command="test")
    return folder / "one.nc"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_stopped_run_resumes_to_the_same_results(start, tmp_path, undisturbed, number):
    write_study(tmp_path / "one.yaml", LONG)
    first = start("run", "one.yaml", "-o", "cases")
    read_until(first, "cycle 0 of")
    first.send_signal(number)
    said = first.communicate()[1]
    stopped = number != signal.SIGKILL
    assert first.returncode == (128 + number if stopped else -number)
    assert "Traceback" not in said
    left = {path.suffix for path in (tmp_path / "cases").iterdir() if path.name[0] != "."}
    assert left == ({".checkpoint"} if stopped else {".failed"})
    again = start("run", "one.yaml", "-o", "cases")
    assert ("resuming after cycle" in again.communicate()[1]) == stopped
    (path,) = (tmp_path / "cases").iterdir()
    assert_same(path, undisturbed)


def test_two_runs_of_one_case_at_once_spoil_nothing(start, bench):
    first, *_ = load_study("tiny.yaml").cases()
    both = [start("run", "tiny.yaml", "--case", first, "-o", "cases") for _ in range(2)]
    for process in both:
        said = process.communicate()[1]
        assert process.returncode == 0, said
    assert [path.name for path in (bench.folder / "cases").iterdir()] == [f"{first}.nc"]
    bench.call("run", "tiny.yaml", "--case", first, "-o", "alone.nc")
    assert_same(bench.cases()[0], bench.folder / "alone.nc")
