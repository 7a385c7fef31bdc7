"""The page of performance is what its data say."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from benchmarks.performance import page
from benchmarks.performance.__main__ import main
from benchmarks.performance.parts import PARTS, Part
from benchmarks.scale import cells
from benchmarks.speed.rows import Row

DOCS = Path(__file__).resolve().parents[2] / "docs"


def part(name: str) -> Part:
    return next(part for part in PARTS if part.name == name)


@pytest.mark.skipif(
    not (DOCS / "performance.json").exists(), reason="docs/performance.json was not measured yet"
)
def test_the_page_is_what_its_data_say():
    assert main(["--check"]) == 0


@pytest.mark.slow
def test_a_part_is_measured_drawn_and_kept(tmp_path):
    page.measure(tmp_path, replace(part("cells"), measure=partial(cells.curve, (16, 24))))
    page.write(tmp_path)
    text = (tmp_path / "performance.md").read_text("utf-8")
    assert "images/performance/cells.svg" in text
    assert (tmp_path / "images/performance/cells.svg").exists()
    assert main(["--check", "--docs", str(tmp_path)]) == 0
    stored = json.loads((tmp_path / "performance.json").read_text("utf-8"))
    points = stored["cells"]["data"]["points"]
    assert all(point["peak_bytes"] > point["start_bytes"] > 0 for point in points)
    points[0]["steps"] = 99
    (tmp_path / "performance.json").write_text(json.dumps(stored))
    assert main(["--check", "--docs", str(tmp_path)]) == 1


def test_a_row_that_falls_short_says_so_on_the_page(tmp_path):
    row = Row("help", "fretwear --help", 0.5, "s", 0.4, 0.2, note="shortest of 9")
    entry = {"cores": 2, "processor": "one", "load_average": 0.1, "versions": {}, "seconds": 1}
    entry["data"] = {"rows": [row.as_json()]}
    (tmp_path / "performance.json").write_text(json.dumps({"table": entry}))
    assert main(["--render", "--docs", str(tmp_path)]) == 0
    text = (tmp_path / "performance.md").read_text("utf-8")
    assert "| fretwear --help | ≤ 0.4 | ≤ 0.2 | 0.5 | s | falls short |" in text
