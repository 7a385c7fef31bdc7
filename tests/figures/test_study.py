"""A study gets its figures with captions, written together with their index."""

import json
from dataclasses import asdict
from itertools import islice
from pathlib import Path

import pytest
from docutils.core import publish_parts
from jinja2 import Environment

from fretwear.data.merge import merge_study
from fretwear.data.safe import DataFileError
from fretwear.figures.index import (
    INDEX_NAME,
    FigureEntry,
    captions,
    figure_category,
    figure_labels,
    read_figure_index,
)
from fretwear.figures.study import study_figures, write_study_figures
from fretwear.running.workflow import CAPTION

NAMES = [
    "effects",
    "contact_half_width",
    "stick_half_width",
    "wear_volume",
    "dissipated_energy",
    *(
        f"{kind}_by_roughness_amplitude_and_plastic_limit"
        for kind in (
            "pressure_profiles",
            "shear_profiles",
            "gap_profiles",
            "wear_rate_profiles",
            "wear_profiles",
            "wear_map",
        )
    ),
]


def test_a_study_has_named_and_explained_figures_that_can_be_read(small_study, check_texts):
    found = list(study_figures(small_study.summary, small_study.cases))
    assert [figure.name for figure in found] == NAMES
    for figure in found:
        check_texts(figure.figure)
        assert figure.caption.endswith(".")
        assert "$" not in figure.caption
    assert "all 24 cases" in found[1].caption
    assert "normal load 40 N, coefficient of friction 0.6" in found[-1].caption


def test_files_and_index_agree_and_captions_count_what_is_done(small_study, tmp_path):
    one = small_study.summary.isel(friction=1, roughness_amplitude=0, plastic_limit=0)
    entries = write_study_figures(one, small_study.cases, tmp_path)
    assert read_figure_index(tmp_path) == entries
    files = {f"{entry.name}.{ending}" for entry in entries for ending in ("svg", "png")}
    assert {file.name for file in tmp_path.iterdir()} == files | {INDEX_NAME}
    assert not list(study_figures(small_study.summary.where(False), small_study.cases))


def test_the_caption_counts_cases_that_are_not_done(small_study, tmp_path):
    ids = list(small_study.study.cases())
    for case_id in ids[1:]:
        (tmp_path / f"{case_id}.nc").symlink_to(small_study.cases / f"{case_id}.nc")
    merge_study(small_study.study, tmp_path, tmp_path / "summary.nc")
    import xarray as xr

    with xr.open_dataset(tmp_path / "summary.nc") as summary:
        _, first = islice(study_figures(summary, tmp_path), 2)
    assert "23 of 24 cases, those done" in first.caption


@pytest.mark.parametrize("kept", [["load"], []])
def test_smaller_studies_have_the_same_kinds_of_figures(small_study, kept):
    names = ("load", "friction", "roughness_amplitude", "plastic_limit")
    part = small_study.summary.isel({name: 0 for name in names if name not in kept})
    found = [figure.name for figure in study_figures(part, small_study.cases)]
    assert len(found) == len(NAMES) - (not kept)
    assert ("wear_map_by_load" in found) is bool(kept)


ODD = (
    'Load *P* at 50 %, {{ 1 }} and {% raw %}, a_b_ `c` |d| <i>"e"</i> \\ of µ = 0.3. Colour: load.'
)
ENTRIES = [
    FigureEntry("wear_map", ODD, "Over the contact"),
    FigureEntry("wear_volume", "Wear volume.", "Over the cycles"),
]


class _Snakemake:
    """What Snakemake hands to the template of a caption."""

    def __init__(self, folder, figure):
        self.wildcards = type("Wildcards", (), {"figure": figure})
        self.params = type("Params", (), {"captions": captions(folder)})


def write_index(folder, entries):
    (folder / INDEX_NAME).write_text(json.dumps(entries), encoding="utf-8")


def test_a_caption_is_read_as_it_was_written_and_never_run(tmp_path):
    write_index(tmp_path, [asdict(entry) for entry in ENTRIES])

    def _rendered(figure):
        template = Environment().from_string(Path(CAPTION).read_text(encoding="utf-8"))
        text = template.render(snakemake=_Snakemake(tmp_path, figure))
        return str(publish_parts(text, writer="html")["body"])

    expected = ODD.replace("<", "&lt;").replace(">", "&gt;").replace('"', "&quot;")
    assert _rendered("wear_map").strip() == f"<p>{expected}</p>"
    assert _rendered("wear_volume").strip() == "<p>Wear volume.</p>"
    caption = "Wear over the contact. Lines: edges."
    index = [{"name": "wear_map", "caption": caption, "category": "Over the contact"}]
    write_index(tmp_path, index)
    assert figure_category(tmp_path, "wear_map") == "Over the contact"
    assert figure_labels(tmp_path, "wear_map") == {
        "figure": "wear_map",
        "shows": "Wear over the contact",
    }


@pytest.mark.parametrize(
    "entry",
    [
        {"name": "../../private", "caption": "", "category": ""},
        {"name": ".hidden", "caption": "", "category": ""},
        {"name": "a/b", "caption": "", "category": ""},
        {"name": "a", "caption": 3, "category": ""},
        {"name": ["a"], "caption": "", "category": ""},
        {"name": "a"},
    ],
)
def test_an_index_that_names_other_things_than_figures_is_none(tmp_path, entry):
    write_index(tmp_path, [entry])
    with pytest.raises(DataFileError, match="not a list of figures"):
        read_figure_index(tmp_path)
