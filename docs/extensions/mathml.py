"""Sphinx extension: equations become MathML while the pages are built.

A browser then needs no script and no network to show them.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging

logger = logging.getLogger(__name__)

NAMESPACE = "http://www.w3.org/1998/Math/MathML"


def to_mathml(latex: str, *, display: str) -> str:
    """Convert LaTeX to MathML.

    Parameters
    ----------
    latex : str
        The equation, without dollar signs.
    display : {"inline", "block"}
        Whether it stands in a line of text or by itself.

    Raises
    ------
    ValueError
        When the converter did not understand all of it.
    """
    mathml = convert(latex, display=display)
    try:
        root = ElementTree.fromstring(mathml)
    except ElementTree.ParseError as cause:
        raise ValueError(f"no sound MathML comes of {latex!r}: {cause}") from cause
    for element in root.iter():
        text = (element.text or "").strip()
        if "\\" in text or text == "&":
            raise ValueError(f"{text!r} of {latex!r} is not understood")
    return mathml


def _write(translator: Any, node: nodes.Element, display: str) -> str:
    try:
        return to_mathml(node.astext(), display=display)
    except ValueError as error:
        logger.warning("equation: %s", error, location=node)
        return f"<code>{translator.encode(node.astext())}</code>"


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(f'<span class="math">{_write(translator, node, "inline")}</span>')
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    equation = _write(translator, node, "block")
    translator.body.append(f'<div class="math" tabindex="0">{equation}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer and select it."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.connect("config-inited", lambda _, config: setattr(config, "html_math_renderer", "mathml"))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
