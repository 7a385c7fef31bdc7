"""What a user gets wrong: each is answered by one message that helps."""

import os

import pytest

from fretwear.study.problems import StudyError
from fretwear.study.study import load_study

from .conftest import Desk, tiny_study


@pytest.mark.parametrize("command", ["run", "plan", "merge", "figures", "report"])
def test_all_mistakes_in_a_study_are_named_and_nothing_is_written(desk, content, command):
    """The rules are those of tests/study/test_file.py."""
    content["base"].update(lod="50 N", radius="10 N", friction=-1)
    content["vary"]["load"] = ["25 N", "0.025 kN"]
    del content["base"]["wear_coefficient"]
    desk.write(content)
    result = desk.call(command, "tiny.yaml")
    assert result.exit_code == 2
    with pytest.raises(StudyError) as caught:
        load_study("tiny.yaml")
    assert len(caught.value.problems) == 5
    assert result.stderr == f"fretwear: error: {caught.value}\n"
    assert result.stdout == ""
    assert desk.files() == ["tiny.yaml"]


HELP = "--help'"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a study, results of it, and files that went wrong in one way each."""
    desk = Desk(tmp_path_factory.mktemp("mistakes"))
    study = desk.write(tiny_study(), "studies/tiny.yaml")
    good = desk.folder / "results/tiny/cases/good.nc"
    assert desk.call("run", study, "--case", "P25N", "-o", good).exit_code == 0
    content = good.read_bytes()
    (desk.folder / "cut.nc").write_bytes(content[: len(content) // 2])
    text = study.read_text(encoding="utf-8")
    changes = {
        "tab": ("  radius", "\tradius"),
        "colon": ("radius:", "radius"),
        "space": ("radius: ", "radius:"),
        "quote": ("title: Tiny", "title: 'Tiny"),
        "comma": ("0.3", "0,3"),
        "unit": ("10 mm", "10"),
        "unknown": ("50 N", "50 Nt"),
        "dimension": ("10 mm", "10 N"),
        "key": ("friction", "fricton"),
        "section": ("vary", "varry"),
    }
    for name, (right, wrong) in changes.items():
        assert right in text
        desk.write(text.replace(right, wrong), f"{name}.yaml")
    desk.write("cell: [1 um]", "note.txt")
    return desk


# What was typed after `fretwear`, and what the answer must have.
MISTAKES = {
    "a study without its folder": ("run tiny.yaml", "did you mean 'studies/tiny.yaml'?"),
    "a study by its name": ("plan tiny", "did you mean 'studies/tiny.yaml'?"),
    "a misspelt study": ("run studies/tinny.yaml", "did you mean 'studies/tiny.yaml'?"),
    "another folder": ("run elsewhere/tiny.yaml", "did you mean 'studies/tiny.yaml'?"),
    "a folder for a study": ("run studies", "give one of its files: studies/tiny.yaml"),
    "results for a study": ("plan cut.nc", "fretwear show cut.nc"),
    "a tab": ("plan tab.yaml", "(line 3)", "use spaces"),
    "no colon": ("plan colon.yaml", "(line 3)", "a colon and a space must follow the key"),
    "no space": ("plan space.yaml", "(line 3)", "a colon and a space must follow the key"),
    "an open quote": ("plan quote.yaml", "a quote opened before is not closed"),
    "a decimal comma": ("plan comma.yaml", "poisson_ratio = 0,3", "write a decimal point"),
    "no unit": ("plan unit.yaml", "base.radius = 10 ", "did you mean '10 mm'?"),
    "an unknown unit": ("plan unknown.yaml", "unknown unit 'Nt'", "did you mean 'N'?"),
    "a unit of something else": ("plan dimension.yaml", "must be a length", "'N' is a force"),
    "a misspelt parameter": ("plan key.yaml", "base.fricton", "did you mean 'friction'?"),
    "a misspelt section": ("plan section.yaml", "varry", "did you mean 'vary'?"),
    "no choice of a case": ("run studies/tiny.yaml", "give --case ID, one of", "P25N-", "P50N-"),
    "an unknown case": ("run studies/tiny.yaml --case Q9", "fretwear plan lists the cases"),
    "a beginning of several ids": ("run studies/tiny.yaml --case P", "2 ids", "P25N-", "P50N-"),
    "a misspelt command": ("rum studies/tiny.yaml", "Did you mean 'run'?"),
    "a misspelt option": ("run studies/tiny.yaml --cases Q", "did you mean --case?", HELP),
    "an option before the command": ("--quiet run x.yaml", "fretwear run --quiet"),
    "no file at all": ("show", "missing argument 'OUT.nc'", "see 'fretwear show --help'"),
    "an option without its value": ("run studies/tiny.yaml --case", "requires an argument", HELP),
    "a change without =": ("run studies/tiny.yaml --set load", "name=value", "--set 'load=30 N'"),
    "a change without quotes": ("run studies/tiny.yaml --set load=3 N", "in quotes", "'load=30 N'"),
    "a change without unit": ("plan studies/tiny.yaml --set load=3", "did you mean '3 N'?"),
    "a change of nothing": ("plan studies/tiny.yaml --set laod=3N", "did you mean 'load'?"),
    "sliding": (
        "run studies/tiny.yaml --case P25 --set tangential_load=20N",
        "Q must be less than µP = 12.5 N",
        "lower tangential_load",
    ),
    "another file format": ("run studies/tiny.yaml --case P25 -o a.h5", "such as a.nc"),
    "a folder to write to": ("run studies/tiny.yaml --case P25 -o results", "results/x.nc"),
    "a file as a folder": ("plot results/tiny/cases/good.nc -o note.txt/a.png", "is not a folder"),
    "another picture format": ("plot results/tiny/cases/good.nc -o a.bmp", "such as a.png"),
    "a log format": ("run studies/tiny.yaml --log-format yaml", "'auto', 'lines', 'json'"),
    "a study to look at": ("show studies/tiny.yaml", "fretwear plan studies/tiny.yaml"),
    "a misspelt case file": ("show results/tiny/cases/god.nc", "did you mean", "good.nc"),
    "a folder to look at": ("show results/tiny", "results/tiny/cases/good.nc"),
    "a truncated file": ("show cut.nc", "cut short", "run the case again"),
    "no case file": ("plot note.txt", "not a netCDF-4 file"),
    "nothing to compare": ("compare results/tiny/cases/good.nc no.nc", "no.nc: "),
    "another film": ("animate results/tiny/cases/good.nc -o a.avi", "must end in .gif or .mp4"),
    "a missing film": ("animate missing.nc", "missing.nc: "),
    "results elsewhere": ("figures studies/tiny.yaml --results nowhere", "nowhere/summary.nc"),
}
# The study, the call and the files are right; what they are applied to is not there yet.
FAILURES = ("results elsewhere",)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_answered_by_one_message_that_tells_what_to_do(place, monkeypatch, mistake):
    monkeypatch.chdir(place.folder)
    typed, *expected = MISTAKES[mistake]
    before = place.files()
    result = place.call(*typed.split())
    assert result.exit_code == (1 if mistake in FAILURES else 2)
    assert result.stderr.count("fretwear: error: ") == 1
    for words in expected:
        assert words in result.stderr
    assert "Traceback" not in result.output
    assert result.stdout == ""
    assert place.files() == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_written_to_is_refused(place, monkeypatch):
    monkeypatch.chdir(place.folder)
    (place.folder / "closed").mkdir(mode=0o500)
    result = place.call("run", "studies/tiny.yaml", "--case", "P25N", "-o", "closed/a.nc")
    assert result.exit_code == 2
    assert "choose another place" in result.stderr


def test_a_call_from_a_folder_without_studies_is_told_where_it_looked(desk):
    (desk.folder / "tiny.yaml").unlink()
    result = desk.call("run", "demo.yaml")
    assert result.exit_code == 2
    assert f"no study lies in {desk.folder}" in result.stderr
    assert "change to the folder with studies/" in result.stderr
