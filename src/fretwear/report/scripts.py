"""The scripts of a report, and the policy that lets a browser run these and load nothing."""

from __future__ import annotations

import base64
import hashlib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from markupsafe import Markup

from fretwear.report.explorer.packing import compressed

_TABLE = ("table.js",)
_EXPLORER = ("explorer_data.js", "explorer_axes.js", "explorer_figures.js", "explorer.js")
_NOTHING_ELSE = (
    "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; "
    "style-src 'unsafe-inline'; script-src "
)


@dataclass(frozen=True)
class Scripts:
    """What runs in a page.

    Parameters
    ----------
    texts : tuple of markupsafe.Markup
        The scripts, in the order in which they are to run.
    plotly : str
        The library that the explorer draws with, as base64 of a gzip stream; empty if it is not
        needed.
    policy : markupsafe.Markup
        Content security policy: no script runs but these, nothing is loaded from anywhere.
    """

    texts: tuple[Markup, ...]
    plotly: str
    policy: Markup


def page_scripts(*, with_explorer: bool) -> Scripts:
    """Return the scripts of a report with or without an explorer."""
    names = (*_TABLE, *(_EXPLORER if with_explorer else ()))
    folder = files("fretwear.report") / "templates"
    texts = tuple((folder / name).read_text(encoding="utf-8") for name in names)
    plotly, its_hash = _plotly() if with_explorer else ("", "")
    allowed = [*(_hash(text.encode("utf-8")) for text in texts), its_hash]
    return Scripts(
        texts=tuple(Markup(text) for text in texts),
        plotly=plotly,
        policy=Markup(_NOTHING_ELSE + " ".join(allowed).rstrip()),
    )


@cache
def _plotly() -> tuple[str, str]:
    """Return the library, compressed, and what the policy calls it."""
    script = (files("plotly") / "package_data" / "plotly.min.js").read_bytes()
    return compressed(script), _hash(script)


def _hash(script: bytes) -> str:
    digest = base64.b64encode(hashlib.sha256(script).digest()).decode("ascii")
    return f"'sha256-{digest}'"
