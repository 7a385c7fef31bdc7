"""The figures of whole studies: regimes of slip, files and their index."""

import json

import numpy as np
import pytest
import xarray as xr

from fretwear import figures
from fretwear.data.files import open_summary
from fretwear.figures.study import study_figures, write_study_figures
from fretwear.study.reading import load_study

from ..studies import base, line_contact, run_study, write_study


def test_a_fretting_map_shows_the_regime_over_load_and_displacement():
    regime = np.array([[0.0, 1.0], [0.0, 0.0]])
    summary = xr.Dataset(
        {
            "status": (("normal_load", "displacement_amplitude"), np.zeros((2, 2), dtype="int8")),
            "regime": (("normal_load", "displacement_amplitude", "cycle"), regime[..., None]),
            "wear_volume": (
                ("normal_load", "displacement_amplitude", "cycle"),
                np.array([[[1.0], [8.0]], [[1.0], [1.0]]]) * 1e-15,
                {"units": "m3"},
            ),
        },
        {"normal_load": [10.0, 20.0], "displacement_amplitude": [1e-6, 4e-6], "cycle": [100]},
    )
    (axes,) = figures.fretting_map(summary).axes
    partial, gross = axes.collections
    assert partial.get_offsets().tolist() == [[1.0, 10.0], [1.0, 20.0], [4.0, 20.0]]
    assert gross.get_offsets().tolist() == [[4.0, 10.0]]
    assert gross.get_sizes()[0] == pytest.approx(4.0 * partial.get_sizes()[0])
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        "Displacement amplitude (µm)",
        "Normal load (N)",
    )


@pytest.mark.slow
def test_a_study_has_its_figures_and_no_text_overlaps(small_study, check_texts):
    drawn = [*study_figures(small_study.summary, small_study.cases)]
    width = "radius" if "contact_radius" in small_study.summary else "half_width"
    assert [figure.name for figure in drawn if "_by_" not in figure.name] == [
        *[f"{zone}_{size}" for size in (width, "area") for zone in ("contact", "stick")],
        "wear_volume",
        "dissipated_energy",
    ]
    assert [figure.name.partition("_by_")[0] for figure in drawn[6:]] == [
        "pressure_profiles",
        "shear_profiles",
        "wear_profiles",
        "wear_map",
    ]
    for figure in drawn:
        assert figure.caption.endswith(".")
        check_texts(figure.figure)


@pytest.mark.slow
def test_files_and_index_agree(small_study, tmp_path):
    summary = small_study.summary.isel(normal_load=[0], roughness_amplitude=[0], plastic_limit=[0])
    entries = write_study_figures(summary, small_study.cases, tmp_path)
    assert json.loads((tmp_path / "index.json").read_text(encoding="utf-8")) == entries
    files = {f"{entry['name']}.svg" for entry in entries}
    assert {path.name for path in tmp_path.iterdir()} == {*files, "index.json"}
    assert write_study_figures(summary, small_study.cases, tmp_path / "2", processes=2) == entries
    for name in (*files, "index.json"):
        assert (tmp_path / name).read_bytes() == (tmp_path / "2" / name).read_bytes()
    nothing = summary.assign(status=summary["status"] + 1)
    assert [*study_figures(nothing, small_study.cases)] == []


@pytest.mark.slow
@pytest.mark.parametrize("thickest", ["2 nm", "2 um"])
def test_lives_of_coatings_are_drawn_if_one_is_worn_through(thickest, tmp_path, check_texts):
    layer = {"youngs_modulus": "400 GPa", "poisson_ratio": 0.2}
    coating = {"coating": layer, "cell": "8 um", "error_estimate": False}
    coated = base(**line_contact("6 mm", "100 N/mm"), **coating)
    varied = {"coating.thickness": {"from": f"1 {thickest[2:]}", "to": thickest}}
    sample = {"kind": "sobol", "points": 8, "seed": 1}
    content = {"title": "Coated", "base": coated, "vary": varied, "design": sample}
    run_study(load_study(write_study(tmp_path / "study.yaml", content)), tmp_path)
    with open_summary(tmp_path / "summary.nc") as summary:
        drawn = {each.name: each.figure for each in study_figures(summary, tmp_path / "cases")}
    assert ("coating_life" in drawn) == (thickest == "2 nm")
    for figure in drawn.values():
        check_texts(figure)
