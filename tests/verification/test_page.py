"""The page of the verification is what its data say, and says what the data say."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "docs" / "verification.json"


def verification(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "benchmarks.verification", *arguments],
        cwd=ROOT,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=300,
    )


def test_the_page_is_what_its_data_say():
    done = verification("--check")
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_worse_measurement_falls_short_on_the_page(tmp_path):
    stored = json.loads(DATA.read_text(encoding="utf-8"))
    rows = stored["tangential"]["data"]["surfaces"][0]["ratios"]
    rows[0]["slip"] = 3e-8
    (tmp_path / DATA.name).write_text(json.dumps({"tangential": stored["tangential"]}))
    assert verification("--check", "--docs", str(tmp_path)).returncode == 1
    done = verification("--render", "--docs", str(tmp_path))
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "verification.md").read_text(encoding="utf-8")
    (line,) = (line for line in page.splitlines() if "s = µκg*" in line and line.startswith("| ["))
    assert "falls short" in line
    assert "+3.0e-8" in line
    assert verification("--check", "--docs", str(tmp_path)).returncode == 0


@pytest.mark.slow
def test_a_section_is_measured_drawn_and_kept(tmp_path):
    done = verification("closed_forms", "--docs", str(tmp_path))
    assert done.returncode == 0, done.stderr
    measured = json.loads((tmp_path / DATA.name).read_text(encoding="utf-8"))
    stored = json.loads(DATA.read_text(encoding="utf-8"))
    peak, kept = (
        [row["peak_pressure"] for row in data["closed_forms"]["data"]["spacings"]]
        for data in (measured, stored)
    )
    # deviations of 1e-6 on other processors differ in the digits of the contact's tolerance
    assert peak == pytest.approx(kept, abs=1e-6)
    assert (tmp_path / "images" / "verification" / "closed_forms_orders.svg").exists()
    assert "## Closed forms" in (tmp_path / "verification.md").read_text(encoding="utf-8")


def test_an_unknown_section_is_refused():
    done = verification("hertz")
    assert done.returncode == 2
    assert "no such section: hertz" in done.stderr
