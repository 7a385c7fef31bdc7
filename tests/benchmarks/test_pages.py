"""The pages of verification and of performance are what their data say."""

import json
from pathlib import Path

import pytest
from benchmarks.speed.table import Row
from benchmarks.verification.__main__ import PAGE as VERIFICATION

from benchmarks import performance

DOCS = Path(__file__).resolve().parents[2] / "docs"


def stored(page, docs=DOCS):
    return json.loads((docs / f"{page.name}.json").read_text(encoding="utf-8"))


def keep(page, docs, entries):
    (docs / f"{page.name}.json").write_text(json.dumps(entries), encoding="utf-8")


@pytest.mark.parametrize("page", [VERIFICATION, performance.PAGE], ids=lambda page: page.name)
def test_the_page_is_what_its_data_say(page):
    assert page.main(["--check"]) == 0


def test_a_worse_measurement_falls_short_on_the_page(tmp_path):
    entry = stored(VERIFICATION)["tangential"]
    entry["data"]["surfaces"][0]["ratios"][0]["slip"] = 3e-8
    keep(VERIFICATION, tmp_path, {"tangential": entry})
    docs = ["--docs", str(tmp_path)]
    assert VERIFICATION.main(["--check", *docs]) == 1
    assert VERIFICATION.main(["--render", *docs]) == 0
    page = (tmp_path / "verification.md").read_text(encoding="utf-8")
    (line,) = (line for line in page.splitlines() if "s = µκg*" in line and line.startswith("| ["))
    assert "falls short" in line
    assert "+3.0e-8" in line
    assert VERIFICATION.main(["--check", *docs]) == 0
    row = Row("help", "fretwear --help", 0.5, "s", 0.4, 0.2, note="shortest of 9")
    entry = {"cores": 2, "processor": "one", "load_average": 0.1, "versions": {}, "seconds": 1}
    keep(performance.PAGE, tmp_path, {"table": {**entry, "data": {"rows": [row.as_json()]}}})
    assert performance.PAGE.main(["--render", "--docs", str(tmp_path)]) == 0
    text = (tmp_path / "performance.md").read_text("utf-8")
    assert "| fretwear --help | ≤ 0.4 | ≤ 0.2 | 0.5 | s | falls short |" in text


@pytest.mark.slow
def test_a_section_is_measured_drawn_and_kept(tmp_path):
    assert VERIFICATION.main(["closed_forms", "--docs", str(tmp_path)]) == 0
    peak, kept = (
        [row["peak_pressure"] for row in data["closed_forms"]["data"]["spacings"]]
        for data in (stored(VERIFICATION, tmp_path), stored(VERIFICATION))
    )
    # deviations of 1e-6 on other processors differ in the digits of the contact's tolerance
    assert peak == pytest.approx(kept, abs=1e-6)
    assert (tmp_path / "images" / "verification" / "closed_forms_orders.svg").exists()
    assert "## Closed forms" in (tmp_path / "verification.md").read_text(encoding="utf-8")
