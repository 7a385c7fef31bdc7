"""Mistakes of values, each with its place, its rule and a remedy, and the error that lists them."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from fretwear.quantity import Schema
from fretwear.units import QuantityError, did_you_mean

Form = TypeVar("Form")

LISTED, RANGE = "[]", "{}"
"""What tells a list of values from a range where either may be; no key of a file."""
_LONGEST_VALUE, _FEW_KEYS = 60, 12
# Words for keys on other pages, and what to write here.
_OTHER_WORDS = {
    "diameter": "give the radius, half of it",
    "stroke": "give sliding_amplitude, half of it",
    "displacement": "give displacement_amplitude",
    **dict.fromkeys(("ra", "sa"), "self_affine roughness takes rms_height, about 1.25 times that"),
    **dict.fromkeys(("rq", "sq"), "self_affine roughness takes it as rms_height"),
    "wavelength": "give the slopes of waves: tan(slope) = 4 amplitude/wavelength",
    **dict.fromkeys(("mu", "cof", "friction_coefficient"), "did you mean 'friction'?"),
    **dict.fromkeys(("force", "normal_load", "normal_force"), "did you mean 'load'?"),
    **dict.fromkeys(("geometry", "shape", "ball", "body"), "did you mean 'indenter'?"),
    **dict.fromkeys(("grid", "mesh", "resolution", "dx"), "give cell, the spacing, or accuracy"),
    "dt": "steps over the cycles follow from tolerance",
    "tangential_force": "did you mean 'tangential_load'?",
    "e": "did you mean 'youngs_modulus'?",
    "k": "did you mean 'wear_coefficient'?",
    "path": "did you mean 'file'?",
    "nu": "did you mean 'poisson_ratio'?",
    "hardness": "give plastic_limit, about the hardness",
    **dict.fromkeys(("yield_strength", "yield_stress"), "give plastic_limit, about 3 times that"),
    "material": "only base takes it: give youngs_modulus, poisson_ratio and plastic_limit",
}


@dataclass(frozen=True)
class Mistake:
    """One mistake of a study."""

    key: str  # dotted name as in the file, such as vary.load[1]; empty for the file as a whole
    entry: object  # the value there, or None
    rule: str  # what is wrong or required, as a sentence without its subject
    remedy: str = ""  # what to do
    line: int | None = None  # of the file, counted from 1

    @property
    def value(self) -> str:
        """The value, as written in the file."""
        text = in_words(self.entry)
        return text if len(text) <= _LONGEST_VALUE else f"{text[: _LONGEST_VALUE - 3]}..."

    @property
    def _place(self) -> str:
        return self.key + (f" = {self.value}" if self.value else "")

    @property
    def sentence(self) -> str:
        """Everything in one line."""
        return f"{self._place} {self.rule}" + (f"; {self.remedy}" if self.remedy else "")

    def __str__(self) -> str:
        where = f" (line {self.line})" if self.line else ""
        text = f"{self._place}{where}: {self.rule}" if self.key else f"{self.rule}{where}"
        return text + (f"\n    {self.remedy}" if self.remedy else "")


class Mistakes(list[Mistake]):
    """The mistakes found while reading, in order."""

    def add(self, key: str, value: object, rule: str, remedy: str = "") -> None:
        """Add a mistake, which has no line yet."""
        self.append(Mistake(key, value, rule, remedy))

    def read(
        self,
        form: TypeAdapter[Form],
        values: Mapping[str, object],
        schema: Callable[[], Schema],
        folder: Path | None = None,
        nested: Sequence[str] = (),
    ) -> Form:
        """Read a mapping without its wrong entries, each of which becomes a mistake.

        If a nested key holds a mapping, only its wrong entries are left out. The JSON Schema gives
        the names near unknown keys.
        """
        try:
            return form.validate_python(values, context=folder)
        except ValidationError as error:
            found = error.errors(include_url=False)
        kept = dict(values)
        for one in found:
            place = one["loc"]
            inner = [each["loc"] for each in found if each["loc"][: len(place)] == place]
            # A list whose items are all wrong is not too short as well.
            if one["type"] != "too_short" or len(inner) == 1:
                self.append(_mistake(one, values, schema))
            first, *inner_path = place
            if inner_path and first in nested:
                entries = kept.get(str(first), {})
                assert isinstance(entries, Mapping)
                kept[str(first)] = {key: entries[key] for key in entries if key != inner_path[0]}
            else:
                kept.pop(str(first), None)
        return self.read(form, kept, schema, folder, nested)


def nearest_key(name: str, valid: Iterable[str]) -> str:
    """Return a hint at the valid key that is meant by an unknown one, or at all if they are few."""
    from fretwear.results import RESULTS  # most studies have no unknown key

    keys = [*dict.fromkeys(valid)]
    whole, dot, part = name.rpartition(".")
    if name in keys:
        return f"write {whole}: {{{part}: …}}; vary and --set take {name}"
    if dot and (own := [key[len(whole) + 1 :] for key in keys if key.startswith(f"{whole}.")]):
        return nearest_key(part, own).replace("did you mean '", f"did you mean '{whole}.")
    hint, there = _OTHER_WORDS.get(name.lower(), ""), {key.rpartition(".")[2] for key in keys}
    if hint and there.issuperset(re.findall(r"'(\w+)'", hint)):
        return hint
    if name in RESULTS or name.startswith("hertz_"):
        return "it is a result, which follows from the parameters"
    for whole, dot, part in (key.rpartition(".") for key in keys):
        if dot and part == name:
            return f"it is a key of {whole}; vary and --set take {whole}.{part}"
    return did_you_mean(name, keys) or _known(keys) or "fretwear schema lists all keys"


def _known(keys: Collection[str]) -> str:
    """Return a hint at all keys if they are few."""
    return f"its keys are {', '.join(keys)}" if 0 < len(keys) <= _FEW_KEYS else ""


def _unknown_key(path: Sequence[int | str], values: Mapping[str, object], schema: Schema) -> str:
    """Return a hint at the key that is meant by an unknown one, of the same kind or another."""
    *outer, name = path
    found = [*_keys_at(schema, outer)]
    kinds = {keys.get("kind", {}).get("const", ""): keys for keys in found}
    for kind, keys in kinds.items():
        if kind and name in keys:
            return f"it is a key of kind: {kind}"
    place: object = values
    for step in outer:
        place = place[step] if isinstance(place, Mapping | list) else {}  # type: ignore[index]
    kind = place.get("kind") if isinstance(place, Mapping) else None
    valid = [*kinds.get(kind, found[0] if found else {})]
    if outer == ["base"]:
        valid += [key for keys in _keys_at(schema, ["vary"]) for key in keys]
    return nearest_key(str(name), valid)


def _keys_at(schema: Schema, path: Sequence[int | str]) -> Iterator[Mapping[str, Schema]]:
    """The keys of each mapping that a JSON Schema allows at a place."""
    for choice in (schema, *schema.get("anyOf", ()), *schema.get("oneOf", ())):
        keys = choice.get("properties", {})
        if path:
            of_others = choice.get("items" if isinstance(path[0], int) else "additionalProperties")
            inner = keys.get(path[0]) or of_others
            yield from _keys_at(inner, path[1:]) if inner else ()
        elif keys:
            yield keys


def _mistake(
    one: ErrorDetails, values: Mapping[str, object], schema: Callable[[], Schema]
) -> Mistake:
    """A mistake that pydantic reports, in our words."""
    path = [step for step in one["loc"] if step not in (LISTED, RANGE)]
    steps = (f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    place, value, context = "".join(steps).removeprefix("."), one["input"], one.get("ctx", {})
    match one["type"]:
        case "value_error" if isinstance(context["error"], QuantityError):
            return Mistake(place, value, context["error"].rule, context["error"].hint)
        case "missing":
            return Mistake(place, None, "is missing")
        case "unexpected_keyword_argument" | "extra_forbidden":
            return Mistake(place, value, "is not known", _unknown_key(path, values, schema()))
        case "literal_error":
            words = re.findall(r"'([^']*)'", str(context["expected"]))
            return Mistake(
                place, value, f"must be {context['expected']}", did_you_mean(value, words)
            )
        case "bool_parsing" | "bool_type":
            return Mistake(place, value, "must be true or false")
        case "dict_type" | "model_type" | "dataclass_type":
            hint = _known(next(_keys_at(schema(), path), {}))
            return Mistake(place, value, "must be a mapping", hint)
        case "list_type" | "tuple_type" | "too_short":
            sample = "; a sample takes {from: …, to: …}" if path[0] == "vary" else ""
            return Mistake(place, value, "must be a list of values", f"write [first, …]{sample}")
        case _:
            message = one["msg"].removeprefix("Value error, ").replace("Input should", "must")
            return Mistake(place, value, message[:1].lower() + message[1:])


def in_words(value: object) -> str:
    """Return a value as written in the file, printable; unequal values give unequal texts."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return value if value.isprintable() and value.strip() else repr(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {in_words(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(in_words(item) for item in value) + "]"
    return str(value)


class StudyError(ValueError):
    """A study file that cannot be run; `mistakes` lists everything that is wrong, in order."""

    def __init__(self, file: Path, mistakes: Iterable[Mistake]) -> None:
        self.file = file
        self.mistakes = tuple(mistakes)
        super().__init__(file, self.mistakes)

    def __str__(self) -> str:
        if len(self.mistakes) == 1:
            return f"{self.file}: {self.mistakes[0]}"
        listed = "\n".join(f"  {mistake}" for mistake in self.mistakes)
        return f"{self.file}: {len(self.mistakes)} mistakes\n{listed}"


def few_of(things: Sequence[object], most: int = 5) -> list[str]:
    """Return the first few items as text, and the number of the others."""
    more = [f"and {len(things) - most} more"] if len(things) > most else []
    return [*map(str, things[:most]), *more]
