"""The site builds without a warning, and asks the network for nothing."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

pytest.importorskip("sphinx", reason="the extra docs is not installed")

from mathml import to_mathml

from fretwear.study.tree import parameter_names

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The built site; the pictures, which take minutes, are those of the last whole build."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-d", folder / "trees"]
    settings = ["-D", "run_examples=0", "-D", "suppress_warnings=myst.header,image.not_readable"]
    done = subprocess.run(
        [*command, *settings, DOCS, folder / "html"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return folder / "html"


class Loaded(HTMLParser):
    """Collects what a page makes a browser load, and its ids."""

    def __init__(self):
        super().__init__()
        self.addresses = []

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        if tag in ("script", "img", "iframe", "source"):
            self.addresses.append(given.get("src") or "")
        if tag == "link" and given.get("rel") not in ("canonical", "index", "search"):
            self.addresses.append(given.get("href") or "")


@pytest.mark.slow
def test_no_page_loads_anything_from_outside(site):
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 20
    for page in pages:
        loaded = Loaded()
        loaded.feed(page.read_text(encoding="utf-8"))
        outside = [address for address in loaded.addresses if re.match(r"(https?:)?//", address)]
        assert not outside, page.name
    for sheet in site.rglob("*.css"):
        assert not re.search(r"url\(['\"]?(https?:)?//", sheet.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_equations_are_mathml(site):
    page = (site / "explanation" / "mechanics.html").read_text(encoding="utf-8")
    source = (DOCS / "explanation" / "mechanics.md").read_text(encoding="utf-8")
    assert page.count("<math ") == len(re.findall(r"\$\$.+?\$\$|\$.+?\$", source, re.DOTALL))
    assert "MathJax" not in page


@pytest.mark.slow
def test_every_parameter_of_a_study_is_in_the_reference(site):
    page = (site / "reference" / "study-file.html").read_text(encoding="utf-8")
    for name in parameter_names():
        assert f">{name}<" in page


@pytest.mark.slow
def test_every_command_is_in_the_reference(site):
    help_text = subprocess.run(
        [sys.executable, "-m", "fretwear", "--help"], capture_output=True, text=True, check=True
    ).stdout
    page = (site / "reference" / "command-line.html").read_text(encoding="utf-8")
    commands = re.findall(r"^│ (\w+) {2,}[A-Z]", help_text, re.MULTILINE)
    assert {"run", "plan", "merge"} <= set(commands)
    for command in commands:
        assert f"fretwear {command}" in page


@pytest.mark.parametrize("latex", [r"\begin{aligned} a &= b \end{aligned}", r"\nosuchcommand{x}"])
def test_an_equation_that_is_not_understood_is_refused(latex):
    with pytest.raises(ValueError, match=r"understood|sound"):
        to_mathml(latex, display="block")
