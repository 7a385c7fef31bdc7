"""What computed a result is told by its sources and libraries, wherever they are installed."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fretwear
from fretwear.version import code_digest

PACKAGE = Path(fretwear.__file__).parent
PRINT = "from fretwear.version import code_digest; print(code_digest())"


def digest_of(package):
    done = subprocess.run(
        [sys.executable, "-c", PRINT],
        cwd=package.parent,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


@pytest.fixture
def package(tmp_path, monkeypatch):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    return shutil.copytree(PACKAGE, tmp_path / "fretwear", ignore=shutil.ignore_patterns("*.pyc"))


def test_the_same_sources_have_the_same_digest_wherever_they_lie(package):
    assert digest_of(package) == code_digest()


COMPUTING = ("mechanics/kernels.cpp", "mechanics/geometry/grid.py", "theory/hertz.py", "units.py")
DRIVERS = ("study/case.py", "parts.py", "running/simulate.py", "data/labels.py")


@pytest.mark.parametrize("file", [*COMPUTING, *DRIVERS, "mechanics/new.py"])
def test_a_change_of_what_numbers_depend_on_changes_it(package, file):
    with (package / file).open("a") as source:
        source.write("\n")
    assert digest_of(package) != code_digest()


def test_a_change_of_figures_or_report_does_not(package):
    for file in ("figures/maps.py", "report/build.py", "cli/show.py", "running/batch.py"):
        with (package / file).open("a") as source:
            source.write("\n")
    assert digest_of(package) == code_digest()


def test_kernels_that_are_not_compiled_and_other_libraries_change_it(package, monkeypatch):
    for compiled in (package / "mechanics").glob("compiled_kernels*"):
        compiled.unlink()
        assert digest_of(package) != code_digest()
    monkeypatch.setattr("fretwear.version._version_of", lambda library: f"{library} 99")
    assert code_digest.__wrapped__() != code_digest()
