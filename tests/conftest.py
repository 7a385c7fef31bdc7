"""How the property tests run everywhere: the same examples each time, however slow the machine.

With ``--hypothesis-profile=thorough`` they try other and far more examples every time.
"""

import fcntl
import os
import shutil
import signal
import subprocess
from collections import Counter

import pytest
from hypothesis import settings

# Tests run beside each other; threads of BLAS on top of that only wait for one another. It reads
# this when numpy is imported.
os.environ.setdefault("OMP_NUM_THREADS", "1")
# In the background a shell lets its commands ignore Ctrl-C, and their children would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("reproducible", deadline=None, derandomize=True)
settings.register_profile("thorough", deadline=None, max_examples=10_000, print_blob=True)
settings.load_profile("reproducible")


def pytest_configure(config):
    """Let xdist hand out files in the order below, not those of the most tests first."""
    config.option.loadscopereorder = False


def pytest_report_header():
    """Tell whether `tests/shaken` changes the last bits, or hides a library."""
    return [f"{n}={v}" for n, v in os.environ.items() if n.startswith("FRETWEAR_TEST_") and v]


def pytest_collection_modifyitems(items):
    """Begin with files of many slow tests: workers side by side end at about the same time."""
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: -slow[item.path])


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers():
    """Have a worker on each core that is given here."""
    return len(os.sched_getaffinity(0))


@pytest.fixture(scope="session")
def made_once(tmp_path_factory):
    """Fill a folder with results that workers side by side share: the first to ask makes them."""
    root = tmp_path_factory.getbasetemp()
    root = root.parent if "PYTEST_XDIST_WORKER" in os.environ else root

    def folder(name, make):
        place, done = root / name, root / f"{name}.done"
        with (root / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not done.exists():
                shutil.rmtree(place, ignore_errors=True)
                place.mkdir()
                make(place)
                done.touch()
        return place

    return folder


@pytest.fixture
def mounted(tmp_path):
    """Mount a small file system, for whoever may, and take it away again."""
    places = []

    def mount(size="12m"):
        place = tmp_path / "disk"
        place.mkdir()
        command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", place]
        try:
            subprocess.run(command, check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            pytest.skip("mounting a small file system takes rights that are not given here")
        places.append(place)
        return place

    yield mount
    for place in places:
        # After a failure the netCDF library keeps its file open until the process ends.
        subprocess.run(["umount", "-l", place], check=True)
