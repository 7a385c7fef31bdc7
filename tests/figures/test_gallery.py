"""The page of figures, which runs when the site is built, shows every public figure."""

from pathlib import Path

import pytest

from fretwear import figures

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "figures.md"
DRAWN = {name for name in figures.__all__ if name.islower()}


@pytest.mark.parametrize("name", sorted(DRAWN - {"save_as", "style_context"}))
def test_every_public_figure_is_on_the_page(name):
    assert f"figures.{name}(" in PAGE.read_text(encoding="utf-8")
