"""``fretwear init``: a folder to work in, with the workflow and a study of the package."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fretwear.cli.common import CommandError, Status, aligned, option, say

_FOLDER = typer.Argument(
    metavar="[FOLDER]", help="Where; created if necessary.", show_default="here"
)
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
    """Create a folder to work in: a Snakefile, its settings, a study to change, and .gitignore.

    Existing files are not changed.
    """
    from fretwear.data.safe import DataFileError, atomic_path, why_not_writable
    from fretwear.running.workflow import workspace

    known = {file.stem: file for file in sorted((workspace() / "studies").glob("*.yaml"))}
    if list_:
        from fretwear.study.yamlfile import read_document

        extra = "pip install 'fretwear[surfaces]'"
        told = [
            (name, str(read_document(file).data["title"]), extra if _surfaces(file) else "")
            for name, file in known.items()
        ]
        for line in aligned(told, str.ljust, indent=""):
            say(line)
        return
    if study not in known:
        raise CommandError(f"--study {study}: there are {', '.join(known)}")
    if problem := why_not_writable(folder):
        raise CommandError(problem)
    contents = {Path("Snakefile"): _SNAKEFILE.encode(), Path(".gitignore"): _GITIGNORE.encode()}
    root = workspace()
    for file in (*root.glob("profiles/*/config*.yaml"), known[study], *_surfaces(known[study])):
        contents[file.relative_to(root)] = file.read_bytes()
    for name, content in contents.items():
        file = folder / name
        if file.exists() or file.is_symlink():
            say(f"{file}: exists already, unchanged")
            continue
        try:
            with atomic_path(file) as temporary:
                temporary.write_bytes(content)
        except DataFileError as error:
            raise CommandError(str(error), Status.FAILED) from error
        say(str(file))
    there = "" if folder == Path() else f"cd {folder} && "
    which = "" if study == "demo" else f" --config study={study}"
    say(f"\nNow {there}snakemake --cores 2{which}, or change studies/{study}.yaml first")


def _surfaces(study: Path) -> list[Path]:
    """Return the files beside a study from which it takes surfaces."""
    text = study.read_text(encoding="utf-8")
    return [file for file in study.parent.glob("*/*") if f"{file.parent.name}/{file.name}" in text]
