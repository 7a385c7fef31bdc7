"""The pages run and show their output, their links lead somewhere, their names are in files."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from examples import ExampleError, agrees, blocks, patch
from notebook import text_of

REPOSITORY = Path(__file__).resolve().parents[2]
DOCS = REPOSITORY / "docs"
PAGES = [
    DOCS / "tutorial.md",
    DOCS / "exercises.md",
    *sorted((DOCS / "how-to").glob("*.md")),
    REPOSITORY / "CONTRIBUTING.md",
]


def is_run_here(page):
    """Whether a page runs, and has not been run for its pictures when the site was built."""
    text = page.read_text(encoding="utf-8")
    is_in_site = "FRETWEAR_SITE" in os.environ and f"generated/{page.stem}/" in text
    return not is_in_site and any(block.is_run for block in blocks(text))


RUNNING = [page for page in PAGES if is_run_here(page)]


@pytest.fixture(scope="module")
def outcomes():
    """What two processes said that run half of the pages each, and their errors."""
    program = [sys.executable, DOCS / "extensions" / "examples.py"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    halves = [subprocess.Popen([*program, *RUNNING[n::2]], **pipes) for n in (0, 1)]
    return ["".join(parts) for parts in zip(*(half.communicate() for half in halves), strict=True)]


@pytest.mark.slow
@pytest.mark.parametrize("page", RUNNING, ids=lambda page: page.stem)
def test_a_page_runs_and_shows_what_it_prints(page, outcomes):
    said, errors = outcomes
    assert f"{page}: done\n" in said, errors[-9000:]


@pytest.mark.parametrize(
    ("shown", "printed", "is_same"),
    [
        ("0.9864 ± 0.0016", "0.9864 ± 0.0017", True),  # a unit of the last decimal
        ("0.9864 ± 0.0016", "0.9849 ± 0.0016", True),  # within the error
        ("wear 2.10 ± 0.30 µm", "wear 1.81 ± 0.30 µm", True),
        ("4 ± 1", "3 ± 1", True),
        ("1.0e-15 m3", "1.1e-15 m3", True),
        ("0.004", "0.005", True),
        ("10537 µm³", "10600 µm³", True),  # 1 %
        ("a\n...\n9.99 %", "a\nb\nc\n 10.01 %", True),
        ("0.9864 ± 0.0016", "0.9901 ± 0.0016 or so", False),
        ("0.9864 ± 0.0016", "1.0064 ± 0.0016", False),
        ("0.0250 ± 0.0001", "0.0254 ± 0.0001", False),
        ("24 cases", "23 cases", False),
        ("10537 µm³", "10700 µm³", False),
        ("P25N-N1000-abc12345", "P25N-N1001-abc12345", False),
        ("1.0e-15 m3", "1.0e-16 m3", False),
        ("file_101.nc", "file_102.nc", False),
    ],
)
def test_numbers_of_a_page_may_differ_within_their_error_and_their_last_decimal(
    shown, printed, is_same
):
    assert agrees(shown, printed) == is_same


def test_a_page_that_prints_other_digits_still_has_its_pictures(tmp_path):
    pictures = pytest.importorskip("pictures", reason="the extra docs is not installed")
    page = tmp_path / "page.md"
    page.write_text(
        "```bash\necho 23 cases\n```\n\n```text\n24 cases\n```\n\n"
        "```bash\ntouch one.svg\n```\n\n![One](generated/page/one.svg)\n"
    )
    with pytest.raises(ExampleError, match=r"shows\n24 cases\n+but it prints\n23 cases"):
        pictures.make(page, tmp_path / "made")
    assert (tmp_path / "made/one.svg").exists()


def test_the_notebook_has_the_text_and_code_of_its_page():
    made = text_of(DOCS / "exercises.md")
    assert (DOCS / "exercises.ipynb").read_text(encoding="utf-8") == made, "run notebook.py"
    cells = json.loads(made)["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    page = blocks((DOCS / "exercises.md").read_text(encoding="utf-8"))
    assert code == [block.text.strip() for block in page if block.language == "python"]


def test_a_diff_changes_the_one_place_that_has_its_lines(tmp_path):
    file = tmp_path / "law.py"
    file.write_text("a = 1\n\nb = 2\na = 1\n")
    patch("+++ law.py\n@@ between\n a = 1\n\n-b = 2\n+b = 3\n+c = 4\n", tmp_path)
    assert file.read_text() == "a = 1\n\nb = 3\nc = 4\na = 1\n"
    for lines in (" a = 1\n", "-b = 2\n", " = 3\n"):  # twice, no longer, part of a line
        with pytest.raises(ExampleError, match=r"law\.py does not have these lines in one place"):
            patch(f"+++ law.py\n@@\n{lines}+d = 5\n", tmp_path)


def test_every_block_that_is_not_run_says_why_and_the_tutorial_installs_as_the_readme_does():
    for page in PAGES:
        for block in blocks(page.read_text(encoding="utf-8")):
            if block.language not in ("bash", "python", "yaml", "diff", "text"):
                assert not block.is_run, f"{page.name}, line {block.line}"
            if not block.is_run:
                assert len(block.note.removeprefix("not run: ")) > 10
    (readme, *_) = re.findall(r"```bash\n(.*?)```", (REPOSITORY / "README.md").read_text(), re.S)
    (tutorial, *_) = re.findall(r"```bash\n(.*?)```", (DOCS / "tutorial.md").read_text(), re.S)
    assert tutorial == readme


LINKED = [
    *(REPOSITORY / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *(page for page in sorted(DOCS.rglob("*.md")) if "generated" not in page.parts),
]


def test_pages_link_to_nothing_outside_and_files_that_readers_are_sent_to_exist():
    outside = {"https://semver.org"}
    for page in LINKED:
        text = page.read_text(encoding="utf-8")
        assert set(re.findall(r"https?://[^\s)>]+", text)) <= outside, page.name
        files = r"\b(?:tests|benchmarks|docs|src)/[\w./-]+\.(?:py|md|csv)\b"
        for name in re.findall(files, text):
            assert (REPOSITORY / name).exists(), f"{page.name}: {name}"
