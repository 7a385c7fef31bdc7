"""What is wrong with values: each problem with its place, its rule and a remedy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from fretwear.units import QuantityError, did_you_mean

_LONGEST_VALUE = 60
_NOT_KNOWN = "is not known"


@dataclass(frozen=True)
class Problem:
    """One problem of a study; it is put into words when it is shown."""

    key: str  # dotted name as in the file, such as vary.load[1]; empty for the file as a whole
    given: object  # the value there, or None
    rule: str  # what is wrong or required, as a sentence without its subject
    remedy: str = ""  # what to do
    line: int | None = None  # of the file, counted from 1
    known: Sequence[str] = ()  # the valid words, where one may be misspelt
    written: str = ""  # the word that may be misspelt, if it is not the value

    @property
    def value(self) -> str:
        """The value, as written in the file."""
        text = in_words(self.given)
        return text if len(text) <= _LONGEST_VALUE else f"{text[: _LONGEST_VALUE - 3]}..."

    @property
    def hint(self) -> str:
        """The likely correction or remedy; may be empty."""
        return did_you_mean(self.written or self.given, self.known) or self.remedy

    @property
    def _place(self) -> str:
        return self.key + (f" = {self.value}" if self.value else "")

    @property
    def sentence(self) -> str:
        """Everything in one line."""
        return f"{self._place} {self.rule}" + (f"; {self.hint}" if self.hint else "")

    def __str__(self) -> str:
        where = f" (line {self.line})" if self.line else ""
        text = f"{self._place}{where}: {self.rule}" if self.key else f"{self.rule}{where}"
        return text + (f"\n    {self.hint}" if self.hint else "")


class Problems(list[Problem]):
    """The problems found while reading, in order."""

    @contextmanager
    def at(self, key: str, given: object) -> Iterator[None]:
        """Collect errors raised in the context as problems of a key."""
        try:
            yield
        except QuantityError as wrong:
            self.extend(replace(each, key=f"{key}{each.key}") for each in wrong.inside)
            if not wrong.inside:
                self.add(key, given, wrong.rule, wrong.hint, known=wrong.known)

    def raise_any(self) -> None:
        """Raise all of them as one error, if there are any."""
        if self:
            raise QuantityError("has problems", inside=self)

    def add(self, key: str, given: object, rule: str, remedy: str = "", **words: Any) -> None:
        """Add a problem; `known` lists the valid words, of which one may have been `written`."""
        self.append(Problem(key, given, rule, remedy, **words))

    def unknown(
        self, place: str, keys: Mapping[str, object], known: Sequence[str], rule: str = _NOT_KNOWN
    ) -> None:
        """Add the unknown keys at a place."""
        remedy = f"known {'are' if len(known) > 1 else 'is'} {', '.join(known)}"
        for name in (name for name in keys if name not in known):
            self.add(f"{place}.{name}", keys[name], rule, remedy, known=known, written=name)


def in_words(value: object) -> str:
    """Return a value as written in the file, printable; different values give different texts."""
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
    try:
        return str(value)
    except ValueError:  # Python refuses to write out whole numbers of thousands of digits
        return "a number of thousands of digits"
