import json

from fretwear.running.records import ENDED, failures, forget, log_end, log_file, reasons, record


def test_a_failed_case_is_told_with_its_reason_and_its_log(tmp_path):
    record(tmp_path, "P50N-1", "no step after cycle 3 comes to an end")
    (failure,) = failures(tmp_path).values()
    assert (failure.case_id, failure.reason) == ("P50N-1", "no step after cycle 3 comes to an end")
    assert tmp_path / failure.log == log_file(tmp_path, "P50N-1")
    assert reasons(tmp_path) == {
        "P50N-1": "no step after cycle 3 comes to an end (log: logs/simulate/P50N-1.log)"
    }


def test_a_case_whose_process_vanished_is_told_as_well(tmp_path):
    record(tmp_path, "killed")
    assert failures(tmp_path)["killed"].reason == ENDED
    record(tmp_path, "killed", "out of memory")
    assert failures(tmp_path)["killed"].reason == "out of memory"


def test_a_case_that_has_a_result_now_is_not_told(tmp_path):
    record(tmp_path, "first", "broken")
    record(tmp_path, "second", "broken")
    forget(tmp_path, "first")
    forget(tmp_path, "never failed")
    assert list(failures(tmp_path)) == ["second"]


def test_a_study_without_failures_has_none(tmp_path):
    assert failures(tmp_path) == {}
    assert reasons(tmp_path / "missing") == {}


def test_records_that_are_cut_short_or_of_something_else_are_passed_over(tmp_path):
    record(tmp_path, "sound", "broken")
    (file,) = (tmp_path / "logs/simulate").iterdir()
    text = file.read_text()
    file.with_name("cut.failed.json").write_text(text[:-20])
    file.with_name("other.failed.json").write_text(text)
    file.with_name("list.failed.json").write_text("[1, 2]")
    file.with_name("odd.failed.json").write_text(json.dumps({**json.loads(text), "reason": 3}))
    file.with_name("large.failed.json").write_text(text + " " * 200_000)
    assert list(failures(tmp_path)) == ["sound"]


def test_the_end_of_a_log_is_whole_lines(tmp_path):
    assert log_end(tmp_path, "P50N-1") == ""
    file = log_file(tmp_path, "P50N-1")
    file.parent.mkdir(parents=True)
    file.write_bytes(b"cycle 1\ncycle 2\n\xffcycle 3\n")
    assert log_end(tmp_path, "P50N-1") == "cycle 1\ncycle 2\n\ufffdcycle 3\n"
    assert log_end(tmp_path, "P50N-1", most=12) == "\ufffdcycle 3\n"
