"""The parts of a self-contained page: sections, images, scripts, and the policy on scripts."""

from __future__ import annotations

import base64
import gzip
import hashlib
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import distribution
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from fretwear.data.atomic import DataFileError
from fretwear.figures.index import PAGE_WIDTH, FigureEntry
from fretwear.vocabulary import RESULTS

_LARGE = 1_000_000
_MM_PER_POINT = 25.4 / 72.0
_NOTHING_ELSE = (
    "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; "
    "style-src 'unsafe-inline'; script-src "
)


@dataclass(frozen=True)
class Section:
    """A section of a report."""

    id: str  # anchor of the section, unique in the page
    title: str  # its heading
    body: Markup  # its content, in which text from outside is escaped
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


def macros(package: str = "fretwear.report") -> Mapping[str, Callable[..., str]]:
    """Return the macros in the ``sections.html.j2`` of a package, which make bodies of sections."""
    return vars(environment(package).get_template("sections.html.j2").module)


class Image(NamedTuple):
    """A figure inside the page."""

    entry: FigureEntry
    uri: str  # of its data
    share: float = 1.0  # its width over the page width, so that text has one size in all figures


def embedded(folder: Path, entries: Sequence[FigureEntry]) -> list[Image]:
    """Return figures as parts of the page, grouped by category.

    `folder` holds every figure as SVG and PNG. A bitmap replaces a vector file of more than 1 MB if
    it is smaller. Raises a `DataFileError` if a figure is missing or empty.
    """
    order = list(dict.fromkeys(entry.category for entry in entries))
    images = []
    for entry in sorted(entries, key=lambda entry: order.index(entry.category)):
        content, kind = _read(folder / f"{entry.name}.svg"), "svg+xml"
        width = re.search(rb'<svg[^>]*\swidth="(\d+(?:\.\d+)?)pt"', content[:2000])
        share = float(width[1]) * _MM_PER_POINT / PAGE_WIDTH if width else 1.0
        if len(content) > _LARGE:
            bitmap = _read(folder / f"{entry.name}.png")
            content, kind = min((content, kind), (bitmap, "png"), key=lambda file: len(file[0]))
        images.append(Image(entry, _uri(content, kind), round(min(1.0, share), 3)))
    return images


def _uri(content: bytes, kind: str) -> str:
    # Separate images, because the ids inside two inlined SVGs would collide.
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"


def _read(path: Path) -> bytes:
    content = b""
    with suppress(OSError):
        content = path.read_bytes()
    if not content:
        raise DataFileError(path, "this figure is missing or empty", "Draw the figures again")
    return content


class Scripts(NamedTuple):
    """The scripts of a page."""

    texts: list[Markup]  # the scripts, in the order in which they run
    plotly: str  # the library of the explorer, as `compressed` returns it; empty without one
    licence: str  # of plotly
    policy: Markup  # content security: only these scripts run, and no file is loaded


@cache
def page_scripts(*, with_explorer: bool) -> Scripts:
    """Return the scripts of a report with or without an explorer."""
    folder = files("fretwear.report") / "templates"
    names = ("table.js", "explorer.js") if with_explorer else ("table.js",)
    texts = [(folder / name).read_bytes() for name in names]
    allowed, plotly, licence = list(texts), "", ""
    if with_explorer:
        # Importing the package would take longer than reading its script.
        spec = find_spec("plotly")
        assert spec is not None
        assert spec.origin is not None
        allowed.append((Path(spec.origin).parent / "package_data/plotly.min.js").read_bytes())
        plotly = compressed(allowed[-1])
        about = distribution("plotly")
        licence = about.read_text("licenses/LICENSE.txt") or about.read_text("LICENSE.txt") or ""
    hashes = (hashlib.sha256(script).digest() for script in allowed)
    digests = [base64.b64encode(digest).decode("ascii") for digest in hashes]
    policy = _NOTHING_ELSE + " ".join(f"'sha256-{digest}'" for digest in digests)
    return Scripts(
        [Markup(text.decode("utf-8")) for text in texts], plotly, licence, Markup(policy)
    )


def compressed(content: bytes) -> str:
    """Return bytes as base64 of a gzip stream without a date: equal bytes give equal text."""
    return base64.b64encode(gzip.compress(content, 6, mtime=0)).decode("ascii")
