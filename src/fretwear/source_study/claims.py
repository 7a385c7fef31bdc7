"""The claims of the source study, in its words, each a row of `CLAIMS`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from fretwear.source_study import measures
from fretwear.source_study.cases import RUN_IN, TITLES, Evolution
from fretwear.source_study.measures import Answer, Finding


@dataclass(frozen=True)
class Claim:
    """A claim of the source study.

    Attributes
    ----------
    words, criterion : str
        What the study says, and how it is read: fixed by the words, not by the result.
    subjects : mapping of str to sequence of str
        What is judged: the titles of the cases of each subject.
    measure : callable
        Takes the cases of one subject and returns its `Finding`.
    """

    number: int
    words: str
    criterion: str
    subjects: Mapping[str, Sequence[str]]
    measure: Callable[..., Finding]

    def judge(self, cases: Mapping[str, Evolution]) -> Judgement:
        """Judge the claim by the four cases of `fretwear.source_study.cases.TITLES`."""
        return Judgement(
            self,
            {
                subject: self.measure(*(cases[title] for title in titles))
                for subject, titles in self.subjects.items()
            },
        )


@dataclass(frozen=True)
class Judgement:
    """A claim and the finding of each of its subjects."""

    claim: Claim
    findings: Mapping[str, Finding]

    @property
    def answers(self) -> tuple[Answer, ...]:
        """The answer of each subject."""
        return tuple(finding.answer for finding in self.findings.values())

    @property
    def verdict(self) -> Answer:
        """The answer that all subjects give; where they differ, the claim holds in part."""
        return self.answers[0] if len(set(self.answers)) == 1 else Answer.IN_PART

    @property
    def told(self) -> str:
        """The answer of each subject in words where they differ; else nothing."""
        if len(set(self.answers)) == 1:
            return ""
        return ", ".join(f"{s}: {finding.answer.value}" for s, finding in self.findings.items())


_EACH = {title: (title,) for title in TITLES}
_SMOOTH_ELASTIC = {"smooth elastic": ("smooth elastic",)}
_ROUGH = {title: (title,) for title in TITLES if title.startswith("rough")}
_PAIRS = {body: (f"smooth {body}", f"rough {body}") for body in ("elastic", "plastic")}

CLAIMS = (
    Claim(
        1,
        "Pressure increases within the stick zone and decreases inside the slip zones.",
        "From every snapshot to the next the mean pressure over the first stick disc rises, and "
        "that over the ring from there to the edge of the contact falls; changes by less than "
        "0.1 % of the first mean count as none. In part: from the first snapshot to the last.",
        _EACH,
        measures.pressure_moves_inward,
    ),
    Claim(
        2,
        "The largest peak of a smooth elastic surface is at the ends of the stick zone after the "
        "last cycle.",
        "After the last cycle the cell of highest pressure is within two cells of the edge of the "
        "stick zone.",
        _SMOOTH_ELASTIC,
        measures.peak_at_stick_edge,
    ),
    Claim(
        3,
        f"Rough, after about {RUN_IN} cycles: pressure and slip in the slip area are almost those "
        "of a smooth surface after the same number.",
        f"At the snapshot nearest cycle {RUN_IN}, over the slip zone that both have in common, the "
        "mean difference of pressure and that of slip are at most 5 % of the smooth contact's "
        "mean. In part: at most 5 % of the Hertz pressure and of the smooth contact's largest "
        "slip, as good as equal in a figure.",
        _PAIRS,
        measures.rough_becomes_smooth,
    ),
    Claim(
        4,
        "Elastic: no change of the stick zone. Plastic: its edges deform and it reduces "
        "continuously.",
        "Elastic: no cell goes from stick to slip or back. Plastic: there is plastic depth in the "
        "outer quarter of the stick zone, and the area that sticks falls from every snapshot to "
        "the next once bodies yield. In part: it falls from a later cycle on.",
        _EACH,
        measures.stick_zone,
    ),
    Claim(
        5,
        "The maximum wear is in the middle of the slip zones, smooth and rough, and at the "
        "beginning.",
        "Averaged over rings, wear is deepest in the middle third of the slip zone at every "
        "snapshot after cycle 0, and the cycle that wears most is among the first tenth. In part: "
        "deepest there at some snapshots.",
        _EACH,
        measures.deepest_in_the_middle,
    ),
    Claim(
        6,
        "After some number of cycles the wear of one cycle becomes almost constant over the slip "
        "zone.",
        "Averaged over rings, its standard deviation over the slip zone is at most 10 % of the "
        "mean, at the last snapshot at which the mean is still at least 1 % of the first. In part: "
        "at most 10 % over the middle half of the slip zone.",
        _EACH,
        measures.even_wear,
    ),
    Claim(
        7,
        "Rough: wear is first on the asperities with the biggest pressures; after about "
        f"{RUN_IN} cycles the asperities on the slip area are worn.",
        "In cycle 0 at least 90 % of the wear is on the half of the surface that stands out, and "
        "pressure is higher there than in the slip zone on average; at the snapshot nearest cycle "
        f"{RUN_IN} at most 10 % of the amplitude of the waves is left in the slip zone. In part: "
        "one of the two, or at most 10 % in its middle half.",
        _ROUGH,
        measures.asperities,
    ),
    Claim(
        8,
        "Contact width grows much faster for rough surfaces and stabilises at almost the same "
        "level.",
        "By cycle 100 the rough half-width has grown at least 1.5 times as much as the smooth one; "
        "after the last cycle they are within 5 % of each other, and in the second half of all "
        "cycles each grows by at most 5 % of its whole growth. In part: one of the two.",
        _PAIRS,
        measures.width_grows_faster_when_rough,
    ),
    Claim(
        9,
        "Shear tractions exhibit a similar behaviour.",
        "From snapshot to snapshot the means of shear over the two zones of claim 1 rise where "
        "those of pressure rise, and fall where they fall. In part: more often than not.",
        _EACH,
        measures.shear_like_pressure,
    ),
    Claim(
        10,
        "Wear has higher values at the beginning for rough bodies.",
        f"From cycle 1 to {RUN_IN} wear volume and largest depth of the rough contact exceed those "
        "of the smooth one. In part: one of them, or at some snapshots.",
        _PAIRS,
        measures.more_wear_when_rough,
    ),
)
"""All claims, in the order of their numbers; 10 is of the study's conclusions."""


def judge(cases: Mapping[str, Evolution]) -> tuple[Judgement, ...]:
    """Judge every claim by the four cases of `fretwear.source_study.cases.TITLES`."""
    return tuple(claim.judge(cases) for claim in CLAIMS)
