"""The gallery, whose scripts run when the site is built, shows every public figure."""

from pathlib import Path

import pytest

from fretwear import figures

SCRIPTS = sorted((Path(__file__).parents[2] / "docs" / "gallery").glob("*.py"))
DRAWN = {name for name in figures.__all__ if name.islower()}


@pytest.mark.parametrize("name", sorted(DRAWN - {"save_as", "style_context"}))
def test_every_public_figure_is_in_the_gallery(name):
    assert any(f"figures.{name}(" in script.read_text(encoding="utf-8") for script in SCRIPTS)
