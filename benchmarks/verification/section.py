"""What a section of the page is made of."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

Data = dict[str, Any]
"""What a section has measured: numbers, texts, lists and dictionaries of them, as JSON has them."""


@dataclass(frozen=True)
class Check:
    """A number that had to be reached.

    Parameters
    ----------
    what
        What is compared, in a few words.
    measured, required
        The largest deviation found and the largest allowed, relative.
    """

    what: str
    measured: float
    required: float

    @property
    def holds(self) -> bool:
        return abs(self.measured) <= self.required


def no_checks(_: Data) -> list[Check]:
    """The checks of a section that has none."""
    return []


def no_figures(_: Data) -> dict[str, Figure]:
    """The figures of a section that has none."""
    return {}


@dataclass(frozen=True)
class Section:
    """A part of the page.

    Parameters
    ----------
    name
        Key of its data and beginning of its figures' names.
    title
        Heading.
    measure
        Runs the comparison.
    text
        Markdown below the heading; a figure goes where the text has ``{figure:name}``.
    checks, figures
        The numbers with a bound, and figures by name.
    """

    name: str
    title: str
    measure: Callable[[], Data]
    text: Callable[[Data], str]
    checks: Callable[[Data], list[Check]] = no_checks
    figures: Callable[[Data], dict[str, Figure]] = no_figures
