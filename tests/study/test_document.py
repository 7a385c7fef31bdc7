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


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("base:\n  load: 1 N\n  load: 2 N\n", "first in line 2"),
        # YAML 1.2 makes a key of a word that ends in a colon, the library that reads it a text.
        ("a: [1, 010:, 3]\n", "key without a value"),
        ("a: {b: c:}\n", "key without a value"),
        *(
            (text, "not text")
            for text in ("1: a\n", "{[1, 2]: a}\n", "? {a: b}\n: c\n", "true: a\n")
        ),
        ("a: &x {b: 1}\nc:\n  <<: *x\n", "merge"),
    ],
)
def test_keys_that_no_study_has_are_problems(tmp_path, text, words):
    (problem,) = read(tmp_path, text).problems
    assert words in problem.rule
    if "twice" in problem.rule or "load" in problem.key:
        assert (problem.key, problem.value, problem.line) == ("base.load", "2 N", 3)


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


def test_a_pipe_is_refused_without_waiting_and_a_byte_order_mark_is_no_text(tmp_path):
    os.mkfifo(tmp_path / "pipe.yaml")
    with pytest.raises(StudyError, match="not a regular file"):
        read_document(tmp_path / "pipe.yaml")
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
