"""``fretwear init``: a folder to work in, with the workflow and a study of the package."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.common import CommandError, Status, aligned, option, say

_FOLDER = typer.Argument(metavar="[FOLDER]", help="Where; made if need be.", show_default="here")
_STUDY = "Study to begin with, one of those that --list shows."
_LIST = typer.Option("--list", help="Print the studies that come with fretwear; write nothing.")

_SNAKEFILE = """\
# The workflow that comes with fretwear, from study files to datasets, figures and reports:
#
#     snakemake --cores 2                         runs studies/demo.yaml
#     snakemake --cores 2 --config study=NAME     runs studies/NAME.yaml
from fretwear.running.workflow import SNAKEFILE


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
    study: Annotated[str, option("--study", "NAME", _STUDY, "demo")] = "demo",
    list_: Annotated[bool, _LIST] = False,
) -> None:
    """Begin a folder to work in: a Snakefile, its settings, a study to change, and .gitignore.

    Files that are there already are left as they are.
    """
    from fretwear.data.safe import DataFileError, why_not_writable, write_text
    from fretwear.running.workflow import workspace

    known = {file.stem: file for file in sorted((workspace() / "studies").glob("*.yaml"))}
    if list_:
        for line in aligned([*_studies(known)], str.ljust, indent=""):
            say(line)
        return
    if study not in known:
        raise CommandError(f"--study {study}: there are {', '.join(known)}")
    if problem := why_not_writable(folder):
        raise CommandError(problem)
    profiles = sorted((workspace() / "profiles").glob("*/config*.yaml"))
    texts = {
        Path("Snakefile"): _SNAKEFILE,
        **{file.relative_to(workspace()): file.read_text(encoding="utf-8") for file in profiles},
        Path("studies", f"{study}.yaml"): known[study].read_text(encoding="utf-8"),
        Path(".gitignore"): _GITIGNORE,
    }
    for name, text in texts.items():
        file = folder / name
        if file.exists() or file.is_symlink():
            say(f"{file}: is there already, left as it is")
            continue
        try:
            write_text(file, text)
        except DataFileError as error:
            raise CommandError(str(error), Status.FAILED) from error
        say(str(file))
    there = "" if folder == Path() else f"cd {folder} && "
    which = "" if study == "demo" else f" --config study={study}"
    say(f"\nNow {there}snakemake --cores 2{which}, or change studies/{study}.yaml first")


def _studies(known: dict[str, Path]) -> Iterator[tuple[str, ...]]:
    from fretwear.study.study import load_study

    for name, file in known.items():
        study = load_study(file)
        yield name, f"{study.size} points", study.title
