"""What jobs leave beside the case files is read again, whatever else lies there."""

import json

import pytest

from fretwear.running.records import (
    ENDED,
    failures,
    forget,
    log_end,
    log_file,
    record,
    spent_on_simulations,
)

HEAD = "s\th:m:s\tmax_rss\tcpu_time\n"


def test_failed_cases_are_told_with_reason_and_log_until_they_have_a_result(tmp_path):
    assert failures(tmp_path) == failures(tmp_path / "missing") == {}
    record(tmp_path, "first")
    assert failures(tmp_path)["first"].reason == ENDED, "its process vanished"
    record(tmp_path, "first", "no step after cycle 3 comes to an end")
    record(tmp_path, "second", "broken")
    failure, _ = failures(tmp_path).values()
    assert tmp_path / failure.log == log_file(tmp_path, "first")
    assert str(failure) == "no step after cycle 3 comes to an end (log: logs/simulate/first.log)"
    forget(tmp_path, "first")
    forget(tmp_path, "never failed")
    assert list(failures(tmp_path)) == ["second"]


def test_records_that_are_cut_short_or_of_something_else_are_passed_over(tmp_path):
    record(tmp_path, "sound", "broken")
    (file,) = (tmp_path / "logs/simulate").iterdir()
    text = file.read_text()
    for name, content in {
        "cut": text[:-20],
        "other": text,
        "list": "[1, 2]",
        "odd": json.dumps({**json.loads(text), "reason": 3}),
        "large": text + " " * 200_000,
        "deep": "[" * 50_000,
    }.items():
        file.with_name(f"{name}.failed.json").write_text(content)
    assert list(failures(tmp_path)) == ["sound"]


def test_the_end_of_a_log_is_whole_lines(tmp_path):
    assert log_end(tmp_path, "P50N-1") == ""
    file = log_file(tmp_path, "P50N-1")
    file.parent.mkdir(parents=True)
    file.write_bytes(b"cycle 1\ncycle 2\n\xffcycle 3\n")
    assert log_end(tmp_path, "P50N-1") == "cycle 1\ncycle 2\n\ufffdcycle 3\n"
    assert log_end(tmp_path, "P50N-1", most=12) == "\ufffdcycle 3\n"


def test_simulations_are_added_up_and_what_was_not_measured_counts_for_nothing(tmp_path):
    def write(name, row):
        file = tmp_path / "benchmarks" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"{HEAD}{row}\n", encoding="utf-8")

    assert spent_on_simulations(tmp_path) is None
    write("batches/long.tsv", "1\t0:01\t" + "9" * 200_000)
    assert spent_on_simulations(tmp_path) is None
    write("simulate/a.tsv", "0.2\t0:00:00\t-\tNA")
    (tmp_path / "benchmarks/simulate/b.tsv").write_bytes(b"\xff\xfe not a table")
    spent = spent_on_simulations(tmp_path)
    assert (spent.jobs, spent.seconds, spent.processor_seconds) == (1, 0.2, 0.0)
    assert spent.memory_bytes != spent.memory_bytes
    write("simulate/a.tsv", "2.0\t0:00:02\t100\t1.5")
    write("simulate/b.tsv", "3.0\t0:00:03\t200\t2.5")
    write("merge.tsv", "9.0\t0:00:09\t900\t9.0")
    spent = spent_on_simulations(tmp_path)
    assert (spent.jobs, spent.seconds, spent.processor_seconds) == (2, 5.0, 4.0)
    assert spent.memory_bytes == pytest.approx(200 * 2**20)


def test_records_that_cannot_be_written_or_lead_elsewhere_end_nothing(tmp_path):
    (tmp_path / "logs").write_text("no folder")
    record(tmp_path, "a", "broken")
    forget(tmp_path, "a")
    assert failures(tmp_path) == {}
    precious = tmp_path / "precious"
    precious.write_text("mine")
    (tmp_path / "logs").unlink()
    for file in (log_file(tmp_path, "a"), tmp_path / "logs/simulate/a.failed.json"):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.symlink_to(precious)
    assert log_end(tmp_path, "a") == "", "nobody else's file is shown in a report"
    record(tmp_path, "a", "broken")
    assert failures(tmp_path)["a"].reason == "broken"
    assert precious.read_text() == "mine"
