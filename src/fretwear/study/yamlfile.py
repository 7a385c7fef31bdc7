"""Study files as plain values, with the line of every entry."""

from __future__ import annotations

from pathlib import Path

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, SequenceNode

from fretwear.study.mistakes import Mistake, StudyError
from fretwear.units import QuantityError, nearest

STUDIES = Path("studies")

# Remedies of errors that the parser reports.
_REMEDIES = {
    "'\\t'": "indent with spaces, not with a tab",
    "mapping values are not allowed": "indent keys alike, and quote text with a colon",
}
# Everything else is text: YAML 1.2 has no dates.
_CORE = tuple(f"tag:yaml.org,2002:{kind}" for kind in ("int", "float", "bool", "null"))


class Document:
    """The content of a YAML text: dicts, lists, text, numbers, true, false and None."""

    def __init__(self, text: str) -> None:
        self.lines: dict[str, int] = {}  # of every entry, such as vary.load[1]
        self.mistakes: list[Mistake] = []  # of duplicate keys and unreadable values
        yaml = YAML(typ="safe", pure=True)
        self._constructor = yaml.constructor
        node = yaml.compose(text)
        self.data: object = None if node is None else self._value(node, "")

    def _value(self, node: Node, key: str) -> object:
        self.lines.setdefault(key, node.start_mark.line + 1)
        if isinstance(node, MappingNode):
            return self._mapping(node, key)
        if isinstance(node, SequenceNode):
            return [self._value(item, f"{key}[{i}]") for i, item in enumerate(node.value)]
        if node.tag not in _CORE:
            return str(node.value)
        try:
            return self._constructor.construct_object(node)
        except (YAMLError, LookupError, ValueError):
            self._refuse(key, node, "cannot be read")
            return node.value

    def _mapping(self, node: MappingNode, key: str) -> dict[str, object]:
        values: dict[str, object] = {}
        for name_node, value_node in node.value:
            name = str(name_node.value)
            path = f"{key}.{name}" if key else name
            if name in values:
                self._refuse(path, value_node, f"is given twice, first in line {self.lines[path]}")
            else:
                values[name] = self._value(value_node, path)
                self.lines[path] = name_node.start_mark.line + 1
        return values

    def _refuse(self, key: str, node: Node, rule: str) -> None:
        self.mistakes.append(Mistake(key, None, rule, line=node.start_mark.line + 1))


def read_document(file: Path) -> Document:
    """Read a YAML file; `StudyError` if it is missing or unreadable."""
    try:
        return Document(file.read_text(encoding="utf-8-sig"))
    except YAMLError as error:
        mark = error.problem_mark if isinstance(error, MarkedYAMLError) else None
        reason = getattr(error, "problem", None) or "it has characters that are not text"
        remedy = next((_REMEDIES[part] for part in _REMEDIES if part in reason), "")
        mistake = Mistake("", None, f"is not YAML: {reason}", remedy, mark and mark.line + 1)
    except UnicodeDecodeError as error:
        is_case = file.suffix == ".nc"
        remedy = "give a study file; fretwear show takes a case" if is_case else "save it as UTF-8"
        mistake = Mistake("", None, f"is not UTF-8 text (byte {error.start})", remedy)
    except RecursionError:
        mistake = Mistake("", None, "is nested too deeply: does an alias hold itself?")
    except OSError as error:
        mistake = Mistake("", None, f"cannot be read: {error.strerror}", _meant(file))
    raise StudyError(file, [mistake])


def parse_value(text: str) -> object:
    """Read one YAML value as in a study file (``30 N``, ``none``, ``[0, 100]``)."""
    try:
        document = Document(text)
    except YAMLError as error:
        raise QuantityError("is not a value that YAML can read") from error
    if document.mistakes:
        raise QuantityError(document.mistakes[0].rule)
    return "" if document.data is None else document.data


def _meant(file: Path) -> str:
    """A hint at the study file with the nearest name, here or among the studies."""
    folders = (STUDIES, file.parent, file)
    present = {path.stem: path for folder in folders for path in folder.glob("*.y*ml")}
    near = nearest(file.stem, present)
    return f"did you mean {str(present[near])!r}?" if near else ""
