"""The parameters of a case by name, and their values for people."""

from __future__ import annotations

from fretwear.quantity import Parameter
from fretwear.study.case import case_keys


def parameter(name: str) -> Parameter:
    """Return a parameter by its name in a study file or as a coordinate.

    An unknown name, such as a dimension that a user added, is taken to be a plain number.
    """
    return case_keys().coordinate(name)


def value_text(name: str, value: object) -> str:
    """Return the value in readable units: ``25 N``, ``smooth``, ``elastic``."""
    return parameter(name).text(value)


def symbol_text(name: str, value: object) -> str:
    """Return symbol and value in mathtext, for labels inside figures: ``$P$ = 25 N``."""
    declaration = parameter(name)
    return declaration.word_for(value) or f"{declaration.symbol} = {declaration.text(value)}"


def words_text(name: str, value: object) -> str:
    """Return words and value, for captions: ``normal load 25 N``, ``elastic``."""
    declaration = parameter(name)
    return declaration.word_for(value) or f"{declaration.words} {declaration.text(value)}"
