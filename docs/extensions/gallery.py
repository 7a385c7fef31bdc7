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
from examples import REPOSITORY
from sphinx.application import Sphinx
from sphinx.util import logging

from fretwear.figures import save_as

logger = logging.getLogger(__name__)


def draw(script: Path, folder: Path) -> None:
    """Run a script in the current folder, and keep its figure and a small picture of it."""
    names: dict[str, Any] = {}
    exec(compile(script.read_text(encoding="utf-8"), script, "exec"), names)
    save_as(names["figure"], folder / f"{script.stem}.svg")
    names["figure"].savefig(folder / f"{script.stem}.png", dpi=50)
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
        draw_all(source, folder)


def draw_all(source: Path, folder: Path) -> None:
    """Run the studies of the gallery, draw its pictures and keep the report of its first study."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as place:
        for study in sorted((source / "gallery").glob("*.yaml")):
            call = [sys.executable, "-m", "snakemake", "--quiet", "all", "--cores", "2"]
            call += ["--snakefile", REPOSITORY / "Snakefile", "--config", f"study={study}"]
            subprocess.run(call, cwd=place, check=True)
        shutil.copy(Path(place, "results", "gallery", "report.html"), folder.parent)
        os.chdir(place)
        try:
            for script in sorted((source / "gallery").glob("*.py")):
                logger.info("drawing %s", script.name)
                draw(script, folder)
        finally:
            os.chdir(before)


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
