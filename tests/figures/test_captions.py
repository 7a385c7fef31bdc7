"""Snakemake's own report shows every figure with its caption, category and labels."""

import json
from pathlib import Path

from docutils.core import publish_parts
from jinja2 import Environment

from fretwear.figures.captions import caption_template, figure_category, figure_labels
from fretwear.figures.study import INDEX_NAME, FigureEntry

ODD = (
    'Load *P* at 50 %, {{ 1 }} and {% raw %}, a_b_ `c` |d| <i>"e"</i> \\ of µ = 0.3. Colour: load.'
)
ENTRIES = [
    FigureEntry("wear_map", ODD, "Over the contact"),
    FigureEntry("wear_volume", "Wear volume.", "Over the cycles"),
]


class _Snakemake:
    """What Snakemake hands to the template of a caption."""

    def __init__(self, figure: str) -> None:
        self.wildcards = type("Wildcards", (), {"figure": figure})


def _rendered(figure: str) -> str:
    template = Environment().from_string(caption_template(ENTRIES))
    text = template.render(snakemake=_Snakemake(figure))
    return str(publish_parts(text, writer="html")["body"])


def test_a_caption_is_read_as_it_was_written() -> None:
    expected = ODD.replace("<", "&lt;").replace(">", "&gt;").replace('"', "&quot;")
    assert _rendered("wear_map").strip() == f"<p>{expected}</p>"
    assert _rendered("wear_volume").strip() == "<p>Wear volume.</p>"


def test_category_and_labels_are_those_of_the_index(tmp_path: Path) -> None:
    caption = "Wear over the contact. Lines: edges."
    index = [{"name": "wear_map", "caption": caption, "category": "Over the contact"}]
    (tmp_path / INDEX_NAME).write_text(json.dumps(index), encoding="utf-8")
    assert figure_category(tmp_path, "wear_map") == "Over the contact"
    assert figure_labels(tmp_path, "wear_map") == {
        "figure": "wear_map",
        "shows": "Wear over the contact",
    }
