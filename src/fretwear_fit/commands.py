"""The commands ``fretwear fit`` and ``fretwear loops``: what measurements tell."""

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
from fretwear.units import BY_SI_UNIT, QuantityError, parse_quantity

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
    from fretwear_fit.results import parameter_table

    try:
        result = fits.fit(study, folder=path.with_suffix(".runs"), processes=processes, tell=note)
    except fits.FitError as error:
        raise CommandError(str(error)) from error
    result.write(path)
    result.write_json(beside)
    table = parameter_table(result.as_dict())
    for line in aligned([("parameter", *table.columns), *table.itertuples()]):
        say(line)
    for warning in result.warnings:
        note(f"warning: {warning}")
    say(f"{path}: {result.computed} runs")


def split_loops(
    file: Annotated[Path, typer.Argument(help="Recording with displacement and force.")],
    load: Annotated[str, option("--load", "LOAD", "Normal load, such as '50 N'.")],
    output: Annotated[Path, option("-o/--output", "LOOPS.csv", "Table to write.")],
) -> None:
    """Split a recording into cycles: friction, displacement and energy over the cycles.

    The last line is the friction in the form for the base of a study.
    """
    from fretwear.data.atomic import write_text
    from fretwear_fit.loops import friction_text, loop_history

    path = check_output(output, ".csv")
    try:
        table = loop_history(file, parse_quantity(load, BY_SI_UNIT["N"], units_required=True))
    except QuantityError as error:
        raise CommandError(f"{file}: {error}") from error
    write_text(path, table.to_csv(index=False))
    say(f"{path}: {len(table)} cycles")
    say(friction_text(table))


app = typer.Typer()
add_command(app, fit_scar, "fretwear fit studies/mine.yaml")
add_command(app, split_loops, "fretwear loops recording.csv --load '50 N' -o loops.csv")
