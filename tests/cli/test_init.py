"""A folder to work in, made from what comes with the package."""

import subprocess
import sys
from pathlib import Path

import pytest

from fretwear.running.workflow import workspace

MADE = [".gitignore", "Snakefile", "profiles/default/config.yaml", "profiles/slurm/config.yaml"]


def files(folder):
    return sorted(str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file())


def test_a_new_folder_has_workflow_settings_study_and_gitignore(desk):
    assert desk.call("init", "new").exit_code == 0
    assert files(Path("new")) == [*MADE, "studies/demo.yaml"]
    study = Path("new/studies/demo.yaml").read_text(encoding="utf-8")
    assert study == (workspace() / "studies/demo.yaml").read_text(encoding="utf-8")
    assert desk.call("plan", "new/studies/demo.yaml").exit_code == 0
    # A study brings the surfaces that it names.
    assert desk.call("init", "other", "--study", "measured").exit_code == 0
    assert Path("other/studies/surfaces/ground.nc").is_file()
    assert not Path("other/studies/demo.yaml").exists()


def test_what_is_there_is_left_as_it_is(desk, tmp_path):
    precious = tmp_path / "elsewhere"
    Path("new").mkdir()
    Path("new/Snakefile").write_text("mine")
    Path("new/.gitignore").symlink_to(precious)
    said = desk.call("init", "new", "--study", "paper").stdout
    assert "new/Snakefile: exists already" in said
    assert "snakemake --cores 2 --config study=paper" in said
    assert Path("new/Snakefile").read_text() == "mine"
    assert not precious.exists()
    assert Path("new/studies/paper.yaml").is_file()


def test_the_studies_that_come_with_the_package_are_listed(desk):
    before = desk.files()
    said = desk.call("init", "--list").stdout
    for file in (workspace() / "studies").glob("*.yaml"):
        assert file.stem in said
    assert "Loads, friction, roughness and plastic limits" in said
    (measured,) = (line for line in said.splitlines() if line.startswith("measured "))
    assert measured.endswith("pip install 'fretwear[surfaces]'")
    assert said.count("pip install") == 1
    assert desk.files() == before
    result = desk.call("init", "new", "--study", "dmo")
    assert result.exit_code == 2
    assert "there are demo, " in result.stderr


@pytest.mark.slow
def test_the_workflow_of_a_new_folder_has_the_whole_study_to_do(desk):
    desk.call("init", "new")
    command = [sys.executable, "-m", "snakemake", "--dry-run", "--cores", "2"]
    said = subprocess.check_output(command, cwd="new", text=True, stderr=subprocess.STDOUT)
    assert "Writing the report of demo" in said
    assert said.count("Simulating ") >= 2
