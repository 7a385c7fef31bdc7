"""The claims of the source study, each judged by a number: datasets in, verdicts out."""

from fretwear.claims.evolution import Evolution
from fretwear.claims.judge import CLAIMS, judge
from fretwear.claims.quartet import Pair, Quartet
from fretwear.claims.verdict import Answer, Finding, Judgement, Measurement, Verdict

__all__ = [
    "CLAIMS",
    "Answer",
    "Evolution",
    "Finding",
    "Judgement",
    "Measurement",
    "Pair",
    "Quartet",
    "Verdict",
    "judge",
]
