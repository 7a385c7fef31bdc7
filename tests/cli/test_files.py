"""Full disks, read-only folders and damaged files: one sentence, and nothing is lost."""

import re
import shutil

import pytest

from fretwear.plugins import plugins

FULL = "not written: the disk is full"


ADDED = """
from markupsafe import Markup
from fretwear.figures.style import JournalFigure
from fretwear.figures.study import StudyFigure
from fretwear.report import Section

def figures(summary, cases):
    figure = JournalFigure(1, 50.0)
    figure.subplots()
    yield StudyFigure("points", f"{summary.sizes['normal_load']} loads.", figure)

def sections(summary, cases):
    yield Section("files", "Files", Markup(len(list(cases.glob("*.nc")))))
"""


@pytest.mark.slow
def test_packages_add_figures_and_sections_by_entry_points(desk, monkeypatch):
    desk.call("run", "tiny.yaml", "-o", "results/tiny/cases")
    desk.call("merge", "tiny.yaml")
    folder = desk.folder / "more-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: more\nVersion: 1.0\n")
    points = (f"[fretwear.{each}]\nmore = more_of_it:{each}\n" for each in ("figures", "sections"))
    (folder / "entry_points.txt").write_text("".join(points))
    (desk.folder / "more_of_it.py").write_text(ADDED)
    monkeypatch.syspath_prepend(desk.folder)
    plugins.cache_clear()
    # Its own figures are drawn by other tests.
    monkeypatch.setattr("fretwear.figures.study.study_figures", lambda *_: ())
    for step in ("figures", "report"):
        desk.call(step, "tiny.yaml")
    page = (desk.folder / "results/tiny/report.html").read_text(encoding="utf-8")
    assert re.search(r"Files.*?2", page, re.DOTALL)


def fill(disk, leaving):
    free = shutil.disk_usage(disk).free
    (disk / "filler").write_bytes(b"x" * (free - leaving))


@pytest.mark.slow
def test_a_run_on_a_full_disk_says_so_and_goes_on_when_there_is_space(desk, mounted):
    disk = mounted()
    call = ("run", "tiny.yaml", "--set", "load=50 N", "-o", disk / "a.nc")
    # Enough for the checkpoint of this small case, too little for its file.
    fill(disk, leaving=100_000)
    result = desk.call(*call, status=1)
    assert f"{disk / 'a.nc'}: {FULL}" in result.stderr
    assert not (disk / "a.nc").exists()
    (disk / "filler").unlink()
    desk.call(*call)
    assert [path.name for path in disk.iterdir()] == ["a.nc"]
