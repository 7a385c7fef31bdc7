"""The pages run: every block of commands, Python and YAML, and they show its output."""

import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import nbformat
import pytest
from examples import ExampleError, Session, agrees, blocks, check, notebook, written

REPOSITORY = Path(__file__).resolve().parents[2]
DOCS = REPOSITORY / "docs"
PAGES = [
    DOCS / "tutorial.md",
    *sorted((DOCS / "how-to").glob("*.md")),
    REPOSITORY / "CONTRIBUTING.md",
]
RUNNING = [page for page in PAGES if any(block.is_run for block in blocks(page.read_text()))]


@pytest.fixture(scope="module")
def outcomes():
    """What became of every page; two at a time, each in a process of its own."""

    def run(page):
        command = [sys.executable, DOCS / "extensions" / "examples.py", page]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    with ThreadPoolExecutor(2) as pool:
        return dict(zip(RUNNING, pool.map(run, RUNNING), strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("page", RUNNING, ids=lambda page: page.stem)
def test_a_page_runs_and_shows_what_it_prints(page, outcomes):
    assert outcomes[page].returncode == 0, outcomes[page].stderr[-3000:]


def test_every_block_that_is_not_run_says_why_and_the_tutorial_installs_as_the_readme_does():
    for page in PAGES:
        for block in blocks(page.read_text(encoding="utf-8")):
            if block.language not in ("bash", "python", "yaml", "text"):
                assert not block.is_run, f"{page.name}, line {block.line}"
            if not block.is_run:
                assert len(block.note.removeprefix("not run: ")) > 10
    (readme, *_) = re.findall(r"```bash\n(.*?)```", (REPOSITORY / "README.md").read_text(), re.S)
    (tutorial, *_) = re.findall(r"```bash\n(.*?)```", (DOCS / "tutorial.md").read_text(), re.S)
    assert tutorial == readme


def page_of(*parts):
    return "\n\n".join(parts) + "\n"


def fence(language, text):
    return f"```{language}\n{text}\n```"


@pytest.mark.parametrize(
    ("block", "complaint"),
    [
        (fence("bash", "exit 3"), "exit status 3 instead of 0"),
        (fence("python", "1 / 0"), "ZeroDivisionError"),
        (fence("yaml", "title: no name"), "the name of its file"),
        (fence("matlab", "x = 1"), "cannot be run"),
        (page_of(fence("bash", "echo one"), fence("text", "two")), "but it prints"),
        ("<!-- fails with status 2 -->\n" + fence("bash", "true"), "exit status 0 instead of 2"),
    ],
)
def test_a_page_that_does_not_hold_is_found(block, complaint, tmp_path):
    with pytest.raises(ExampleError, match=complaint):
        check(page_of("Some text.", block), Session(tmp_path))


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("a  b", "a b", True),
        ("first\n...\nlast", "first\nmore\nlast", True),
        ("volume 1.234", "volume 1.240", True),
        ("volume 1.234", "volume 1.340", False),
        ("12 steps", "13 steps", False),
        ("first ... 2.00", "first 7.00 2.01", True),
    ],
)
def test_shown_and_printed_agree_but_for_what_is_left_out_and_the_last_digits(shown, printed, same):
    assert agrees(shown, printed) is same


def test_what_is_printed_can_be_written_into_a_page_and_its_python_into_a_notebook(tmp_path):
    page = page_of(fence("bash", "echo new"), fence("text", "old"), "End.")
    assert written(page, Session(tmp_path)) == page.replace("old", "new")
    page = (DOCS / "how-to" / "notebook.md").read_text(encoding="utf-8")
    book = nbformat.reads(notebook(page), as_version=4)
    nbformat.validate(book)
    code = [cell.source for cell in book.cells if cell.cell_type == "code"]
    assert code == [block.text.strip() for block in blocks(page) if block.language == "python"]
    text = "\n".join(cell.source for cell in book.cells if cell.cell_type == "markdown")
    assert "## Save it" in text
    assert "```" not in text
    assert "](" not in text
