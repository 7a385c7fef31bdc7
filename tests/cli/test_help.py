"""Help, completion, new folders, and one message that helps for every mistake."""

import subprocess
import sys
from pathlib import Path

import pytest
import typer

import fretwear
from fretwear.cli.program import app
from fretwear.run.workflow import workspace
from fretwear.study.mistakes import StudyError
from fretwear.study.reading import load_study

from ..studies import printed
from .conftest import Desk, tiny_study

COMMANDS = [command.name or command.callback.__name__ for command in app.registered_commands]


def assert_reads_well(text):
    assert "\x1b" not in text
    assert max(map(len, text.splitlines())) <= 80


def test_all_commands_are_listed_and_the_program_alone_prints_its_help(desk):
    text = desk.call("--help").stdout
    assert_reads_well(text)
    assert {"run", "plan", "show", "plot", "compare"} <= set(COMMANDS)
    for command in COMMANDS:
        assert f"│ {command} " in text
    result = desk.call(status=2)
    assert "Usage: fretwear" in result.stdout


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_has_an_example_which_is_a_call_of_it(desk, command):
    text = desk.call(command, "--help").stdout
    assert_reads_well(text)
    assert desk.call(command, "-h").stdout == text
    (example,) = (line.split("Example: ")[1] for line in text.splitlines() if "Example: " in line)
    program, name, *_ = example.split()
    assert (program, name) == ("fretwear", command)
    group = typer.main.get_command(app)
    arguments = example.partition(">")[0].replace("'", "").replace("=30 N", "=30N").split()[2:]
    # Parsing refuses what the command does not know; nothing is run.
    group.commands[command].make_context(command, arguments)


def test_the_version_is_printed():
    said = printed(sys.executable, "-m", "fretwear", "--version")
    assert said == f"fretwear {fretwear.__version__}\n"


@pytest.mark.parametrize(
    ("command", "spared"),
    [
        ("--help", {"numpy", "scipy", "xarray", "pandas", "pydantic"}),
        pytest.param("plan studies/demo.yaml", {"scipy", "xarray"}, marks=pytest.mark.slow),
    ],
)
def test_a_command_does_without_libraries_that_it_does_not_need(command, spared):
    listed = "import sys, atexit, fretwear.cli as cli; atexit.register(lambda: print(*sys.modules))"
    program = [sys.executable, "-c", f"{listed}; cli.main()", *command.split()]
    assert not spared & {*printed(*program, folder=workspace()).split()}


MADE = [".gitignore", "Snakefile", "profiles/default/config.yaml", "profiles/slurm/config.yaml"]


def files(folder):
    return sorted(str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file())


def test_a_new_folder_has_workflow_settings_study_and_gitignore_and_keeps_what_it_had(desk):
    desk.call("init", "new")
    assert files(Path("new")) == [*MADE, "studies/demo.yaml"]
    for name in (*MADE[2:], "studies/demo.yaml"):
        assert Path("new", name).read_bytes() == (workspace() / name).read_bytes()
    desk.call("plan", "new/studies/demo.yaml")
    Path("new/Snakefile").write_text("mine")
    Path("new/.gitignore").unlink()
    Path("new/.gitignore").symlink_to("../elsewhere")
    # A study brings the surfaces that it names.
    said = desk.call("init", "new", "--study", "measured").stdout
    assert "new/Snakefile: exists already" in said
    assert "snakemake --cores 2 --config study=measured" in said
    assert Path("new/studies/surfaces/ground.nc").is_file()
    assert Path("new/Snakefile").read_text() == "mine"
    # That of an experiment comes with what was measured.
    said = desk.call("init", "new", "--study", "experiments/cruzado2010").stdout
    assert "--config study=experiments/cruzado2010, or change studies/experiments/cruzado" in said
    assert Path("new/studies/experiments/cruzado2010.csv").is_file()
    assert not Path("elsewhere").exists()


@pytest.mark.slow
def test_the_workflow_of_a_new_folder_has_the_whole_study_to_do(desk):
    desk.call("init", "new")
    command = [sys.executable, "-m", "snakemake", "--dry-run", "--cores", "2"]
    said = subprocess.check_output(command, cwd="new", text=True, stderr=subprocess.STDOUT)
    assert "rule report:" in said
    assert said.count("rule simulate:") >= 2


@pytest.mark.parametrize("command", ["run", "plan", "merge", "figures", "report"])
def test_all_mistakes_in_a_study_are_named_and_nothing_is_written(desk, content, command):
    """The rules are those of tests/study/test_file.py."""
    content["base"].update(lod="50 N", radius="10 N", friction=-1)
    content["vary"]["load"] = ["25 N", "0.025 kN"]
    del content["base"]["wear_coefficient"]
    desk.write(content)
    result = desk.call(command, "tiny.yaml", status=2)
    with pytest.raises(StudyError) as caught:
        load_study("tiny.yaml")
    assert len(caught.value.mistakes) == 5
    assert result.stderr == f"fretwear: error: {caught.value}\n"
    assert result.stdout == ""
    assert desk.files() == ["tiny.yaml"]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a study, results of it, and files that went wrong in one way each."""
    desk = Desk(tmp_path_factory.mktemp("mistakes"))
    study = desk.write(tiny_study(), "studies/tiny.yaml")
    good = desk.folder / "results/tiny/cases/good.nc"
    good.parent.mkdir(parents=True)
    desk.call("run", study, "--case", "P25N", "-o", good)
    content = good.read_bytes()
    (desk.folder / "cut.nc").write_bytes(content[: len(content) // 2])
    desk.write("cell: [1 um]", "note.txt")
    return desk


# What was typed after `fretwear`, and what the answer must have.
MISTAKES = {
    "a study without its folder": ("run tiny.yaml", "did you mean 'studies/tiny.yaml'?"),
    "no choice of a case": ("run studies/tiny.yaml", "one of", "P25N-", "P50N-", "study=tiny"),
    "a beginning of several ids": ("run studies/tiny.yaml --case P", "2 of the 2 cases", "P25N-"),
    "a change without unit": ("plan studies/tiny.yaml --set load=3", "did you mean '3 N'?"),
    "two cases for a file": ("run studies/tiny.yaml --case P2 --case P5 -o a.nc", "a folder"),
    "a study to look at": ("show studies/tiny.yaml", "it is a study file", "fretwear run"),
    "a folder to look at": ("show studies", "it is a folder"),
    "a misspelt case file": ("show results/tiny/cases/god.nc", "there is no such file"),
    "a table to look at": ("show note.txt", "it is not a netCDF file"),
    "a truncated file": ("show cut.nc", "cut.nc: it is damaged"),
    "results elsewhere": ("figures studies/tiny.yaml --results nowhere", "nowhere/summary.nc"),
}
# The study, the call and the files are right; what they are applied to is not there yet.
FAILURES = ("results elsewhere",)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_answered_by_one_message_that_tells_what_to_do(place, monkeypatch, mistake):
    monkeypatch.chdir(place.folder)
    typed, *expected = MISTAKES[mistake]
    files = place.files()
    result = place.call(*typed.split(), status=1 if mistake in FAILURES else 2)
    assert result.stderr.count("fretwear: error: ") == 1
    for words in expected:
        assert words in result.stderr
    assert result.stdout == ""
    assert place.files() == files
