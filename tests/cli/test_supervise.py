"""Processes that are asked to stop, once, twice, and in vain."""

import signal
import subprocess
import sys
import time

import pytest

SCRIPT = """
import time
from fretwear.cli import supervise as signals
signals._SAME_WISH_SECONDS, signals._LONGEST_CLEANING_SECONDS = {patience}
with signals.stopping():
    try:
        print("at work", flush=True)
        time.sleep(60)
    finally:
        print("cleaning", flush=True)
        for _ in range(600):
            time.sleep(0.1)
"""


@pytest.fixture
def cleaning():
    """Start a process, ask it to stop, and leave it while it cleans up, which takes for ever."""
    processes = []

    def start(asked, patience):
        process = subprocess.Popen(
            [sys.executable, "-c", SCRIPT.format(patience=patience)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        processes.append(process)
        assert process.stdout.readline() == "at work\n"
        process.send_signal(asked)
        assert process.stdout.readline() == "cleaning\n"
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(
    ("asked", "patience", "again", "status"),
    [(signal.SIGINT, (0.0, 60.0), True, 130), (signal.SIGTERM, (60.0, 1.0), False, 143)],
)
def test_a_second_ctrl_c_or_lost_patience_ends_a_process_that_cleans_up_for_too_long(
    cleaning, asked, patience, again, status
):
    process = cleaning(asked, patience)
    if again:
        process.send_signal(asked)
    assert "stopped: at once" in process.communicate(timeout=30)[1]
    assert process.returncode == status


def test_a_wish_that_is_told_twice_is_one_wish(cleaning):
    process = cleaning(signal.SIGINT, patience=(60.0, 60.0))
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGTERM)
    time.sleep(0.3)
    assert process.poll() is None
