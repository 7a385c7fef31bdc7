"""Sphinx extension: the pictures of a page are made by the blocks of that page.

A picture ``generated/NAME/FILE`` of the page ``…/NAME.md`` is the file that the page's own commands
leave in their folder (`examples.Session`). It is made when the pages are built. A page that does
not run, or prints something else than it shows, is a warning; other output costs no picture.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from pathlib import Path
from typing import Any

from examples import ExampleError, Session, differences
from sphinx.application import Sphinx
from sphinx.util import logging

logger = logging.getLogger(__name__)


def pictures_of(page: Path) -> list[str]:
    """Files that the blocks of a page must make."""
    pattern = rf"generated/{re.escape(page.stem)}/([^)>\s]+)[)>]"
    return re.findall(pattern, page.read_text(encoding="utf-8"))


def make(page: Path, folder: Path) -> None:
    """Run a page and put its pictures into a folder."""
    logger.info("running %s", page.name)
    text = page.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as place:
        different = differences(text, Session(Path(place)))
        for name in pictures_of(page):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(Path(place, name), folder / name)
    if different:
        raise ExampleError(different)


def _make_all(app: Sphinx) -> None:
    if not app.config.run_examples:
        return
    source = Path(app.srcdir)
    for page in sorted(source.rglob("*.md")):
        if page.is_relative_to(source / "generated") or not pictures_of(page):
            continue
        try:
            make(page, source / "generated" / page.stem)
        except (ExampleError, OSError) as error:
            logger.warning("%s: %s", page, error)


def setup(app: Sphinx) -> dict[str, Any]:
    """Make the pictures before the pages are read, unless ``-D run_examples=0`` leaves them."""
    app.add_config_value("run_examples", True, "env", bool)
    app.connect("builder-inited", _make_all)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
