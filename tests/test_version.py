"""What computed a result is told by its sources and libraries, wherever they are installed."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fretwear
from fretwear.version import code_digest

PACKAGE = Path(fretwear.__file__).parent
# The digest of a copy as it is, and with a line more in each of some files.
DIGESTS = """
import sys
from pathlib import Path
from fretwear.version import code_digest
print(code_digest())
for name in sys.argv[1:]:
    file = Path("fretwear", name)
    kept = file.read_bytes() if file.exists() else None
    file.write_bytes((kept or b"") + b"\\n")
    print(code_digest.__wrapped__())
    file.unlink() if kept is None else file.write_bytes(kept)
"""
COMPUTING = ("mechanics/kernels.cpp", "mechanics/geometry/grid.py", "theory/hertz.py", "units.py")
DRIVERS = ("study/case.py", "parts.py", "running/simulate.py", "data/labels.py")
OTHERS = ("figures/maps.py", "report/build.py", "cli/show.py", "running/batch.py")


def digests_of(package, *files):
    command = [sys.executable, "-c", DIGESTS, *files]
    return subprocess.check_output(command, cwd=package.parent, text=True).split()


@pytest.fixture
def package(tmp_path, monkeypatch):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    return shutil.copytree(PACKAGE, tmp_path / "fretwear", ignore=shutil.ignore_patterns("*.pyc"))


def test_the_digest_changes_with_what_numbers_depend_on_and_with_nothing_else(package):
    changed = (*COMPUTING, *DRIVERS, "mechanics/new.py")
    found = digests_of(package, *changed, *OTHERS)
    # Wherever the same sources lie, and whatever draws or reports.
    assert {found[0], *found[len(changed) + 1 :]} == {code_digest()}
    assert len(set(found)) == len(changed) + 1


def test_kernels_that_are_not_compiled_and_other_libraries_change_it(package, monkeypatch):
    for compiled in (package / "mechanics").glob("compiled_kernels*"):
        compiled.unlink()
        assert digests_of(package) != [code_digest()]
    monkeypatch.setattr("fretwear.version._version_of", lambda library: f"{library} 99")
    assert code_digest.__wrapped__() != code_digest()
