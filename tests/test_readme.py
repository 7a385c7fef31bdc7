"""The README is what a new user has: what it says must run."""

import re
import shlex
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from fretwear.cli.program import app
from fretwear.study.reading import load_study

from .studies import run_study, write_study

REPOSITORY = Path(__file__).parents[1]
README = (REPOSITORY / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


def call(*arguments):
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.stderr
    return result.stdout


def test_the_study_file_and_the_commands_of_the_readme_can_be_run(tmp_path, monkeypatch):
    (text,) = blocks("yaml")
    monkeypatch.chdir(tmp_path)
    assert len(load_study(write_study(tmp_path / "studies/mine.yaml", text)).cases()) == 6
    assert "6 points, 6 cases" in call("plan", "studies/mine.yaml")
    lines = [line for block in blocks("bash")[2:] for line in block.splitlines()]
    assert blocks("bash")[-1].strip().endswith("sphinx-build -W --keep-going docs site")
    words = [shlex.split(line, comments=True) for line in lines]
    commands = {line[1] for line in words if line[0] == "fretwear"}
    assert commands == {*("plan", "run", "show", "plot")}
    for command in commands:
        assert f"fretwear {command}" in call(command, "--help")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with results of one point of the default study, on a coarse grid."""
    folder = tmp_path_factory.mktemp("readme")
    content = yaml.safe_load((REPOSITORY / "studies/demo.yaml").read_text(encoding="utf-8"))
    content["base"].update(cycles=300, cell="6 um")
    content["base"]["roughness"].update(slope_x="0.3 deg", slope_y="0.3 deg")
    content["vary"] = {name: values[1:2] for name, values in content["vary"].items()}
    content["output"] = {"cycles": [0, 300]}
    run_study(load_study(write_study(folder / "demo.yaml", content)), folder / "results/demo")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(blocks("python"))))
def test_the_python_of_the_readme_runs(number, folder, monkeypatch, capsys):
    """For fewer cycles on wider cells."""
    monkeypatch.chdir(folder)
    short = 'cycles=30, cell="2 um", error_estimate=False'
    code = blocks("python")[number].replace("cycles=3000", short)
    exec(compile(code, "README.md", "exec"), {})
    assert "nan" not in capsys.readouterr().out
