"""What a self-contained page is made of: sections, images, scripts, and the policy on scripts."""

from __future__ import annotations

import base64
import gzip
import hashlib
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from fretwear.data.safe import DataFileError, read_data
from fretwear.figures.index import PAGE_WIDTH, FigureEntry
from fretwear.vocabulary import RESULTS

_LARGE = 1_000_000
_MOST_BYTES = 200_000_000
_HEAD = 2000
_MM_PER_POINT = 25.4 / 72.0
_MIME = {".svg": "image/svg+xml", ".png": "image/png"}
_NOTHING_ELSE = (
    "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; "
    "style-src 'unsafe-inline'; script-src "
)


@dataclass(frozen=True)
class Section:
    """A section of a report."""

    id: str  # anchor of the section, unique in the page
    title: str  # its heading
    body: Markup  # its content; what comes from outside must have been escaped
    entry: str = ""  # its entry in the contents; empty: the title


def environment(package: str = "fretwear.report") -> Environment:
    """Return the environment that renders the templates of a package, from its ``templates``."""
    rendering = Environment(
        loader=PackageLoader(package, "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    rendering.globals["results"] = RESULTS
    return rendering


class Image(NamedTuple):
    """A figure inside the page.

    Its image is a data URI; its width is a share of a journal page's, so that text has the same
    size in every figure.
    """

    entry: FigureEntry
    uri: str
    share: float


def embedded(folder: Path, entries: Sequence[FigureEntry]) -> list[Image]:
    """Return figures as parts of the page, those of a category together.

    Parameters
    ----------
    folder : pathlib.Path
        Holds each figure as SVG and PNG. A vector file of more than 1 MB gives way to its bitmap
        if that is smaller.
    entries : sequence of FigureEntry
        The figures.

    Raises
    ------
    fretwear.data.safe.DataFileError
        When a figure is missing or empty.
    """
    order = list(dict.fromkeys(entry.category for entry in entries))
    images = []
    for entry in sorted(entries, key=lambda entry: order.index(entry.category)):
        vector, bitmap = (folder / f"{entry.name}{suffix}" for suffix in _MIME)
        content, suffix = _read(vector), vector.suffix
        share = _share(content)
        if len(content) > _LARGE and len(small := _read(bitmap)) < len(content):
            content, suffix = small, bitmap.suffix
        # An image of its own, not inline SVG: the ids inside two inlined SVGs would collide.
        text = base64.b64encode(content).decode("ascii")
        images.append(Image(entry, f"data:{_MIME[suffix]};base64,{text}", share))
    return images


def _read(path: Path) -> bytes:
    content = b""
    with suppress(OSError):
        content = read_data(path, _MOST_BYTES)
    if not content:
        raise DataFileError(path, "this figure is missing or empty", "Draw the figures again")
    return content


def _share(vector: bytes) -> float:
    found = re.search(rb'<svg[^>]*\swidth="(\d+(?:\.\d+)?)pt"', vector[:_HEAD])
    millimetres = float(found[1]) * _MM_PER_POINT if found else PAGE_WIDTH
    return round(min(1.0, millimetres / PAGE_WIDTH), 3)


@dataclass(frozen=True)
class Scripts:
    """What runs in a page."""

    texts: tuple[Markup, ...]  # the scripts, in the order in which they run
    # The library that the explorer draws with, as `compressed` returns it; empty if it is not
    # needed.
    plotly: str
    # Content security policy: only these scripts run, and nothing is loaded from anywhere.
    policy: Markup


def page_scripts(*, with_explorer: bool) -> Scripts:
    """Return the scripts of a report with or without an explorer."""
    names = ("table.js", "explorer.js") if with_explorer else ("table.js",)
    folder = files("fretwear.report") / "templates"
    texts = tuple(Markup((folder / name).read_text(encoding="utf-8")) for name in names)
    plotly, plotly_hash = _plotly() if with_explorer else ("", "")
    allowed = [*(_hash(text.encode("utf-8")) for text in texts), plotly_hash]
    return Scripts(texts, plotly, Markup(_NOTHING_ELSE + " ".join(allowed).rstrip()))


@cache
def _plotly() -> tuple[str, str]:
    """Return the library, compressed, and its name in the policy."""
    # Importing the package itself would take longer than reading its script.
    spec = find_spec("plotly")
    assert spec is not None
    assert spec.origin is not None
    script = Path(spec.origin).with_name("package_data").joinpath("plotly.min.js").read_bytes()
    return compressed(script), _hash(script)


def _hash(script: bytes) -> str:
    digest = base64.b64encode(hashlib.sha256(script).digest()).decode("ascii")
    return f"'sha256-{digest}'"


def compressed(content: bytes) -> str:
    """Return bytes as base64 of a gzip stream without a date: the same bytes, the same text."""
    return base64.b64encode(gzip.compress(content, 6, mtime=0)).decode("ascii")
