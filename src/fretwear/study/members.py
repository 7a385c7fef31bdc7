"""How a part belongs to a case: under its key, by its fields as keys, or in blocks."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import cast

from fretwear.parts import (
    Choice,
    Coordinates,
    Parameter,
    Part,
    Plain,
    Quantity,
    Schema,
    WholeNumber,
    derived,
    is_list,
    keys_schema,
    means_none,
    read_fields,
    required,
)
from fretwear.problems import Problem, Problems, in_words
from fretwear.units import QuantityError, listed, nearest

_CYCLES = "cycles"
_OTHER_KINDS = {
    "sphere": "ball",
    "cylinder": "roller line",
    "wavy": "sinusoidal sine waves",
    "self_affine": "fractal gaussian random",
    "measured": "file scan",
    "latin_hypercube": "lhs latin random monte_carlo",
    "grid": "factorial full_factorial product",
    "zip": "paired",
}
"""Words that users may write for a kind of a part."""

_MATHTEXT = re.compile(r"\$|\\mathrm|[{}_]")


@dataclass(frozen=True)
class PartOf(Parameter):
    """A part under its own key: a mapping ``{kind: ..., ...}``, or the name of a kind."""

    family: type[Part]
    words: str = ""
    short: str = ""  # the kind whose fields may be given as keys of the case instead
    # The word for a case without the part, such as "smooth"; empty if the part is required.
    none: str = ""
    example: str = ""
    description: str = ""
    is_second: bool = False  # second part of its family, whose name its parameters bear
    may_be_partial: bool = True  # whether some fields may be given elsewhere, such as varied ones
    varied: tuple[str, ...] = ()  # the varied fields, which are not read with the others

    si_unit = "1"

    @property
    def symbol(self) -> str:  # type: ignore[override]
        return self.words  # a part has no symbol

    @property
    def kinds(self) -> Mapping[str, type[Part]]:
        """The kinds of the part by name, the usual one first."""
        return self.family.kinds()

    @property
    def open_kinds(self) -> Mapping[str, type[Part]]:
        """The kinds, by name, whose fields may be keys of the case instead."""
        return {self.short: self.kinds[self.short]} if self.short else {}

    @property
    def keys(self) -> Mapping[str, Parameter]:
        kinds = self.open_kinds.values()
        return {name: about for kind in kinds for name, about in kind.parameters().items()}

    @property
    def shared(self) -> list[str]:
        """The keys that every kind requires."""
        kinds = self.open_kinds.values()
        return [name for name in self.keys if all(name in required(kind) for kind in kinds)]

    def are_keys(self, value: Part | None) -> bool:
        """Whether the fields of a part, as keys of the case, specify it completely."""
        return value is not None and value.kind == self.short

    def kind_of(self, keys: Set[str], kinds: Iterable[type[Part]] = ()) -> type[Part] | None:
        """Return the first kind that has all of the keys and requires no others."""
        for kind in kinds or self.open_kinds.values():
            if required(kind) <= keys <= kind.parameters().keys():
                return kind
        return None

    def make(self, values: Mapping[str, object], kinds: Iterable[type[Part]] = ()) -> Part | None:
        """Make a part of the kind that has all of these keys; None if there is none."""
        kind = self.kind_of(values.keys(), kinds)
        return None if kind is None else kind.unchecked(**values)

    def named(self, parameters: Mapping[str, Parameter]) -> Mapping[str, Parameter]:
        """Parameters of a kind by name; their words mention a second part of the family."""
        named = dict(parameters)
        for name, about in parameters.items() if self.is_second else ():
            words = re.sub("roughness|surface", self.words, about.words)
            words = words if self.words in words else f"{words} of the {self.words}"
            named[name] = about.called(words)
        return named

    def such_as(self, name: str) -> str:
        text = super().such_as(name)
        return f"{text}, or none" if text and self.none else text

    def read(self, value: object, units_required: bool) -> Part | None:
        """Return a part; one error lists all problems inside it."""
        if isinstance(value, self.family):
            return value
        if self.none and not self.varied and means_none(value, units_required):
            return None
        if isinstance(value, str) and value in self.kinds:
            value = {"kind": value}
        # Varied fields tell the kind of the others.
        usual = [*self.kinds.values()]
        usual = [kind for kind in usual if {*self.varied} <= kind.parameters().keys()] or usual
        lacking = required(usual[0]).difference(self.varied)
        if self.varied and (not isinstance(value, Mapping) or (lacking and not value)):
            whole = self.words.replace(" ", "_")
            what = f"the other parts of the {whole}, because {whole}.{self.varied[0]} is varied"
            remedy = f"such as {whole}: {usual[0].such(lacking)}"
            problem = Problem("", value or None, f"must give {what}", remedy)
            raise QuantityError(problem.rule, inside=[problem])
        if not isinstance(value, Mapping):
            whole = f"{'an' if self.words[0] in 'aeiou' else 'a'} {self.words}"
            names = [*self.kinds] if any(not required(kind) for kind in self.kinds.values()) else []
            choices = names or [*(["none"] if self.none else []), whole]
            remedy = self.such_as(self.words)
            if self.none and value in (0, self.none):
                remedy = f"write none for {self.none} bodies"
            elif meant := self._meant(value):
                remedy = f"such as {self.words}: {meant.such(required(meant))}"
                remedy = remedy if required(meant) else f"did you mean {meant.kind!r}?"
                names = []
            raise QuantityError(f"must be {listed(choices, 'or')}", remedy, names)
        name = value.get("kind", usual[0].kind)
        if name not in [*self.kinds]:
            rule, meant = f"must be {listed(self.kinds, 'or')}", self._meant(name)
            remedy = f"did you mean {meant.kind!r}?" if meant else ""
            words = () if meant else (*self.kinds,)
            raise QuantityError(rule, inside=[Problem(".kind", name, rule, remedy, None, words)])
        kind = self.kinds[name]
        self._check_kind(value, kind, usual)
        fields = {"kind": Choice("", "", (name,)), **kind.parameters()}
        needed = required(kind).difference(self.varied)
        if len(needed) > 1 and not {*value} - {"kind"}:
            such = f"such as {self.words.replace(' ', '_')}: {kind.such(needed)}"
            rule = f"needs {listed([n for n in kind.parameters() if n in needed])}"
            raise QuantityError("", inside=[Problem("", kind.kind, rule, such)])
        part = kind.unchecked(**read_fields(value, fields, needed, units_required))
        if not self.varied and part.problem is not None:
            raise QuantityError("", inside=[Problem("", None, *part.problem)])
        return part

    def _check_kind(
        self, given: Mapping[str, object], kind: type[Part], kinds: Iterable[type[Part]]
    ) -> None:
        """Raise an error if a mapping has keys of another kind, and no others."""
        keys = [name for name in given if name != "kind"]
        other = next((meant for meant in kinds if {*keys} <= meant.parameters().keys()), kind)
        foreign = [name for name in keys if name not in kind.parameters()]
        is_complete = "kind" in given and required(kind) <= {*keys}
        if not foreign or other is kind or is_complete:
            return
        belong = f"{listed(foreign)} belong{'' if foreign[1:] else 's'} to kind {other.kind}"
        rule = f"is not of kind {kind.kind}" if "kind" in given else "lacks its kind"
        remedy = f"write {other.such(required(other) | {*keys}, given)}"
        raise QuantityError("", inside=[Problem("", given, f"{rule}: {belong}", remedy)])

    def _meant(self, word: object) -> type[Part] | None:
        """The kind that people also call by a word, if any."""
        called = in_words(word).casefold().replace(" ", "_")
        meant = (n for n in self.kinds if called in _OTHER_KINDS.get(n, "").split())
        return self.kinds.get(next(meant, ""))

    def schema(self) -> Schema:
        choices: list[Schema] = [{"const": "none"}] if self.none else []
        bare = [name for name, kind in self.kinds.items() if not required(kind)]
        choices += [{"enum": bare}] if bare else []
        for name, kind in self.kinds.items():
            named = self.named(kind.parameters()).items()
            fields = {field: about.described() for field, about in named}
            needed = [] if self.may_be_partial else sorted(required(kind))
            needed = ["kind", *needed] if needed else []
            choices.append(keys_schema({"kind": {"const": name}, **fields}, needed))
        return {"anyOf": choices}

    def canonical(self, value: Part | None) -> object:
        """Return the mapping, or the name of a kind without fields; None without a part."""
        return None if value is None else value.under_key

    def coordinates(self, name: str, value: Part | None) -> Coordinates:
        """Yield the coordinates of the fields; zero without a part."""
        kind = next(iter(self.kinds.values())) if value is None else type(value)
        parameters = self.named(kind.parameters())
        if value is not None:
            if not parameters:
                yield name, self, value.kind
            for field, about in self.named(derived(kind)).items():
                yield from about.coordinates(f"{name}_{field}", getattr(value, field))
        for field, about in parameters.items():
            number = about.absent if value is None else vars(value)[field]
            if number is not None:
                key = field if kind.kind == self.short else f"{name}_{field}"
                yield from about.coordinates(key, number)

    def word_for(self, value: object) -> str:
        """Return the short form of a part given as text: ``{kind: wavy, amplitude: 0.3 um}``."""
        if value == "none":
            return self.none
        if isinstance(value, str) and value in self.kinds:
            return self.kinds[value].caption or value
        fields = [
            f"{_MATHTEXT.sub('', about.symbol)} = {match[1]}"
            for kind in self.kinds.values()
            for field, about in kind.parameters().items()
            if (match := re.search(rf"\b{field}: ([^,}}]+)", str(value)))
        ]
        text = ", ".join(dict.fromkeys(fields)) or str(value)
        return re.sub(r"\bum\b", "µm", text.replace(" deg", "°"))


class Inline(PartOf):
    """A part whose fields are keys of the case; the keys given decide its kind.

    If there are several kinds, each has a leading key that identifies it.
    """

    @property
    def open_kinds(self) -> Mapping[str, type[Part]]:
        return self.kinds

    def are_keys(self, value: Part | None) -> bool:
        return value is not None

    @property
    def leading(self) -> dict[str, type[Part]]:
        """The kinds by their leading key, the first required one that not all kinds have."""
        leading: dict[str, type[Part]] = {}
        common = set.intersection(*({*kind.parameters()} for kind in self.kinds.values()))
        for kind in self.kinds.values():
            keys = [name for name in kind.parameters() if name in required(kind) - common]
            leading |= {name: kind for name in keys[:1] if name not in leading}
        return leading

    def changed(self, part: Part, given: dict[str, object]) -> Part | None:
        """Return the part with other values of some fields, of another kind if these need it."""
        for kind in (type(part), *self.kinds.values()):
            common = kind.parameters().keys() & vars(part).keys()
            fields = {name: vars(part)[name] for name in common} | given
            if changed := self.make(fields, [kind]):
                return changed
        return None

    def completed(
        self, values: Mapping[str, object], blocks: Sequence[Block]
    ) -> Mapping[str, object]:
        """Return values completed from the first block, if every block gives what they lack.

        Only required values are completed: a block without an optional one has its default.
        """
        given = [{n: v for n, v in block.values if n in self.keys} for block in blocks]
        kinds = [self.kind_of(values.keys() | fields.keys()) for fields in given]
        if self.kind_of(values.keys()) or not kinds or None in kinds:
            return values
        lacking = required(cast("type[Part]", kinds[0])) - values.keys()
        return {**values, **{name: given[0][name] for name in lacking}}

    def broken(self, given: set[str], unknown: list[str]) -> Iterator[Problem]:
        """Yield problems if the keys of no kind, or of several kinds, are given."""
        leading = self.leading
        touched = [name for name in leading if name in given]
        for name in touched[1:]:
            symbol = self.keys[touched[0]].symbol.strip("$").replace("Q/µP", "Q/(µP)")
            rule = f"is redundant: {touched[0]}, {symbol}, is given too"
            yield Problem(name, None, rule, "give exactly one of the two")
        if leading and not touched and not any(nearest(key, [*leading]) for key in unknown):
            first, *others = leading
            examples = [f"{name}: {self.keys[name].example}" for name in leading]
            rule = f"is missing, and so {'are' if others[1:] else 'is'} {listed(others)}"
            yield Problem(first, None, rule, f"give exactly one of {listed(examples)}")
        if len(touched) == 1:
            foreign = self.keys.keys() - leading[touched[0]].parameters().keys() - leading.keys()
            for name in sorted(foreign & given):
                needed = [lead for lead, kind in leading.items() if name in kind.parameters()]
                rule = f"has no meaning with {touched[0]}"
                yield Problem(name, None, rule, f"it belongs to {listed(needed, 'or')}")


@dataclass(frozen=True)
class Block:
    """A number of cycles with other values of some parameters, in SI units."""

    cycles: int
    values: tuple[tuple[str, object], ...] = ()


@dataclass(frozen=True)
class Blocks(Plain):
    """A list of blocks; consecutive blocks with the same values are merged."""

    parts: tuple[Inline, ...]  # parts that a block may change
    number: WholeNumber  # of cycles

    example = "[{cycles: 2000, tangential_ratio: 0.5}, {cycles: 5000, tangential_ratio: 0.9}]"

    def read(self, value: object, units_required: bool) -> tuple[Block, ...]:
        if not is_list(value) or not value:
            raise QuantityError("must be a list of blocks", self.example)
        problems, blocks = Problems(), list[Block]()
        for position, block in enumerate(value):
            with problems.at(f"[{position}]", block):
                if isinstance(block, Mapping):
                    rule = "is a key that a block cannot change"
                    values = read_fields(block, self.fields, (_CYCLES,), units_required, rule)
                    block = Block(values.pop(_CYCLES), tuple(sorted(values.items())))
                elif not isinstance(block, Block):
                    raise QuantityError("must be a block", self.example)
                same = blocks and blocks[-1].values == block.values
                earlier = blocks.pop().cycles if same else 0
                blocks.append(Block(earlier + block.cycles, block.values))
        problems.raise_any()
        return tuple(blocks)

    @property
    def fields(self) -> Mapping[str, Parameter]:
        """The parameters that a block may have, by name."""
        changes = (item for part in self.parts for item in part.keys.items())
        return {_CYCLES: self.number, **dict(changes)}

    def schema(self) -> Schema:
        fields = {name: about.schema() for name, about in self.fields.items()}
        return {"type": "array", "minItems": 1, "items": keys_schema(fields, [_CYCLES])}

    def canonical(self, value: Sequence[Block]) -> object:
        """Return a list of mappings."""
        fields = self.fields
        return [
            {_CYCLES: block.cycles, **{n: fields[n].canonical(v) for n, v in block.values}}
            for block in value
        ]

    def coordinates(self, name: str, value: Sequence[Block]) -> Coordinates:
        """Yield the blocks as text, if there are any."""
        if value:
            yield name, Quantity("1", name, self.words), self.text(value)

    def text(self, value: Sequence[Block] | str) -> str:
        if isinstance(value, str) or not value:
            return str(value or "none")
        fields = self.fields
        return ", then ".join(
            f"{block.cycles} cycles"
            + "".join(f", {fields[n].symbol} = {fields[n].text(v)}" for n, v in block.values)
            for block in value
        ).replace("$", "")
