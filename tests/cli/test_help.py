"""Help, version, and what a shell completes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

import fretwear
from fretwear.cli import app
from fretwear.study.parameters import parameter_names
from fretwear.study.study import load_study

COMMANDS = [command.name or command.callback.__name__ for command in app.registered_commands]


def assert_reads_well(text):
    """Help has no colours and fits on 80 columns."""
    assert "\x1b" not in text
    assert max(map(len, text.splitlines())) <= 80
    assert "<bool>" not in text
    assert "{" not in text.partition("Usage:")[2].partition("\n")[0]


def test_all_commands_are_listed_and_the_program_alone_prints_its_help(desk):
    text = desk.call("--help").stdout
    assert_reads_well(text)
    assert {"run", "batch", "plan", "show", "plot", "compare", "animate"} <= set(COMMANDS)
    for command in COMMANDS:
        assert f"│ {command} " in text
    result = desk.call()
    assert result.exit_code == 2
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


@pytest.mark.parametrize(
    "program", [["-m", "fretwear"], ["-c", "import fretwear.cli as c; c.main()"]]
)
def test_the_version_is_printed(program):
    done = subprocess.run(
        [sys.executable, *program, "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"fretwear {fretwear.__version__}\n"


SHELL = """
eval "$(_FRETWEAR_COMPLETE=source_bash fretwear)"
COMP_WORDS=(fretwear "$@"); COMP_CWORD=$#
_fretwear_completion fretwear
printf '%s\\n' "${COMPREPLY[@]}"
"""


def offered(*words):
    """What bash would offer for the last one of the words after ``fretwear``."""
    environment = {
        "_FRETWEAR_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(["fretwear", *words]),
        "COMP_CWORD": str(len(words)),
    }
    result = CliRunner().invoke(app, [], env=environment, prog_name="fretwear")
    assert (result.exit_code, result.stderr) == (0, "")
    return result.stdout.split()


def test_commands_options_studies_and_case_files_are_offered(desk):
    assert {"run", "plan", "show", "plot"} <= set(offered(""))
    assert offered("pl") == ["plan", "plot"]
    assert {"--case", "--set", "--quiet", "--log-format"} <= set(offered("run", "--"))
    assert offered("run", "tiny.yaml", "--log-format", "") == ["auto", "lines", "json"]
    for name in ("studies/demo.yaml", "studies/mine.yml", "studies/notes.txt", "readme.md"):
        desk.write("", name)
    expected = ["tiny.yaml", "studies/demo.yaml", "studies/mine.yml"]
    assert offered("run", "") == expected
    assert offered("plan", "st") == expected[1:]
    assert offered("run", "studies/d") == ["studies/demo.yaml"]
    for name in ("results/summary.nc", "results/cases/a.nc", "results/cases/b.nc", "results/x.png"):
        desk.write("", name)
    assert offered("show", "results/") == ["results/cases/", "results/summary.nc"]
    assert offered("plot", "results/cases/") == ["results/cases/a.nc", "results/cases/b.nc"]
    # Where only a folder is left or a name must be quoted, the shell does it.
    desk.write("", "results/cases/my case.nc")
    assert offered("show", "res") == []
    assert offered("show", "results/cases/") == []


def test_the_ids_of_the_study_that_was_typed_are_offered(desk, content):
    assert offered("run", "tiny.yaml", "--case", "") == list(load_study("tiny.yaml").cases())
    (only,) = offered("run", "tiny.yaml", "--set", "friction=0.4", "--case", "P25")
    assert only.startswith("P25N-")
    desk.write("base: [1", "broken.yaml")
    for words in (("missing.yaml",), ("broken.yaml",), ()):
        assert offered("run", *words, "--case", "P") == []
    content["vary"] = {
        "load": [f"{load} N" for load in range(25, 75)],
        "friction": [0.2 + 0.001 * step for step in range(50)],
    }
    desk.write(content)
    ids = offered("run", "tiny.yaml", "--case", "")
    assert len(ids) == 2000, "of very many points the first ones"
    assert ids[0] == load_study("tiny.yaml").points(1, 1)[0].id


def test_names_of_parameters_are_offered_and_an_example_that_runs_for_the_last_one_left(desk):
    names = offered("run", "tiny.yaml", "--set", "")
    assert set(names) == {f"{name}=" for name in (*parameter_names(), "output.cycles", "title")}
    assert offered("run", "tiny.yaml", "--set", "lo") == ["load=", "load=50N"]
    assert desk.call("plan", "tiny.yaml", "--set", "load=50N").exit_code == 0


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash on this machine")
def test_bash_itself_gets_them(desk):
    folder = Path(sys.executable).parent
    if not (folder / "fretwear").exists():
        pytest.skip("the command fretwear is not installed beside this Python")
    done = subprocess.run(
        ["bash", "--norc", "-c", SHELL, "bash", "run", "tiny.yaml", "--case", "P2"],
        cwd=desk.folder,
        env={**os.environ, "PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == ""
    assert done.stdout.startswith("P25N")
