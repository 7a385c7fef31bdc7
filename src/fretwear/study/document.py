"""Reading YAML the careful way: safe, bounded, with line numbers, and strict about duplicates."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from fretwear.study.missing import instead_of, listed, studies_in
from fretwear.study.problems import Problem, StudyError, shown
from fretwear.study.yaml_errors import not_yaml

MAX_BYTES = 1_000_000
MAX_DEPTH = 12
MAX_NODES = 300_000

_NETCDF = b"\x89HDF"

_Loader: type[Any] = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass
class Document:
    """The content of a YAML file.

    Attributes
    ----------
    data : object
        Plain values: dict, list, str, int, float, bool, None (and dates, which YAML knows).
    lines : dict
        Line of every entry by its dotted key, such as ``vary.load[1]``.
    problems : list of Problem
        Duplicate and unusable keys, unreadable values.
    """

    data: Any
    lines: dict[str, int] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)


def read_document(file: Path) -> Document:
    """Read a YAML file; `StudyError` where there is none that could be read."""
    text = _read_text(file)
    try:
        _refuse_depth(text)
        loader = _Loader(text)
        try:
            node = loader.get_single_node()
            if node is None:
                raise StudyError(
                    file, [Problem("", "", "the file is empty", "a study needs base and vary")]
                )
            return _Builder(loader).document(node)
        finally:
            loader.dispose()
    except yaml.YAMLError as error:
        raise StudyError(file, [not_yaml(error, text)]) from error
    except _TooMuchError as error:
        raise StudyError(file, [Problem("", "", str(error))]) from error


def parse_value(text: str) -> Any:
    """Read one value as a study file would have it (``30 N``, ``none``, ``[0, 100]``).

    Raises
    ------
    ValueError
        Not a single YAML value.
    """
    try:
        _refuse_depth(text)
        loader = _Loader(text)
        try:
            node = loader.get_single_node()
            document = _Builder(loader).document(node) if node is not None else Document("")
        finally:
            loader.dispose()
    except (yaml.YAMLError, _TooMuchError) as error:
        raise ValueError("is not a value that YAML can read") from error
    if document.problems:
        raise ValueError(document.problems[0].rule)
    return document.data


class _TooMuchError(Exception):
    """The document is larger than any study could be."""


def _read_text(file: Path) -> str:
    def refused(rule: str, hint: str = "") -> StudyError:
        return StudyError(file, [Problem("", "", rule, hint)])

    if "\0" in str(file):
        raise refused("is not a usable file name")
    try:
        if file.is_dir():
            present = studies_in(file)
            hint = listed("give one of its files:", present) if present else ""
            raise refused("is a folder, not a study file", hint)
        if not file.exists():
            raise refused("there is no such file", instead_of(file))
        if not file.is_file():
            raise refused("is not a regular file")
        with file.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise refused(f"cannot be read: {error.strerror}") from error
    if len(content) > MAX_BYTES:
        raise refused(f"is larger than {MAX_BYTES // 1000} kB, the limit for study files")
    if content.startswith(_NETCDF):
        raise refused("is a netCDF file, not a study file", f"fretwear show {file} tells of it")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise refused(
            f"is not UTF-8 text (line {line}, byte {error.start})", "save it as UTF-8"
        ) from error


def _refuse_depth(text: str) -> None:
    # Composing recurses; events do not, so a file of brackets alone is caught here.
    depth = 0
    for event in yaml.parse(text, Loader=_Loader):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            if depth > MAX_DEPTH:
                raise _TooMuchError(f"is nested more than {MAX_DEPTH} levels deep")
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1


class _Builder:
    """Turns composed nodes into plain values, remembering lines, refusing what is not plain."""

    def __init__(self, loader: Any) -> None:
        self._loader = loader
        self._nodes = 0
        self._result = Document(None)

    def document(self, node: yaml.Node) -> Document:
        self._result.data = self._value(node, "", 0)
        return self._result

    def _value(self, node: yaml.Node, key: str, depth: int) -> Any:
        # Aliases are followed, so that the count and the depth bound what they expand to.
        self._nodes += 1
        if self._nodes > MAX_NODES:
            raise _TooMuchError(f"holds more than {MAX_NODES} values")
        if depth > MAX_DEPTH:
            raise _TooMuchError(f"is nested more than {MAX_DEPTH} levels deep")
        self._result.lines.setdefault(key, node.start_mark.line + 1)
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, key, depth)
        if isinstance(node, yaml.SequenceNode):
            return [
                self._value(item, f"{key}[{position}]", depth + 1)
                for position, item in enumerate(node.value)
            ]
        try:
            return self._loader.construct_object(node)
        except (
            yaml.YAMLError,
            ArithmeticError,
            AttributeError,
            LookupError,
            TypeError,
            ValueError,
        ):
            # With a tag such as !!int on what is none, the library fails in many ways.
            self._refuse(key, node, "cannot be read", "put it in quotes if it is meant as text")
            return node.value

    def _mapping(self, node: yaml.MappingNode, key: str, depth: int) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for name_node, value_node in node.value:
            if name_node.tag == "tag:yaml.org,2002:merge":
                self._refuse(key, name_node, "holds a merge, which studies do not know", "")
                continue
            name = self._value(name_node, f"{key}?", depth + 1)
            if not isinstance(name, str):
                self._refuse(key, name_node, "holds a key that is not text", "put it in quotes")
                continue
            path = f"{key}.{name}" if key else name
            if name in values:
                first = self._result.lines[path]
                self._refuse(path, value_node, f"is given twice, first in line {first}", "")
                continue
            values[name] = self._value(value_node, path, depth + 1)
            self._result.lines[path] = name_node.start_mark.line + 1
        return values

    def _refuse(self, key: str, node: yaml.Node, rule: str, hint: str) -> None:
        value = shown(node.value) if isinstance(node, yaml.ScalarNode) else ""
        line = node.start_mark.line + 1
        self._result.problems.append(Problem(key, value, rule, hint, line))
