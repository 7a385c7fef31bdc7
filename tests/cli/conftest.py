import sys

import pytest
from typer.testing import CliRunner

from fretwear.cli.program import app

from ..studies import base, two_loads, write_study


def tiny_study():
    """A study whose cases take a fraction of a second each: few cycles on a coarse grid."""
    return two_loads(title="Tiny", base=base(cycles=200, cell="10 um"), output={"cycles": [0, 20]})


class Desk:
    def __init__(self, folder):
        self.folder = folder

    def write(self, content, name="tiny.yaml"):
        return write_study(self.folder / name, content)

    def call(self, *arguments, status=0):
        """What a command says; it must end with this status and without a traceback."""
        sys.argv[1:] = map(str, arguments)
        done = CliRunner().invoke(app, sys.argv[1:])
        assert done.exit_code == status, done.stderr
        assert "Traceback" not in done.output
        return done

    def files(self):
        return sorted(str(path.relative_to(self.folder)) for path in self.folder.rglob("*"))


@pytest.fixture(autouse=True)
def _no_settings(monkeypatch):
    """What the environment may say about colours and logs is not what is tested."""
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.argv", ["fretwear"])
    monkeypatch.setattr("typer.rich_utils.FORCE_TERMINAL", None)  # typer looked for them too


@pytest.fixture
def desk(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    desk = Desk(tmp_path)
    desk.write(tiny_study())
    return desk


@pytest.fixture
def content():
    return tiny_study()


@pytest.fixture(scope="session")
def case_file(tmp_path_factory):
    desk = Desk(tmp_path_factory.mktemp("case"))
    study, path = desk.write(tiny_study()), desk.folder / "case.nc"
    desk.call("run", study, "--set", "load=50 N", "-o", path)
    return path
