"""Every case parameter by its dotted name, and how its value in a study file is read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from fretwear.study.case import Case, WavyRoughness
from fretwear.study.fields import STUDY_FILE, Quantity, Reader
from fretwear.study.problems import Problem, shown, suggestion

ROUGHNESS = "roughness"
ROUGHNESS_EXAMPLE = "{kind: wavy, amplitude: 0.2 um, slope_x: 5.7 deg, slope_y: 1 deg}"


@lru_cache(maxsize=1)
def case_fields() -> Mapping[str, FieldInfo]:
    """Return the keys that `base` may have, with their pydantic fields."""
    return {name: info for name, info in Case.model_fields.items() if name != "output_cycles"}


@lru_cache(maxsize=1)
def parameter_fields() -> Mapping[str, FieldInfo]:
    """Return the names that may be varied: case keys and ``roughness.amplitude`` and so on."""
    parts = {f"{ROUGHNESS}.{name}": info for name, info in WavyRoughness.model_fields.items()}
    return {**case_fields(), **parts}


@lru_cache(maxsize=64)
def quantity_of(name: str) -> Quantity | None:
    """Return how a parameter that is a single quantity is read; None for any other kind."""
    reader = _reader(name)
    return reader if isinstance(reader, Quantity) else None


def example_of(name: str) -> str:
    """Return an example of a parameter that is a single value, "50 N"; nothing for others."""
    reader = _reader(name)
    return "" if reader is None else str(reader.example)


def such_as(name: str) -> str:
    """Return an example for a parameter, "such as load: 50 N", or nothing."""
    if example := example_of(name):
        return f"such as {name.rpartition('.')[2]}: {example}"
    if name == ROUGHNESS:
        return f"such as roughness: {ROUGHNESS_EXAMPLE}, or none"
    return ""


def _reader(name: str) -> Reader | None:
    info = parameter_fields().get(name)
    if info is None:
        return None
    candidates = [*info.metadata]
    for part in getattr(info.annotation, "__args__", ()):
        candidates.extend(getattr(part, "__metadata__", ()))
    return next((item for item in candidates if isinstance(item, Reader)), None)


@lru_cache(maxsize=64)
def _adapter(name: str) -> TypeAdapter[Any]:
    if name == "output.cycles":
        info = Case.model_fields["output_cycles"]
    else:
        info = parameter_fields()[name]
    return TypeAdapter(info.rebuild_annotation())


@dataclass(frozen=True)
class Reading:
    """What became of one value of a file: the value in SI units, or what is wrong with it."""

    value: Any = None
    problems: tuple[Problem, ...] = ()


def read_parameter(name: str, raw: object, key: str) -> Reading:
    """Read the value of a parameter as it stands in a study file.

    Parameters
    ----------
    name : str
        One of `parameter_fields`, or ``output.cycles``.
    raw : object
        The plain value from the file.
    key : str
        Where it stands, for messages.
    """
    if raw is None:
        return Reading(problems=(Problem(key, "", "has no value", _no_value_hint(name)),))
    try:
        return Reading(_adapter(name).validate_python(raw, context=dict(STUDY_FILE)))
    except ValidationError as error:
        listed = error.errors(include_url=False)
        return Reading(problems=tuple(_problem(details, raw, key) for details in listed))


def _no_value_hint(name: str) -> str:
    if name in ("plastic_limit", ROUGHNESS):
        return f"write {name}: none if that is meant"
    return such_as(name)


def _problem(details: Mapping[str, Any], raw: object, key: str) -> Problem:
    location = [part for part in details["loc"] if not str(part).startswith("function-")]
    for part in location:
        key += f"[{part}]" if isinstance(part, int) else f".{part}"
    given = details["input"]
    kind = details["type"]
    context = details.get("ctx", {})
    if kind == "fretwear":
        return Problem(key, shown(given), context["rule"], context["hint"])
    if kind == "missing":
        return Problem(key, "", "is missing", such_as(f"{ROUGHNESS}.{location[-1]}"))
    if kind == "extra_forbidden":
        known = list(WavyRoughness.model_fields)
        hint = suggestion(str(location[-1]), known) or f"known are {', '.join(known)}"
        return Problem(key, shown(given), "is not known", hint)
    if kind == "literal_error":
        choices = [choice.strip("'") for choice in context["expected"].split(" or ")]
        hint = suggestion(given, choices) if isinstance(given, str) else ""
        return Problem(key, shown(given), f"must be {' or '.join(choices)}", hint)
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return Problem(key, shown(given), "must be none or a roughness", such_as(ROUGHNESS))
    if kind in ("tuple_type", "list_type"):
        rule = "must be a list such as [0, 1000, 30000]"
        return Problem(key, shown(raw), rule)
    return Problem(key, shown(given), str(details["msg"]))
