"""Pages of the documentation that are made of measurements: measured, kept as JSON, written.

A page is a row of sections. What a section measures is kept in a JSON file beside the page, from
which page and figures are written, so that a page can be rewritten without measuring anew.
"""

import argparse
import json
import math
import os
import platform
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from textwrap import fill
from typing import Any

from matplotlib.figure import Figure

from fretwear.figures import save_as

ROOT = Path(__file__).resolve().parents[1]
DIGITS = 6
WIDTH = 150  # of the lines of a page's introduction, in characters

Data = dict[str, Any]
"""The data of a section: numbers, texts, and lists and dictionaries of them, as in JSON."""


def no_figures(_: Data) -> dict[str, Figure]:
    """The figures of a section that has none."""
    return {}


@dataclass(frozen=True)
class Section:
    """A part of a page.

    Parameters
    ----------
    name
        Key of its data and beginning of its figures' names.
    title
        Heading.
    measure
        Finds its data.
    text
        Markdown below the heading, if it is not written by the page's lead; a figure goes where
        the text has ``{figure:name}``, or ``{figure}`` for the one named by an empty string.
    figures
        Figures by name.
    on_request
        Whether it is measured only where its name is given.
    """

    name: str
    title: str
    measure: Callable[[], Data]
    text: Callable[[Data], str] | None = None
    figures: Callable[[Data], dict[str, Figure]] = no_figures
    on_request: bool = False

    def stem(self, figure: str) -> str:
        """Name of a figure's file without its ending."""
        return f"{self.name}_{figure}" if figure else self.name


@dataclass(frozen=True)
class Page:
    """A page ``docs/NAME.md``, its data ``NAME.json`` and its figures ``images/NAME/*.svg``.

    Parameters
    ----------
    name
        Name of the page, and of the module that measures it: ``python -m benchmarks.NAME``.
    introduction
        Text above the sections, with their ``{names}``, the ``{minutes}`` that they took and the
        ``{versions}`` of libraries.
    sections
        What it is made of.
    lead
        Writes what stands between introduction and sections from the data of all of these.
    """

    name: str
    introduction: str
    sections: tuple[Section, ...]
    lead: Callable[[Data], str] | None = None

    def load(self, docs: Path) -> Data:
        """The data measured so far, by section."""
        path = docs / f"{self.name}.json"
        return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}

    def measure(self, docs: Path, section: Section) -> None:
        """Measure a section and keep its data; if a library is missing, the old data stay."""
        print(f"== {section.title}", flush=True)
        started = sum(os.times()[:4])  # with processes that have ended
        try:
            data = section.measure()
        except ModuleNotFoundError as missing:
            print(f"skipped: {missing.name} is not installed")
            return
        seconds = round(sum(os.times()[:4]) - started)
        print(f"{seconds} s", flush=True)
        versions = {name: version(name) for name in ("fretwear", "numpy", "scipy")}
        versions = {"Python": platform.python_version(), **versions}
        entry = {"versions": versions, "seconds": seconds, "data": rounded(data)}
        write_json(docs / f"{self.name}.json", self.load(docs) | {section.name: entry})

    def render(self, entries: Data) -> str:
        """The page in Markdown."""
        parts, seconds, versions = [], 0, dict[str, None]()
        for section in self.sections:
            if section.name not in entries:
                continue
            entry = entries[section.name]
            seconds += 0 if section.on_request else entry["seconds"]

            def image(match: re.Match[str], section: Section = section) -> str:
                stem = section.stem(match[1] or "")
                return f"![{section.title}](images/{self.name}/{stem}.svg)"

            versions |= {f"{name} {number}": None for name, number in entry["versions"].items()}
            if section.text is not None:
                text = section.text(entry["data"])
                text = re.sub(r"\{figure(?::(\w+))?\}", image, text).rstrip()
                parts.append(f"## {section.title}\n\n{text}")
        head = self.introduction.format(
            minutes="a minute" if seconds <= 60 else f"{-(-seconds // 60)} minutes",
            versions=", ".join(versions),
            names=", ".join(f"`{section.name}`" for section in self.sections),
        )
        if self.lead is not None:
            parts.insert(0, self.lead({name: each["data"] for name, each in entries.items()}))
        return "\n\n".join(part.strip("\n") for part in [wrapped(head), *parts]) + "\n"

    def write(self, docs: Path) -> None:
        """Write the page and its figures to a folder."""
        entries = self.load(docs)
        folder = docs / "images" / self.name
        folder.mkdir(parents=True, exist_ok=True)
        for section in self.sections:
            if section.name in entries:
                for name, figure in section.figures(entries[section.name]["data"]).items():
                    save_as(figure, folder / f"{section.stem(name)}.svg")
        (docs / f"{self.name}.md").write_text(self.render(entries), encoding="utf-8")

    def check(self, docs: Path) -> int:
        """Exit status: 0 if the page in a folder agrees with its data, else 1."""
        page = docs / f"{self.name}.md"
        if page.exists() and page.read_text(encoding="utf-8") == self.render(self.load(docs)):
            return 0
        print(f"{page} is not what its data say: python -m benchmarks.{self.name} --render")
        return 1

    def main(self, arguments: Sequence[str] | None = None) -> int:
        """Measure sections and write the page; with ``--render`` or ``--check`` measure none."""
        names = [section.name for section in self.sections]
        parser = argparse.ArgumentParser(prog=f"python -m benchmarks.{self.name}")
        parser.add_argument(
            "sections", nargs="*", metavar="SECTION", help=f"what to measure, of {', '.join(names)}"
        )
        parser.add_argument("--render", action="store_true", help="write the page from stored data")
        parser.add_argument("--check", action="store_true", help="say whether the page is current")
        parser.add_argument("--docs", type=Path, default=ROOT / "docs", help="folder of the page")
        options = parser.parse_args(arguments)
        if unknown := sorted(set(options.sections) - set(names)):
            parser.error(f"no such section: {', '.join(unknown)}; there are {', '.join(names)}")
        if options.check:
            return self.check(options.docs)
        usual = [each.name for each in self.sections if not each.on_request]
        wanted = [each for each in self.sections if each.name in (options.sections or usual)]
        for section in () if options.render else wanted:
            self.measure(options.docs, section)
        self.write(options.docs)
        return 0


def write_json(path: Path, content: Data) -> None:
    """Write data as an indented JSON file, into a folder that is made if it is missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(content, indent=1, ensure_ascii=False) + "\n"
    path.write_text(text, encoding="utf-8")


def rounded(value: object) -> object:
    """The same data with floats of as many digits as a reader can use."""
    if isinstance(value, dict):
        return {str(key): rounded(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(entry) for entry in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def wrapped(text: str) -> str:
    """Paragraphs on lines of at most `WIDTH` characters that end between words, not in code."""
    glued = re.sub(r"`.*?`", lambda code: code[0].replace(" ", "\0"), text, flags=re.DOTALL)
    lines = (
        fill(paragraph, WIDTH, break_long_words=False, break_on_hyphens=False)
        for paragraph in glued.split("\n\n")
    )
    return "\n\n".join(lines).replace("\0", " ")


def table(header: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> str:
    """A Markdown table, so many first columns to the left, the others to the right."""
    rules = ["---"] * left + ["---:"] * (len(header) - left)
    lines = [list(header), rules, *map(list, rows)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def percent(fraction: float) -> str:
    """A signed deviation in per cent with two significant digits; tiny ones as powers of ten."""
    if fraction == 0.0:
        return "0"
    if abs(fraction) < 1e-6:
        return scientific(fraction, "+.1e")
    decimals = min(max(1 - math.floor(math.log10(abs(100.0 * fraction))), 0), 6)
    return f"{100.0 * fraction:+.{decimals}f} %"


def named(deviations: Mapping[str, float]) -> str:
    """Deviations in size, each with its name."""
    return ", ".join(f"{name} {percent(abs(each))[1:]}" for name, each in deviations.items())


def scientific(value: float, form: str = ".0e") -> str:
    """A number in powers of ten, without zeros before the exponent."""
    return f"{value:{form}}".replace("e-0", "e-")


def worst(deviations: Iterable[float]) -> float:
    """The deviation that is largest in size, with its sign."""
    return max(deviations, key=abs)
