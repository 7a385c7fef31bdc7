"""A case: everything that one simulation needs to know, validated, frozen, in SI units."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from types import MappingProxyType
from typing import Any, ClassVar, Self, cast

from fretwear.parts import Part, Plain, WholeNumber, is_list
from fretwear.study.members import Inline, PartOf, fields_are_keys
from fretwear.study.parameters import (
    base_names,
    html_table,
    leaves,
    member_of,
    parameter,
    parameter_names,
    parameter_of,
    replaced_by,
    value_text,
)
from fretwear.study.problems import Problem, Problems, nearest
from fretwear.study.rules import findings
from fretwear.study.tree import MAX_CYCLES, CaseTree, members
from fretwear.units import QuantityError

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
_DEFAULTS = {each.name: each.default for each in fields(CaseTree) if each.default is not MISSING}


@dataclass(frozen=True)
class Snapshots(Plain):
    """The cycles at which the fields are kept, beside 0 and the last: None for ``auto``."""

    cycle: ClassVar[WholeNumber] = WholeNumber(
        "$N$", "cycle", 0, MAX_CYCLES, 1000, description="A cycle at which the fields are kept."
    )

    @property
    def example(self) -> str:
        """A sensible value as a study file would have it."""
        return "[0, 1000, 30000]"

    def read(self, value: object, units_required: bool) -> tuple[int, ...] | None:
        """Return the cycles; a file, where values have units, tells each once."""
        if value == "auto":
            return None
        if not is_list(value):
            raise QuantityError(f"must be auto, or a list such as {self.example}")
        problems, cycles = Problems(), list[int]()
        for position, each in enumerate(value):
            with problems.at(f"[{position}]", each):
                cycles.append(self.cycle.read(each, True))
                if units_required and cycles[-1] in cycles[:-1]:
                    raise QuantityError("is given twice")
        problems.raise_any()
        return tuple(cycles)

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""
        cycles = {"type": "array", "items": self.cycle.described()}
        return {"default": "auto", "anyOf": [{"const": "auto"}, cycles]}


SNAPSHOTS = Snapshots(
    "",
    "snapshots",
    description="Cycles at which the fields are kept, beside 0 and the last; auto: about eight, "
    "powers of ten and three times these.",
)


class CaseError(ValueError):
    """Parameters that make no case; its `problems` list everything that is wrong with them."""

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
        asked, snapshots = given.pop("output_cycles", "auto"), None
        with problems.at("output_cycles", asked):
            snapshots = SNAPSHOTS.read(asked, False)
        values = read_values(given, "", problems, units_required=False)
        problems += missing(given, in_file=False)
        if problems:
            raise CaseError(problems)
        own = by_member({**values, "output_cycles": snapshots})
        super().__init__(**_suited({name: make_member(name, own[name]) for name in own}))
        if broken := findings(self):
            raise CaseError(broken)

    @classmethod
    def of(cls, assembled: Mapping[str, Any]) -> Self:
        """Return the case of members that have been read and checked; some may be missing."""
        case = object.__new__(cls)
        case.__dict__.update({**_DEFAULTS, **_suited(assembled)})
        return case

    def _repr_html_(self) -> str:
        """Return a table of the parameters, for notebooks."""
        known = self.scalar_coordinates().items()
        rows = ((n, parameter(n).words, value_text(n, value)) for n, (value, *_) in known)
        return html_table(self.case_id, rows)

    def replace(self, **changes: Any) -> Case:
        """Return the case with other values of some parameters: ``case.replace(load="60 N")``."""
        kept: dict[str, Any] = {}
        for member, about in members().items():
            value = getattr(self, member)
            given = {member: value}
            if fields_are_keys(about, value):
                given = {name: vars(value)[name] for name in value.parameters()}
            kept |= given
        # Blocks have cycles of their own.
        del kept["cycles" if self.blocks else "blocks"]
        for other in {other for name in changes for other in replaced_by(name)}:
            kept.pop(other, None)
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


def _suited(members: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return members that suit each other: cycles of blocks, snapshots, loads per length."""
    suited = dict(members)
    if blocks := members.get("blocks"):
        suited["cycles"] = sum(block.cycles for block in blocks)
        suited["blocks"] = blocks if len(blocks) > 1 or blocks[0].values else ()
    if "cycles" in suited:
        suited["output_cycles"] = snapshots_of(members.get("output_cycles"), suited["cycles"])
    if getattr(members.get("indenter"), "is_line", False):
        loads = {name: members[name] for name in ("normal", "loading") if name in members}
        suited |= {name: part.in_line() for name, part in loads.items()}
    return suited


def read_values(
    raw: Mapping[str, Any],
    prefix: str,
    problems: Problems,
    *,
    units_required: bool,
    varied: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> dict[str, Any]:
    """Read keys as `base` has them; return the valid values, add what is wrong with the others.

    Of parts of which some fields are `varied` the others are read.
    """
    values: dict[str, Any] = {}
    known = base_names()
    for key, value in raw.items():
        with problems.at(place := f"{prefix}{key}", value):
            if key in known:
                fields = varied.get(key, ())
                values[key] = read_value(key, value, fields, units_required=units_required)
                continue
            whole, _, part = key.partition(".")
            remedy = _OTHER_NAMES.get(key.casefold().replace(" ", "_"), "")
            if key in leaves():
                remedy = f"write {whole}: {{{part}: ...}}"
            rule, meant = "is not a case parameter", () if remedy else known
            problems.append(Problem(place, value, rule, remedy, written=key, known=meant))
    return values


def read_value(
    name: str, raw: object, varied: Sequence[str] = (), *, units_required: bool = True
) -> Any:
    """Read the value of a parameter or of a whole part, as in a file or (units apart) in Python.

    What is wrong with it is a `QuantityError`, what is wrong inside of a part an `UnreadError`.
    """
    parameter = parameter_of(name)
    if raw is None and units_required:
        can_be_none = getattr(parameter, "none", "") or getattr(parameter, "infinite", "")
        remedy = f"write {name}: none if that is meant" if can_be_none else parameter.such_as(name)
        raise QuantityError("has no value", remedy)
    if varied and isinstance(parameter, PartOf):
        return parameter.read_partly(raw, varied)
    return parameter.read(raw, units_required)


def by_member(values: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return values by name, those of each member of a case together."""
    found: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        found.setdefault(member_of(name), {})[name] = value
    return found


def make_member(member: str, values: Mapping[str, Any]) -> Any:
    """Make a member of a case of its values by name; a `KeyError` tells that they make none."""
    if member in values:
        value = values[member]
        return None if isinstance(value, Part) and value.is_trivial else value
    if part := cast("PartOf | Inline", members()[member]).make(values):
        return part
    raise KeyError(member)


def missing(given: Iterable[str], *, in_file: bool) -> Iterator[Problem]:
    """Yield what has to be given and is not, and which of alternative keys are too many.

    All that is given counts, valid or not, and a misspelt key stands for the one that is meant.
    In a file some of what has a default in Python must be written.
    """
    given = set(given)
    unknown = [key for key in given if key not in parameter_names()]
    if {"cycles", "blocks"} <= given:
        rule = "is redundant: blocks have cycles of their own"
        yield Problem("cycles", None, rule, "give one of the two")
    for member, about in members().items():
        instead = about.keys if isinstance(about, PartOf) else ()
        if member in given:
            for name in sorted(given.intersection(instead)):
                rule = f"is redundant: {member} is given too"
                yield Problem(name, None, rule, "give one of the two")
            continue
        if member == "cycles" and "blocks" in given:
            continue
        if member in _DEFAULTS and not (in_file and about.must_be_written):
            continue
        wanted: Iterable[str] = instead or (member,)
        if isinstance(about, Inline):
            yield from about.broken(given, unknown)
            wanted = about.needed(given)
        for name in wanted:
            parts_given = any(each.startswith(f"{name}.") for each in given)
            misspelt = any(nearest(key, (name,)) for key in unknown)
            if name not in given and not parts_given and not misspelt:
                yield Problem(name, None, "is missing", parameter_of(name).such_as(name))


def schema_required() -> list[dict[str, Any]]:
    """Return what has to stand in `base` or be varied, as conditions of a JSON Schema."""
    conditions = []
    for problem in missing((), in_file=True):
        about, names = members()[member := member_of(problem.key)], [problem.key]
        if isinstance(about, Inline) and problem.key in about.leading:
            names = [*about.leading]
        elif isinstance(about, PartOf) and member != problem.key:
            names.append(member)
        places = [_given(name) for name in names]
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
