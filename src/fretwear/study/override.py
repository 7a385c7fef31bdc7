"""Changing single values of a study from the command line (``--set load=30 N``)."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from typing import Any

from fretwear.study.checks import TANGENTIAL
from fretwear.study.document import parse_value
from fretwear.study.parameters import ROUGHNESS, parameter_fields
from fretwear.study.problems import Problem, shown, suggestion

OPTION = "--set"


def override(
    raw: Mapping[str, Any], assignments: Iterable[str]
) -> tuple[dict[str, Any], list[Problem]]:
    """Apply assignments ``name=value`` to the plain content of a study file.

    The value replaces that of `base`, and the parameter is no longer varied.  Setting one of the
    two tangential parameters drops the other.  ``output.cycles`` and ``title`` can be set too.

    Returns
    -------
    dict, list of Problem
        The changed content (the one given stays as it is), and what was wrong with the
        assignments themselves; values are checked with the study.
    """
    changed = copy.deepcopy(dict(raw))
    problems: list[Problem] = []
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        name = name.strip()
        known = (*parameter_fields(), "output.cycles", "title")
        if not equals:
            rule = "must have the form name=value"
            problems.append(Problem(OPTION, shown(assignment), rule, "such as --set 'load=30 N'"))
        elif name not in known:
            hint = suggestion(name, known)
            problems.append(Problem(f"{OPTION} {name}", text, "is not a parameter", hint))
        else:
            try:
                value = parse_value(text)
            except ValueError as error:
                problems.append(Problem(f"{OPTION} {name}", shown(text), str(error)))
            else:
                problems.extend(_assign(changed, name, value))
    return changed, problems


def _assign(content: dict[str, Any], name: str, value: Any) -> list[Problem]:
    if name == "title":
        content["title"] = value
        return []
    if name == "output.cycles":
        content["output"] = {"cycles": value}
        return []
    base = _mapping(content, "base")
    vary = _mapping(content, "vary")
    if name in TANGENTIAL:
        for other in TANGENTIAL:
            base.pop(other, None)
            vary.pop(other, None)
    vary.pop(name, None)
    whole, _, part = name.partition(".")
    if part:
        if whole in vary:
            rule = f"cannot be set while vary.{whole} varies the whole of it"
            return [Problem(f"{OPTION} {name}", shown(value), rule)]
        present = base.get(whole)
        base[whole] = {**(present if isinstance(present, Mapping) else {}), part: value}
    else:
        for varied in [key for key in vary if name == ROUGHNESS and key.startswith(f"{name}.")]:
            del vary[varied]
        base[name] = value
    if not vary:
        # A sampled design without anything to sample would be an error of its own.
        del content["vary"]
        content.pop("design", None)
    return []


def _mapping(content: dict[str, Any], section: str) -> dict[str, Any]:
    present = content.get(section)
    content[section] = dict(present) if isinstance(present, Mapping) else {}
    mapping: dict[str, Any] = content[section]
    return mapping


def renamed(problem_key: str, assignments: Iterable[str]) -> str:
    """Return the key of a problem in the words of the command line where it was set there."""
    for assignment in assignments:
        name = assignment.partition("=")[0].strip()
        for place in (f"base.{name}", name):
            if problem_key == place or problem_key.startswith((f"{place}.", f"{place}[")):
                return f"{OPTION} {name}{problem_key.removeprefix(place)}"
    return problem_key
