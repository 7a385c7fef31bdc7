"""The command ``fretwear export``: results in formats that other programs read."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Literal

import typer

from fretwear.cli.common import CaseFile, CommandError, check_output, open_checked, option, say

_TO = "Format of the files."
_OUTPUT = "File to write; several files share the beginning of this name."
_CYCLE = "Snapshot to write."


def export(
    file: CaseFile,
    to: Annotated[
        Literal["vtk", "csv", "parquet", "abaqus", "x3p"], typer.Option("--to", help=_TO)
    ],
    output: Annotated[
        Path | None, option("-o/--output", "OUT", _OUTPUT, "OUT.pvd, .csv, …")
    ] = None,
    cycle: Annotated[
        float | None, option("--cycle", "NUMBER", _CYCLE, "all; abaqus, x3p: the last")
    ] = None,
) -> None:
    """Write a case or its stresses in a format that other programs read.

    vtk opens in ParaView, pyvista and meshio, csv everywhere, parquet in pandas and polars; abaqus
    has nodes and loads for your own model, at the worn flat, x3p its heights for surface software.
    """
    from fretwear.data.atomic import DataFileError
    from fretwear.data.export import WRITERS, ExportError, at_cycle
    from fretwear.data.groups import open_group

    ending, write = WRITERS[to]
    path = check_output(output or file.with_suffix(ending), ending)
    with ExitStack() as stack:
        try:
            ds = stack.enter_context(open_group(file))
        except DataFileError as error:
            raise CommandError(str(error)) from error
        if "case_id" in ds.attrs and "pressure" in ds:
            ds = stack.enter_context(open_checked(file))[0].fretwear.full()
        try:
            written = write(ds if cycle is None else at_cycle(ds, cycle), path)
        except ExportError as error:
            raise CommandError(f"{file}: {error}") from error
    for path in written:
        say(str(path))
