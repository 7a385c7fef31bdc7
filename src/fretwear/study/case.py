"""A case: everything that one simulation needs to know, validated, frozen, in SI units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from fretwear.parts import Plain, WholeNumber, is_list
from fretwear.study.members import PartOf
from fretwear.study.parameters import (
    DEFAULTS,
    by_member,
    html_table,
    make_member,
    missing,
    parameter,
    read_values,
    replaced_by,
    value_text,
)
from fretwear.study.problems import Problem, Problems
from fretwear.study.rules import findings
from fretwear.study.tree import MAX_CYCLES, CaseTree, members
from fretwear.units import QuantityError

_SNAPSHOTS = 8


@dataclass(frozen=True)
class Snapshots(Plain):
    """The cycles, besides 0 and the last, at which fields are kept; None for ``auto``."""

    cycle: ClassVar[WholeNumber] = WholeNumber(
        "$N$", "cycle", 0, MAX_CYCLES, 1000, description="A cycle at which the fields are kept."
    )

    example = "[0, 1000, 30000]"

    def read(self, value: object, units_required: bool) -> tuple[int, ...] | None:
        """Return the cycles; in a file, where values have units, each may occur only once."""
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
    """Parameters that do not make a valid case; `problems` lists everything that is wrong."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__(self.problems)

    def __str__(self) -> str:
        return "\n".join(str(problem) for problem in self.problems)


@dataclass(frozen=True, init=False)
class Case(CaseTree):
    """One contact, one loading, one number of cycles: what `simulate` takes.

    Values are SI numbers or text with a unit (``load="50 N"``); attributes are SI floats.  The
    parameters are those of `base` in a study file, and ``output_cycles``, the cycles besides 0 and
    the last at which fields are kept; by default (``auto``) about eight.

    The model is that of equal bodies or of bodies whose composite moduli E* and G* stand for
    both.  For two different materials the coupling of normal pressure and tangential
    displacement (Dundurs' β) is neglected.

    Raises
    ------
    CaseError
        If names are unknown, values wrong or rules broken; the message lists all of them.

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
        """Return the case made of members already read and checked; some may be missing."""
        case = object.__new__(cls)
        case.__dict__.update({**DEFAULTS, **_suited(assembled)})
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
            if isinstance(about, PartOf) and about.are_keys(value):
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

    By default they are the powers of ten and, up to eight in all, the largest of three times these.
    """
    if asked is None:
        powers = [10**n for n in range(len(str(cycles))) if 10**n < cycles]
        between = [3 * power for power in reversed(powers) if 3 * power < cycles]
        asked = [*powers, *between[: max(0, _SNAPSHOTS - 2 - len(powers))]]
    return tuple(sorted({0, cycles, *asked}))


def _suited(members: Mapping[str, Any]) -> Mapping[str, Any]:
    """Make members consistent: cycles of blocks, snapshots, loads per length."""
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
