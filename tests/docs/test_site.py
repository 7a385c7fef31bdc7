"""The site builds without a warning, and asks the network for nothing."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("sphinx", reason="the extra docs is not installed")


DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The built site, or one without new pictures, which take minutes."""
    if "FRETWEAR_SITE" in os.environ:
        return Path(os.environ["FRETWEAR_SITE"])
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-d", folder / "trees"]
    command += ["-D", "run_examples=0", "-D"]
    command += ["suppress_warnings=myst.header,myst.xref_missing,image.not_readable"]
    subprocess.run([*command, DOCS, folder / "html"], check=True)
    return folder / "html"


LOADED = re.compile(
    r"<(?:script|img|iframe|source)\b[^>]*\bsrc=[\"']([^\"']*)"
    r"|<link\b(?![^>]*\brel=[\"'](?:canonical|index|search))[^>]*\bhref=[\"']([^\"']*)"
)


@pytest.mark.slow
def test_no_page_loads_anything_from_outside(site):
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 20
    for page in pages:
        loaded = ["".join(found) for found in LOADED.findall(page.read_text(encoding="utf-8"))]
        assert loaded
        assert not [address for address in loaded if re.match(r"(https?:)?//", address)], page.name
    for sheet in site.rglob("*.css"):
        assert not re.search(r"url\(['\"]?(https?:)?//", sheet.read_text(encoding="utf-8"))
    page = (site / "explanation" / "mechanics.html").read_text(encoding="utf-8")
    source = (DOCS / "explanation" / "mechanics.md").read_text(encoding="utf-8")
    assert page.count("<math ") == len(re.findall(r"\$\$.+?\$\$|\$.+?\$", source, re.DOTALL))
    assert "MathJax" not in page
