"""Files that fail a command, and files that somebody has made up."""

import json
import os
import re
import shutil
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import fretwear
from fretwear.cli.program import app, swallowing_no_lack_of_memory
from fretwear.data.files import _LENGTH, add_checksum, open_summary
from fretwear.data.safe import DataFileError
from fretwear.figures.index import read_figure_index
from fretwear.run.workflow import failures, is_finished, spent_on_simulations
from fretwear.study.problems import printable

from ..studies import flip, spoil_chunks

FULL = "not written, because the disk (or the quota on it) is full"


SUMMARY = "its checksum does not match. Merge the study again"


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
    yield StudyFigure("points", f"{summary.sizes['load']} loads.", "More", figure)

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


@pytest.mark.usefixtures("desk")
@pytest.mark.skipif(not shutil.which("gcc"), reason="compiles a library")
def test_a_file_system_without_locks_is_told_and_a_case_written_and_read(tmp_path):
    source, library = tmp_path / "flock.c", tmp_path / "flock.so"
    refusing = "int flock(int file, int how) { errno = ENOLCK; return -1; }"
    source.write_text(f"#include <errno.h>\n{refusing}\n")
    subprocess.run(["gcc", "-shared", "-fPIC", "-o", library, source], check=True)
    result = subprocess.run(
        [sys.executable, "-m", "fretwear", "run", "tiny.yaml", "--case", "P50N", "-o", "a.nc"],
        env=os.environ | {"LD_PRELOAD": str(library)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert "a.nc: no locks on this file system; let one process compute it" in result.stderr
    with fretwear.open_case("a.nc") as case:
        assert case.attrs["complete"] == 1


def test_damage_that_shows_only_when_values_are_used_is_told(copied):
    """A checksum that fits keeps nobody from reading on; HDF5 has one more in each chunk."""
    summary = Path("results/tiny/summary.nc")
    spoil_chunks(summary)
    result = copied.call("figures", "tiny.yaml", status=1)
    assert "NetCDF: HDF error" in result.stderr
    assert "defect" not in result.stderr


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


def forged(source, folder, change):
    """A copy of a file of results that somebody has changed, with a checksum that fits."""
    path = shutil.copy(source, folder / "forged.nc")
    os.truncate(path, path.stat().st_size - _LENGTH)
    with netCDF4.Dataset(path, "a") as file:
        change(file)
    add_checksum(path)
    return path


def call(*arguments):
    """What a command says; it must end with a status of its own and no traceback."""
    done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    said = done.stdout + done.stderr
    assert done.exit_code in (0, 1, 2), said
    assert "defect" not in said
    assert printable(said) == said
    return done.exit_code, said


def number(name, value):
    def change(file):
        file[name][...] = value

    return change


def attribute(name, value):
    return lambda file: file.setncattr(name, value)


def of_variable(variable, name, value):
    return lambda file: file[variable].setncattr(name, value)


def large(file):
    for name, length in (("huge_x", 100_000), ("huge_y", 100_000)):
        file.createDimension(name, length)
    file.createVariable("huge", "f4", ("huge_x", "huge_y"))


def strings(file):
    file.createVariable("words", str, ())[...] = "word"


def pairs(file):
    kind = file.createCompoundType(np.dtype([("a", "f8")]), "pair")
    file.createVariable("pairs", kind, ())


REFUSED = {
    "falling cycles": (number("cycle", [5, 3, 1]), "cycle does not increase"),
    "cycles that are none": (number("cycle", [0, 1, np.nan]), "cycle does not increase"),
    "cycles before the first": (number("cycle", [-1, 3, 5]), "cycle begins before 0"),
    "a negative limit": (number("plastic_limit", -3e9), "plastic_limit is -3e+09"),
    "a limit that is none": (number("plastic_limit", np.nan), "plastic_limit is nan"),
    "a result that is none": (number("wear_volume", np.nan), "wear_volume holds values"),
    "a history that is none": (number("history/approach", np.inf), "approach holds values"),
    "another unit": (of_variable("approach", "units", "mm"), "approach is in mm, not in m"),
    "a field in another unit": (of_variable("gap", "units", "um"), "gap is in um, not in m"),
    "a scale": (of_variable("pressure", "scale_factor", 2.0), "scale_factor, which changes"),
    "no symmetry": (attribute("symmetry", "odd"), "its symmetry is none"),
    "numbers as title": (attribute("title", np.arange(3)), "its attribute title is not text"),
    "no parameters": (attribute("parameters", "[1"), "its attribute parameters is not a JSON"),
    "nested parameters": (attribute("parameters", "[" * 90_000), "parameters is not a JSON"),
    "40 GB in a small file": (large, "announces 400"),
    "40 GB in its history": (lambda file: large(file["history"]), "announces 400"),
    "text of any length": (strings, "words holds neither numbers nor plain text"),
    "pairs of numbers": (pairs, "pairs holds neither numbers nor plain text"),
    "a title that has no end": (attribute("title", "x" * 10_000_001), "title is not text"),
    "a history less": (
        lambda file: file["history"].renameVariable("approach", "appro"),
        "it lacks history/approach",
    ),
    "a result less": (lambda file: file.renameVariable("approach", "appro"), "it lacks approach"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_a_forged_case_is_refused_by_a_sentence(case_file, tmp_path, what):
    change, words = REFUSED[what]
    path = forged(case_file, tmp_path, change)
    for command in ("show", "plot"):
        status, said = call(command, path)
        assert status == 2
        assert words in said


@pytest.mark.parametrize(
    ("change", "words"),
    [(number("status", 7), "its status has unknown values"),
     (number("cycle", np.nan), "cycle does not increase"),
     (number("x", np.nan), "x does not increase"),
     (number("load", -5.0), "load is -5"),
     (attribute("study", np.arange(2)), "its attribute study is not text"),
     (attribute("study_file", "[1]"), "its attribute study_file is not a JSON object"),
     (of_variable("approach", "units", "mm"), "approach is in mm, not in m"),
     (of_variable("approach", "add_offset", 1.0), "add_offset, which changes"),
     (lambda file: file.renameVariable("case_id", "ids"), "it lacks case_id"),
     (large, "announces 400"),
     (strings, "words holds neither numbers nor plain text")],
)  # fmt: skip
def test_a_forged_summary_is_refused_by_a_sentence(finished_desk, tmp_path, change, words):
    path = forged(finished_desk.folder / "results/summary.nc", tmp_path, change)
    with pytest.raises(DataFileError, match=re.escape(words)):
        open_summary(path)


def rebuilt(source, path, *, sizes=(), kinds=(), along=()):
    """Write a file anew, with other sizes of dimensions, types and dimensions of variables."""
    sizes, kinds, along = dict(sizes), dict(kinds), dict(along)
    with netCDF4.Dataset(source) as old, netCDF4.Dataset(path, "w") as new:
        new.setncatts(vars(old))
        for name, dimension in old.dimensions.items():
            new.createDimension(name, sizes.get(name, dimension.size))
        for name, variable in old.variables.items():
            dims = along.get(name, variable.dimensions)
            made = new.createVariable(name, kinds.get(name, variable.dtype), dims)
            made.setncatts({n: v for n, v in vars(variable).items() if n != "_FillValue"})
            # Characters as they are: netCDF4 1.7.2 does not write again the words it makes of them.
            made.set_auto_chartostring(False)
            variable.set_auto_chartostring(False)
            if made.shape == variable.shape and name not in kinds:
                made[...] = variable[...]
            elif made.dtype.kind in "if":
                made[...] = np.arange(made.size).reshape(made.shape)
    add_checksum(path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"along": {"x": ("cycle",)}}, "x is not an axis"),
        ({"kinds": {"x": "i4"}}, "x is not an axis"),
        ({"sizes": {"x": 0}}, "x is not an axis"),
        ({"along": {"approach": ("cycle", "load")}}, "it lacks approach"),
        ({"kinds": {"approach": "S1"}}, "it lacks approach"),
    ],
)
def test_a_summary_of_other_shapes_and_types_is_refused(finished_desk, tmp_path, change, words):
    path = tmp_path / "summary.nc"
    rebuilt(finished_desk.folder / "results/summary.nc", path, **change)
    with pytest.raises(DataFileError, match=words):
        open_summary(path)


@pytest.mark.parametrize(("name", "value"), [("pressure", np.inf), ("shear_traction", 1e30)])
def test_fields_that_no_contact_has_are_refused_where_they_are_used(
    case_file, tmp_path, name, value
):
    def change(file):
        file[name][-1, 1, 1] = value

    path = forged(case_file, tmp_path, change)
    assert call("show", path)[0] == 0
    film, stresses = tmp_path / "a.gif", tmp_path / "s.nc"
    for command in (("plot",), ("animate", "-o", film), ("stress", "-o", stresses)):
        status, said = call(*command, path)
        assert status == 2
        assert f"{name} holds {value:g}, which no contact has" in said
    assert not film.exists()


@pytest.mark.parametrize("name", ["title", "case_id", "source", "warnings"])
def test_what_a_file_says_sends_no_commands_to_the_terminal(case_file, tmp_path, name):
    path = forged(case_file, tmp_path, attribute(name, TEXT))
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
VALUES = (
    st.floats(width=64) | st.integers(-(2**31), 2**31 - 1) | st.text(max_size=5) | st.just(TEXT)
)
OTHER = ("title", "case_id", "source", "parameters", "symmetry", "warnings", "complete", "history")


@settings(of_files, max_examples=settings.default.max_examples // 10)
@given(data=st.data())
def test_any_change_is_refused_by_a_sentence_or_shown(case_file, finished_desk, tmp_path, data):
    source = data.draw(st.sampled_from([case_file, finished_desk.folder / "results/summary.nc"]))

    def change(file):
        for _ in range(data.draw(st.integers(1, 3))):
            group = data.draw(st.sampled_from([file, *file.groups.values()]))
            name = data.draw(st.sampled_from([*group.variables]))
            kind = data.draw(st.sampled_from(["value", "units", "attribute", "remove", "rename"]))
            value = data.draw(VALUES)
            variable = group.variables[name]
            if kind == "value" and variable.dtype.kind in "if" and not isinstance(value, str):
                with np.errstate(all="ignore"):
                    variable[...] = np.asarray(value).astype(variable.dtype)
            elif kind == "units":
                which = data.draw(st.sampled_from(["units", "coordinates", "flag_values", "axis"]))
                variable.setncattr(which, value)
            elif kind == "attribute":
                file.setncattr(data.draw(st.sampled_from(OTHER)), value)
            elif kind == "remove" and (names := file.ncattrs()):
                file.delncattr(data.draw(st.sampled_from(names)))
            elif kind == "rename" and not name.endswith("_renamed"):
                group.renameVariable(name, f"{name}_renamed")

    path = forged(source, tmp_path, change)
    call("show", path)
    call("show", path, "--json")


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
