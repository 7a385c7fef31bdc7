"""Study files as plain values: YAML 1.2, safe, bounded, with line numbers, strict on duplicates."""

from __future__ import annotations

import re
from pathlib import Path

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from fretwear.study.problems import ENDINGS, Problem, StudyError, few_of
from fretwear.units import QuantityError, nearest

STUDIES = Path("studies")
MAX_BYTES = 1_000_000
MAX_DEPTH = 12
MAX_NODES = 300_000

_NETCDF = b"\x89HDF"
# YAML 1.2 has no dates; they stay text, like everything with a tag outside its core schema.
_CORE = tuple(f"tag:yaml.org,2002:{kind}" for kind in ("int", "float", "bool", "null"))
_BEYOND_CORE = re.compile(r"[+-]?0b|[^'\"]*_")
_TEXT = ("tag:yaml.org,2002:str", "tag:yaml.org,2002:timestamp", "tag:yaml.org,2002:value")


class Document:
    """The content of a YAML text as plain values; anything else is a problem."""

    def __init__(self, text: str) -> None:
        self.lines: dict[str, int] = {}  # of every entry, such as vary.load[1]
        self.problems: list[Problem] = []  # duplicate keys, unreadable values
        self._nodes = 0
        yaml = YAML(typ="safe", pure=True)
        self._constructor = yaml.constructor
        try:
            node = yaml.compose(text)
        except RecursionError as error:
            raise QuantityError(f"is nested more than {MAX_DEPTH} levels deep") from error
        self.is_empty = node is None
        # Dict, list, str, int, float, bool or None.
        self.data: object = None if node is None else self._value(node, "", 0)

    def _value(self, node: Node, key: str, depth: int) -> object:
        # Aliases are followed, so that the count and the depth bound what they expand to.
        self._nodes += 1
        if self._nodes > MAX_NODES:
            raise QuantityError(f"holds more than {MAX_NODES} values")
        if depth > MAX_DEPTH:
            raise QuantityError(f"is nested more than {MAX_DEPTH} levels deep")
        self.lines.setdefault(key, node.start_mark.line + 1)
        if isinstance(node, MappingNode):
            return self._mapping(node, key, depth)
        if isinstance(node, SequenceNode):
            items = enumerate(node.value)
            return [self._value(item, f"{key}[{i}]", depth + 1) for i, item in items]
        assert isinstance(node, ScalarNode)
        if node.tag in _TEXT or (node.tag in _CORE and _BEYOND_CORE.match(node.value)):
            return str(node.value)
        try:
            if node.tag in _CORE:
                return self._constructor.construct_object(node)
        except (YAMLError, ArithmeticError, LookupError, TypeError, ValueError):
            pass
        self._refuse(key, node, "cannot be read", "put it in quotes if it is meant as text")
        return node.value

    def _mapping(self, node: MappingNode, key: str, depth: int) -> dict[str, object]:
        values: dict[str, object] = {}
        for name_node, value_node in node.value:
            if name_node.tag == "tag:yaml.org,2002:merge" or name_node.value == "<<":
                self._refuse(key, name_node, "holds a merge, which studies do not know", "")
                continue
            name = self._value(name_node, f"{key}?", depth + 1)
            if not isinstance(name, str):
                self._refuse(key, name_node, "holds a key that is not text", "put it in quotes")
                continue
            path = f"{key}.{name}" if key else name
            if name in values:
                first = self.lines[path]
                self._refuse(path, value_node, f"is given twice, first in line {first}", "")
            else:
                values[name] = self._value(value_node, path, depth + 1)
                self.lines[path] = name_node.start_mark.line + 1
        return values

    def _refuse(self, key: str, node: Node, rule: str, hint: str) -> None:
        value = node.value if isinstance(node, ScalarNode) else None
        self.problems.append(Problem(key, value, rule, hint, node.start_mark.line + 1))


def read_document(file: Path) -> Document:
    """Read a YAML file; `StudyError` if it is missing or unreadable."""
    try:
        if file.is_dir():
            raise QuantityError("is a folder, not a study file", _present(file))
        if not file.exists():
            raise QuantityError("there is no such file", _present(file))
        if not file.is_file():
            raise QuantityError("is not a regular file")
        with file.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
        if content.startswith(_NETCDF):
            raise QuantityError("is a netCDF file", f"fretwear show {file} describes it")
        if len(content) > MAX_BYTES:
            raise QuantityError(f"is larger than {MAX_BYTES // 1000} kB, the limit for study files")
        document = Document(content.decode("utf-8-sig"))
        if document.is_empty:
            raise QuantityError("the file is empty", "a study needs base and vary")
        return document
    except YAMLError as error:
        reason = getattr(error, "problem", None) or getattr(error, "reason", None) or "unreadable"
        mark = getattr(error, "problem_mark", None)
        line = None if mark is None else mark.line + 1
        problem = Problem("", None, f"is not YAML: {reason}", line=line)
    except UnicodeDecodeError as error:
        problem = Problem("", None, f"is not UTF-8 text (byte {error.start})", "save it as UTF-8")
    except QuantityError as error:
        problem = Problem("", None, error.rule, error.hint)
    except OSError as error:
        problem = Problem("", None, f"cannot be read: {error.strerror}")
    raise StudyError(file, [problem])


def parse_value(text: str) -> object:
    """Read one YAML value as in a study file (``30 N``, ``none``, ``[0, 100]``)."""
    try:
        document = Document(text)
    except (YAMLError, QuantityError) as error:
        raise QuantityError("is not a value that YAML can read") from error
    if document.problems:
        raise QuantityError(document.problems[0].rule)
    return "" if document.is_empty else document.data


def _present(file: Path) -> str:
    """Return a hint at the study meant by a name without folder or ending, or at those present."""
    present = [*_studies_in(file), *_studies_in(file.parent), *_studies_in(STUDIES)]
    meant = [path for path in present if file.name in (path.name, path.stem)]
    similar = nearest(file.name, [path.name for path in present], cutoff=0.75)
    meant += [path for path in present if path.name == similar]
    if meant:
        return f"did you mean {str(meant[0])!r}?"
    return f"there are {', '.join(few_of(present))}" if present else ""


def _studies_in(folder: Path) -> list[Path]:
    """Return the study files of a folder; none if it cannot be read."""
    try:
        files = (path for path in folder.iterdir() if path.suffix in ENDINGS)
        return sorted(path for path in files if not path.name.startswith("."))
    except OSError:
        return []
