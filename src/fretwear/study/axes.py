"""The varied values of a study file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fretwear.study.designs import MAX_POINTS, Design, Range, sample
from fretwear.study.parameters import (
    ROUGHNESS,
    parameter_fields,
    quantity_of,
    read_parameter,
)
from fretwear.study.points import Axis
from fretwear.study.problems import Problem, shown, suggestion
from fretwear.study.quantities import exact_text

_RANGE_KEYS = ("from", "to", "scale")


def read_axes(vary: Mapping[str, Any], design: Design, problems: list[Problem]) -> tuple[Axis, ...]:
    """Read the section `vary`; return the sound axes and add what is wrong to `problems`."""
    read: dict[str, Axis | Range] = {}
    for name, raw in vary.items():
        axis = _read_axis(name, raw, f"vary.{name}", design, problems)
        if axis is not None:
            read[name] = axis
    _refuse_whole_and_part(vary, problems)
    if design.is_sampled and not vary:
        rule = "is missing: a sampled design needs something to vary"
        problems.append(Problem("vary", "", rule, "such as load: {from: 10 N, to: 100 N}"))
    if design.is_sampled:
        return _sampled_axes(read, design) if design.points and read else ()
    axes = tuple(axis for axis in read.values() if isinstance(axis, Axis))
    lengths = {axis.name: len(axis.values) for axis in axes}
    if design.kind == "zip" and len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        rule = f"must have lists of equal length under design: zip, but {listed}"
        problems.append(Problem("vary", "", rule, "design: grid takes every combination"))
        return ()
    if design.kind == "zip":
        _refuse_equal_rows(axes, problems)
    size = design.size(list(lengths.values()))
    if size > MAX_POINTS:
        rule = f"makes {size} points, more than the limit of {MAX_POINTS}"
        problems.append(Problem("vary", "", rule, "split the study"))
        return ()
    return axes


def _read_axis(
    name: str, raw: object, key: str, design: Design, problems: list[Problem]
) -> Axis | Range | None:
    if name not in parameter_fields():
        known = tuple(parameter_fields())
        hint = suggestion(name, known)
        problems.append(Problem(key, shown(raw), "is not a case parameter", hint))
        return None
    if name == ROUGHNESS and isinstance(raw, Mapping):
        hint = f"to vary a part of it write {ROUGHNESS}.amplitude: [0.1 um, 0.2 um]"
        problems.append(Problem(key, shown(raw), "must be a list of roughnesses", hint))
        return None
    if isinstance(raw, Mapping):
        return _read_range(name, raw, key, design, problems)
    if not isinstance(raw, list):
        hint = f"write [{shown(raw)}]" if isinstance(raw, str | int | float) else ""
        if design.is_sampled:
            hint = "or a range such as {from: 10 N, to: 100 N, scale: log}"
        problems.append(Problem(key, shown(raw), "must be a list of values", hint))
        return None
    if not raw:
        hint = "list at least one value, or leave it out"
        problems.append(Problem(key, "[]", "is an empty list", hint))
        return None
    values: list[Any] = []
    seen: dict[object, int] = {}
    sound = True
    for position, item in enumerate(raw):
        place = f"{key}[{position}]"
        reading = read_parameter(name, item, place)
        problems.extend(reading.problems)
        if reading.problems:
            sound = False
            continue
        values.append(reading.value)
        identity = _identity(reading.value)
        # Paired lists may repeat a value: only a whole row makes the same point.
        if identity in seen and design.kind != "zip":
            rule = f"is the same value as {key}[{seen[identity]}], {shown(raw[seen[identity]])}"
            problems.append(Problem(place, shown(item), rule, "leave one of them out"))
        seen.setdefault(identity, position)
    return Axis(name, tuple(values), tuple(raw)) if sound else None


def _refuse_equal_rows(axes: tuple[Axis, ...], problems: list[Problem]) -> None:
    seen: dict[object, int] = {}
    for row, values in enumerate(zip(*(axis.values for axis in axes), strict=True)):
        first = seen.setdefault(_identity(values), row)
        if first != row:
            given = ", ".join(f"{axis.name} {axis.labels[row]}" for axis in axes)
            rule = f"make point {row + 1} the same as point {first + 1} under design: zip"
            problems.append(Problem("vary", given, rule, "leave one of them out of every list"))


def _identity(value: Any) -> object:
    """Return what makes two values of an axis the same, whatever their units were."""
    if isinstance(value, float):
        return f"{value:.11e}"
    if isinstance(value, tuple):
        return tuple(_identity(item) for item in value)
    if hasattr(value, "model_dump"):
        return tuple(_identity(item) for item in value.model_dump().values())
    return value


def _read_range(
    name: str, raw: Mapping[str, Any], key: str, design: Design, problems: list[Problem]
) -> Range | None:
    before = len(problems)
    if not design.is_sampled:
        rule = f"is a range, which design: {design.kind} cannot take"
        hint = "write a list, or design: {kind: latin_hypercube, points: 64, seed: 1}"
        problems.append(Problem(key, shown(raw), rule, hint))
        return None
    quantity = quantity_of(name)
    if quantity is None:
        rule = "has values that are no single quantity and cannot be drawn from a range"
        problems.append(Problem(key, shown(raw), rule, "write a list: its values are drawn"))
        return None
    for part, value in raw.items():
        if part not in _RANGE_KEYS:
            hint = suggestion(part, _RANGE_KEYS) or f"known are {', '.join(_RANGE_KEYS)}"
            problems.append(Problem(f"{key}.{part}", shown(value), "is not known", hint))
    scale = raw.get("scale", "linear")
    if scale not in ("linear", "log"):
        hint = suggestion(str(scale), ("linear", "log"))
        problems.append(Problem(f"{key}.scale", shown(scale), "must be linear or log", hint))
    ends = []
    for part in _RANGE_KEYS[:2]:
        if part not in raw:
            hint = f"such as {part}: {quantity.example}"
            problems.append(Problem(f"{key}.{part}", "", "is missing", hint))
            continue
        reading = read_parameter(name, raw[part], f"{key}.{part}")
        problems.extend(reading.problems)
        ends.append(reading.value)
    if len(problems) > before:
        return None
    low, high = ends
    if not low < high < float("inf"):
        rule = f"must be more than {key}.from = {shown(raw['from'])}, and finite"
        problems.append(Problem(f"{key}.to", shown(raw["to"]), rule))
        return None
    if scale == "log" and low <= 0.0:
        rule = "must be larger than 0 on a logarithmic scale"
        problems.append(Problem(f"{key}.from", shown(raw["from"]), rule))
        return None
    return Range(low, high, logarithmic=scale == "log")


def _refuse_whole_and_part(vary: Mapping[str, Any], problems: list[Problem]) -> None:
    parts = [name for name in vary if name.startswith(f"{ROUGHNESS}.")]
    if ROUGHNESS in vary and parts:
        rule = f"varies the whole of which {parts[0]} is a part"
        problems.append(Problem(f"vary.{ROUGHNESS}", "", rule, "vary one or the other"))


def _sampled_axes(read: Mapping[str, Axis | Range], design: Design) -> tuple[Axis, ...]:
    pools = [
        axis if isinstance(axis, Range) else list(zip(axis.values, axis.written, strict=True))
        for axis in read.values()
    ]
    axes = []
    for (name, source), drawn in zip(read.items(), sample(design, pools), strict=True):
        if isinstance(source, Range):
            quantity = quantity_of(name)
            assert quantity is not None
            written = tuple(exact_text(value, quantity.dimension) for value in drawn)
            axes.append(Axis(name, tuple(drawn), written))
        else:
            values, texts = zip(*drawn, strict=True)
            axes.append(Axis(name, values, texts))
    return tuple(axes)
