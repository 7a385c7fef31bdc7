"""Jobs that are killed outright, which nothing in them can notice."""

import multiprocessing
import random
import time

import pytest
import xarray as xr

import fretwear
from fretwear.data.files import open_case, open_history
from fretwear.data.safe import Lock
from fretwear.running.batch import simulate_to_file

KILLS = 20

CASE = fretwear.Case(
    radius="10 mm",
    youngs_modulus="208 GPa",
    poisson_ratio=0.3,
    load="50 N",
    tangential_ratio=0.8,
    friction=0.5,
    wear_coefficient="7e-13 / Pa",
    plastic_limit="3 GPa",
    cycles=3000,
    cell=("4 um", "4 um"),
    output_cycles=(10, 1000),
)


@pytest.fixture(scope="module")
def start():
    """Start a job in a process of its own and wait until it is at work."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["fretwear.running.batch", "fretwear.data.dataset"])

    def begin(path):
        settings = {"tell": print, "command": "test", "interval": 0.05}
        process = context.Process(target=simulate_to_file, args=(CASE, path), kwargs=settings)
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
def test_kill_at_random_moments_and_rerun_gives_the_same_bits(start, tmp_path):
    whole, killed = tmp_path / "whole" / "a.nc", tmp_path / "killed" / "a.nc"
    seconds_of(start(whole))
    duration = seconds_of(start(tmp_path / "again.nc"))
    generator = random.Random(7)
    gone_on, finished = 0, 0
    for _ in range(KILLS):
        gone_on += killed.with_suffix(".checkpoint").exists()
        process = start(killed)
        process.join(generator.uniform(0.0, 0.6 * duration))
        process.kill()
        process.join()
        if killed.exists():
            finished += 1
            assert_same(killed, whole)
            killed.unlink()
    seconds_of(start(killed))
    assert_same(killed, whole)
    assert [path.name for path in killed.parent.iterdir()] == ["a.nc"], "nothing is left behind"
    assert gone_on >= 3
    assert finished < KILLS


def assert_same(killed, whole):
    for opened in (open_case, open_history):
        with opened(killed) as one, opened(whole) as other:
            xr.testing.assert_equal(one.load(), other.load())
