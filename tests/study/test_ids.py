"""Ids of the shipped studies, by which finished cases are found again, stay what they are."""

import csv
import hashlib
from pathlib import Path

import pytest

from fretwear.study.reading import load_study

FOLDER = Path(__file__).parents[2] / "studies"
STUDIES = {str(file.relative_to(FOLDER)): file for file in sorted(FOLDER.rglob("*.yaml"))}
PINNED = Path(__file__).with_name("ids.csv")


def pinned(name):
    """Name, number of points, digest of the ids of all points in order, and the first id."""
    ids = [point.id for point in load_study(STUDIES[name]).points()]
    return [name, str(len(ids)), hashlib.sha256("\n".join(ids).encode()).hexdigest()[:16], ids[0]]


@pytest.mark.parametrize("name", STUDIES)
def test_a_shipped_study_has_the_ids_that_it_always_had(name):
    with PINNED.open(encoding="utf-8") as stream:
        rows = {row[0]: row for row in csv.reader(stream)}
    assert pinned(name) == rows[name]


if __name__ == "__main__":  # python -m tests.study.test_ids writes the table anew
    with PINNED.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows(map(pinned, STUDIES))
