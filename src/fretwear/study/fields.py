"""Kinds of case parameters: how each is read, what range it has, how the schema describes it.

Each class is used as pydantic metadata (``Annotated[float, Quantity(FORCE, above=0.0)]``) and is
the single source of a parameter's reading, its messages and its JSON Schema.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import PydanticCustomError, core_schema

from fretwear.study.quantities import (
    NUMBER_PATTERN,
    Dimension,
    QuantityError,
    format_quantity,
    parse_quantity,
)

STUDY_FILE: Mapping[str, bool] = {"units_required": True}
"""Validation context of study files: physical values need units, and `null` is no value."""

# No physical value is beyond; powers and quotients of such numbers are still numbers.
_SMALLEST, _LARGEST = 1e-30, 1e30

_NUMBER_SCHEMA = rf"^\s*[+-]?{NUMBER_PATTERN}\s*$"
_QUANTITY_SCHEMA = rf"^\s*[+]?{NUMBER_PATTERN}\s*[A-Za-zµμ°/].*$"


def refuse(rule: str, hint: str = "") -> PydanticCustomError:
    """Return the error that refuses a value; its context keeps rule and hint apart."""
    template = "{rule}; {hint}" if hint else "{rule}"
    return PydanticCustomError("fretwear", template, {"rule": rule, "hint": hint})


def means_none(value: object, units_required: bool) -> bool:
    """Whether a value is the word ``none`` (or Python's None, outside of files)."""
    if isinstance(value, str):
        return value.strip() == "none"
    return value is None and not units_required


class Reader(ABC):
    """Glue to pydantic: values through `read`, JSON Schema through `schema`."""

    @abstractmethod
    def read(self, value: object, units_required: bool) -> Any:
        """Return the value in SI units; `QuantityError` where it is none or out of range."""

    @abstractmethod
    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""

    @property
    @abstractmethod
    def example(self) -> str:
        """A sensible value as a study file would have it."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        del source, handler

        def validate(value: object, info: core_schema.ValidationInfo) -> Any:
            try:
                return self.read(value, bool((info.context or {}).get("units_required")))
            except QuantityError as error:
                raise refuse(error.rule, error.hint) from error

        return core_schema.with_info_plain_validator_function(validate)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        del schema, handler
        return self.schema()


@dataclass(frozen=True)
class Quantity(Reader):
    """A physical quantity or a plain number, within a range.

    Attributes
    ----------
    dimension : Dimension
        What it is, with an example.
    above, at_least, below, at_most : float or None
        Bounds in SI units.
    none_is_infinite : bool
        Whether the word ``none`` stands for no limit, infinity.
    """

    dimension: Dimension
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    none_is_infinite: bool = False

    @property
    def example(self) -> str:
        """A sensible value as a study file would have it."""
        return self.dimension.example

    def read(self, value: object, units_required: bool) -> float:
        """Return the SI value; `QuantityError` where it is none or out of range."""
        if self.none_is_infinite and means_none(value, units_required):
            return math.inf
        if self.none_is_infinite and value == math.inf:
            if not units_required:
                return math.inf
            raise QuantityError(f"{self.dimension.expectation}, or none", "write none for no limit")
        try:
            number = parse_quantity(value, self.dimension, units_required=units_required)
        except QuantityError as error:
            if not self.none_is_infinite:
                raise
            raise QuantityError(f"{error.rule}, or none", error.hint) from error
        if not self._contains(number):
            raise QuantityError(f"must be {self.range_text()}")
        if number > _LARGEST or (0.0 in (self.above, self.at_least) and 0.0 < number < _SMALLEST):
            raise QuantityError(f"must lie between {_SMALLEST:g} and {_LARGEST:g} in SI units")
        return number

    def _contains(self, number: float) -> bool:
        return (
            (self.above is None or number > self.above)
            and (self.at_least is None or number >= self.at_least)
            and (self.below is None or number < self.below)
            and (self.at_most is None or number <= self.at_most)
        )

    def range_text(self) -> str:
        """Say the range in words, such as "larger than -1 and at most 0.5"."""
        bounds = (
            ("larger than", self.above),
            ("at least", self.at_least),
            ("less than", self.below),
            ("at most", self.at_most),
        )
        return " and ".join(
            f"{words} {format_quantity(bound, self.dimension) if bound else '0'}"
            for words, bound in bounds
            if bound is not None
        )

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""
        if self.dimension.is_plain_number:
            number: dict[str, Any] = {"type": "number"}
            for keyword, bound in (
                ("exclusiveMinimum", self.above),
                ("minimum", self.at_least),
                ("exclusiveMaximum", self.below),
                ("maximum", self.at_most),
            ):
                if bound is not None:
                    number[keyword] = bound
            text: dict[str, Any] = {"type": "string", "pattern": _NUMBER_SCHEMA}
            return {"anyOf": [number, text], "examples": [float(self.dimension.example)]}
        quantity = {
            "type": "string",
            "pattern": _QUANTITY_SCHEMA,
            "examples": [self.dimension.example],
        }
        if self.none_is_infinite:
            return {"anyOf": [{"const": "none"}, quantity]}
        return quantity


@dataclass(frozen=True)
class PerBody(Reader):
    """One value for both bodies, or a pair [body I, body II]."""

    each: Quantity

    @property
    def example(self) -> str:
        """A sensible value as a study file would have it."""
        return self.each.example

    def read(self, value: object, units_required: bool) -> float | tuple[float, float]:
        """Return a float, or a pair of floats where the bodies are given apart."""
        if _is_list(value):
            return _read_pair(self.each, value, units_required, "one value, or two for two bodies")
        return self.each.read(value, units_required)

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""
        return {"anyOf": [self.each.schema(), _pair_schema(self.each)]}


@dataclass(frozen=True)
class Spacing(Reader):
    """Grid spacing along x and y; one value serves for both."""

    each: Quantity

    @property
    def example(self) -> str:
        """A sensible value as a study file would have it."""
        return self.each.example

    def read(self, value: object, units_required: bool) -> tuple[float, float] | None:
        """Return (dx, dy), or None for the default."""
        if value is None and not units_required:
            return None
        if _is_list(value):
            return _read_pair(self.each, value, units_required, "the spacing along x and along y")
        both = self.each.read(value, units_required)
        return both, both

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""
        return {"anyOf": [self.each.schema(), _pair_schema(self.each)]}


@dataclass(frozen=True)
class WholeNumber(Reader):
    """A whole number within a range (bounds included)."""

    at_least: int
    at_most: int
    usual: int

    @property
    def example(self) -> str:
        """A sensible value as a study file would have it."""
        return str(self.usual)

    def read(self, value: object, units_required: bool) -> int:
        """Return an int; ``1e4``, which YAML reads as text, is accepted."""
        del units_required
        number = _any_number(value)
        if not math.isfinite(number) or number != int(number):
            raise QuantityError(f"must be a whole number such as {self.example}")
        if not self.at_least <= number <= self.at_most:
            raise QuantityError(f"must be at least {self.at_least} and at most {self.at_most}")
        return int(number)

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the value in a study file."""
        number = {"type": "integer", "minimum": self.at_least, "maximum": self.at_most}
        text = {"type": "string", "pattern": _NUMBER_SCHEMA}
        return {"anyOf": [number, text], "examples": [self.usual]}


def _any_number(value: object) -> float:
    """Return a number or the number that a text says; nan where there is none."""
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    if not is_number and not (isinstance(value, str) and len(value) < 30):
        return math.nan
    try:
        return float(value)  # type: ignore[arg-type]
    except (ValueError, OverflowError):
        return math.nan


def _is_list(value: object) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str | bytes)


def _read_pair(
    each: Quantity, values: Any, units_required: bool, meaning: str
) -> tuple[float, float]:
    if len(values) != 2:
        raise QuantityError(f"must be {meaning}, but is a list of {len(values)}")
    read = []
    for position, value in enumerate(values, start=1):
        try:
            read.append(each.read(value, units_required))
        except QuantityError as error:
            rule = f"has a value number {position}, {value!r}, that {error.rule}"
            raise QuantityError(rule, error.hint) from error
    return read[0], read[1]


def _pair_schema(each: Quantity) -> dict[str, Any]:
    return {"type": "array", "items": each.schema(), "minItems": 2, "maxItems": 2}
