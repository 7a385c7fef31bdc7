"""The version of the package, and digests of the code that its numbers depend on.

The module imports no other of the package, because every start of the workflow loads it.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fretwear.study.case import Case

__version__ = "0.1.0"

SOURCES = (
    *("mechanics", "theory", "quantity.py", "results.py", "variable.py"),
    *("study/case.py", "study/cycles.py", "study/keys.py", "study/memory.py"),
    *("study/discretisation.py", "data/labels.py", "run/accuracy.py", "run/errors.py"),
    *("run/fields.py", "run/simulate.py", "run/states.py", "run/twin.py"),
)
"""Sources that turn the parameters of a case into the numbers in its file.

Sources that read, check or plan a case, or draw and report its numbers, do not count.
"""

LIBRARIES = ("numpy", "scipy", "ducc0")

# Texts are matched too, so that a sign in one opens neither a comment nor another text.
_TEXTS = re.compile(
    r'''(?P<alone>(?:(?<=:\n)[ ]+|^)r?"""[\s\S]*?"""[ ]*$)|"""[\s\S]*?"""|"(?:\\.|[^"\\\n])*"'''
    r"""|'(?:\\.|[^'\\\n])*'|(?P<comment>[ ]*\#.*)""",
    re.MULTILINE,
)


@cache
def code_digest(*packages: str) -> str:
    """Return the digest of the code that computes a case, and of `packages` beside this one.

    Hash of the statements (no comments, no docstrings) and of the libraries' minor versions:
    omitted parts do not change results. Every version of Python, a checkout and a wheel give the
    same digest.
    """
    here = Path(__file__).parent
    places = [here / name for name in SOURCES] + [here.parent / name for name in packages]
    digest = hashlib.sha256()
    for file in _python_files(places):
        digest.update(f"{file.relative_to(here.parent).as_posix()}\n".encode())
        digest.update(_statements(file.read_text(encoding="utf-8")).encode())
    for name in LIBRARIES:
        digest.update(f"{name} {minor_version(name)}\n".encode())
    return digest.hexdigest()[:16]


def case_digest(case: Case) -> str:
    """Return the digest of the code that computes a case, and of measured heights that it reads.

    Another version of the library that reads them may find other heights in the same file.
    """
    return "-".join([code_digest(*case.packages), *case.checksums])


def minor_version(library: str) -> str:
    """Return the first two numbers of the version of a library; empty if it is not installed."""
    try:
        return ".".join(metadata.version(library).split(".")[:2])
    except metadata.PackageNotFoundError:
        return ""


def _python_files(places: Iterable[Path]) -> list[Path]:
    return sorted(f for place in places for f in (place, *place.rglob("*.py")) if f.suffix == ".py")


def _statements(source: str) -> str:
    """Return a source without comments, and texts that stand alone."""

    def kept(found: re.Match[str]) -> str:
        return "" if found["comment"] or found["alone"] else found[0]

    without_comments = _TEXTS.sub(kept, source)  # some of which come before docstrings
    return " ".join(_TEXTS.sub(kept, without_comments).split())
