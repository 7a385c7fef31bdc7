"""What judging a claim gives: measured numbers, an answer for each case, a verdict."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

_NEGLIGIBLE = 1e-4


class Answer(Enum):
    """Whether a claim is met by one case, or by one pair of cases."""

    YES = "yes"
    PARTLY = "partly"
    NO = "no"


class Verdict(Enum):
    """What becomes of a claim once all cases have answered."""

    HOLDS = "holds"
    CONDITIONAL = "holds with a condition"
    FAILS = "does not hold"


@dataclass(frozen=True)
class Measurement:
    """One measured number.

    Attributes
    ----------
    label : str
        What was measured.
    value : float
        The number, in `unit`.
    unit : str
        ``%``, ``µm``, or empty for a pure number.
    """

    label: str
    value: float
    unit: str = ""

    @property
    def text(self) -> str:
        """Number and unit, three significant digits."""
        return f"{short(self.value)} {self.unit}".rstrip()


@dataclass(frozen=True)
class Finding:
    """What one case, or one pair of cases, says to a claim.

    Attributes
    ----------
    subject : str
        Which case or pair, such as ``smooth elastic``.
    answer : Answer
        Whether it meets the criterion.
    measurements : tuple of Measurement
        The numbers that the answer rests on.
    remark : str
        Why it does not, or under which condition it does; empty for a plain yes.
    """

    subject: str
    answer: Answer
    measurements: tuple[Measurement, ...]
    remark: str = ""


@dataclass(frozen=True)
class Judgement:
    """A claim of the source study, judged.

    Attributes
    ----------
    number : int
        Number of the claim.
    statement : str
        What is claimed.
    criterion : str
        When it counts as met; fixed by the words of the claim, not by the result.
    findings : tuple of Finding
        The answer of each case, at least one.
    """

    number: int
    statement: str
    criterion: str
    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        if not self.findings:
            raise ValueError(f"claim {self.number} is judged by no case; give at least one finding")

    @property
    def verdict(self) -> Verdict:
        """Holds when every case says yes, does not when every case says no."""
        answers = {finding.answer for finding in self.findings}
        if answers == {Answer.YES}:
            return Verdict.HOLDS
        return Verdict.FAILS if answers == {Answer.NO} else Verdict.CONDITIONAL

    @property
    def sentence(self) -> str:
        """The verdict in words, with the condition where there is one."""
        return self._told(
            lambda finding: (
                f"{finding.subject} ({finding.remark})" if finding.remark else finding.subject
            )
        )

    @property
    def answers(self) -> str:
        """The answer of each case, without its reasons."""
        return self._told(lambda finding: finding.subject)

    def _told(self, words: Callable[[Finding], str]) -> str:
        introductions = {
            Answer.YES: "holds for",
            Answer.PARTLY: "in part for",
            Answer.NO: "not for",
        }
        parts = []
        for answer, introduction in introductions.items():
            subjects = [words(finding) for finding in self.findings if finding.answer is answer]
            if subjects:
                parts.append(f"{introduction} {joined(subjects)}")
        text = "; ".join(parts)
        return f"{text[0].upper()}{text[1:]}."


def short(value: float) -> str:
    """Return a number with three significant digits, as people write it."""
    if math.isnan(value):
        return "–"
    if abs(value) < _NEGLIGIBLE:
        return "0"
    text = f"{value:.0f}" if abs(value) >= 100.0 else f"{float(f'{value:.3g}'):.10g}"
    return text.replace("-", "−")


def snapshot(cycle: int | None) -> float:
    """Return a cycle as a number to measure; NaN, which prints as a dash, when there is none."""
    return math.nan if cycle is None else float(cycle)


def percent(share: float) -> str:
    """Return a share in percent, for running text."""
    return f"{short(round(100.0 * share, 1 if abs(share) < 0.1 else 0))} %"


def joined(words: Sequence[str]) -> str:
    """Return words as a list in running text."""
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)
