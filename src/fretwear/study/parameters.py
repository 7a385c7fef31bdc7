"""The parameters of a case: their names, how they are read, and their values for people."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType
from typing import Any, TypeVar, cast

from fretwear.forms import Either
from fretwear.parts import Parameter, Part, Quantity, derived, required
from fretwear.plugins import plugins
from fretwear.problems import Problem, Problems
from fretwear.study.materials import MATERIAL, PROPERTIES
from fretwear.study.members import Block, Inline, PartOf
from fretwear.study.setup import IN_BLOCKS, PARTS_OF_A_DISTANCE, Draft, members
from fretwear.units import QuantityError, nearest

_Value = TypeVar("_Value")

_SECTIONS = ("title", "base", "vary", "seeds", "design", "invalid", "batch", "output")

_OTHER_NAMES = {
    word: (name, remedy)
    for words, name, remedy in (
        ("hardness hv hb hrc vickers_hardness", "plastic_limit", "about the hardness"),
        ("yield_stress yield_strength", "plastic_limit", "about three times the yield stress"),
        (
            "ra rq sa sq rz rms_roughness",
            "roughness",
            "{kind: wavy, amplitude: ..., slope_x: ..., "
            "slope_y: ...}; Ra is 0.41 and Rq 0.5 of this amplitude",
        ),
        ("stroke", "displacement_amplitude", "half of the stroke"),
        ("displacement amplitude u", "displacement_amplitude", ""),
        ("diameter", "radius", "half of the diameter"),
        ("r", "radius", ""),
        ("e young modulus", "youngs_modulus", ""),
        ("nu v", "poisson_ratio", ""),
        ("p force normal_load normal_force", "load", ""),
        ("q tangential_force", "tangential_load", ""),
        ("mu cof friction_coefficient", "friction", ""),
        ("k kw k_w archard", "wear_coefficient", ""),
        ("n n_cycles number_of_cycles", "cycles", ""),
        ("time duration test_duration", "cycles", "the duration times the frequency"),
        ("wear_rate specific_wear_rate", "wear_coefficient", ""),
        ("dx spacing mesh grid", "cell", ""),
        ("coupled", "slip_model", "coupled"),
        ("debris third_body third_body_layer", "debris_fraction", ""),
    )
    for word in words.split()
}
"""Words that users may write for a parameter: its name, and what to write there if that differs."""

_NOT_MODELLED = {"temperature", "humidity", "lubricant", "environment", "atmosphere"}

# A key with which another one has a default.
_INSTEAD = {"cycles": "sliding_distance"}


@dataclass(frozen=True)
class Leaf:
    """One parameter of a case, or a part as a whole."""

    name: str  # in study files, dotted within a part: ``load``, ``roughness.amplitude``
    member: str  # field of the case to which it belongs
    kind: type[Part] | None  # the part that has it; None: the case itself
    field: str
    parameter: Parameter


def section_names() -> tuple[str, ...]:
    """The sections of a study file."""
    added = plugins("fretwear.study_sections")
    return *_SECTIONS, *(place for place in added if "." not in place)


def leaves() -> Mapping[str, list[Leaf]]:
    """Return the parameters of a case by name, the keys of `base` first.

    Several kinds of a part may have a parameter of the same name.
    """
    return _tables()[0]


def _tables() -> tuple[Mapping[str, list[Leaf]], Mapping[str, Parameter]]:
    """Return the parameters by name and by coordinate, including classes that users defined."""
    parts = (about for about in members().values() if isinstance(about, PartOf))
    return _tables_of(tuple(tuple(part.kinds.values()) for part in parts))


@cache
def _tables_of(_: object) -> tuple[Mapping[str, list[Leaf]], Mapping[str, Parameter]]:
    keys: dict[str, list[Leaf]] = {}
    dotted: dict[str, list[Leaf]] = {}
    following: dict[str, Parameter] = {}
    for member, about in members().items():
        if not isinstance(about, Inline):
            keys[member] = [Leaf(member, member, None, member, about)]
        if not isinstance(about, PartOf):
            continue
        for kind in about.kinds.values():
            is_open = kind.kind in about.open_kinds
            for field, parameter in about.named(kind.parameters()).items():
                whole = f"{member}.{field}"
                leaf = Leaf(field if is_open else whole, member, kind, field, parameter)
                if is_open:
                    keys.setdefault(field, []).append(leaf)
                if not isinstance(about, Inline):
                    dotted.setdefault(whole, []).append(leaf)
            named = about.named(derived(kind)).items()
            following |= {f"{member}_{name}": quantity for name, quantity in named}
    coordinates: dict[str, Parameter] = {}
    for leaf in (leaf for leaves in (keys | dotted).values() for leaf in leaves):
        coordinates[coordinate(leaf.name)] = leaf.parameter
        if isinstance(leaf.parameter, Either):
            possible = leaf.parameter.coordinates(coordinate(leaf.name), None)
            coordinates |= {name: about for name, about, _ in possible}
    return keys | dotted, {**following, **coordinates, **derived(Draft)}


def base_names() -> tuple[str, ...]:
    """Return the keys that `base` may have: parts and single parameters."""
    return tuple(name for name in leaves() if "." not in name)


def parameter_names() -> tuple[str, ...]:
    """Return the names that may be varied: keys of `base`, ``roughness.amplitude`` and so on."""
    return tuple(leaves())


def member_of(name: str) -> str:
    """Return the member of a case that a name belongs to or denotes."""
    return leaves()[name][0].member if name in leaves() else name


def parameter_of(name: str) -> Parameter:
    """Return the parameter or the whole part with this name."""
    return leaves()[name][0].parameter


def replaced_by(name: str) -> set[str]:
    """Return the names that a new value of one replaces: ``radius`` by ``indenter``."""
    if name == MATERIAL:
        return {*PROPERTIES}
    member = member_of(name)
    if member in ("cycles", "blocks"):
        return {"cycles", "blocks"} - {name}
    about = members().get(member)
    if isinstance(about, Inline):
        kind = about.leading.get(name)
        return {*about.keys} - {*kind.parameters()} if kind else set()
    keys = {*about.keys} if about else set()
    return {member} if name in keys else keys


def coordinate(name: str) -> str:
    """Return the name of a parameter as a dataset coordinate.

    The load is ``normal_load`` there, because ``load`` is a method of datasets.
    """
    return "normal_load" if name == "load" else name.replace(".", "_")


def parameter(name: str) -> Parameter:
    """Return a parameter by its name in a study file or as a coordinate.

    An unknown name, such as a dimension that a user added, is taken to be a plain number.
    """
    plain = Quantity("1", name, name.replace("_", " "))
    return _tables()[1].get(coordinate(name), plain)


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


def html_table(caption: str, rows: Iterable[Sequence[str]]) -> str:
    """Return a table for notebooks, the first column in the type of code."""
    from html import escape

    left = "style='text-align:left'"
    lines = "".join(
        f"<tr><th {left}><code>{escape(name)}</code></th>"
        f"{''.join(f'<td {left}>{escape(cell)}</td>' for cell in others)}</tr>"
        for name, *others in rows
    )
    return f"<table><caption>{escape(caption)}</caption>{lines}</table>"


def read_values(
    raw: Mapping[str, object],
    prefix: str,
    problems: Problems,
    *,
    units_required: bool,
    varied: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> dict[str, Any]:
    """Read keys of `base`; return the valid values and collect the problems of the others.

    If some fields of a part are `varied`, only its other fields are read.
    """
    values: dict[str, object] = {}
    parameters = {name: parameter_of(name) for name in base_names()}
    for name, fields in varied.items():
        parameters[name] = replace(cast("PartOf", parameters[name]), varied=tuple(fields))
    for key, value in raw.items():
        with problems.at(place := f"{prefix}{key}", value):
            if key in parameters:
                whole_value = _with_keys_beside(parameters[key], value, raw)
                try:
                    values[key] = parameters[key].read_given(key, whole_value, units_required)
                except QuantityError as wrong:
                    is_range = isinstance(value, Mapping) and {*value} <= {"from", "to", "scale"}
                    if prefix and is_range and not isinstance(parameters[key], PartOf):
                        hint = f"a range belongs under vary, in a sampled design: vary.{key}"
                        raise QuantityError(wrong.rule or "is a range", hint) from wrong
                    is_list = prefix and isinstance(value, list) and "list" not in wrong.rule
                    if not is_list or wrong.hint or wrong.inside:
                        raise
                    hint = f"a list of values, each a case, belongs under vary: vary.{key}"
                    raise QuantityError(wrong.rule, hint) from wrong
                continue
            whole, _, part = key.partition(".")
            meant = (*parameters,)
            remedy = "fretwear schema lists all parameters"
            if key.casefold() in _NOT_MODELLED:
                remedy, meant = "leave it out: the model does not depend on it", ()
            if words := other_name(key):
                remedy, meant = f"write {words}", ()
            if key in section_names():
                remedy, meant = "it is a section of its own, beside base", ()
            if key in leaves():
                remedy, meant = f"write {whole}: {{{part}: ...}}", ()
            rule = "is not a case parameter"
            problems.append(Problem(place, value, rule, remedy, written=key, valid_words=meant))
    return values


def _with_keys_beside(about: object, value: object, raw: Mapping[str, object]) -> object:
    """Return the value of a part with its keys beside it, which are reported as redundant."""
    content = {"kind": value} if isinstance(value, str) else value
    if not isinstance(about, PartOf) or not isinstance(content, Mapping):
        return value
    kind = about.kinds.get(str(content.get("kind", "")))
    of_kind = {*kind.parameters()} if kind else set()
    beside = {name: raw[name] for name in about.keys if name in raw and name in of_kind}
    return {**beside, **content} if beside else value


def other_name(key: str) -> str:
    """Return the parameter that another word stands for, and what to write there; empty if none."""
    return ": ".join(filter(None, _OTHER_NAMES.get(key.casefold().replace(" ", "_"), ())))


def with_parts_of_distance(
    given: Mapping[str, object], varied: Iterable[str] = ()
) -> dict[str, object]:
    """Keys of a case with the cycles into which a sliding distance is divided, unless given."""
    names = {*given, *varied}
    divided = "sliding_distance" in names and not names & {"cycles", "blocks"}
    return {**given, "cycles": PARTS_OF_A_DISTANCE} if divided else dict(given)


def by_member(
    values: Mapping[str, _Value], given: Iterable[str] = ()
) -> dict[str, dict[str, _Value]]:
    """Return values by name, grouped by the member of the case to which they belong.

    A member that is incomplete without the blocks gets them too. Names ``given`` elsewhere count
    towards completeness.
    """
    grouped: dict[str, dict[str, _Value]] = {}
    for name, value in values.items():
        grouped.setdefault(member_of(name), {})[name] = value
    for member, about in IN_BLOCKS.items() if "blocks" in values else ():
        if about.kind_of(about.keys.keys() & {*values, *given}) is None:
            grouped.setdefault(member, {})["blocks"] = values["blocks"]
    return grouped


def make_member(member: str, values: Mapping[str, object]) -> object:
    """Make a member of a case from its values by name; `KeyError` if they are incomplete.

    Blocks among the values may complete them.
    """
    if member in values:
        value = values[member]
        return None if isinstance(value, Part) and value.is_trivial else value
    about, blocks = members()[member], cast("Sequence[Block]", values.get("blocks", ()))
    values = {name: value for name, value in values.items() if name != "blocks"}
    if blocks:
        values = IN_BLOCKS[member].completed(values, blocks)
    if part := cast("PartOf", about).make(values):
        return part
    raise KeyError(member)


def missing_parameters(given: Iterable[str], blocks: Sequence[Block] = ()) -> Iterator[Problem]:
    """Yield required keys that are missing, and alternative keys that exclude each other.

    Every key given counts, valid or not, and a misspelt key, or another name, stands for the one
    meant. Keys that all blocks give may be missing.
    """
    given = set(given)
    given |= {other_name(key).partition(":")[0] for key in given}
    for part in IN_BLOCKS.values():
        given |= part.completed(dict.fromkeys(given & part.keys.keys()), blocks).keys()
    unknown = [key for key in given if key not in parameter_names()]
    if {"cycles", "blocks"} <= given:
        rule = "is redundant: each block gives its cycles"
        yield Problem("cycles", None, rule, "give one of the two")
    for member, about in members().items():
        if member in given:
            for name in sorted(given.intersection(about.keys)):
                rule = f"is redundant: {member} is given too"
                remedy = f"write it inside {member}, beside its kind, as in {about.example}"
                yield Problem(name, None, rule, remedy)
            continue
        # Blocks that could not be read may give the member.
        unread = member in IN_BLOCKS and not (blocks or given.intersection(about.keys))
        if member not in required(Draft) or ("blocks" in given and (member == "cycles" or unread)):
            continue
        if isinstance(about, Inline):
            yield from about.broken(given, unknown)
        for name in about.shared if isinstance(about, PartOf) and about.keys else (member,):
            parts_given = any(key.startswith(f"{name}.") for key in given)
            misspelt = any(nearest(key, (name,)) for key in unknown)
            if name not in given and not parts_given and not misspelt:
                yield Problem(name, None, "is missing", parameter_of(name).such_as(name))


def schema_required() -> list[dict[str, object]]:
    """Return conditions of a JSON Schema for the keys required in `base` or `vary`."""
    conditions: list[dict[str, object]] = []
    for problem in missing_parameters(()):
        about = members()[member := member_of(problem.key)]
        names = [problem.key] if problem.key == member else [problem.key, member]
        if isinstance(about, Inline):
            names = [*about.leading] if problem.key in about.leading else [problem.key]
        names += ["blocks"] if member == "cycles" else []
        by_material = [MATERIAL] if problem.key in PROPERTIES else []
        places: list[dict[str, object]] = [
            {
                "anyOf": [
                    {"required": [section], "properties": {section: {"required": [key]}}}
                    for key in (*parameter_names(), *by_material)
                    for section in ("base", "vary")
                    if key in (name, _INSTEAD.get(name))
                    or (section == "vary" and key.startswith(f"{name}."))
                ]
            }
            for name in (*names, *by_material)
        ]
        condition = places[0]
        if len(places) > 1:
            condition = {"anyOf" if by_material else "oneOf": places}
        if member in IN_BLOCKS:
            all_give = {"items": {"anyOf": [{"required": [name]} for name in names]}}
            sections = {"base": all_give, "vary": {"items": all_give}}
            in_blocks = [
                {
                    "required": [section],
                    "properties": {section: {"required": ["blocks"], "properties": {"blocks": of}}},
                }
                for section, of in sections.items()
            ]
            condition = {"anyOf": [condition, *in_blocks]}
        conditions.append(condition)
    return conditions
