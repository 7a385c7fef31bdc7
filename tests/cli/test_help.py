import subprocess
import sys

import pytest
import typer

import fretwear
from fretwear.cli import app

COMMANDS = [command.name or command.callback.__name__ for command in app.registered_commands]


def test_all_commands_are_listed(desk):
    text = desk.call("--help").stdout
    assert {"run", "batch", "plan", "show", "plot", "compare", "animate"} <= set(COMMANDS)
    for command in COMMANDS:
        assert f"│ {command} " in text


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_has_an_example_which_is_a_call_of_it(desk, command):
    text = desk.call(command, "--help").stdout
    assert desk.call(command, "-h").stdout == text
    (example,) = (line.split("Example: ")[1] for line in text.splitlines() if "Example: " in line)
    program, name, *_ = example.split()
    assert (program, name) == ("fretwear", command)
    group = typer.main.get_command(app)
    arguments = example.partition(">")[0].replace("'", "").replace("=30 N", "=30N").split()[2:]
    # Parsing refuses what the command does not know; nothing is run.
    group.commands[command].make_context(command, arguments)


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_reads_well_without_colours_on_80_columns(desk, command):
    text = desk.call(*filter(None, [command]), "--help").stdout
    assert "\x1b" not in text
    assert max(map(len, text.splitlines())) <= 80
    assert "<bool>" not in text
    assert "{" not in text.partition("Usage:")[2].partition("\n")[0]


@pytest.mark.parametrize(
    "program", [["-m", "fretwear"], ["-c", "import fretwear.cli as c; c.main()"]]
)
def test_the_version_is_printed(program):
    done = subprocess.run(
        [sys.executable, *program, "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"fretwear {fretwear.__version__}\n"
