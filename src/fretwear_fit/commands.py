"""The command ``fretwear fit``: parameters from what was measured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.common import (
    CommandError,
    Processes,
    Results,
    StudyFile,
    add_command,
    aligned,
    check_output,
    note,
    option,
    say,
    study_and_results,
)

_OUTPUT = "File to write, for ArviZ."
_JSON = "File to write with values, intervals, correlations and warnings."


def fit_scar(
    file: StudyFile,
    output: Annotated[
        Path | None, option("-o/--output", "FIT.nc", _OUTPUT, "results/STUDY/fit.nc")
    ] = None,
    json_: Annotated[Path | None, option("--json", "FIT.json", _JSON, "FIT.json")] = None,
    results: Results = None,
    processes: Processes = 1,
) -> None:
    """Find parameters from measured scars, with intervals, and state what the data leave open.

    The section fit of the study names the parameters and the measurements. An interrupted fit
    resumes from the runs it has kept beside its file.
    """
    study, folder = study_and_results(file, results)
    if output is None:
        folder.mkdir(parents=True, exist_ok=True)
    path = check_output(output or folder / "fit.nc", ".nc")
    beside = check_output(json_ or path.with_suffix(".json"), ".json")

    from fretwear_fit import search as fits

    try:
        result = fits.fit(study, folder=path.with_suffix(".runs"), processes=processes, tell=note)
    except fits.FitError as error:
        raise CommandError(str(error)) from error
    result.write(path)
    result.write_json(beside)
    for line in aligned(result.table()):
        say(line)
    for warning in result.warnings:
        note(f"warning: {warning}")
    say(f"{path}: {result.computed} runs")


app = typer.Typer()
add_command(app, fit_scar, "fretwear fit studies/mine.yaml")
