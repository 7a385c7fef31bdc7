"""Sphinx extension: parts of the reference are written from the code that they describe.

Before the pages are read this puts Markdown into ``docs/generated/``, for the pages to include:
the parameters and sections of a study file, the variables of a dataset, the command line.
"""

from __future__ import annotations

import html
import math
import re
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from notation import NOTATION

from fretwear.data.files import MERGED_PROFILES
from fretwear.quantity import Inline, Parameter, Part, PartOf, Quantity, declared, required
from fretwear.results import (
    CONVOLUTIONS,
    CYCLE,
    DEPTH,
    ERROR_ESTIMATE,
    FIELDS,
    LOOP,
    RESULTS,
    SCALARS,
    STEP,
    X,
    Y,
)
from fretwear.study.case import Case
from fretwear.study.contact import case_keys, members
from fretwear.study.materials import material_table
from fretwear.study.parameters import parameter
from fretwear.study.sections import study_schema
from fretwear.variable import Variable
from fretwear_cracks.section import StressOutput
from fretwear_cracks.variables import CRACKS, EDGE_STRESSES, FATIGUE, STRESSES

if TYPE_CHECKING:
    from sphinx.application import Sphinx


def table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table in Markdown."""
    lines = [titles, ["---"] * len(titles), *rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def parameters() -> str:
    """Write the table of every case parameter."""
    titles = ("parameter", "example", "range", "in a file", "meaning")
    rows = [
        (f"`{name}`", f"`{_example(name)}`", _range(name), _presence(name), meaning)
        for name in case_keys().all_names
        for about in [case_keys()[name].about]
        for meaning in [about.description or f"{about.words.capitalize()}."]
    ]
    return table(titles, rows)


def materials() -> str:
    """Write the table of materials."""
    rows = [[*row.values()] for row in material_table().values()]
    return table(["material", "E", "ν", "hardness", "source"], rows)


def _example(name: str) -> str:
    about = case_keys()[name].about
    return about.example or (next(iter(about.family.kinds())) if isinstance(about, PartOf) else "")


def _range(name: str) -> str:
    match case_keys()[name].about:
        case Quantity(is_whole=True) as number:
            return f"whole, {_whole(int(number.ge or 0))} to {_whole(int(number.le or 0))}"
        case Quantity() as quantity:
            fields = (", ".join(form.__dataclass_fields__) for form in quantity.forms)
            pair = ["a pair"] if quantity.places else []
            forms = [*pair, *(f"`{{{keys}}}`" for keys in fields)]
            none = ["`none`"] if quantity.infinite else []
            return "; or ".join([quantity.range_text(), *none, *forms])
        case PartOf() as part:
            choices = ["none"] if part.none else []
            return " or ".join(f"`{choice}`" for choice in [*choices, *part.family.kinds()])
        case other:
            return _kinds(study_schema()["properties"]["base"]["properties"].get(name, {})) or (
                other.example
            )


def _presence(name: str) -> str:
    member = case_keys().member_of(name)
    about = members()[member]
    if "." in name:
        return "a part of it"
    kinds = [*about.family.kinds().values()] if isinstance(about, Inline) else []
    if not all(name in kind.parameters() for kind in kinds):
        needed = any(name in required(kind) for kind in kinds)
        return "one of them" if needed else "may be left out"
    if isinstance(about, PartOf) and about.short:
        short = about.family.kinds()[about.short].parameters()
        others = [member] if name != member else [*short]
        return "needed, or " + ", ".join(f"`{other}`" for other in others)
    if member in required(Case):
        return "needed"
    default = getattr(Case, member)
    if isinstance(default, Part):
        default = default.kind
    if default == math.inf or (isinstance(about, PartOf) and about.none):
        default = "none"
    if default == ():
        return "may be left out"
    return "left out: follows from the case" if default is None else f"left out: `{default}`"


def sections() -> str:
    """Write the table of the top-level keys of a study file with their values."""
    schema = study_schema()
    rows = [
        (
            f"`{name}`",
            _kinds(part),
            f"`{part['default']}`"
            if isinstance(part.get("default"), str) and part["default"]
            else "",
            part.get("description", ""),
        )
        for name, part in schema["properties"].items()
    ]
    return table(("key", "value", "default", "meaning"), rows)


def keys_of(*path: str) -> str:
    """Write the table of the keys at a place in the schema of a study file."""
    schema: Any = study_schema()
    for key in path:
        schema = schema[key] if key == "items" else schema["properties"][key]
    rows = [(f"`{name}`", part["description"]) for name, part in schema["properties"].items()]
    return table(("key", "meaning"), rows)


def _kinds(part: Mapping[str, Any]) -> str:
    """Return the values that a part of a JSON Schema allows, in a few words."""
    if "const" in part:
        return f"`{part['const']}`"
    if "enum" in part:
        return " or ".join(f"`{value}`" for value in part["enum"])
    if "anyOf" in part:
        kinds = dict.fromkeys(_kinds(choice) for choice in part["anyOf"])
        return "; ".join(kind for kind in kinds if kind)
    kind = part.get("type", "")
    if kind == "object" and 0 < len(part.get("properties", {})) <= 4:
        inside = ", ".join(f"{key}: {_kinds(one)}" for key, one in part["properties"].items())
        return f"{{{inside}}}"
    if kind == "integer":
        bounds = (("from", part.get("minimum")), ("to", part.get("maximum")))
        return " ".join(["whole number", *(f"{w} {_whole(b)}" for w, b in bounds if b is not None)])
    if kind == "array":
        return f"list, each a {_kinds(part['items'])}" if "items" in part else "list"
    if kind == "string" and "pattern" in part:
        # Numbers written as text are accepted, but not documented.
        return "value with a unit" if "examples" in part else ""
    names = {"object": "section", "string": "text", "integer": "whole number"}
    return " or ".join(names.get(one, one) for one in ([kind] if isinstance(kind, str) else kind))


def _whole(number: int) -> str:
    """Write a whole number exactly, round millions as a power of ten."""
    short = f"{number:g}".replace("e+0", "e")
    return short if float(short) == number else str(number)


def variables(listed: Iterable[Variable]) -> str:
    """Write a table of variables."""
    rows = [
        (f"`{one.name}`", one.si_unit or "–", one.dtype, _meaning(one.words, one.comment))
        for one in listed
    ]
    return table(("variable", "units", "type", "meaning"), rows)


def profiles() -> str:
    """Write the table of the profiles of a merged study."""
    rows = [
        (f"`{name}`", f"`{field.name}`", field.si_unit, field.words)
        for name, field in MERGED_PROFILES.items()
    ]
    return table(("variable", "of the field", "units", "meaning"), rows)


def notation() -> dict[str, list[tuple[str, Parameter | Variable]]]:
    """Return what each symbol stands for: names in files and datasets, with their declarations."""
    listed: list[tuple[str, Parameter | Variable]] = []
    for name in case_keys().all_names:
        about = case_keys()[name].about
        listed.append((name, about))
        for form in getattr(about, "forms", ()):
            listed += declared(form).items()
    listed += [(name, parameter(name)) for name in ("hertz_radius", "hertz_pressure")]
    listed += StressOutput.parameters().items()
    variables = (X, Y, CYCLE, DEPTH, *RESULTS.values(), *NOTATION, *LOOP)
    listed += [(one.name, one) for one in (*variables, *STRESSES, *CRACKS, *FATIGUE)]
    symbols: dict[str, list[tuple[str, Parameter | Variable]]] = {}
    for name, about in listed:
        if about.symbol.startswith("$"):
            symbols.setdefault(about.symbol, []).append((name, about))
    return symbols


def notation_table() -> str:
    """Write the table of symbols; the given value of a quantity and its result share one."""
    rows = []
    for symbol, meant in notation().items():
        meanings = dict.fromkeys(
            _meaning(about.words, about.comment) if about in NOTATION else about.words
            for _, about in meant
        )
        names = dict.fromkeys(f"`{name}`" for name, about in meant if about not in NOTATION)
        rows.append((symbol, "; ".join(meanings), meant[0][1].si_unit, ", ".join(names)))
    return table(("symbol", "meaning", "unit", "in files"), rows)


def case_coordinates() -> str:
    """Write the table of the scalar coordinates, from a rough case."""
    case = Case(
        radius="10 mm",
        youngs_modulus="208 GPa",
        poisson_ratio=0.3,
        load="50 N",
        tangential_ratio=0.8,
        friction=0.5,
        wear_coefficient="7e-13 / Pa",
        cycles=1,
    )
    rows = [
        (f"`{name}`", units or "–", long_name)
        for name, (_, units, long_name) in case.scalar_coordinates().items()
    ]
    return table(("coordinate", "units", "meaning"), rows)


def _meaning(long_name: str, comment: str) -> str:
    return f"{long_name}; {comment}" if comment else long_name


def command_line() -> str:
    """Write the commands, arguments and options as typer documents them, with their examples."""
    documented = ("-m", "typer", "fretwear.cli.program", "utils", "docs", "--name", "fretwear")
    done = subprocess.run(
        [sys.executable, *documented],
        check=True,
        capture_output=True,
        text=True,
    )
    text = html.unescape(done.stdout)
    text = re.sub(r"^# `fretwear`\n", "", text, flags=re.MULTILINE)
    example = r"Example:\n\n```bash\n\1\n```"
    text = re.sub(r"\[/?dim\]", "", text)
    text = re.sub(r"^Example: (.*)$", example, text, flags=re.MULTILINE)
    text = re.sub(
        r"^\$ (.*)$", lambda match: re.sub(r"[{}]", "", match[1]), text, flags=re.MULTILINE
    )
    return _with_whole_sentences(text)


def _with_whole_sentences(text: str) -> str:
    """Replace the texts that typer shortens in its list of commands by first sentences."""
    first = dict(re.findall(r"^## `fretwear (\w+)`\n\n(.*?[.])(?:\s|$)", text, re.MULTILINE))
    return re.sub(
        r"^\* `(\w+)`: .*$",
        lambda match: f"* `{match[1]}`: {first.get(match[1], '')}",
        text,
        flags=re.MULTILINE,
    )


def write_all(folder: Path) -> None:
    """Write every part into a folder."""
    parts = {
        "parameters": parameters(),
        "materials": materials(),
        "notation": notation_table(),
        "sections": sections(),
        "stress_output": keys_of("output", "stress"),
        "measurements": keys_of("fit", "data", "items"),
        "coordinates": variables((CYCLE, X, Y)),
        "fields": variables(FIELDS),
        "stresses": variables((*STRESSES, *EDGE_STRESSES, *CRACKS)),
        "fatigue": variables(FATIGUE),
        "scalars": variables(SCALARS),
        "history": variables((STEP, CYCLE, ERROR_ESTIMATE, CONVOLUTIONS)),
        "profiles": profiles(),
        "case_coordinates": case_coordinates(),
        "command_line": command_line(),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in parts.items():
        (folder / f"{name}.md").write_text(f"{text}\n", encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Write the parts before the pages are read."""
    app.connect("builder-inited", lambda app: write_all(Path(app.srcdir) / "generated"))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
