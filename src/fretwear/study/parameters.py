"""The parameters of a case by name, and their values for people."""

from __future__ import annotations

from fretwear.quantity import Parameter
from fretwear.study.contact import case_keys
from fretwear.study.keys import coordinate as coordinate


def base_names() -> tuple[str, ...]:
    """Return the keys that `base` may have: parts and single parameters."""
    return case_keys().names


def parameter_names() -> tuple[str, ...]:
    """Return the names that may be varied: keys of `base`, ``roughness.amplitude`` and so on."""
    return case_keys().all_names


def member_of(name: str) -> str:
    """Return the member of a case that a name belongs to or denotes."""
    return case_keys().member_of(name)


def parameter_of(name: str) -> Parameter:
    """Return the parameter or the whole part with this name."""
    return case_keys()[name].about


def replaced_by(name: str) -> set[str]:
    """Return the names that a new value of one replaces: ``radius`` by ``indenter``."""
    return case_keys().replaced_by(name)


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
    about = parameter(name)
    return about.word_for(value) or f"{about.symbol} = {about.text(value)}"


def words_text(name: str, value: object) -> str:
    """Return words and value, for captions: ``normal load 25 N``, ``elastic``."""
    about = parameter(name)
    return about.word_for(value) or f"{about.words} {about.text(value)}"
