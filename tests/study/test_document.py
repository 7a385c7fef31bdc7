import os

import pytest

from fretwear.study.problems import StudyError
from fretwear.study.yamlfile import MAX_BYTES, parse_value, read_document


def read(folder, text):
    file = folder / "study.yaml"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_document(file)


def refusal(folder, text):
    with pytest.raises(StudyError) as caught:
        read(folder, text)
    assert str(folder / "study.yaml") in str(caught.value)
    return str(caught.value)


def test_values_come_with_the_lines_they_stand_in(tmp_path):
    document = read(tmp_path, "a: 1\nb:\n  - x\n  - {c: 2.5}\nroughness.amplitude: [1]\n")
    assert document.data == {"a": 1, "b": ["x", {"c": 2.5}], "roughness.amplitude": [1]}
    lines = {key: document.lines[key] for key in ("a", "b", "b[1]", "b[1].c")}
    assert lines == {"a": 1, "b": 2, "b[1]": 4, "b[1].c": 4}
    assert document.lines["roughness.amplitude[0]"] == 5
    assert document.problems == []


def test_a_key_given_twice_is_a_problem_with_both_lines(tmp_path):
    (problem,) = read(tmp_path, "base:\n  load: 1 N\n  load: 2 N\n").problems
    assert (problem.key, problem.value, problem.line) == ("base.load", "2 N", 3)
    assert "first in line 2" in problem.rule


@pytest.mark.parametrize("text", ["a: [1, 010:, 3]\n", "a: {b: c:}\n"])
def test_a_colon_that_ends_a_word_in_brackets_is_a_problem(tmp_path, text):
    """YAML 1.2 makes a key of the word, the library that reads it a text."""
    (problem,) = read(tmp_path, text).problems
    assert "key without a value" in problem.rule


@pytest.mark.parametrize("text", ["1: a\n", "{[1, 2]: a}\n", "? {a: b}\n: c\n", "true: a\n"])
def test_a_key_that_is_not_text_is_a_problem(tmp_path, text):
    (problem,) = read(tmp_path, text).problems
    assert "not text" in problem.rule


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("a: [1, 2\n", "not YAML"),
        ("a: b: c\n", "not YAML"),
        ("a:\n\t- b\n", "not YAML"),
        ("a: 1\n---\nb: 2\n", "not YAML"),
        ("a: 3\u20284\n", "U+2028 in line 1"),
        ("a: 1\nb: [\x851]\n", "U+0085 in line 2"),
        ("", "empty"),
        ("# only a comment\n", "empty"),
        ("a: \x00\n", "not YAML"),
        (b"a: \xff\xfe\n", "not UTF-8"),
        ("[" * 1000, "levels deep"),
        ("{a: " * 1000, "levels deep"),
        ("a: " + "x" * MAX_BYTES, "larger than 1000 kB"),
        ("a: *b\n", "not YAML"),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_reason(tmp_path, text, part):
    assert part in refusal(tmp_path, text)


@pytest.mark.parametrize(
    "text", ["a: !!python/object/apply:os.getcwd []\n", "a: !!python/name:os.system x\n", "a: !x y"]
)
def test_tags_that_would_make_objects_make_problems(tmp_path, text):
    document = read(tmp_path, text)
    assert document.problems or document.data == {"a": []}
    assert document.data["a"] in ([], "x", "y")


def test_aliases_are_followed_but_cannot_explode(tmp_path):
    assert read(tmp_path, "a: &x [1]\nb: *x\n").data == {"a": [1], "b": [1]}
    levels = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    for level in range(1, 9):
        levels.append(f"a{level}: &a{level} [{', '.join([f'*a{level - 1}'] * 10)}]")
    assert "more than" in refusal(tmp_path, "\n".join(levels))
    assert "levels deep" in refusal(tmp_path, "a: &x [*x]\n")


def test_merge_keys_are_refused(tmp_path):
    (problem,) = read(tmp_path, "a: &x {b: 1}\nc:\n  <<: *x\n").problems
    assert "merge" in problem.rule


def test_a_pipe_is_refused_without_waiting_for_it(tmp_path):
    os.mkfifo(tmp_path / "pipe.yaml")
    with pytest.raises(StudyError, match="not a regular file"):
        read_document(tmp_path / "pipe.yaml")


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path):
    assert read(tmp_path, b"\xef\xbb\xbfa: 1\n").data == {"a": 1}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("30 N", "30 N"),
        ("0.3", 0.3),
        ("none", "none"),
        ("[0, 100]", [0, 100]),
        ("", ""),
        ("{kind: wavy, amplitude: 1 um}", {"kind": "wavy", "amplitude": "1 um"}),
    ],
)
def test_single_values_read_as_in_a_file(text, value):
    assert parse_value(text) == value
