"""The profile for SLURM, as far as it can be tried without a cluster."""

import pytest

pytest.importorskip("snakemake_executor_plugin_slurm", reason="needs the extra slurm")


def test_the_profile_holds_settings_that_snakemake_and_its_plugin_know(checkout):
    run = checkout.start("snakemake --profile profiles/slurm --dry-run")
    assert run.end(60) == 0, run.output
    assert "Using profiles profiles/slurm and workflow specific profile profiles/default" in (
        run.output
    )
    # A misspelt setting would not have been taken.
    file = checkout.folder / "profiles/slurm/config.yaml"
    file.write_text(file.read_text().replace("slurm-status-command", "slurm-status-comand"))
    run = checkout.start("snakemake --profile profiles/slurm --dry-run")
    assert run.end(60) != 0
