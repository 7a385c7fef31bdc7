"""One case to one file, whoever else works on it and whatever goes wrong."""

import multiprocessing
import os
import random
import re
import shutil
import signal
import time
from pathlib import Path

import pytest
import xarray as xr

from fretwear.data.files import open_case, write_case
from fretwear.data.safe import DataFileError, Lock
from fretwear.mechanics.contact.problem import ContactError
from fretwear.mechanics.slip.models import Jaeger
from fretwear.mechanics.wear.integrator import WearError
from fretwear.run import simulate
from fretwear.run.batch import simulate_to_file

from ..studies import WAVES, flip, write_study
from .conftest import BASE, assert_same, make_case, read_until

KILLS = 7


@pytest.fixture
def case():
    return make_case(cycles=200)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "cases" / "a.nc"


@pytest.fixture
def run(start, tmp_path):
    """Start `fretwear run` of one case to a file, which takes a second or two."""
    long = {"cycles": 7000, "cell": "1 um", "roughness": WAVES, "error_estimate": False}
    write_study(tmp_path / "one.yaml", {"base": {**BASE, **long}})
    (tmp_path / "out").mkdir()
    return lambda: start("run", "one.yaml", "-o", "out/a.nc", start_new_session=True)


def job(case, path, told=None, observers=()):
    tell = [].append if told is None else told.append
    return simulate_to_file(case, path, observers=observers, tell=tell, command="test")


def names(path):
    return sorted(each.name for each in path.parent.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("then", [signal.SIGCONT, signal.SIGKILL])
def test_of_two_processes_one_computes_and_the_other_waits_for_its_file(run, tmp_path, then):
    first = run()
    read_until(first, "cycle 0 of")
    os.killpg(first.pid, signal.SIGSTOP)
    second = run()
    child = Path(f"/proc/{first.pid}/task/{first.pid}/children").read_text().strip()
    read_until(second, f"out/a.nc: process {child} on ")
    os.killpg(first.pid, then)
    written = first.communicate()[0]
    taken, told = second.communicate()
    assert second.returncode == 0, told
    assert "by another process" not in written
    is_taken = then == signal.SIGCONT
    assert first.returncode == (0 if is_taken else -signal.SIGKILL)
    assert ("by another process" in taken) == is_taken
    assert ("cycle 7000 of 7000" in told) == (not is_taken), "it resumes where the other was"
    assert names(tmp_path / "out/a.nc") == ["a.nc"]


@pytest.mark.parametrize(
    ("changes", "is_taken_over"),
    [({}, True), ({"friction": 0.6}, False), ({"output_cycles": (7,)}, False), (None, False)],
    ids=["the same", "another case", "other snapshots", "damaged"],
)
def test_after_waiting_only_a_whole_file_of_the_same_run_is_taken(
    case, path, changes, is_taken_over
):
    def write():
        result = simulate.run(make_case(cycles=200, **(changes or {})))
        write_case(result.dataset, result.history, path)
        if changes is None:
            flip(path)
        lock.release()

    # The job is told of the lock of another, which writes its file then.
    lock = Lock(path)
    lock.acquire()
    outcome = simulate_to_file(case, path, tell=lambda _: write(), command="test")
    assert outcome.is_taken_over is is_taken_over
    with open_case(path) as dataset:
        assert dataset.attrs["case_id"] == case.case_id
        assert dataset["cycle"].values.tolist() == list(case.output_cycles)
    assert names(path) == ["a.nc"]


def test_results_that_are_removed_while_they_are_computed_are_written_all_the_same(case, path):
    def remove(_):
        shutil.rmtree(path.parent, ignore_errors=True)

    job(case, path, observers=[remove])
    with open_case(path) as dataset:
        assert dataset.attrs["case_id"] == case.case_id
    assert names(path) == ["a.nc"]


def test_a_job_whose_lock_another_has_taken_leaves_without_writing(case, path):
    rivals = []

    def take(_):
        if not rivals:
            rivals.append(Lock(path))
            rivals[0].file.unlink()
            rivals[0].acquire()

    told = []
    with pytest.raises(DataFileError, match="was removed from outside"):
        job(case, path, told, [take])
    assert names(path) == [".a.nc.lock", "a.checkpoint"]
    assert "kept; the same command resumes after cycle 200" in told[-1]
    rivals[0].release()
    job(case, path, told)
    assert "resuming after cycle 200" in told[-1]
    assert names(path) == ["a.nc"]


def failing_below(deepest):
    """The wear layer of the slip model, which fails in every step from a depth of wear on."""
    wear_layer = Jaeger.wear_layer

    def failing(self, wear, *others):
        if wear.max() >= deepest:
            raise ContactError("the slip model does not go that far")
        return wear_layer(self, wear, *others)

    return failing


def test_a_job_that_fails_on_its_way_keeps_the_checkpoint_to_resume_from(path, monkeypatch):
    case = make_case(cycles=5000)
    # The depth that a step ends with: no step is cut because the depth is passed within it.
    deepest = [float(step.state.wear.max()) for step in simulate.steps(case)][5]
    told = []
    with monkeypatch.context() as patch:
        patch.setattr(Jaeger, "wear_layer", failing_below(deepest))
        with pytest.raises(WearError, match=r"no step after cycle \d+.* a residual of"):
            job(case, path, told)
    assert names(path) == ["a.checkpoint"]
    reached = re.search(r"resumes after cycle (\d+)", told[-1]).group(1)
    assert 10 < int(reached) < 5000
    job(case, path, told)
    assert f"resuming after cycle {reached}" in told[-1]
    with open_case(path) as dataset:
        undisturbed = simulate.simulate(case, quarter=True)
        xr.testing.assert_equal(dataset["wear_depth"].load(), undisturbed["wear_depth"])


@pytest.fixture
def start_job(monkeypatch):
    """Start a job in a process of its own and wait until it is at work."""
    monkeypatch.setattr("fretwear.run.batch.SECONDS_BETWEEN", 0.05)
    context = multiprocessing.get_context("fork")

    def begin(path):
        settings = {"tell": print, "command": "test"}
        case = make_case(plastic_limit="3 GPa", cycles=3000, cell="4 um", output_cycles=(10, 1000))
        process = context.Process(target=simulate_to_file, args=(case, path), kwargs=settings)
        process.start()
        while process.is_alive() and f"process {process.pid} " not in Lock(path).holder():
            time.sleep(0.002)
        return process

    return begin


def seconds_of(process):
    """How long a job that was just begun works."""
    begun = time.monotonic()
    process.join()
    assert process.exitcode == 0
    return time.monotonic() - begun


@pytest.mark.slow
def test_kill_at_random_moments_and_rerun_gives_the_same_bits(start_job, tmp_path):
    whole, killed = tmp_path / "whole" / "a.nc", tmp_path / "killed" / "a.nc"
    seconds_of(start_job(whole))
    duration = seconds_of(start_job(tmp_path / "again.nc"))
    generator = random.Random(7)
    resumed, finished = 0, 0
    for _ in range(KILLS):
        resumed += killed.with_suffix(".checkpoint").exists()
        process = start_job(killed)
        process.join(generator.uniform(0.0, 0.6 * duration))
        process.kill()
        process.join()
        if killed.exists():
            finished += 1
            assert_same(killed, whole)
            killed.unlink()
    seconds_of(start_job(killed))
    assert_same(killed, whole)
    assert [path.name for path in killed.parent.iterdir()] == ["a.nc"], "nothing is left behind"
    assert resumed >= 2
    assert finished < KILLS
