"""Problems of values, each with its place, its rule and a remedy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

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
    valid_words: Sequence[str] = ()  # where one may be misspelt
    written: str = ""  # the word that may be misspelt, if it is not the value

    @property
    def value(self) -> str:
        """The value, as written in the file."""
        text = in_words(self.given)
        return text if len(text) <= _LONGEST_VALUE else f"{text[: _LONGEST_VALUE - 3]}..."

    @property
    def hint(self) -> str:
        """The likely correction or remedy; may be empty."""
        return did_you_mean(self.written or self.given, self.valid_words) or self.remedy

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
            self.extend(replace(problem, key=f"{key}{problem.key}") for problem in wrong.inside)
            if not wrong.inside:
                self.add(key, given, wrong.rule, wrong.hint, valid_words=wrong.valid_words)

    def raise_any(self) -> None:
        """Raise the problems as one error, if there are any."""
        if self:
            raise QuantityError("has problems", inside=self)

    def add(
        self,
        key: str,
        given: object,
        rule: str,
        remedy: str = "",
        valid_words: Sequence[str] = (),
        written: str = "",
    ) -> None:
        """Add a problem, which has no line yet."""
        self.append(Problem(key, given, rule, remedy, None, valid_words, written))

    def unknown(
        self, place: str, keys: Mapping[str, object], valid: Sequence[str], rule: str = _NOT_KNOWN
    ) -> None:
        """Add the unknown keys at a place as problems."""
        remedy = f"known {'are' if len(valid) > 1 else 'is'} {', '.join(valid)}"
        for name in (name for name in keys if name not in valid):
            self.add(f"{place}.{name}", keys[name], rule, remedy, valid_words=valid, written=name)


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
    try:
        return str(value)
    except ValueError:  # Python refuses to write out whole numbers of thousands of digits
        return "a number of thousands of digits"
