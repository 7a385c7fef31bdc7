"""Verdicts and the sentences that tell them."""

import math

import pytest

from fretwear.source_study.verdict import (
    Answer,
    Finding,
    Judgement,
    Measurement,
    Verdict,
    joined,
    percent,
    short,
)

YES, PARTLY, NO = Answer.YES, Answer.PARTLY, Answer.NO


def judged(*answers: Answer) -> Judgement:
    findings = tuple(
        Finding(f"case {i}", answer, (), "" if answer is YES else f"reason {i}")
        for i, answer in enumerate(answers)
    )
    return Judgement(1, "It is so.", "It must be so.", findings)


@pytest.mark.parametrize(
    ("answers", "verdict"),
    [
        ((YES, YES), Verdict.HOLDS),
        ((NO, NO), Verdict.FAILS),
        ((YES, NO), Verdict.CONDITIONAL),
        ((PARTLY,), Verdict.CONDITIONAL),
        ((PARTLY, NO), Verdict.CONDITIONAL),
    ],
)
def test_verdict_follows_from_the_answers(answers, verdict):
    assert judged(*answers).verdict is verdict


def test_sentence_names_every_case_and_why_it_is_against():
    judgement = judged(YES, PARTLY, NO, YES)
    assert judgement.sentence == (
        "Holds for case 0 and case 3; in part for case 1 (reason 1); not for case 2 (reason 2)."
    )
    assert judgement.answers == "Holds for case 0 and case 3; in part for case 1; not for case 2."


def test_a_claim_that_no_case_answers_is_refused():
    with pytest.raises(ValueError, match="claim 1 is judged by no case"):
        judged()


def test_numbers_are_short():
    texts = [short(value) for value in (0.0, 1e-9, 0.12345, -12.345, 1234.5, math.nan)]
    assert texts == ["0", "0", "0.123", "−12.3", "1234", "–"]
    assert Measurement("share", 12.345, "%").text == "12.3 %"
    assert Measurement("ratio", 2.0).text == "2"
    assert [percent(share) for share in (0.4567, 0.0123, 0.0)] == ["46 %", "1.2 %", "0 %"]


def test_lists_read_as_text():
    assert joined(["a"]) == "a"
    assert joined(["a", "b", "c"]) == "a, b and c"
