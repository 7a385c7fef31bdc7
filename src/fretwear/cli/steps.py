"""The steps of the workflow that follow the simulations: merge, figures, report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from fretwear.cli.arguments import Format, Quiet, Results, StudyFile, results_of
from fretwear.cli.commands import open_log
from fretwear.cli.log import LogFormat
from fretwear.cli.outputs import check_folder
from fretwear.cli.status import CommandError, Status, failing_as

if TYPE_CHECKING:
    from fretwear.study.file import Study


def merge(
    context: typer.Context,
    file: StudyFile,
    results: Results = None,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Merge the cases of a study that are done into summary.nc, and list all in points.csv."""
    log = open_log(context, log_format, quiet=quiet)
    study, folder = _study_and_folder(file, results)

    from fretwear.data.merge import merge_study
    from fretwear.data.safe import DataFileError, atomic_path
    from fretwear.study.plan import write_points

    with failing_as(Status.FAILED, DataFileError):
        tally = merge_study(
            study, folder / "cases", folder / "summary.nc", command=f"fretwear merge {file}"
        )
        with atomic_path(folder / "points.csv") as temporary:
            write_points(study, temporary)
    log.result(
        folder / "summary.nc",
        f"{tally.done} points done, {tally.failed} failed, {tally.invalid} invalid",
        points_done=tally.done,
        points_failed=tally.failed,
        points_invalid=tally.invalid,
    )


def figures(
    context: typer.Context,
    file: StudyFile,
    results: Results = None,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Draw the figures of a merged study, as SVG and PNG, into figures/."""
    log = open_log(context, log_format, quiet=quiet)
    _, folder = _study_and_folder(file, results)

    from fretwear.data.files import open_summary
    from fretwear.data.safe import DataFileError, write_text
    from fretwear.figures.captions import CAPTIONS_NAME, caption_template
    from fretwear.figures.study import write_study_figures
    from fretwear.source_study import source_figures

    with (
        failing_as(Status.FAILED, DataFileError),
        open_summary(folder / "summary.nc") as summary,
    ):
        cases = folder / "cases"
        entries = write_study_figures(
            summary, cases, folder / "figures", extra=source_figures(summary, cases)
        )
        write_text(folder / "figures" / CAPTIONS_NAME, caption_template(entries))
    log.result(folder / "figures", f"{len(entries)} figures", figures=len(entries))


def report(
    context: typer.Context,
    file: StudyFile,
    results: Results = None,
    quiet: Quiet = False,
    log_format: Format = LogFormat.AUTO,
) -> None:
    """Write the report of a merged study and its figures to report.html."""
    log = open_log(context, log_format, quiet=quiet)
    study, folder = _study_and_folder(file, results)

    from fretwear.data.files import open_summary
    from fretwear.data.safe import DataFileError, write_text
    from fretwear.figures.study import INDEX_NAME
    from fretwear.report import build_report
    from fretwear.source_study import source_sections
    from fretwear.study.plan import plan_study

    with (
        failing_as(Status.FAILED, DataFileError),
        open_summary(folder / "summary.nc") as summary,
    ):
        index = folder / "figures" / INDEX_NAME
        if not index.is_file():
            rule = "there is no such file: draw the figures before the report, by"
            raise CommandError(f"{index}: {rule}\n    fretwear figures {file}", Status.FAILED)
        sections = source_sections(summary, folder / "cases")
        page = build_report(plan_study(study), summary, folder, sections=sections)
        write_text(folder / "report.html", page)
    log.result(folder / "report.html", f"{len(page) / 1e6:.1f} MB")


def _study_and_folder(file: Path, results: Path | None) -> tuple[Study, Path]:
    from fretwear.study.file import StudyError, load_study

    with failing_as(Status.WRONG_INPUT, StudyError):
        study = load_study(file)
    return study, check_folder(results_of(study, results))
