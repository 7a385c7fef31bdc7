"""The figures of whole studies: effects of parameters, files and their index."""

import json

import numpy as np
import pytest
import xarray as xr

from fretwear import figures
from fretwear.data.atomic import DataFileError
from fretwear.data.effects import Points
from fretwear.figures.effects import effects, sensitivity
from fretwear.figures.index import INDEX_NAME, captions, read_figure_index
from fretwear.figures.study import study_figures, write_study_figures

from ..studies import sampled


def test_a_result_is_drawn_at_the_values_of_the_parameter_with_its_median_and_range(small_study):
    points = Points.of(small_study.summary)
    (axes,) = effects(points, ["wear_volume"], columns=1).axes
    first, second = points.leading("wear_volume")[:2]
    (lower, upper), volumes = axes.get_lines(), points.results["wear_volume"]
    unit = 1e-18 * (1e3 if "10³" in axes.get_ylabel() else 1.0)
    for line, level in zip((lower, upper), (0, 1), strict=True):
        for place, drawn in enumerate(line.get_ydata()):
            here = (points.place(second) == level) & (points.place(first) == place)
            assert unit * drawn == pytest.approx(np.median(volumes[here]), rel=1e-6)
    assert axes.get_xlabel().startswith(("Normal load (N)", "Coefficient of friction"))


def test_sobol_indices_of_a_sample_are_drawn_at_their_values():
    unit = np.random.default_rng(2).random((64, 2))
    points = Points.of(sampled(unit, 1.0 + 3.0 * unit[:, 0] + unit[:, 1]))
    axes = sensitivity(points, ["wear_volume"]).axes[0]
    marks = [line.get_ydata()[0] for line in axes.get_lines() if line.get_fillstyle() == "full"]
    drawn = [value for value in marks if value > 0.05]
    assert max(drawn) == pytest.approx(0.9, abs=0.02)  # 9 of 10 parts of the variance


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


def test_a_study_has_its_figures_and_no_text_overlaps(small_study, check_texts):
    drawings = study_figures(small_study.summary, small_study.cases)
    assert [drawing.name for drawing in drawings if "_by_" not in drawing.name] == [
        "answer",
        "effects",
        *[f"{zone}_{width(small_study.summary)}" for zone in ("contact", "stick")],
        "wear_volume",
        "dissipated_energy",
    ]
    assert [drawing.name.partition("_by_")[0] for drawing in drawings[6:]] == [
        "pressure_profiles",
        "shear_profiles",
        "wear_profiles",
        "wear_map",
    ]
    for drawing in drawings:
        drawn = drawing.draw()
        assert drawn.caption.endswith(".")
        check_texts(drawn.figure)


def width(summary):
    return "radius" if "contact_radius" in summary else "half_width"


def test_files_and_index_agree(small_study, tmp_path):
    summary = small_study.summary.isel(normal_load=[0], friction=[0])
    entries = write_study_figures(summary, small_study.cases, tmp_path)
    assert read_figure_index(tmp_path) == entries
    files = {f"{entry.name}.{ending}" for entry in entries for ending in ("svg", "png")}
    assert {path.name for path in tmp_path.iterdir()} == {*files, INDEX_NAME}
    assert captions(tmp_path).keys() == {entry.name for entry in entries}
    nothing = summary.assign(status=summary["status"] + 1)
    assert study_figures(nothing, small_study.cases) == []


@pytest.mark.parametrize("name", ["../secret", "/etc/passwd", "", None])
def test_an_index_that_names_other_things_than_figures_is_refused(tmp_path, name):
    entry = {"name": name, "caption": "A caption.", "category": "Over the cycles"}
    (tmp_path / INDEX_NAME).write_text(json.dumps([entry]))
    with pytest.raises(DataFileError):
        read_figure_index(tmp_path)
