"""Jobs that share nothing but the folder of the results, as containers on Kubernetes do.

The cluster here is a script that runs every job in an empty folder, into which Snakemake has to
bring the workflow, with the folder of the results mounted.
"""

import shlex
import shutil
import subprocess

import pytest

from fretwear.data.files import open_summary

for plugin in ("snakemake_executor_plugin_cluster_generic", "snakemake_storage_plugin_fs"):
    pytest.importorskip(plugin, reason="needs the extra pods")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("rsync") is None, reason="needs rsync, which the storage uses"),
]

SUBMIT = """#!/bin/bash
pod="$(mktemp -d {pods}/XXXXXX)"
ln -s {volume}/results "$pod/results"
cd "$pod" && bash "$1" >log 2>&1
echo $? >status
basename "$pod"
"""
STATUS = """#!/bin/bash
[ "$(cat {pods}/"$1"/status)" = 0 ] && echo success || echo failed
"""


def write_program(path, text, **folders):
    path.write_text(text.format(**{name: shlex.quote(str(each)) for name, each in folders.items()}))
    path.chmod(0o755)
    return shlex.quote(str(path))


def keep_under_version_control(folder):
    """Snakemake brings to a job what is kept under version control beside the Snakefile."""
    git = ["git", "-c", "user.name=test", "-c", "user.email=test@localhost"]
    for command in ("init --quiet", "add Snakefile profiles studies", "commit --quiet -m study"):
        subprocess.run([*git, *command.split()], cwd=folder, check=True)


@pytest.mark.skipif(shutil.which("git") is None, reason="needs git")
def test_jobs_may_share_nothing_but_the_folder_of_the_results(checkout, tmp_path):
    pods, volume = tmp_path / "pods", tmp_path / "volume"
    for folder in (pods, volume / "results"):
        folder.mkdir(parents=True)
    coarse = {"roughness": "none", "plastic_limit": "none", "cell": "10 um", "cycles": 50}
    checkout.write_one_case("pods", load="20 N", friction=0.3, **coarse)
    keep_under_version_control(checkout.folder)
    (checkout.folder / "results").symlink_to(volume / "results")
    submit = write_program(tmp_path / "submit", SUBMIT, pods=pods, volume=volume)
    status = write_program(tmp_path / "status", STATUS, pods=pods)
    command = (
        "snakemake --config study=pods --executor cluster-generic --jobs 2"
        f" --cluster-generic-submit-cmd {submit} --cluster-generic-status-cmd {status}"
        f" --default-storage-provider fs --default-storage-prefix {shlex.quote(str(volume))}"
        " --shared-fs-usage none --job-deploy-sources"
    )
    run = checkout.start(command)
    assert run.end(300) == 0, run.output
    (pod,) = pods.iterdir()
    assert (pod / "Snakefile").is_file()
    results = checkout.folder / "results/pods"
    with open_summary(results / "summary.nc") as summary:
        assert (summary["status"] == 0).all()
    assert (results / "report.html").is_file()
    again = checkout.start(command)
    assert again.end(120) == 0
    assert "Nothing to be done" in again.output
