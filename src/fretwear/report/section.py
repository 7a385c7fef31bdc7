"""Sections of a report, and the environment that renders its templates."""

from __future__ import annotations

from dataclasses import dataclass

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup


@dataclass(frozen=True)
class Section:
    """One more section of a report.

    Parameters
    ----------
    id : str
        Anchor of the section, unique in the page.
    title : str
        Its heading.
    body : markupsafe.Markup
        Its content; what comes from outside must have been escaped.
    """

    id: str
    title: str
    body: Markup


def environment(package: str = "fretwear.report") -> Environment:
    """Return the environment that renders the ``templates`` of a package for the report."""
    rendering = Environment(
        loader=PackageLoader(package, "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    rendering.filters["script_number"] = _script_number
    return rendering


def _script_number(value: float) -> str:
    """Return a number in the spelling of the page's script, which knows no ``inf``."""
    return repr(float(value)).replace("inf", "Infinity").replace("nan", "NaN")
