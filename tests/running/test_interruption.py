"""The workflow and its commands, stopped from outside or given names that mean harm."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

import fretwear
from fretwear.running.workflow import StudyJobs
from fretwear.study.problems import StudyError
from fretwear.study.study import load_study

REPOSITORY = Path(__file__).parents[2]
BASE = {
    "radius": "10 mm",
    "youngs_modulus": "208 GPa",
    "poisson_ratio": 0.3,
    "tangential_ratio": 0.8,
    "friction": 0.5,
    "wear_coefficient": "7e-13 / Pa",
    "plastic_limit": "none",
    "roughness": "none",
    "cycles": 20000,
    "cell": "10 um",
}


@pytest.fixture
def checkout(tmp_path):
    """A folder with the workflow, as a user has it."""
    shutil.copy(REPOSITORY / "Snakefile", tmp_path)
    shutil.copytree(REPOSITORY / "profiles", tmp_path / "profiles")
    return tmp_path


def write_study(file, cell="10 um", **changes):
    content = {"base": {**BASE, "cell": cell}, "vary": {"load": ["45 N", "50 N"]}, **changes}
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(yaml.safe_dump(content, sort_keys=False))


def wait_for(condition, process):
    while not condition():
        assert process.poll() is None
        time.sleep(0.02)


@pytest.mark.slow
def test_stopping_the_workflow_keeps_a_checkpoint_of_every_case_that_runs(checkout):
    write_study(checkout / "studies/demo.yaml", cell="0.5 um", batch=1)
    cases, logs = checkout / "results/demo/cases", checkout / "results/demo/logs/simulate"
    process = subprocess.Popen(
        [sys.executable, "-m", "snakemake", "--cores", "2"],
        cwd=checkout,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    wait_for(
        lambda: sum("cycle 0 of" in log.read_text() for log in logs.glob("*.log")) == 2, process
    )
    # As a terminal does it on Ctrl-C, and a scheduler: to all processes of the group.
    os.killpg(process.pid, signal.SIGINT)
    message = process.communicate(timeout=120)[1]
    assert process.returncode != 0
    assert "fretwear: stopped: by Ctrl-C" in message
    assert {path.suffix for path in cases.iterdir()} == {".checkpoint"}
    assert len(list(cases.iterdir())) == 2
    for log in logs.glob("*.log"):
        assert "kept; the same command resumes after cycle" in log.read_text()


@pytest.mark.slow
def test_a_run_that_is_stopped_while_it_writes_ends_when_its_file_is_whole(tmp_path):
    # Enough snapshots that writing them takes a while.
    output = {"cycles": [*range(1, 30)]}
    write_study(tmp_path / "one.yaml", cell="1.5 um", vary={"load": ["50 N"]}, output=output)
    process = subprocess.Popen(
        [sys.executable, "-m", "fretwear", "run", "one.yaml", "-o", "out/a.nc"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for(lambda: list((tmp_path / "out").glob(".a.nc.*.tmp")), process)
    process.send_signal(signal.SIGTERM)
    # Interrupted inside of the netCDF library, it would wait for itself for ever.
    message = process.communicate(timeout=120)[1]
    assert process.returncode == 143
    assert "fretwear: stopped: by SIGTERM" in message
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["a.nc"]
    with fretwear.open_case(tmp_path / "out/a.nc") as case:
        assert case.sizes["cycle"] == 31


HARMFUL = "my 'dir' $(touch harm) \"q\" {x} ;`touch harm`"


@pytest.mark.slow
def test_names_of_folders_and_titles_are_never_commands(checkout):
    study = checkout / HARMFUL / "study.yaml"
    write_study(study, title="$(touch harm) `touch harm` {x} <b>'\"")
    done = subprocess.run(
        [
            *(sys.executable, "-m", "snakemake", "--cores", "2", "results/study/points.csv"),
            *("--config", f"study={HARMFUL}/study.yaml"),
        ],
        cwd=checkout,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (checkout / "results/study/summary.nc").exists()
    assert not list(checkout.rglob("harm"))


@pytest.mark.parametrize("name", ["$(touch harm)", "it's", "a b", "..", "-x", "a;b", "a\nb", "{x}"])
def test_a_study_whose_name_is_more_than_a_name_has_no_results(tmp_path, name):
    write_study(tmp_path / f"{name}.yaml")
    with pytest.raises(StudyError, match="names the folder of its results"):
        load_study(tmp_path / f"{name}.yaml")


def test_a_study_of_another_folder_has_its_results_among_the_others(checkout, monkeypatch):
    monkeypatch.chdir(checkout)
    write_study(checkout / "above.yaml")
    (checkout / "studies").mkdir()
    for name in ("../above", "studies/../above.yaml", str(checkout / "above.yaml")):
        assert StudyJobs.of(name).folder == "results/above"
