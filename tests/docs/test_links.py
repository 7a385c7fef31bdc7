"""Every link of the pages, and of those in the root, leads to a file and a heading that exist."""

import importlib
import re
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
GUIDE = (REPOSITORY / "CONTRIBUTING.md").read_text(encoding="utf-8")
PAGES = sorted(
    [
        *(REPOSITORY / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
        *(
            page
            for page in (REPOSITORY / "docs").rglob("*.md")
            if "generated" not in page.relative_to(REPOSITORY).parts
        ),
    ]
)


def without_code(text):
    return re.sub(r"^```.*?^```$|`[^`\n]*`", "", text, flags=re.MULTILINE | re.DOTALL)


def links(page):
    return re.findall(r"\]\(([^)\s]+)\)", without_code(page.read_text(encoding="utf-8")))


def anchors(page):
    """Anchors of the headings, as they are made from their words."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    words = (title.strip().lower() for title in re.findall(r"^#+ (.*)$", text, re.MULTILINE))
    return {re.sub(r"[^\w\- ]", "", title).replace(" ", "-") for title in words}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_links_lead_somewhere(page):
    for link in links(page):
        target, _, anchor = link.partition("#")
        file = (page.parent / target).resolve() if target else page
        if target.startswith("https:"):
            continue
        if "/generated/" in target or target.startswith("generated/"):
            continue  # a picture that the page makes when the site is built
        assert file.exists(), f"{page.name}: {link}"
        if anchor:
            assert anchor in anchors(file), f"{page.name}: {link}"


def test_pages_link_to_nothing_outside_and_files_that_readers_are_sent_to_exist():
    outside = {"https://semver.org"}
    for page in PAGES:
        found = set(re.findall(r"https?://[^\s)>]+", page.read_text(encoding="utf-8")))
        assert found <= outside, page.name
    # Those named in any page, and those that the guide for contributors names by their room.
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for name in re.findall(
            r"\b(?:tests|benchmarks|docs|src)/[\w./-]+\.(?:py|md|csv|cpp)\b", text
        ):
            assert (REPOSITORY / name).exists(), f"{page.name}: {name}"
    named = set(re.findall(r"`([\w./-]+(?:\.py|\.md|/))`", GUIDE))
    assert len(named) > 20
    for name in named:
        places = (REPOSITORY / name, REPOSITORY / "src/fretwear" / name)
        assert any(place.exists() for place in places), name


def test_families_that_contributors_derive_from_have_the_methods_named():
    rows = re.findall(
        r"^\| [^|]*\| ((?:`\w+`(?:, )?)+) in `(.*?)\.py`[^|]*\| ([^|]*) \|$", GUIDE, re.M
    )
    assert len(rows) == 7
    for classes, file, methods in rows:
        module = importlib.import_module(f"fretwear.{file.replace('/', '.')}")
        families = [getattr(module, name) for name in re.findall(r"`(\w+)`", classes)]
        for method in re.findall(r"`(\w+)`", methods):
            assert any(hasattr(family, method) for family in families), (file, method)
