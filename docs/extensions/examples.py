"""Run the blocks of a page of the documentation, and compare their output with the page.

The blocks of a page run in order, in one folder that begins as a copy of the parts of the
repository that pages need (`Snakefile`, `profiles/`, `studies/`):

- ``yaml``: a file; its first line is a comment with the name, ``# studies/mine.yaml``. The line
  ``# in studies/mine.yaml`` instead changes single entries of an existing file.
- ``bash``: commands, run by bash as they stand; the first that fails ends them.
- ``python``: run like the cells of a notebook, with one set of names for the whole page.
- ``diff``: changes of a copy of the package, with which the blocks after it run, each of ``python``
  in a process of its own. A hunk has no line numbers: its old lines stand in one place of the file.
- ``text``: the output of the block before it, with ``...`` for omissions. Numbers agree within
  1 %, the error that stands after them (``0.986 ± 0.002``), or a unit of their last decimal.

A comment above a block says what else to expect: ``<!-- fails with status 2 -->`` or
``<!-- not run: the reason -->``. Blocks of any other language are an error unless they are not run.

    python docs/extensions/examples.py docs/tutorial.md           runs a page
    python docs/extensions/examples.py --write docs/tutorial.md   and writes its output into it
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

REPOSITORY = Path(__file__).resolve().parents[2]
NEEDED = ("Snakefile", "profiles", "studies")

_BLOCK = re.compile(
    r"(?:^<!-- (?P<note>[^>]*) -->\n+)?^```(?P<language>\w+)\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
# With decimals, or whole ones that stand alone: digits of a name are words.
_NUMBER = r"\d+\.\d+(?:e[+-]\d+)?|(?<![\w.-])\d+(?![\w.-])"
_TOLERANCE = 0.01


class ExampleError(AssertionError):
    """A block did not run, or its output differs from the page."""


@dataclass(frozen=True)
class Block:
    """One fenced block of a page."""

    language: str
    text: str
    note: str  # the comment above it
    line: int  # of its first line in the page
    start: int  # of its text in the page

    @property
    def is_run(self) -> bool:
        """Whether the block is meant to run."""
        return not self.note.startswith("not run: ")


def blocks(page: str) -> list[Block]:
    """Find the fenced blocks of a page."""
    return [
        Block(
            block["language"],
            block["text"],
            (block["note"] or "").strip(),
            page.count("\n", 0, block.start("text")) + 1,
            block.start("text"),
        )
        for block in _BLOCK.finditer(page)
    ]


class Session:
    """Runs the blocks of one page, in a folder of its own.

    Parameters
    ----------
    folder : pathlib.Path
        Where to run; what pages need of the repository is copied there.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._sources = folder / "src"  # the copy of the package, once a block has changed it
        self._names: dict[str, Any] = {"__name__": "__main__"}
        for name in NEEDED:
            source = REPOSITORY / name
            copy = shutil.copytree if source.is_dir() else shutil.copy
            copy(source, folder / name)

    def run(self, block: Block) -> str:
        """Run a block and return its output."""
        kinds = {"bash": self._bash, "python": self._python, "yaml": self._yaml, "diff": self._diff}
        if block.language not in kinds:
            raise ExampleError(
                f"line {block.line}: a block of {block.language} cannot be run; "
                "write <!-- not run: the reason --> above it"
            )
        return kinds[block.language](block)

    def _bash(self, block: Block) -> str:
        return self._process(block, ["bash", "-euo", "pipefail", "-c", block.text])

    def _process(self, block: Block, command: list[str]) -> str:
        # Commands come from the Python that runs this, whether or not its environment is active.
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        environment = {**os.environ, "PATH": path, "COLUMNS": "100", "NO_COLOR": "1"}
        if self._sources.exists():
            environment["PYTHONPATH"] = str(self._sources)
        done = subprocess.run(
            command,
            cwd=self.folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        fails = re.fullmatch(r"fails with status (\d+)", block.note)
        if done.returncode != (status := int(fails[1]) if fails else 0):
            raise ExampleError(
                f"line {block.line}: exit status {done.returncode} instead of {status} "
                f"of\n{block.text}\n{done.stdout}"
            )
        return done.stdout

    def _python(self, block: Block) -> str:
        if self._sources.exists():
            return self._process(block, [sys.executable, "-W", "ignore", "-c", block.text])
        printed = io.StringIO()
        before = Path.cwd()
        os.chdir(self.folder)
        try:
            with contextlib.redirect_stdout(printed):
                code = compile(block.text, f"line {block.line}", "exec", dont_inherit=True)
                exec(code, self._names)
        except Exception as error:
            raise ExampleError(f"line {block.line}: {error!r} in\n{block.text}") from error
        finally:
            os.chdir(before)
        return printed.getvalue()

    def _diff(self, block: Block) -> str:
        if not self._sources.exists():
            compiled = shutil.ignore_patterns("__pycache__", "*.egg-info")
            shutil.copytree(REPOSITORY / "src", self._sources, ignore=compiled)
        try:
            patch(block.text, self.folder)
        except ExampleError as error:
            raise ExampleError(f"line {block.line}: {error}") from error
        return ""

    def _yaml(self, block: Block) -> str:
        heading = re.match(r"# (in )?(\S+\.yaml)\n", block.text)
        if not heading:
            raise ExampleError(
                f"line {block.line}: the first line of a block of yaml is the name of its file, "
                "as # studies/mine.yaml"
            )
        file = self.folder / heading[2]
        text = block.text
        if heading[1]:
            changed = yaml.safe_load(file.read_text(encoding="utf-8"))
            text = yaml.safe_dump(_updated(changed, yaml.safe_load(text)), sort_keys=False)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        return ""


def patch(diff: str, folder: Path) -> None:
    """Apply a diff without line numbers to the files of a folder, each named after ``+++``."""
    for change in re.split(r"^\+\+\+ ", diff, flags=re.MULTILINE)[1:]:
        name, _, hunks = change.partition("\n")
        file = folder / name.strip()
        text = file.read_text(encoding="utf-8")
        for hunk in re.split(r"^@@.*\n", hunks, flags=re.MULTILINE)[1:]:
            lines = [line if line.strip() else " \n" for line in hunk.splitlines(keepends=True)]
            old, new = (
                "".join(line[1:] for line in lines if line[0] in kinds) for kinds in (" -", " +")
            )
            if f"\n{text}".count(f"\n{old}") != 1:
                raise ExampleError(f"{name} does not have these lines in one place:\n{old}")
            text = f"\n{text}".replace(f"\n{old}", f"\n{new}")[1:]
        file.write_text(text, encoding="utf-8")


def _updated(old: Any, new: Any) -> Any:
    if not (isinstance(old, dict) and isinstance(new, dict)):
        return new
    return {**old, **{key: _updated(old.get(key), value) for key, value in new.items()}}


def outputs(page: str, session: Session) -> Iterator[tuple[Block, str]]:
    """Run a page; yield each block of shown output with the actual output."""
    printed = ""
    for block in blocks(page):
        if not block.is_run:
            continue
        if block.language == "text":
            yield block, printed
        else:
            printed = session.run(block)


def agrees(shown: str, printed: str) -> bool:
    """Return whether the shown output agrees with the actual one, by the rules of this file."""
    parts = [part for part in re.split(rf"(\.\.\.|{_NUMBER}|\s+)", shown.strip()) if part]
    pattern = "".join(
        ".*?"
        if part == "..."
        else f"({_NUMBER})"
        if re.fullmatch(_NUMBER, part)
        else r"\s+"
        if part.isspace()
        else re.escape(part)
        for part in parts
    )
    match = re.fullmatch(pattern, printed.strip(), re.DOTALL)
    if match is None:
        return False
    places = [place for place, part in enumerate(parts) if re.fullmatch(_NUMBER, part)]
    return all(
        abs(float(parts[place]) - float(number)) <= 1.001 * _allowed(parts[place:])
        for place, number in zip(places, match.groups(), strict=True)
    )


def _allowed(parts: list[str]) -> float:
    """By how much a number, with which the parts begin, may differ."""
    number, *rest = parts
    error = re.match(rf"\s*±\s*({_NUMBER})", "".join(rest))
    digits, _, power = number.partition("e")
    unit = 10.0 ** (int(power or 0) - len(digits.partition(".")[2])) if "." in digits else 0.0
    return max(_TOLERANCE * float(number), unit, float(error[1]) if error else 0.0)


def differences(page: str, session: Session) -> str:
    """Run a page to its end; return where its output differs from the page, empty if nowhere."""
    return "\n".join(
        f"line {block.line}: the page shows\n{block.text}\nbut it prints\n{printed}"
        for block, printed in outputs(page, session)
        if not agrees(block.text, printed)
    )


def written(page: str, session: Session) -> str:
    """Run a page and return it with the actual output in place of output that differs."""
    result, end = "", 0
    for block, printed in list(outputs(page, session)):
        text = block.text if agrees(block.text, printed) else printed
        result += page[end : block.start] + text
        end = block.start + len(block.text)
    return result + page[end:]


def run_page(file: Path, *, write: bool = False) -> None:
    """Run a page and compare it with its output, or write its output into it."""
    page = file.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        session = Session(Path(folder))
        if write:
            file.write_text(written(page, session), encoding="utf-8")
        elif different := differences(page, session):
            raise ExampleError(different)
    print(f"{file}: done")


def main() -> None:
    """Run pages; with ``--write``, write their output into them."""
    parser = argparse.ArgumentParser(description="Run what pages of the documentation show.")
    parser.add_argument("--write", action="store_true", help="write what is printed into the page")
    parser.add_argument("pages", nargs="+", type=Path)
    arguments = parser.parse_args()
    status = 0
    for file in arguments.pages:
        try:
            run_page(file, write=arguments.write)
        except ExampleError as error:
            print(f"{file}: {error}", file=sys.stderr)
            status = 1
    sys.exit(status)


if __name__ == "__main__":
    main()
