"""Sphinx extension: the gallery, from the scripts that draw its figures.

Each script in ``docs/gallery/`` begins with a docstring, of which the first line becomes the title,
and leaves its figure under the name ``figure``. The studies that they read, the YAML files beside
them, are run first.
"""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from pictures import refresh
from PIL import Image
from sphinx.application import Sphinx
from sphinx.util import logging

from fretwear.data.files import write_case
from fretwear.data.merge import merge_study
from fretwear.figures import save_as
from fretwear.run.simulate import run
from fretwear.study.reading import load_study

logger = logging.getLogger(__name__)
# The study whose report the start page shows.
REPORTED = "gallery"
THUMBNAIL = (240, 150)


def run_study(file: Path, results: Path) -> None:
    """Run every case of a study and merge them, as the workflow does."""
    study = load_study(file)
    for case_id, case in study.cases().items():
        result = run(case)
        write_case(
            result.dataset, result.history, results / "cases" / f"{case_id}.nc", result.loops
        )
    merge_study(study, results / "cases", results / "summary.nc")


def draw(script: Path, place: Path, folder: Path) -> None:
    """Run a script in a folder with the results of its study, and keep its picture."""
    source = script.read_text(encoding="utf-8")
    before = Path.cwd()
    os.chdir(place)
    try:
        names: dict[str, Any] = {}
        exec(compile(source, script, "exec"), names)
    finally:
        os.chdir(before)
    small = folder / f"{script.stem}.png"
    save_as(names["figure"], folder / f"{script.stem}.svg")
    names["figure"].savefig(small, dpi=100)
    picture = Image.open(small).convert("RGB")
    picture.thumbnail(THUMBNAIL)
    picture.save(small, optimize=True)
    plt.close("all")


def said(script: Path) -> tuple[str, str]:
    """Return the title and the text of a script."""
    docstring = ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or script.stem
    title, _, text = docstring.partition("\n\n")
    return title.rstrip("."), text


def thumbnail(script: Path) -> str:
    """Write a small picture that leads to the section of a script."""
    title, _ = said(script)
    anchor = title.lower().replace(" ", "-")
    picture = f"![{title}](generated/gallery/{script.stem}.png)"
    link = f"[{picture}](reference/figures.md#{anchor})"
    return f'<div class="thumbnail">\n\n{link}\n\n{title}\n\n</div>\n'


def section(script: Path) -> str:
    """Write the section of a script: title, text, figure, code."""
    source = script.read_text(encoding="utf-8")
    title, text = said(script)
    code = source.split('"""\n', 2)[-1].strip()
    return (
        f"## {title}\n\n{text}\n\n"
        f"![{title}](../generated/gallery/{script.stem}.svg)\n\n```python\n{code}\n```\n"
    )


def write_all(source: Path, *, with_pictures: bool) -> None:
    """Write the text of the gallery and, unless existing ones are kept, its pictures."""
    scripts = sorted((source / "gallery").glob("*.py"))
    folder = source / "generated" / "gallery"
    folder.mkdir(parents=True, exist_ok=True)
    text = "\n".join(section(script) for script in scripts)
    (folder.parent / "gallery.md").write_text(text, encoding="utf-8")
    small = "\n".join(map(thumbnail, scripts))
    small = f'<div class="thumbnails">\n\n{small}\n</div>\n'
    (folder.parent / "thumbnails.md").write_text(small, encoding="utf-8")
    if with_pictures:
        studies = sorted((source / "gallery").glob("*.yaml"))
        refresh(folder, [*scripts, *studies], lambda: draw_all(source, folder))


def draw_all(source: Path, folder: Path) -> None:
    """Run the studies of the gallery, draw its pictures and make the report."""
    with tempfile.TemporaryDirectory() as place:
        for study in sorted((source / "gallery").glob("*.yaml")):
            run_study(study, Path(place, "results", study.stem))
        for script in sorted((source / "gallery").glob("*.py")):
            logger.info("drawing %s", script.name)
            draw(script, Path(place), folder)
        results = Path(place, "results", REPORTED)
        for command in ("figures", "report"):
            call = [sys.executable, "-m", "fretwear", command, f"{REPORTED}.yaml"]
            subprocess.run([*call, "--results", results], cwd=source / "gallery", check=True)
        shutil.copy(results / "report.html", folder.parent)


def copy_report(app: Sphinx, error: Exception | None) -> None:
    """Put the report beside the start page, which links to it."""
    report = Path(app.srcdir, "generated", "report.html")
    if error is None and report.is_file():
        shutil.copy(report, app.outdir)


def setup(app: Sphinx) -> dict[str, Any]:
    """Write the gallery before the pages are read."""
    app.connect(
        "builder-inited",
        lambda app: write_all(Path(app.srcdir), with_pictures=app.config.run_examples),
    )
    app.connect("build-finished", copy_report)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
