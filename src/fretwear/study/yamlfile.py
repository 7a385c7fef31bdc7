"""Study files as plain values: YAML 1.2, safe, bounded, with line numbers, strict on duplicates."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from fretwear.problems import Problem
from fretwear.study.problems import ENDINGS, StudyError, few_of
from fretwear.units import QuantityError, nearest

STUDIES = Path("studies")
MAX_BYTES = 1_000_000
MAX_DEPTH = 12
MAX_NODES = 300_000
_TOO_DEEP = f"is nested more than {MAX_DEPTH} levels deep"

_NETCDF = b"\x89HDF"
_ENTRY = re.compile(r"\s*(-\s|[^#]*?:(\s|$)|[\]}])")
# YAML 1.2 has no dates; they stay text, like everything with a tag outside its core schema.
_CORE = tuple(f"tag:yaml.org,2002:{kind}" for kind in ("int", "float", "bool", "null"))
_BEYOND_CORE = re.compile(r"[+-]?0b|[^'\"]*_")
# The library still breaks lines here.
_OLD_BREAKS = re.compile("[\x85\u2028\u2029]")
# A thousand whole numbers in brackets, which the library would take its time for.
_LONG_LIST = re.compile(r"\[ *(?:0|[1-9]\d{0,11})(?: *,(?: *\n)? *(?:0|[1-9]\d{0,11})){999,} *\]")
_TEXT = ("tag:yaml.org,2002:str", "tag:yaml.org,2002:timestamp", "tag:yaml.org,2002:value")


class Document:
    """The content of a YAML text as plain values; anything else is a problem."""

    def __init__(self, text: str) -> None:
        if odd := _OLD_BREAKS.search(text):
            line = text.count("\n", 0, odd.start()) + 1
            rule = f"holds the invisible character U+{ord(odd[0]):04X} in line {line}, which ended "
            raise QuantityError(f"{rule}lines in YAML 1.1 and no longer does: remove it")
        long_lists = dict[str, str]()
        marker = iter(number for number in range(10**15, 10**16) if str(number) not in text)

        def shortened(match: re.Match[str]) -> str:
            """A list of one number that occurs nowhere else, on as many lines."""
            long_lists[number := str(next(marker))] = match[0]
            last = match[0].rpartition("\n")[2]
            indented = "\n" + last[: len(last) - len(last.lstrip())]
            return f"[{number}{match[0].count(chr(10)) * indented}]"

        short = _LONG_LIST.sub(shortened, text)
        self._read(short, long_lists)
        if self._long_lists_left:  # in a comment, a quote, or as a key
            self._read(text, {})

    def _read(self, text: str, long_lists: Mapping[str, str]) -> None:
        self.lines: dict[str, int] = {}  # of every entry, such as vary.load[1]
        self.problems: list[Problem] = []  # duplicate keys, unreadable values
        self._nodes = 0
        self._long_lists, self._long_lists_left = long_lists, {*long_lists}
        yaml = YAML(typ="safe", pure=True)
        self._constructor = yaml.constructor
        try:
            node = yaml.compose(text)
        except RecursionError as error:
            raise QuantityError(_TOO_DEEP) from error
        self.is_empty = node is None
        # Dict, list, str, int, float, bool or None.
        self.data: object = None if node is None else self._value(node, "", 0)

    def _count(self, nodes: int, depth: int) -> None:
        # Aliases are followed, so that the count and the depth bound what they expand to.
        self._nodes += nodes
        if self._nodes > MAX_NODES:
            raise QuantityError(f"holds more than {MAX_NODES} values")
        if depth > MAX_DEPTH:
            raise QuantityError(_TOO_DEEP)

    def _numbers(self, text: str, first_line: int, key: str, depth: int) -> list[int]:
        """Return the numbers of a long list."""
        numbers: list[int] = []
        for line, row in enumerate(text.split("\n"), first_line):
            for number in re.findall(r"\d+", row):
                self.lines.setdefault(f"{key}[{len(numbers)}]", line)
                numbers.append(int(number))
        self._count(len(numbers), depth + 1)
        return numbers

    def _value(self, node: Node, key: str, depth: int) -> object:
        self._count(1, depth)
        self.lines.setdefault(key, node.start_mark.line + 1)
        if isinstance(node, MappingNode):
            return self._mapping(node, key, depth)
        if isinstance(node, SequenceNode):
            only = str(getattr(node.value[0], "value", "")) if len(node.value) == 1 else ""
            if only in self._long_lists:
                self._long_lists_left.discard(only)
                of_list = self._long_lists[only], node.start_mark.line + 1
                return list[object](self._numbers(*of_list, key, depth))
            items = enumerate(node.value)
            return [self._value(item, f"{key}[{i}]", depth + 1) for i, item in items]
        assert isinstance(node, ScalarNode)
        if node.tag in _TEXT or (node.tag in _CORE and _BEYOND_CORE.match(node.value)):
            if not node.style and node.value.endswith(":"):  # which the library allows in brackets
                self._refuse(key, node, "is a key without a value", "put it in quotes to be text")
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
    text = ""
    try:
        if file.is_dir():
            present = ", ".join(few_of(_studies_in(file)))
            hint = f"give one of its files: {present}" if present else ""
            raise QuantityError("is a folder, not a study file", hint)
        if not file.exists():
            raise QuantityError("there is no such file", _instead_of(file))
        if not file.is_file():
            raise QuantityError("is not a regular file")
        with file.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
        if content.startswith(_NETCDF):
            rule = "is a netCDF file, not a study file"
            raise QuantityError(rule, f"fretwear show {file} describes it")
        if len(content) > MAX_BYTES:
            raise QuantityError(f"is larger than {MAX_BYTES // 1000} kB, the limit for study files")
        text = content.decode("utf-8-sig")
        document = Document(text)
        if document.is_empty:
            raise QuantityError("the file is empty", "a study needs base and vary")
        return document
    except YAMLError as error:
        problem = _not_yaml(error, text)
        if file.suffix not in ENDINGS:
            problem = Problem("", None, "is not a study file, whose name ends in .yaml")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        rule = f"is not UTF-8 text (line {line}, byte {error.start})"
        problem = Problem("", None, rule, "save it as UTF-8")
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


def as_mapping(given: object) -> Mapping[str, object]:
    """The content of a section, empty if it is no mapping."""
    return given if isinstance(given, Mapping) else {}


def _instead_of(file: Path) -> str:
    """Return a hint at the study meant by a name without folder or ending, or at those present."""
    here = _studies_in(file.parent)
    present = [*here, *_studies_in(STUDIES)]
    similar = nearest(file.name, [path.name for path in present], cutoff=0.75)
    meant = [path for path in present if file.name in (path.name, path.stem)]
    meant += [path for path in reversed(present) if path.name == similar]
    folder = file.parent.absolute()
    if meant:
        return f"did you mean {str(meant[0])!r}?"
    if present:
        return f"there are {', '.join(few_of(here or present))}"
    if folder.is_dir():
        return (
            f"no study lies in {folder}: give a path to one, or change to the folder with studies/"
        )
    return f"there is no folder {folder} either: give another path, or change to the right folder"


def _studies_in(folder: Path) -> list[Path]:
    """Return the study files of a folder; none if it cannot be read."""
    try:
        files = (path for path in folder.iterdir() if path.suffix in ENDINGS)
        return sorted(path for path in files if not path.name.startswith("."))
    except OSError:
        return []


def _not_yaml(error: YAMLError, text: str) -> Problem:
    """Return the problem of a text that cannot be read, with the line to mend and a remedy."""
    reason = getattr(error, "problem", None) or getattr(error, "reason", None) or "unreadable"
    rule = f"is not YAML: {reason}"
    if (mark := getattr(error, "problem_mark", None)) is None:
        return Problem("", None, rule)
    lines = text.splitlines()
    line = lines[mark.line] if mark.line < len(lines) else ""
    number, hint = mark.line, ""
    # This line and the last one before it, without empty lines and comments.
    filled = [i for i, row in enumerate(lines[: number + 1]) if re.match(r"\s*[^\s#]", row)]
    near = filled[-2:] if number in filled else filled[-1:]
    if "\t" in line[: len(line) - len(line.lstrip())]:
        hint = "YAML does not allow tabs as indentation: use spaces"
    elif "'\\t'" in reason:
        hint = "use spaces instead of tabs"
    elif "another document" in reason:
        rule, hint = "holds more than one document", "leave out the line ---, or split the file"
    elif "'%'" in reason:
        hint = "a percent sign follows its number: 2 %"
    elif "cannot start any token" in reason:
        hint = "put a value that begins with this character in quotes"
    elif lacking := [i for i in near if not _ENTRY.match(lines[i])]:
        number = lacking[-1]
        hint = f"a colon and a space must follow the key: {lines[number].strip()!r}"
    elif re.search(r"\]\s*[^\s,#\]}]", line):
        hint = "each value of a list has its unit: [10 N, 20 N]"
    elif "mapping values" in reason and line.count(": ") > 1:
        hint = "put a value with a colon in it in quotes"
    elif "mapping values" in reason:
        hint = "all keys of a section begin in the same column"
    elif "',' or" in reason:
        hint = "a bracket or brace opened before is not closed, or a comma is missing"
    elif "quoted scalar" in reason or "end of stream" in reason:
        hint = "a quote opened before is not closed"
    return Problem("", None, rule, hint, number + 1)
