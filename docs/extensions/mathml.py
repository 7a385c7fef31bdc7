"""Sphinx extension: equations become MathML while the pages are built.

A browser then needs no script and no network to show them.
"""

from __future__ import annotations

from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging

logger = logging.getLogger(__name__)


def _write(node: nodes.Element, display: str) -> str:
    """Convert the LaTeX of a node to MathML; warn if the converter has left a command."""
    mathml: str = convert(node.astext(), display=display)
    if "\\" in mathml:
        logger.warning("equation: %r is not understood", node.astext(), location=node)
    return mathml


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(f'<span class="math">{_write(node, "inline")}</span>')
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    equation = _write(node, "block")
    translator.body.append(f'<div class="math" tabindex="0">{equation}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer and select it."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.connect("config-inited", lambda _, config: setattr(config, "html_math_renderer", "mathml"))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
