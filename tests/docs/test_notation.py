"""One symbol has one meaning: in files, figures, reports and in the pages that derive equations."""

import re
import unicodedata
from pathlib import Path
from xml.etree import ElementTree

import pytest
from generated_reference import notation

PAGES = Path(__file__).resolve().parents[2] / "docs" / "explanation"

# A symbol stands for one quantity: given or found, of one body or the other, in one law or another.
SAME = (
    {"load", "normal_force"},
    {"indentation", "approach"},
    {"tangential_load", "tangential_force", "force"},
    {"sliding_amplitude", "slip"},
    {"cycles", "cycle"},
    {"frequency"},
    {"friction", "values"},
    {"depth", "z"},
    {"tangential_displacement", "displacement"},
    {"radius", "radii"},
    {"flat_half_width", "flat_radius"},
)


def test_no_symbol_stands_for_two_quantities():
    for symbol, declared in notation().items():
        names = {name.rpartition(".")[2] for name, _ in declared}
        assert len(names) == 1 or any(names <= same for same in SAME), symbol
        assert len({about.si_unit for _, about in declared}) == 1, symbol


# Functions, variables of integration, and constants that are explained where they are used.
LOCAL = {*"eπdtr∫⟨⟩′i", "′′", "cos", "sin", "tan", "asin", "ln", "min", "max"}
LOCAL |= {*"CFKZkζηθξρφχψλ", "k_x", "k_y", "K_xx", "q_x", "u_x", "u_y", "ε_a", "σ_n,max"}


def identifiers(mathml):
    """Every symbol of an equation with its index; starred ones as one symbol."""
    root = ElementTree.fromstring(re.sub(r' xmlns="[^"]*"', "", mathml))

    def text(element):
        return "".join("".join(element.itertext()).split())

    def walk(element):
        if element.tag in ("msub", "msup", "msubsup"):
            base, *ends = element
            if element.tag != "msup":
                yield f"{text(base)}_{text(ends[0])}"
            elif text(ends[0]) == "*":
                yield f"{text(base)}*"
            else:
                yield from (*walk(base), *walk(ends[0]))
        elif element.tag == "mi":
            yield text(element)
        else:
            for inside in element:
                yield from walk(inside)

    # Without the number of a body, and whether at first or in the limit; µ has two code points.
    return {unicodedata.normalize("NFKC", re.sub("_?[0-9∞]$", "", one)) for one in walk(root)}


@pytest.fixture(scope="module")
def of_latex():
    pytest.importorskip("sphinx", reason="the extra docs is not installed")
    mathml = pytest.importorskip("mathml", reason="the extra docs is not installed")
    return lambda latex: identifiers(mathml.to_mathml(latex, display="inline"))


@pytest.fixture(scope="module")
def known(of_latex):
    return set().union(*(of_latex(symbol.strip("$")) for symbol in notation())) | LOCAL


@pytest.mark.parametrize("page", ["mechanics"])
def test_pages_use_the_symbols_of_the_table(page, of_latex, known):
    text = (PAGES / f"{page}.md").read_text(encoding="utf-8")
    equations = re.findall(r"(\$\$?)(.+?)\1", text, re.DOTALL)
    assert set().union(*(of_latex(latex) for _, latex in equations)) <= known
