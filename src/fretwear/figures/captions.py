"""Captions, categories and labels of the figures in Snakemake's own report."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path

from fretwear.figures.study import FigureEntry, read_figure_index

CAPTIONS_NAME = "captions.rst"


def caption_template(entries: Iterable[FigureEntry]) -> str:
    """Return the one caption that Snakemake renders for every figure of a folder.

    Snakemake takes one caption file for all files of a folder and renders it by jinja2 with the
    wildcards of each, here ``figure``, its name; the result is read as reStructuredText.

    Parameters
    ----------
    entries : iterable of FigureEntry
        The figures with their captions.
    """
    captions = {entry.name: _plain(entry.caption) for entry in entries}
    # The strings of JSON are those of jinja2; braces are kept from looking like its marks.
    table = json.dumps(captions).replace("{", r"\u007b").replace("}", r"\u007d")
    table = "{" + table.removeprefix(r"\u007b").removesuffix(r"\u007d") + "}"
    return f"{{% set captions = {table} %}}{{{{ captions[snakemake.wildcards.figure] }}}}\n"


def figure_category(folder: Path, name: str) -> str:
    """Return the category of a figure by its name."""
    return _entry(folder, name).category


def figure_labels(folder: Path, name: str) -> dict[str, str]:
    """Return what tells a figure in a list: its name and the first sentence of its caption."""
    first, _, _ = _entry(folder, name).caption.partition(". ")
    return {"figure": name, "shows": first.removesuffix(".")}


def _entry(folder: Path, name: str) -> FigureEntry:
    return next(entry for entry in read_figure_index(folder) if entry.name == name)


def _plain(text: str) -> str:
    """Return text in which reStructuredText finds no markup."""
    return re.sub(r"([^\w\s]|_)", r"\\\1", " ".join(text.split()))
