"""Sphinx extension: the built pages work by keyboard and with a screen reader.

The theme leaves two marks of its sidebar incomplete, and whatever scrolls by itself, such as code,
tables and, on a phone, figures, must be reachable by the tab key.
"""

from __future__ import annotations

import re
from pathlib import Path

from sphinx.application import Sphinx

_CHANGES = {
    r'role="heading">': 'role="heading" aria-level="2">',
    r'<aside class="sidebar-drawer">': '<aside class="sidebar-drawer" aria-label="Pages">',
    r'(<div class="highlight">)<pre>': r'\1<pre tabindex="0">',
    r'<div class="(table-wrapper[^"]*)">': r'<div class="\1" tabindex="0">',
    r"<p>(<img\b[^>]*></p>)": r'<p tabindex="0">\1',
}


def accessible(page: str) -> str:
    """Return a page with what it lacks; what has been changed once stays the same."""
    for pattern, replacement in _CHANGES.items():
        page = re.sub(pattern, replacement, page)
    return page


def _finish(app: Sphinx, error: Exception | None) -> None:
    for file in Path(app.outdir).rglob("*.html") if error is None else ():
        if file.name != "report.html":
            file.write_text(accessible(file.read_text(encoding="utf-8")), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the extension."""
    app.connect("build-finished", _finish)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
