"""Ids of the shipped studies, by which finished cases are found again, stay what they are."""

import csv
import hashlib
import shutil
import sys
from pathlib import Path

import pytest

import fretwear
from fretwear.study.reading import load_study

from ..studies import printed

FOLDER = Path(__file__).parents[2] / "studies"
STUDIES = {str(file.relative_to(FOLDER)): file for file in sorted(FOLDER.rglob("*.yaml"))}
PINNED = Path(__file__).with_name("ids.csv")


def pinned(name):
    """Name, number of points, digest of their ids, and the first id, all in alphabetical order."""
    ids = sorted(point.id for point in load_study(STUDIES[name]).points())
    return [name, str(len(ids)), hashlib.sha256("\n".join(ids).encode()).hexdigest()[:16], ids[0]]


@pytest.mark.parametrize("name", STUDIES)
def test_a_shipped_study_has_the_ids_that_it_always_had(name):
    with PINNED.open(encoding="utf-8") as stream:
        rows = {row[0]: row for row in csv.reader(stream)}
    assert pinned(name) == rows[name]


NEW_KEYS = {
    "study/case.py": (
        "    output_cycles: tuple[int, ...] = ()",
        """    humidity: Annotated[
        float, Quantity("1", "$h$", "humidity", like="0.4", ge=0.0, le=1.0), "Humidity."
    ] = 0.5
""",
    ),
    "mechanics/surfaces/roughness.py": (
        '    kind: Literal["wavy"]',
        """    skewness: Annotated[float, Quantity("1", "$S$", "skewness", like="0.1")] = 0.0
""",
    ),
}


@pytest.mark.slow
def test_a_new_key_with_a_default_changes_no_id(tmp_path):
    """Of a case and of a part, in a copy of the package."""
    source = Path(fretwear.__file__).parent
    copy = shutil.copytree(source, tmp_path / "fretwear", ignore=shutil.ignore_patterns("__py*"))
    for name, (place, lines) in NEW_KEYS.items():
        text = (copy / name).read_text(encoding="utf-8")
        assert text.count(place) == 1
        (copy / name).write_text(text.replace(place, lines + place), encoding="utf-8")
    script = (
        "import fretwear, sys\n"
        "from fretwear.study.reading import load_study\n"
        "case = [point.case for point in load_study(sys.argv[1]).points()][-1]\n"
        "changed = case.replace(humidity=0.4)\n"
        "print(fretwear.__file__, case.case_id, case.humidity, case.roughness.skewness)\n"
        "print(case.case_id != changed.case_id)"
    )
    asked = [sys.executable, "-c", script, FOLDER / "demo.yaml"]
    file, case_id, *defaults, differs = printed(*asked, PYTHONPATH=str(tmp_path)).split()
    assert Path(file).is_relative_to(tmp_path)
    assert [case_id, *defaults] == [
        [*load_study(FOLDER / "demo.yaml").points()][-1].id,
        "0.5",
        "0.0",
    ]
    assert differs == "True"


if __name__ == "__main__":  # python -m tests.study.test_ids writes the table anew
    with PINNED.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows(map(pinned, STUDIES))
