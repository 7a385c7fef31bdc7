"""What is likely meant where a file is not YAML, in words that need no knowledge of YAML."""

from __future__ import annotations

import re

import yaml

from fretwear.study.problems import Problem, shown

_ENTRY = re.compile(r"\s*(-\s|[^#]*?:(\s|$)|[\]}])")


def not_yaml(error: yaml.YAMLError, text: str) -> Problem:
    """Return the problem of a text that cannot be read, with its line and what to do.

    Parameters
    ----------
    error
        What the reader of YAML has raised.
    text
        The whole text.
    """
    mark = getattr(error, "problem_mark", None)
    reason = getattr(error, "problem", None) or getattr(error, "reason", None) or "unreadable"
    if mark is None:
        return Problem("", "", f"is not YAML: {reason}")
    number, hint = _likely(text.splitlines(), mark.line, reason)
    return Problem("", "", f"is not YAML: {reason}", hint, number + 1)


def _likely(lines: list[str], number: int, reason: str) -> tuple[int, str]:
    """Return the line to be mended, counted from 0, and how."""
    line = lines[number] if number < len(lines) else ""
    if "\t" in line[: len(line) - len(line.lstrip())]:
        return number, "a tab is no indentation in YAML: use spaces"
    before = _line_before(lines, number)
    for candidate in (number, before):
        if candidate is not None and _lacks_colon(lines, candidate):
            entry = shown(lines[candidate].strip())
            return candidate, f"a colon and a space must follow the key: {entry!r}"
    if "mapping values" in reason and line.count(": ") > 1:
        return number, "put a value with a colon in it in quotes"
    if "',' or" in reason:
        return number, "a bracket or brace opened before is not closed, or a comma is missing"
    if "quoted scalar" in reason or "end of stream" in reason:
        return number, "a quote opened before is not closed"
    return number, ""


def _line_before(lines: list[str], number: int) -> int | None:
    """Number of the last line before this one that is neither empty nor a comment."""
    numbers = range(min(number, len(lines)) - 1, -1, -1)
    return next((i for i in numbers if lines[i].strip() and lines[i].lstrip()[0] != "#"), None)


def _lacks_colon(lines: list[str], number: int) -> bool:
    line = lines[number] if number < len(lines) else ""
    return bool(line.strip()) and not _ENTRY.match(line) and not line.lstrip().startswith("#")
