"""Processes that work side by side, and how they end."""

import os
import subprocess
import sys
from concurrent.futures import BrokenExecutor

import psutil
import pytest

from fretwear.platform import side_by_side

_BESIDE = """
import multiprocessing, os, time
from fretwear.platform import pool_of, side_by_side
{}
print(*(each.pid for each in multiprocessing.active_children()), flush=True)
time.sleep(60)
"""
# The last has more to say than a pipe holds.
_WORK = (
    "pool = pool_of(2); pool.submit(os.getpid).result()",
    "results = side_by_side(bytes, [10**6] * 9, 2); next(results)",
)


def test_results_come_in_the_order_of_the_items():
    assert list(side_by_side(abs, [-5, 4, -3, 2, -1], 2)) == [5, 4, 3, 2, 1]


def test_a_process_that_ends_is_noticed():
    with pytest.raises(BrokenExecutor):
        list(side_by_side(os._exit, [3, 3], 2))


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a pool outlives what started it")
@pytest.mark.parametrize("work", _WORK)
def test_processes_end_with_the_one_that_started_them(work):
    with subprocess.Popen(
        [sys.executable, "-c", _BESIDE.format(work)], stdout=subprocess.PIPE, text=True
    ) as started:
        beside = [psutil.Process(int(pid)) for pid in started.stdout.readline().split()]
        assert beside
        started.kill()
        alive = psutil.wait_procs(beside, timeout=20)[1]
    assert alive == []
