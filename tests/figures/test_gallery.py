"""Every script of the gallery runs as it stands, in a folder with the results of its studies."""

import ast
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from fretwear import figures
from fretwear.study.reading import load_study

from ..studies import run_study

GALLERY = Path(__file__).parents[2] / "docs" / "gallery"
pytestmark = pytest.mark.slow

SCRIPTS = sorted(GALLERY.glob("*.py"))
MOST_LINES = 20


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the results of the studies of the gallery, rough; no figure draws errors."""
    folder = tmp_path_factory.mktemp("gallery")
    coarse = ["error_estimate=false", "tolerance=0.1"]
    for name, options in (("gallery", [*coarse, "cell=[2.8 um, 5.7 um]"]), ("rig", coarse)):
        study = load_study(GALLERY / f"{name}.yaml", options)
        run_study(study, folder / "results" / name)
    return folder


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_a_script_says_what_it_shows_and_makes_a_figure(script, folder, monkeypatch):
    source = script.read_text(encoding="utf-8")
    title, _, text = (ast.get_docstring(ast.parse(source)) or "").partition("\n\n")
    assert title.endswith(".")
    assert text.endswith(".")
    assert len(source.splitlines()) <= MOST_LINES
    monkeypatch.chdir(folder)
    names: dict[str, object] = {}
    exec(compile(source, script, "exec"), names)
    assert isinstance(names["figure"], Figure)


DRAWN = {name for name in figures.__all__ if name.islower()}


@pytest.mark.parametrize("name", sorted(DRAWN - {"save_as", "save_figure", "style_context"}))
def test_every_public_figure_is_in_the_gallery(name):
    assert any(f"figures.{name}(" in script.read_text(encoding="utf-8") for script in SCRIPTS)
