"""The commands ``fretwear fit`` and ``fretwear loops``: what measurements tell."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.common import (
    FIGURE_FORMATS,
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
_FIGURE = "Picture of the cycles to draw, of a single recording."
_COLUMNS = "Displacement and force, by number from 0 or by name: '1, 3'."
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
    from fretwear_fit.fit import parameter_table

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
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="Recording with displacement and force; or files with the loop of a cycle each, "
            "whose number is in the name.",
            show_default=False,
        ),
    ],
    load: Annotated[str, option("--load", "LOAD", "Normal load, such as '50 N'.")],
    output: Annotated[Path, option("-o/--output", "LOOPS.csv", "Table to write.")],
    figure: Annotated[Path | None, option("--figure", "FIG.png", _FIGURE)] = None,
    columns: Annotated[str, option("--columns", "LIST", _COLUMNS)] = "",
    units: Annotated[str, option("--units", "LIST", "Their units: 'mm, N'.")] = "",
    scale: Annotated[str, option("--scale", "LIST", "Their factors: '20 um/V, -1'.")] = "",
    skip: Annotated[int, option("--skip", "LINES", "Lines before the names of columns.")] = 0,
    decimal: Annotated[str, option("--decimal", "SIGN", "Sign before the decimals.")] = "",
    encoding: Annotated[str, option("--encoding", "NAME", "Of the text, such as latin-1.")] = "",
) -> None:
    """Split a recording into cycles: friction, displacement and energy over the cycles.

    The last line is the friction in the form for the base of a study.
    """
    from fretwear.data.atomic import write_text
    from fretwear_fit.loops import friction_text, histories, split_recording
    from fretwear_measured.tables import Layout

    path = check_output(output, ".csv")
    picture = None if figure is None else check_output(figure, *FIGURE_FORMATS)
    if picture is not None and len(files) > 1:
        raise CommandError("--figure: draws one recording, not several files")
    if decimal not in ("", ".", ","):
        raise CommandError(f"--decimal {decimal}: must be '.' or ','")
    chosen = tuple(int(one) if one.isdecimal() else one for one in _listed(columns))
    layout = Layout(chosen, _listed(units), skip, decimal, encoding, _listed(scale))
    try:
        normal = parse_quantity(load, BY_SI_UNIT["N"], units_required=True)
    except QuantityError as error:
        raise CommandError(f"--load {load}: {error}") from error
    if normal <= 0.0:
        raise CommandError(f"--load {load}: must be larger than 0")
    try:
        table, notes = histories(files, normal, layout)
    except QuantityError as error:
        raise CommandError(_as_options(str(error))) from error
    if picture is not None:
        from fretwear.figures import save_as
        from fretwear_fit.figures import recording_figure

        save_as(recording_figure(split_recording(files[0], normal, layout)), picture)
    write_text(path, table.to_csv(index=False))
    for text in notes:
        note(text)
    numbers = table["cycle"]
    say(f"{path}: {len(table)} cycles, {numbers.min()} to {numbers.max()}")
    say(friction_text(table))


def _listed(text: str) -> tuple[str, ...]:
    """The values of an option, which may stand in brackets as in a study file."""
    return tuple(one.strip(" []'\"") for one in text.split(",") if one.strip(" []"))


def _as_options(message: str) -> str:
    """A message with the keys of a study file as the options of the command."""
    message = re.sub(r"\b(columns|units|scale): \[(.*?)\]", r"--\1 '\2'", message)
    return re.sub(r"\b(skip|decimal|encoding): ", r"--\1 ", message)


app = typer.Typer()
add_command(app, fit_scar, "fretwear fit studies/mine.yaml")
add_command(app, split_loops, "fretwear loops recording.csv --load '50 N' -o loops.csv")
