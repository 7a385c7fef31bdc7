"""Time and memory of a study are those of its simulations, each by its last run."""

from pathlib import Path

import pytest

from fretwear.running.records import spent_on_simulations

HEAD = "s\th:m:s\tmax_rss\tcpu_time\n"


def _write(file: Path, *rows: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(HEAD + "\n".join(rows) + "\n", encoding="utf-8")


def test_simulations_are_added_up_and_other_rules_are_not(tmp_path: Path) -> None:
    _write(tmp_path / "benchmarks/simulate/a.tsv", "2.0\t0:00:02\t100\t1.5")
    _write(tmp_path / "benchmarks/simulate/b.tsv", "3.0\t0:00:03\t200\t2.5")
    _write(tmp_path / "benchmarks/merge.tsv", "9.0\t0:00:09\t900\t9.0")
    spent = spent_on_simulations(tmp_path)
    assert spent is not None
    assert (spent.jobs, spent.seconds, spent.processor_seconds) == (2, 5.0, 4.0)
    assert spent.memory_bytes == pytest.approx(200 * 2**20)


def test_what_was_not_measured_counts_for_nothing(tmp_path: Path) -> None:
    assert spent_on_simulations(tmp_path) is None
    _write(tmp_path / "benchmarks/simulate/a.tsv", "0.2\t0:00:00\t-\tNA")
    (tmp_path / "benchmarks/simulate/b.tsv").write_bytes(b"\xff\xfe not a table")
    spent = spent_on_simulations(tmp_path)
    assert spent is not None
    assert (spent.jobs, spent.seconds, spent.processor_seconds) == (1, 0.2, 0.0)
    assert spent.memory_bytes != spent.memory_bytes
