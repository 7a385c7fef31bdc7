"""Files that fail a command, and files that somebody has made up."""

import json
import re
import shutil
import subprocess
from contextlib import suppress
from pathlib import Path

import netCDF4
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from fretwear.cli.program import app, swallowing_no_lack_of_memory
from fretwear.data.atomic import DataFileError
from fretwear.figures.index import read_figure_index
from fretwear.run.workflow import failures, is_finished, spent_on_simulations
from fretwear.study.problems import printable

from ..studies import flip

FULL = "not written, because the disk (or the quota on it) is full"


SUMMARY = "it is damaged"


@pytest.fixture
def copied(finished_desk, desk):
    """The same in the folder that the commands are called from, to be spoilt."""
    shutil.copytree(finished_desk.folder / "results", "results/tiny")
    return desk


ADDED = """
from markupsafe import Markup
from fretwear.figures.style import JournalFigure
from fretwear.figures.study import StudyFigure
from fretwear.report import Section

def figures(summary, cases):
    figure = JournalFigure(1, 50.0)
    figure.subplots()
    yield StudyFigure("points", f"{summary.sizes['normal_load']} loads.", "More", figure)

def sections(summary, cases):
    yield Section("files", "Files", Markup(len(list(cases.glob("*.nc")))))
"""


@pytest.mark.slow
def test_packages_add_figures_and_sections_by_entry_points(copied, monkeypatch):
    folder = copied.folder / "more-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: more\nVersion: 1.0\n")
    points = (f"[fretwear.{each}]\nmore = more_of_it:{each}\n" for each in ("figures", "sections"))
    (folder / "entry_points.txt").write_text("".join(points))
    (copied.folder / "more_of_it.py").write_text(ADDED)
    monkeypatch.syspath_prepend(copied.folder)
    # Its own figures are drawn by other tests.
    monkeypatch.setattr("fretwear.figures.study.study_figures", lambda *_: ())
    for step in ("figures", "report"):
        copied.call(step, "tiny.yaml")
    page = (copied.folder / "results/tiny/report.html").read_text(encoding="utf-8")
    assert "2 loads." in page
    assert re.search(r'id="files".*?Files.*?2', page, re.DOTALL)


def fill(disk, leaving):
    free = shutil.disk_usage(disk).free
    (disk / "filler").write_bytes(b"x" * (free - leaving))


def everything(folder):
    return {path.relative_to(folder): path.stat().st_size for path in folder.rglob("*")}


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


@pytest.mark.parametrize(
    ("step", "named"), [("merge", "summary.nc"), ("figures", "figures/"), ("report", "report.html")]
)
def test_a_step_on_a_full_disk_says_so_and_spoils_nothing(
    finished_desk, desk, mounted, step, named
):
    disk = mounted()
    shutil.copytree(finished_desk.folder / "results", disk / "tiny")
    fill(disk, leaving=8_000)
    before = everything(disk)
    result = desk.call(step, "tiny.yaml", "--results", disk / "tiny", status=1)
    assert f"{disk}/tiny/{named}" in result.stderr
    assert FULL in result.stderr
    assert everything(disk) == before


def test_a_folder_that_may_only_be_read_is_refused_before_anything_is_computed(
    finished_desk, desk, mounted
):
    disk = mounted()
    shutil.copytree(finished_desk.folder / "results", disk / "tiny")
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    calls = [
        (step, "tiny.yaml", "--results", disk / "tiny") for step in ("merge", "figures", "report")
    ]
    for call in [*calls, ("run", "tiny.yaml", "--set", "load=50 N", "-o", disk / "new/a.nc")]:
        result = desk.call(*call, status=2)
        assert str(disk) in result.stderr
        assert "Read-only file system; choose another place" in result.stderr
        assert "cycle 0" not in result.stderr


@pytest.mark.parametrize("then", [None, RuntimeError])
def test_memory_that_a_library_lacks_and_does_not_tell_of_ends_a_command(then):
    class Library:
        def __del__(self):
            raise MemoryError

    def work():
        with swallowing_no_lack_of_memory():
            Library()
            if then:
                raise then

    with pytest.raises(MemoryError):
        work()


def make_folder(path):
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize(
    ("file", "damage", "step", "words"),
    [
        *(("summary.nc", flip, step, SUMMARY) for step in ("figures", "report")),
        *(
            (f"figures/{name}", damage, "report", "raw the figures")
            for name in ("index.json", "contact_half_width.svg")
            for damage in (Path.unlink, lambda path: path.write_bytes(b""), make_folder)
        ),
        ("figures/contact_half_width.svg", make_folder, "figures", "not written: "),
    ],
)
def test_a_damaged_file_is_named_by_what_reads_it(copied, file, damage, step, words):
    damage(Path("results/tiny") / file)
    result = copied.call(step, "tiny.yaml", status=1)
    assert f"results/tiny/{file}: " in result.stderr
    assert words in result.stderr


@pytest.mark.parametrize(
    ("place", "where"),
    [
        ("results/tiny", "out of results, to"),
        ("results/tiny/figures", "to"),
        ("results/tiny/logs/simulate", "to"),
        ("results/tiny/logs/merge.log", "to"),
    ],
)
def test_a_link_out_of_the_results_is_refused(copied, tmp_path, place, where):
    Path("results/tiny/logs/simulate").mkdir(parents=True, exist_ok=True)
    Path("results/tiny/logs/merge.log").touch()
    elsewhere = tmp_path / "elsewhere"
    shutil.move(place, elsewhere)
    Path(place).symlink_to(elsewhere)
    before = everything(elsewhere)
    for step in ("batch", "merge", "figures", "report"):
        for option in [()] if place == "results/tiny" else [(), ("--results", "results/tiny")]:
            result = copied.call(step, "tiny.yaml", *option, status=2)
            assert f"{place}: is a link that leads {where} {elsewhere}" in result.stderr
    assert everything(elsewhere) == before


def test_a_link_in_the_place_of_a_file_is_replaced_and_not_written_through(copied, tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("mine")
    for name in ("a.nc", "a.checkpoint"):
        Path(name).symlink_to(precious)
    copied.call("run", "tiny.yaml", "--set", "load=50 N", "-o", "a.nc")
    assert precious.read_text() == "mine"
    assert not Path("a.nc").is_symlink()
    # The folder of all results may be a link, and one among them too.
    shutil.move("results", tmp_path / "scratch")
    Path("results").symlink_to(tmp_path / "scratch")
    copied.call("merge", "tiny.yaml")
    Path("results/tiny").rename("results/other")
    Path("results/tiny").symlink_to("other")
    copied.call("merge", "tiny.yaml")


TEXT = "\x1b[2J\x9b31m\u202eevil\r\n"


def call(*arguments):
    """What a command says; it must end with a status of its own and no traceback."""
    done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    said = done.stdout + done.stderr
    assert done.exit_code in (0, 1, 2), said
    assert "defect" not in said
    assert printable(said) == said
    return done.exit_code, said


@pytest.mark.parametrize("name", ["title", "case_id", "source", "warnings"])
def test_what_a_file_says_sends_no_commands_to_the_terminal(case_file, tmp_path, name):
    path = shutil.copy(case_file, tmp_path / "changed.nc")
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr(name, TEXT)
    status, said = call("show", path)
    assert status == 0
    assert r"\u001b[2J\u009b31m\u202eevil" in said
    status, said = call("show", path, "--json")
    assert TEXT in json.loads(said).get(name, [TEXT]) or name == "warnings"


def test_what_a_study_says_sends_no_commands_to_the_terminal(desk, content):
    content["base"]["lo\x1b[2Jad"] = "\x1b[31m"
    desk.write(content)
    assert r"lo\u001b[2Jad" in call("plan", "tiny.yaml")[1]


of_files = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=10),
    lambda item: (
        st.lists(item, max_size=3)
        | st.dictionaries(st.sampled_from(["name", "cases", "caption", "a", "case_id"]), item)
    ),
    max_leaves=8,
)
CONTENT = st.binary(max_size=60) | JSON.map(lambda value: json.dumps(value).encode())


@of_files
@given(content=CONTENT)
def test_small_files_of_any_content_are_passed_over_or_refused(tmp_path, content):
    names = ("logs/simulate/a.failed.json", "benchmarks/batches/a.tsv", "batches/b.json")
    for name in (*names, "figures/index.json"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(content)
    assert set(failures(tmp_path)) <= {"a"}
    spent_on_simulations(tmp_path)
    is_finished(tmp_path / names[2], ["a"], {"a": (1, 1.0)})
    with suppress(DataFileError):
        entries = read_figure_index(tmp_path / "figures")
        assert all(Path(entry.name).name == entry.name for entry in entries)
