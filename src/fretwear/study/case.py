"""A case: everything that one simulation needs to know, validated, frozen, in SI units."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any, Self

from fretwear.parts import Parameter, Part, WholeNumber, is_list, means_none, required
from fretwear.study.problems import Problem, Problems, UnreadError, nearest
from fretwear.study.rules import findings
from fretwear.study.tree import (
    MAX_CYCLES,
    CaseTree,
    Leaf,
    Member,
    base_names,
    example_of,
    kinds,
    leaves,
    leaves_of,
    member_of,
    members,
    parameter_names,
    parameter_of,
    part_named,
)
from fretwear.units import QuantityError

SNAPSHOT = WholeNumber(
    "$N$", "cycle", 0, MAX_CYCLES, 1000, description="A cycle at which the fields are kept."
)

_HARDNESS = "write plastic_limit: the pressure at which a surface yields is about the hardness"
_RA = (
    "write roughness: {kind: wavy, amplitude: ..., slope_x: ..., slope_y: ...}; Ra is 0.41 and Rq "
    "0.5 of this amplitude"
)
_OTHER_NAMES = {
    **dict.fromkeys(("hardness", "hv", "hb", "hrc", "vickers_hardness"), _HARDNESS),
    **dict.fromkeys(("ra", "rq", "sa", "sq", "rz", "rms_roughness"), _RA),
    "mu": "write friction",
    "stroke": "write displacement_amplitude: half of the stroke",
    "normal_load": "write load",
}
"""What tribologists may write instead of the name of a parameter, and what to do then."""

_SNAPSHOTS = 8
_DEFAULTED = tuple(each.name for each in fields(CaseTree) if each.name not in required(CaseTree))


class CaseError(ValueError):
    """Parameters that make no case; its `problems` tell everything that is wrong with them."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__(self.problems)

    def __str__(self) -> str:
        return "\n".join(str(problem) for problem in self.problems)


@dataclass(frozen=True, init=False)
class Case(CaseTree):
    """One contact, one loading, one number of cycles: what `simulate` takes.

    Values are SI numbers or text with a unit (``load="50 N"``); attributes are SI floats.  The
    parameters are those of `base` in a study file, and ``output_cycles``, the cycles whose fields
    are kept beside those of cycle 0 and the last; left out or ``auto``, about eight.

    The model is that of equal bodies or of bodies whose composite moduli E* and G* stand for
    both.  For two different materials the coupling of normal pressure and tangential
    displacement (Dundurs' β) is neglected.

    Raises
    ------
    CaseError
        With every name that is unknown, value that is wrong and rule that is broken.

    Examples
    --------
    >>> case = Case(radius="10 mm", youngs_modulus="208 GPa", poisson_ratio=0.3, load="50 N",
    ...             tangential_ratio=0.8, friction=0.5, wear_coefficient="7e-13 / Pa", cycles=1000)
    >>> round(case.hertz_radius * 1e6, 1)
    148.6
    """

    def __init__(self, **parameters: Any) -> None:
        given = {name: value for name, value in parameters.items() if value is not None}
        problems = Problems()
        snapshots = read_snapshots(given.pop("output_cycles", "auto"), "output_cycles", problems)
        values = read_values(given, "", problems, units_required=False)
        problems += missing(given, in_file=False)
        if problems:
            raise CaseError(problems)
        assembled = assemble(values)
        assembled["output_cycles"] = snapshots_of(snapshots, assembled["cycles"])
        super().__init__(**_suited(assembled))
        if broken := findings(self):
            raise CaseError(broken)

    @classmethod
    def of(cls, assembled: Mapping[str, Any]) -> Self:
        """Return the case of members that have been read and checked; some may be missing."""
        case = object.__new__(cls)
        defaults = {name: getattr(CaseTree, name) for name in _DEFAULTED}
        case.__dict__.update({**defaults, **_suited(assembled)})
        return case

    def _repr_html_(self) -> str:
        """Return a table of the parameters, for notebooks."""
        from html import escape

        from fretwear.study.parameters import parameter, value_text

        rows = [
            f"<tr><th style='text-align:left'><code>{escape(name)}</code></th>"
            f"<td style='text-align:left'>{escape(parameter(name).words)}</td>"
            f"<td style='text-align:left'>{escape(value_text(name, value))}</td></tr>"
            for name, (value, *_) in self.scalar_coordinates().items()
        ]
        return f"<table><caption>{escape(self.case_id)}</caption>{''.join(rows)}</table>"

    def replace(self, **changes: Any) -> Case:
        """Return the case with other values of some parameters: ``case.replace(load="60 N")``."""
        kept: dict[str, Any] = {}
        for name, about in members().items():
            value = getattr(self, name)
            if isinstance(about, Parameter) or value is None:
                kept[name] = value
            elif about.inline or value.kind == about.short:
                given = {leaf.name: vars(value)[leaf.field] for leaf in leaves_of(type(value))}
                # Another kind may take the place of this one; what both have in common stays.
                of_new = [kind for lead, (_, kind) in _leading(name).items() if lead in changes]
                stays = _names_of(of_new[0]) if of_new else given.keys()
                kept |= {each: given[each] for each in given if each in stays}
            else:
                kept[name] = value
        # Blocks have cycles of their own.
        del kept["cycles" if self.blocks and "cycles" not in changes else "blocks"]
        if self.output_cycles != snapshots_of(None, self.cycles):
            # The last cycle may become another one.
            kept["output_cycles"] = self.output_cycles[:-1]
        return Case(**{**kept, **changes})


def snapshots_of(asked: Iterable[int] | None, cycles: int) -> tuple[int, ...]:
    """Return the snapshots in order, each once, with cycle 0 and the last among them.

    Where none are asked for, they are the powers of ten and, as long as they are not eight in all,
    the largest of three times these.
    """
    if asked is None:
        powers = [10**n for n in range(len(str(cycles))) if 10**n < cycles]
        between = [3 * power for power in reversed(powers) if 3 * power < cycles]
        asked = [*powers, *between[: max(0, _SNAPSHOTS - 2 - len(powers))]]
    return tuple(sorted({0, cycles, *asked}))


def _suited(assembled: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the members of a case, the loads of a line contact per length."""
    indenter = assembled.get("indenter")
    if indenter is None or not indenter.is_line:
        return assembled
    loads = {name: part for name in ("normal", "loading") if (part := assembled.get(name))}
    return {**assembled, **{name: part.in_line() for name, part in loads.items()}}


def such_as(name: str) -> str:
    """Return an example for a name, "such as load: 50 N", or nothing."""
    if not (example := example_of(name)):
        return ""
    can_be_none = parameter_of(name) is None and part_named(name).none
    return f"such as {name.rpartition('.')[2]}: {example}" + (", or none" if can_be_none else "")


def read_values(
    raw: Mapping[str, Any], prefix: str, problems: Problems, *, units_required: bool
) -> dict[str, Any]:
    """Read keys as `base` has them; return the sound values, add what is wrong with the others."""
    values: dict[str, Any] = {}
    for key, value in raw.items():
        with problems.at(place := f"{prefix}{key}", value):
            if key in base_names():
                values[key] = read_value(key, value, place, problems, units_required=units_required)
                continue
            whole, _, part = key.partition(".")
            remedy = _OTHER_NAMES.get(key.casefold().replace(" ", "_"), "")
            if key in leaves():
                remedy = f"write {whole}: {{{part}: ...}}"
            known = () if remedy else base_names()
            rule = "is not a case parameter"
            problems.append(Problem(place, value, rule, remedy, written=key, known=known))
    return values


def read_value(
    name: str, raw: object, key: str, problems: Problems, *, units_required: bool = True
) -> Any:
    """Read the value of a parameter or of a whole part, as in a file or (units apart) in Python.

    What is wrong with it is a `QuantityError`; what is wrong inside of a part is added to the
    problems, under the key of the part, and an `UnreadError` ends the reading.
    """
    parameter = parameter_of(name)
    if raw is None and units_required:
        none = part_named(name).none if parameter is None else getattr(parameter, "infinite", "")
        hint = f"write {name}: none if that is meant" if none else such_as(name)
        raise QuantityError("has no value", hint)
    if parameter is None:
        return _read_part(name, raw, key, problems, units_required)
    return parameter.read(raw, units_required)


def read_snapshots(raw: object, key: str, problems: Problems) -> tuple[int, ...] | None:
    """Read a list of cycles; return the sound ones, None for auto."""
    if raw == "auto":
        return None
    cycles = []
    with problems.at(key, raw):
        if not is_list(raw):
            raise QuantityError("must be auto, or a list such as [0, 1000, 30000]")
        for position, value in enumerate(raw):
            with problems.at(f"{key}[{position}]", value):
                cycles.append(SNAPSHOT.read(value, True))
    return tuple(cycles)


def _read_part(member: str, raw: object, key: str, problems: Problems, units_required: bool) -> Any:
    about, of_kind = part_named(member), {kind.kind: kind for kind in kinds(member)}
    bare = [name for name, kind in of_kind.items() if not required(kind)]
    if isinstance(raw, tuple(of_kind.values())):
        return raw
    if about.none and means_none(raw, units_required):
        return None
    if isinstance(raw, str) and raw in bare:
        raw = {"kind": raw}
    if not isinstance(raw, Mapping):
        whole = f"{'an' if member[0] in 'aeiou' else 'a'} {member}"
        choices = bare or [*(["none"] if about.none else []), whole]
        raise QuantityError(f"must be {' or '.join(choices)}", such_as(member), bare)
    before, values = len(problems), dict[str, Any]()
    with problems.at(f"{key}.kind", name := raw.get("kind", next(iter(of_kind)))):
        if name not in list(of_kind):
            raise QuantityError(f"must be {' or '.join(of_kind)}", "", [*of_kind])
        kind = of_kind[name]
        for field, parameter in kind.parameters().items():
            with problems.at(f"{key}.{field}", raw.get(field)):
                if field in raw:
                    values[field] = parameter.read(raw[field], units_required)
                elif field in required(kind):
                    raise QuantityError("is missing", such_as(f"{member}.{field}"))
        problems.unknown(key, raw, ["kind", *kind.parameters()])
    if len(problems) > before:
        raise UnreadError
    part = kind.unchecked(**values)
    if part.problem is not None:
        problems.append(Problem(key, None, *part.problem))
        raise UnreadError
    return part


def assemble(values: Mapping[str, Any]) -> dict[str, Any]:
    """Make the members of a case of values by name; members that lack a value are left out."""
    assembled: dict[str, Any] = {}
    for member, about in members().items():
        own = {name: value for name, value in values.items() if member_of(name) == member}
        if member in own:
            value = own[member]
            assembled[member] = None if isinstance(value, Part) and value.is_trivial else value
        elif own:
            assert isinstance(about, Member)
            part = _part_of(member, own)
            if part is not None:
                assembled[member] = part
    if blocks := assembled.get("blocks"):
        assembled["cycles"] = sum(block.cycles for block in blocks)
        if len(blocks) == 1 and not blocks[0].values:
            del assembled["blocks"]
    return assembled


def _part_of(member: str, values: Mapping[str, Any]) -> Part | None:
    """Make a part of the values of its parameters by name; None where they make none."""
    for kind in kinds(member):
        by_name = {leaf.name: leaf.field for leaf in leaves_of(kind)}
        given = {by_name[name]: value for name, value in values.items() if name in by_name}
        if len(given) == len(values) and required(kind) <= set(given):
            return kind.unchecked(**given)
    return None


def missing(given: Iterable[str], *, in_file: bool) -> Iterator[Problem]:
    """Yield what has to be given and is not, and which of alternative keys are too many.

    All that is given counts, sound or not, and a misspelt key stands for the one that is meant.
    In a file some of what has a default in Python must be written.
    """
    given = set(given)
    unknown = [key for key in given if key not in parameter_names()]
    if {"cycles", "blocks"} <= given:
        rule = "is one too many: blocks have cycles of their own"
        yield Problem("cycles", None, rule, "give one of the two")
    for member, about in members().items():
        wanted: Iterable[str] = (member,)
        if (
            (member == "cycles" and "blocks" in given)
            or member in given
            or (member in _DEFAULTED and not (in_file and about.must_be_written))
        ):
            wanted = ()
        elif isinstance(about, Member) and about.inline:
            yield from _alternatives_broken(member, given, unknown)
            chosen = _chosen_kind(member, given)
            telling = member_alternatives(member)
            needed = [leaf.name for leaf in leaves_of(chosen) if leaf.field in required(chosen)]
            wanted = [name for name in needed if name not in telling]
        elif isinstance(about, Member) and about.short:
            short = next(kind for kind in kinds(member) if kind.kind == about.short)
            wanted = [leaf.name for leaf in leaves_of(short)]
        if isinstance(about, Member) and member in given:
            own = {leaf.name for kind in kinds(member) for leaf in leaves_of(kind)}
            for name in sorted(name for name in own & given if "." not in name):
                rule = f"is one too many: {member} is given as well"
                yield Problem(name, None, rule, "give one of the two")
        for name in wanted:
            parts_given = any(each.startswith(f"{name}.") for each in given)
            misspelt = any(nearest(key, (name,)) for key in unknown)
            if name not in given and not parts_given and not misspelt:
                yield Problem(name, None, "is missing", such_as(name))


def _names_of(kind: type[Part]) -> set[str]:
    return {leaf.name for leaf in leaves_of(kind)}


def member_alternatives(member: str) -> set[str]:
    """Return the keys that tell the kinds of a part apart."""
    if isinstance(members()[member], Parameter):
        return set()
    names = [_names_of(kind) for kind in kinds(member)]
    common = names[0].intersection(*names)
    return set().union(*names) - common


def _leading(member: str) -> dict[str, tuple[Leaf, type[Part]]]:
    """The first key of each kind that has to be given for it and for no other, by name."""
    found: dict[str, tuple[Leaf, type[Part]]] = {}
    telling = member_alternatives(member)
    for kind in kinds(member) if telling else ():
        for leaf in leaves_of(kind):
            if leaf.name in telling and leaf.field in required(kind):
                found.setdefault(leaf.name, (leaf, kind))
                break
    return found


def _chosen_kind(member: str, given: set[str]) -> type[Part]:
    chosen = (kind for name, (_, kind) in _leading(member).items() if name in given)
    return next(chosen, kinds(member)[0])


def _alternatives_broken(member: str, given: set[str], unknown: list[str]) -> Iterator[Problem]:
    """Find whether the keys of several kinds of a part are given, of none, or of another one."""
    leading = _leading(member)
    touched = [name for name in leading if name in given]
    if len(touched) > 1:
        symbol = leading[touched[0]][0].parameter.symbol.replace("$", "")
        symbol = symbol.replace("Q/µP", "Q/(µP)")
        rule = f"is one too many: {touched[0]}, {symbol}, is given as well"
        for name in touched[1:]:
            yield Problem(name, None, rule, "give exactly one of the two")
    elif leading and not touched and not any(nearest(key, [*leading]) for key in unknown):
        first, *others = leading
        examples = [f"{name}: {leaf.parameter.example}" for name, (leaf, _) in leading.items()]
        rule = f"is missing, and so is {' and '.join(others)}"
        yield Problem(first, None, rule, f"give exactly one of {' and '.join(examples)}")
    if len(touched) == 1:
        own = _names_of(leading[touched[0]][1])
        for name in sorted((member_alternatives(member) - own - {*leading}) & given):
            needed = [lead for lead, (_, kind) in leading.items() if name in _names_of(kind)]
            rule = f"has no meaning with {touched[0]}"
            yield Problem(name, None, rule, f"it belongs to {' or '.join(needed)}")


def schema_of(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a value in a study file: of a parameter, or of a whole part."""
    if (parameter := parameter_of(name)) is not None:
        return parameter.described()
    about, bare = part_named(name), [kind.kind for kind in kinds(name) if not required(kind)]
    choices: list[dict[str, Any]] = [{"const": "none"}] if about.none else []
    choices += [{"enum": bare}] if bare else []
    for kind in kinds(name):
        described = {leaf.field: leaf.parameter.described() for leaf in leaves_of(kind)}
        choices.append(
            {
                "type": "object",
                "additionalProperties": False,
                "properties": {"kind": {"const": kind.kind}, **described},
            }
        )
    return {"description": about.description, "anyOf": choices}


def schema_required() -> list[dict[str, Any]]:
    """Return what has to stand in `base` or be varied, as conditions of a JSON Schema."""
    conditions = []
    for problem in missing((), in_file=True):
        leading = _leading(member_of(problem.key))
        names = [name for name in base_names() if name in leading] or [problem.key]
        short = [name for name in (member_of(problem.key),) if name in base_names()]
        places = [_given(name) for name in dict.fromkeys([*names, *short])]
        conditions.append({"oneOf": places} if len(places) > 1 else places[0])
    return conditions


def _given(name: str) -> dict[str, Any]:
    """A parameter, or a part of it, stands in base or in vary."""
    parts = [each for each in parameter_names() if each == name or each.startswith(f"{name}.")]
    places = [("base", name), *(("vary", part) for part in parts)]
    return {
        "anyOf": [
            {"required": [section], "properties": {section: {"required": [key]}}}
            for section, key in places
        ]
    }
