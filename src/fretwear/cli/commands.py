"""The commands that begin, plan, run, merge and draw; `fretwear.cli.show` prints results."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.common import (
    FIGURE_FORMATS,
    Assignments,
    CaseFile,
    CommandError,
    KeepOlder,
    Processes,
    Results,
    Status,
    StudyFile,
    aligned,
    check_output,
    check_writable,
    note,
    open_checked,
    option,
    progress,
    say,
    study_and_results,
    typed,
)

_CASE = (
    "Case: the beginning of its id, as in `fretwear plan`; may be repeated; not needed if there is "
    "only one."
)
_OUTPUT = "File to write, or the folder for files named by the ids, where finished cases are kept."
_FIGURE = "File to write: .png, .svg or .pdf."
_SNAPSHOT = "The one snapshot to draw, of those in the file."
_FOLDER = typer.Argument(
    metavar="[FOLDER]", help="Folder, created if necessary.", show_default="here"
)
_STUDY_NAME = "Study to begin with; a wrong name lists all names."

_SNAKEFILE = """\
# The workflow that comes with fretwear, from study files to datasets, figures and reports:
#
#     snakemake --cores 2                         runs studies/demo.yaml
#     snakemake --cores 2 --config study=NAME     runs studies/NAME.yaml
from fretwear.run.workflow import SNAKEFILE


include: SNAKEFILE


localrules:
    study,


# Rules of your own may follow.
rule study:
    default_target: True
    input:
        rules.all.input,
"""
_GITIGNORE = "/results/\n/.snakemake/\n*.checkpoint\n"


def init(
    folder: Annotated[Path, _FOLDER] = Path(),
    study: Annotated[str, option("--study", "NAME", _STUDY_NAME, "demo")] = "demo",
) -> None:
    """Create a folder to work in: a Snakefile, its settings, a study to change, and .gitignore.

    Existing files are not changed.
    """
    from fretwear.data.atomic import atomic_path
    from fretwear.run.workflow import workspace

    root = workspace()
    all_studies = root / "studies"
    # Studies of published experiments, in a folder of their own, come last.
    files = sorted(all_studies.rglob("*.yaml"), key=lambda file: (len(file.parents), file))
    studies = {file.relative_to(all_studies).with_suffix("").as_posix(): file for file in files}
    if study not in studies:
        names = ", ".join(studies)
        raise CommandError(f"--study {study}: is not a study that comes with fretwear: {names}")
    check_writable(folder)
    contents = {Path("Snakefile"): _SNAKEFILE.encode(), Path(".gitignore"): _GITIGNORE.encode()}
    chosen = studies[study]
    # A study may come with what was measured, and with the surfaces that it names.
    text = chosen.read_text(encoding="utf-8")
    surfaces = [f for f in chosen.parent.glob("*/*") if f"{f.parent.name}/{f.name}" in text]
    siblings = chosen.parent.glob(f"{chosen.stem}.*")
    for file in (*root.glob("profiles/*/config*.yaml"), *siblings, *surfaces):
        contents[file.relative_to(root)] = file.read_bytes()
    for relative, content in contents.items():
        file = folder / relative
        if file.exists() or file.is_symlink():
            say(f"{file}: exists already, unchanged")
            continue
        with atomic_path(file) as temporary:
            temporary.write_bytes(content)
        say(str(file))
    there = "" if folder == Path() else f"cd {folder} && "
    which = "" if study == "demo" else f" --config study={study}"
    say(f"\nNow {there}snakemake --cores 2{which}, or change studies/{study}.yaml first")


def plan(file: StudyFile, set_: Assignments = None) -> None:
    """Print the points of a study with the time and memory that each will take; run nothing."""
    from fretwear.run import resources
    from fretwear.study.plan import Plan
    from fretwear.study.reading import load_study
    from fretwear.units import duration_text, size_text

    planned = Plan(load_study(file, set_ or ()))
    points, cases = len(planned.points), len(planned.estimates)
    rows = [planned.header(), *planned.rows()]
    for line in (*aligned(rows, str.ljust, indent=""), ""):
        say(line)
    for text in planned.files:
        say(f"{text}\n")
    jobs = len(resources.grouped(planned))
    say(
        f"{points} point{'s' * (points != 1)}, {cases} case{'s' * (cases != 1)} in {jobs} "
        f"job{'s' * (jobs != 1)}: about {duration_text(resources.study_seconds(planned))} on one "
        f"core, with figures and report, up to {size_text(planned.memory_bytes)} of memory per job."
    )
    for warning in resources.machine_warnings(planned):
        typer.echo(f"\nfretwear: warning: {warning}", err=True)


def schema() -> None:
    """Print the JSON Schema of the study file, for editors that complete and check it."""
    from fretwear.study.sections import study_schema

    say(json.dumps(study_schema(), indent=2, ensure_ascii=False))


def coefficients() -> None:
    """Print published wear coefficients: pair, contact, law, value, conditions, source, remark."""
    from fretwear.study.materials import read_table

    table = read_table("coefficients")
    rows = [[*table[0]], *([*row.values()] for row in table)]
    say("\n".join(aligned(rows, str.ljust, indent="")))


def run_case(
    file: StudyFile,
    case: Annotated[list[str] | None, option("--case", "ID", _CASE)] = None,
    set_: Assignments = None,
    output: Annotated[Path | None, option("-o/--output", "OUT.nc", _OUTPUT, "ID.nc")] = None,
    keep_older: KeepOlder = False,
) -> None:
    """Simulate a case of a study and write it to a file, or several to a folder.

    An interrupted run resumes from its checkpoint beside the file.
    """
    from fretwear.study.reading import load_study, select_point

    names, assigned = case or [], set_ or []
    folder = output if output and (output.is_dir() or output.suffix != ".nc") else None
    if folder:
        if not folder.is_dir() and folder.suffix[1:].isalpha():  # the name of another kind of file
            check_output(folder, ".nc")
        check_writable(folder)
    elif names[1:]:
        raise CommandError("several cases need a folder, such as -o cases/")
    study = load_study(file, () if names else assigned)
    chosen: list[str | None] = [*names] if folder else [*names[:1]] or [None]
    points = [select_point(study, name, assigned) for name in chosen]
    cases = {point.id: point.case for point in points if point.case} or study.cases()

    from fretwear.data.labels import study_attributes
    from fretwear.run.case_files import simulate_to_file, simulate_to_folder

    attributes = study_attributes((points[0].study if points else study).content)
    if not folder:
        ((case_id, only),) = cases.items()
        path = check_output(output or Path(f"{case_id}.nc"), ".nc")
        steps = simulate_to_file(only, path, tell=note, command=typed(), attributes=attributes)
        say(f"{path}: {steps} steps")
        return
    command = shlex.join(["fretwear", "run", str(file), "--case"])
    every = study.cases()
    failed = simulate_to_folder(
        cases,
        folder,
        tell=note,
        command=command,
        keep_older=keep_older,
        attributes=attributes,
        count=progress,
        study=every if cases.keys() <= every.keys() else cases,
    )
    if failed:
        listed = "".join(f"\n  {case_id}: {reason}" for case_id, reason in failed.items())
        raise CommandError(f"{len(failed)} of {len(cases)} cases failed{listed}", Status.FAILED)
    for section in study.added.values():
        for case_id in cases:
            section.after_case(folder / f"{case_id}.nc")


def merge(file: StudyFile, results: Results = None, keep_older: KeepOlder = False) -> None:
    """Merge the finished cases into summary.nc and results.csv, and write the table points.csv."""
    study, folder = study_and_results(file, results)

    from fretwear.data.atomic import atomic_path, write_text
    from fretwear.data.effects import results_table
    from fretwear.data.files import open_summary
    from fretwear.data.merge import merge_study
    from fretwear.study.plan import write_points

    summary = folder / "summary.nc"
    count = merge_study(
        study, folder / "cases", summary, command=typed(), keep_older=keep_older, tell=note
    )
    with atomic_path(folder / "points.csv") as temporary:
        write_points(study, temporary)
    with open_summary(summary) as merged:
        write_text(folder / "results.csv", results_table(merged))
    words = "{done} points done, {failed} failed, {invalid} invalid"
    say(f"{summary}: {words.format_map(count)}")


def figures(file: StudyFile, results: Results = None, processes: Processes = 1) -> None:
    """Draw the figures of a merged study, as SVG, into figures/."""
    study, folder = study_and_results(file, results)

    from fretwear.data.files import open_summary
    from fretwear.data.merge import check_belongs
    from fretwear.figures.study import StudyFigure, write_study_figures
    from fretwear.plugins import added

    cases, drawn, merged = folder / "cases", folder / "figures", folder / "summary.nc"
    with open_summary(merged) as summary:
        check_belongs(summary, study)
        extra: Iterator[StudyFigure] = added("fretwear.figures", summary, cases)
        entries = write_study_figures(summary, cases, drawn, extra, processes)
    say(f"{drawn}: {len(entries)} figures")


def report(file: StudyFile, results: Results = None) -> None:
    """Write the report of a merged study, report.html, and its effects as numbers, answer.json."""
    study, folder = study_and_results(file, results)

    from fretwear.data.atomic import write_text
    from fretwear.data.files import open_summary
    from fretwear.plugins import added
    from fretwear.report import Section, build_report
    from fretwear.study.plan import Plan

    with open_summary(folder / "summary.nc") as summary:
        sections: Iterator[Section] = added("fretwear.sections", summary, folder / "cases")
        page, answer = build_report(Plan(study), summary, folder, sections=sections, tell=note)
    write_text(folder / "report.html", page)
    write_text(folder / "answer.json", answer)
    say(f"{folder / 'report.html'}: {len(page) / 1e6:.1f} MB")


def plot(
    file: CaseFile,
    output: Annotated[Path | None, option("-o/--output", "FIG.png", _FIGURE, "OUT.png")] = None,
    cycle: Annotated[int | None, option("--cycle", "NUMBER", _SNAPSHOT, "a few of them")] = None,
) -> None:
    """Draw the profiles and the scar of a case, a fit, or the measured surfaces of a study."""
    from fretwear.figures import overview, save_as
    from fretwear.plugins import added

    path = check_output(output or file.with_suffix(".png"), *FIGURE_FORMATS)
    if figures := dict(added("fretwear.plots", file)):
        for name, figure in figures.items():
            save_as(figure, one := path.with_stem(f"{path.stem}-{name}"))
            say(str(one))
        return
    if file.suffix in (".yaml", ".yml"):
        raise CommandError(f"{file} has no measured surface: plot the file of a case")
    with open_checked(file) as (case, _):
        try:
            save_as(overview(case, cycle), path)
        except ValueError as error:
            raise CommandError(f"{file}: {error}") from error
    say(str(path))
