"""Processes that work beside another end with it."""

import subprocess
import sys

import psutil
import pytest

_BESIDE = """
import multiprocessing, os, time
from fretwear.platform import pool_of
pool = pool_of(2)
pool.submit(os.getpid).result()
print(*(each.pid for each in multiprocessing.active_children()), flush=True)
time.sleep(60)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a pool outlives what started it")
def test_processes_end_with_the_one_that_started_them():
    with subprocess.Popen(
        [sys.executable, "-c", _BESIDE], stdout=subprocess.PIPE, text=True
    ) as started:
        beside = [psutil.Process(int(pid)) for pid in started.stdout.readline().split()]
        assert beside
        started.kill()
        alive = psutil.wait_procs(beside, timeout=20)[1]
    assert alive == []
