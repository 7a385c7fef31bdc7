"""Figures of studies, of rigs and of two cases, with captions, written with their index."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from docutils.core import publish_parts
from jinja2 import Environment
from scipy.stats import qmc

from fretwear import figures
from fretwear.data.atomic import DataFileError
from fretwear.data.effects import Points
from fretwear.data.files import open_history
from fretwear.figures.cases import headline
from fretwear.figures.effects import (
    effect_map,
    effects,
    parallel_coordinates,
    scatter_matrix,
    sensitivity,
)
from fretwear.figures.history import CyclePlot
from fretwear.figures.index import (
    INDEX_NAME,
    NARROW,
    FigureEntry,
    captions,
    figure_category,
    figure_labels,
    read_figure_index,
)
from fretwear.figures.study import study_figures, write_study_figures
from fretwear.run.workflow import CAPTION
from fretwear.study.parameters import parameter, symbol_text

from ..studies import sampled

BY = "_by_roughness_amplitude_and_plastic_limit"
NAMES = [
    "answer",
    "effects",
    "contact_half_width",
    "stick_half_width",
    "wear_volume",
    "dissipated_energy",
    *(f"{field}_profiles{BY}" for field in ("pressure", "shear", "gap", "wear_rate", "wear")),
    f"wear_map{BY}",
]


def test_each_result_is_drawn_over_the_two_parameters_that_change_it_most(small_study, check_texts):
    points = Points.of(small_study.summary)
    narrow, wide = (effects(points, columns=columns) for columns in (1, 2))
    for figure in (narrow, wide):
        check_texts(figure)
    final = small_study.summary["wear_volume"].isel(cycle=-1)
    axes, along = wide.axes[0], points.leading("wear_volume")[:2]
    assert axes.get_xlabel() in {parameter(name).words for name in along}
    assert {text.get_text() for text in axes.get_legend().get_texts()} <= {
        symbol_text(name, level) for name in along for level in points.levels[name]
    }
    rest = [name for name in final.dims if name not in along]
    drawn = [line.get_ydata() for line in axes.lines if line.get_label() == "_median"]
    shown = np.sort(np.concatenate(drawn))
    expected = np.sort(final.median(rest).values, axis=None)
    np.testing.assert_allclose(shown / shown[-1], expected / expected[-1])
    bands = [b.get_paths() for b in axes.collections if b.get_label() == "_band"]
    highest = max(path.vertices[:, 1].max() for paths in bands for path in paths)
    assert highest / shown[-1] == pytest.approx(float(final.max() / expected[-1]), rel=1e-9)


def test_a_limit_that_is_none_stands_apart_and_no_line_rises_to_it(small_study):
    limits = small_study.summary.isel(normal_load=0, friction=0, roughness_amplitude=0).copy(
        deep=True
    )
    limits["wear_volume"][0] *= 2.0
    (axes, *_) = effects(Points.of(limits), ["wear_volume"]).axes
    assert axes.get_xticks().tolist() == [0.0, 1.5]
    assert [line.get_xdata().tolist() for line in axes.lines] == [[0.0], [1.5]]
    assert "stands apart" in effects(Points.of(limits)).caption


def test_figures_that_would_show_nothing_are_a_sentence(small_study):
    same = small_study.summary.copy(deep=True)
    same["dissipated_energy"][:] = 1e-6
    found = {each.name: each for each in study_figures(same, small_study.cases)}
    assert found["dissipated_energy"].figure is None
    assert "same over all cycles in every case" in found["dissipated_energy"].caption
    assert (
        "Equal in all cases, so not drawn: dissipated energy per cycle" in found["effects"].caption
    )
    assert found["wear_volume"].figure is not None


def test_a_study_has_named_and_explained_figures_that_can_be_read(small_study, check_texts):
    found = list(study_figures(small_study.summary, small_study.cases))
    assert [figure.name for figure in found] == NAMES
    for figure in found:
        check_texts(figure.figure)
        assert figure.caption.endswith(".")
        assert "$" not in figure.caption
    assert "all 16 cases" in found[2].caption
    assert "normal load 40 N, coefficient of friction 0.6" in found[-1].caption


def test_files_and_index_agree_and_captions_count_what_is_done(small_study, tmp_path):
    one = small_study.summary.isel(friction=1, roughness_amplitude=0, plastic_limit=0)
    entries = write_study_figures(one, small_study.cases, tmp_path)
    assert read_figure_index(tmp_path) == entries
    drawn = [entry.name for entry in entries if entry.is_drawn]
    files = {f"{name}.{ending}" for name in drawn for ending in ("svg", "png")}
    files |= {INDEX_NAME, f"effects{NARROW}.png"}
    assert {file.name for file in tmp_path.iterdir()} == files
    assert not list(study_figures(small_study.summary.where(False), small_study.cases))


@pytest.mark.parametrize("kept", [["normal_load"], []])
def test_smaller_studies_have_the_same_kinds_of_figures(small_study, kept):
    names = ("load", "friction", "roughness_amplitude", "plastic_limit")
    part = small_study.summary.isel({name: 0 for name in names if name not in kept})
    found = [figure.name for figure in study_figures(part, small_study.cases)]
    assert len(found) == len(NAMES) - (0 if kept else 2)
    assert ("wear_map_by_load" in found) is bool(kept)


ODD = (
    'Load *P* at 50 %, {{ 1 }} and {% raw %}, a_b_ `c` |d| <i>"e"</i> \\ of µ = 0.3. Colour: load.'
)
ENTRIES = [
    FigureEntry("wear_map", ODD, "Over the contact"),
    FigureEntry("wear_volume", "Wear volume.", "Over the cycles"),
]


def write_index(folder, entries):
    (folder / INDEX_NAME).write_text(json.dumps(entries), encoding="utf-8")


def test_a_caption_is_read_as_it_was_written_and_never_run(tmp_path):
    write_index(tmp_path, [asdict(entry) for entry in ENTRIES])
    template = Environment().from_string(Path(CAPTION).read_text(encoding="utf-8"))
    bodies = []
    for entry in ENTRIES:
        # What Snakemake hands to the template of a caption.
        wildcards, params = {"figure": entry.name}, {"captions": captions(tmp_path)}
        text = template.render(snakemake={"wildcards": wildcards, "params": params})
        bodies.append(str(publish_parts(text, writer="html")["body"]).strip())
    odd = ODD.replace("<", "&lt;").replace(">", "&gt;").replace('"', "&quot;")
    assert bodies == [f"<p>{odd}</p>", "<p>Wear volume.</p>"]
    assert figure_category(tmp_path, "wear_map") == "Over the contact"
    assert figure_labels(tmp_path, "wear_volume") == {
        "figure": "wear_volume",
        "shows": "Wear volume",
    }
    assert figure_labels(tmp_path, "wear_map")["shows"].endswith("of µ = 0.3")


@pytest.mark.parametrize("name", ["../../private", ".hidden", "a/b", ["a"], None])
def test_an_index_that_names_other_things_than_figures_is_none(tmp_path, name):
    for entry in ({"name": name, "caption": "", "category": ""}, {"name": "a", "caption": 3}):
        write_index(tmp_path, [entry])
        with pytest.raises(DataFileError, match="not a list of figures"):
            read_figure_index(tmp_path)


LABELS = {
    "contact_half_width": ("contact_half_width_x", "Contact half-width along x (µm)"),
    "stick_half_width": ("stick_half_width_x", "Stick half-width along x (µm)"),
    "wear_volume": ("wear_volume", "Wear volume (µm³)"),
    "dissipated_energy": ("dissipated_energy", "Dissipated energy per cycle (µJ)"),
}


def _lines(axes):
    lines = [line for line in axes.get_lines() if line.get_label() != "_break"]
    return [line.get_ydata() for line in lines]


@pytest.mark.parametrize("name", LABELS)
def test_a_study_shows_every_case_and_no_text_overlaps(name, small_study, check_texts):
    variable, label = LABELS[name]
    figure = getattr(figures, name)(small_study.summary)
    assert sum(len(_lines(axes)) for axes in figure.axes) == 16
    words = check_texts(figure)
    assert label in words
    assert {"smooth", "elastic", "$P$ = 30 N, $µ$ = 0.3", "Cycle"} <= set(words)
    drawn = _lines(figure.axes[3])[0]
    point = small_study.summary[variable].isel(
        load=1, friction=1, roughness_amplitude=0, plastic_limit=0
    )
    np.testing.assert_allclose(drawn / drawn[-1], point.values / point.values[-1], rtol=1e-12)


def test_what_is_not_done_is_left_out_and_lines_go_on_over_missing_snapshots(small_study):
    def drawn_without(*places):
        summary = small_study.summary.copy(deep=True)
        for place in places:
            summary["wear_volume"][place] = np.nan
        done = int(summary["wear_volume"].notnull().any("cycle").sum())
        if 0 < done < 16:
            caption = CyclePlot(summary, "wear_volume").caption
            assert f"{done} of 16 cases that are done" in caption
        return [line for axes in figures.wear_volume(summary).axes for line in _lines(axes)]

    assert len(drawn_without((0, 0, 1, 1))) == 15
    assert len(drawn_without(0, (1, 0))) == 4
    found = drawn_without((0, 0, 0, 0, 2))
    assert sorted(line.size for line in found) == [4] + 15 * [5]
    assert np.isfinite(np.concatenate(found)).all()
    with pytest.raises(ValueError, match="nothing to draw"):
        drawn_without(...)


def test_one_case_and_its_dense_history_have_one_line(smooth_run, check_texts):
    for dataset in (smooth_run.dataset, smooth_run.history):
        figure = figures.contact_half_width(dataset, columns=1)
        (line,) = _lines(figure.axes[0])
        np.testing.assert_allclose(line, dataset["contact_half_width_x"].values * 1e6)
        check_texts(figure)


def test_wear_and_energy_over_decades_are_on_logarithmic_axes_and_widths_from_zero(smooth):
    (axes,) = figures.wear_volume(smooth).axes
    assert axes.get_yscale() == "log"
    assert 0.5 < axes.get_xlim()[0] <= 1.0
    volumes = smooth["wear_volume"].values[1:] * 1e18
    bottom, top = axes.get_ylim()
    assert bottom < volumes.min() < volumes.max() < top
    energy = smooth[["dissipated_energy"]].copy(deep=True)
    energy["dissipated_energy"][:] = [1e-5, 1e-5, 8e-6, 1e-7, 1e-12]
    (axes,) = figures.dissipated_energy(energy).axes
    assert axes.get_yscale() == "log"
    low, high = axes.get_ylim()
    assert high / low < 1e7
    assert figures.stick_half_width(smooth).axes[0].get_ylim()[0] == 0.0
    assert figures.contact_half_width(smooth).axes[0].get_ylim()[0] > 0.0


def test_a_few_lines_are_labelled_beside_themselves_and_many_get_a_colour_bar(
    small_study, check_texts, smooth
):
    part = small_study.summary.isel(friction=0, roughness_amplitude=0, plastic_limit=0)
    figure = figures.contact_half_width(part, columns=1)
    assert not figure.legends
    assert {"$P$ = 30 N", "$P$ = 40 N"} <= set(check_texts(figure))
    loads = np.linspace(10.0, 100.0, 20)
    study = xr.concat([smooth[["wear_volume"]] * load for load in loads], "load")
    study = study.drop_vars("load").assign_coords(load=loads)
    words = check_texts(figures.wear_volume(study))
    assert "normal load (N)" in words


def test_seeds_are_an_ensemble_drawn_by_its_mean_and_deviation(small_study, check_texts):
    # Three surfaces as if they differed by chance alone.
    def ensemble(dataset):
        dataset = dataset.isel(friction=0, plastic_limit=0, drop=True)
        dataset = dataset.isel(roughness_amplitude=[0, 1, 1])
        dataset = dataset.rename(roughness_amplitude="roughness_seed")
        return dataset.assign_coords(roughness_seed=[1.0, 2.0, 3.0])

    summary = ensemble(small_study.summary)
    figure = figures.wear_volume(summary)
    among = summary["wear_volume"].sel(normal_load=40.0)
    mean, deviation = among.mean("roughness_seed"), among.std("roughness_seed", ddof=1)
    (axes,) = (each for each in figure.axes if each.get_lines())
    drawn = _lines(axes)[-1]
    np.testing.assert_allclose(drawn / drawn[-1], mean.values / mean.values[-1], rtol=1e-9)
    size = drawn[-1] / float(mean[-1])
    band = axes.collections[-1].get_paths()[0].vertices
    highest = band[np.isclose(band[:, 0], 1000.0), 1].max()
    assert highest == pytest.approx(size * float(mean[-1] + deviation[-1]), rel=1e-9)
    assert any("means of 3 seeds" in text for text in check_texts(figure))
    # At every step of any of them, where the history is known.
    with open_history(small_study.cases.parent / "summary.nc") as steps:
        history = ensemble(steps.load())
    mean = CyclePlot(summary, "wear_volume", history).lines[-1]
    steps = [history.isel(normal_load=-1, roughness_seed=seed).dropna("step") for seed in range(3)]
    np.testing.assert_array_equal(mean.cycles, np.unique(np.concatenate([s.cycle for s in steps])))
    at = [np.interp(mean.cycles, each.cycle, each.wear_volume) for each in steps]
    np.testing.assert_allclose(mean.quantity, np.mean(at, axis=0), rtol=1e-12)
    np.testing.assert_allclose(mean.deviation, np.std(at, axis=0, ddof=1), rtol=1e-9, atol=1e-30)
    assert len(mean.cycles) > mean.marks.shape[1]


def drawn(count):
    """Return a sampled study whose wear volume is a power law."""
    unit = qmc.Sobol(2, seed=1).random(count)
    return sampled(unit, 1e-16 * (10.0 + 40.0 * unit[:, 0]) ** 2 * (0.2 + 0.6 * unit[:, 1]))


def test_a_heat_map_has_the_final_values_over_both_parameters(small_study):
    part = small_study.summary.isel(friction=0, plastic_limit=0)
    (axes, _) = effect_map(Points.of(part)).axes
    (image,) = axes.images
    shown, expected = np.asarray(image.get_array()), part["wear_volume"].isel(cycle=-1).values
    ratio = shown / (expected if shown.shape == expected.shape else expected.T)
    np.testing.assert_allclose(ratio, ratio[0, 0])


def test_indices_of_a_sample_are_drawn_with_their_convergence():
    points = Points.of(drawn(64))
    _, curves = sensitivity(points, ["wear_volume"]).axes
    assert len(curves.lines) == 2
    assert [line.get_xdata().tolist() for line in curves.lines] == [[16, 32, 64]] * 2
    assert curves.lines[0].get_ydata()[-1] > curves.lines[1].get_ydata()[-1]
    lines = parallel_coordinates(points).axes[0].collections[0]
    assert len(lines.get_paths()) == 64


def test_a_scatter_matrix_has_every_two_parameters_and_the_result():
    summary = drawn(32)
    figure = scatter_matrix(Points.of(summary))
    pairs, by_load, by_friction, _ = figure.axes
    final = summary["wear_volume"].values[:, -1]
    for axes, (x, y) in {
        pairs: ("load", "friction"),
        by_load: ("load", None),
        by_friction: ("friction", None),
    }.items():
        (dots,) = axes.collections
        points, values = np.asarray(dots.get_offsets()), np.asarray(dots.get_array())
        np.testing.assert_allclose(points[:, 0], summary[x].values)
        np.testing.assert_allclose(values / values.max(), final / final.max())
        np.testing.assert_allclose(points[:, 1], summary[y].values if y else values)


LOADS = [10.0, 20.0, 35.0, 50.0, 75.0, 100.0, 150.0, 200.0]
WAYS = [2e-7, 4e-7, 6e-7, 8e-7, 1.2e-6, 1.6e-6, 2.4e-6, 3.2e-6]


def test_dots_of_a_crowded_fretting_map_do_not_overlap():
    load, way = np.meshgrid(LOADS, WAYS, indexing="ij")
    dims = ("load", "displacement_amplitude")
    fields = {
        "status": (dims, np.zeros(load.shape, dtype="int8")),
        "regime": ((*dims, "cycle"), np.where(way < 1e-6, 0.0, 1.0)[..., None]),
        "wear_volume": ((*dims, "cycle"), np.full((*load.shape, 1), 1e-13)),
    }
    summary = xr.Dataset(fields, {dims[0]: LOADS, dims[1]: WAYS, "cycle": [1000.0]})
    figure = figures.fretting_map(summary)
    (axes,) = figure.axes
    assert axes.get_ylabel() == "Normal load (N)"
    assert [each.get_label() for each in axes.collections] == ["partial slip", "gross slip"]
    figure.draw_without_rendering()
    for at, (axis, values) in enumerate(((axes.xaxis, WAYS), (axes.yaxis, LOADS))):
        ticks = axis.get_ticklocs()
        assert len(ticks) == len(values)
        points = np.full((len(ticks), 2), 10.0)
        points[:, at] = ticks
        apart = np.diff(axes.transData.transform(points)[:, at]).min() * 72.0 / figure.dpi
        for dots in axes.collections:
            assert 2.0 < np.sqrt(dots.get_sizes().max()) < apart
    of_lines = summary.assign_coords(load=("load", 1e3 * np.array(LOADS), {"units": "N m-1"}))
    of_lines["wear_volume"] = of_lines.wear_volume.assign_attrs(units="m2")
    (line,) = figures.fretting_map(of_lines).axes
    assert line.get_ylabel() == "Normal load per length (N/mm)"
    assert "wear volume per length" in line.get_title("left")
    assert "100" in [tick.get_text() for tick in line.get_yticklabels()]


def test_all_of_a_case_on_one_page(smooth_run, rough, check_texts):
    words = check_texts(figures.overview(smooth_run.dataset, smooth_run.history))
    axes = {"Pressure (MPa)", "Shear traction (MPa)", "Gap (µm)", "Wear depth (µm)"}
    assert axes | {"Half-width along x (µm)", "contact", "stick"} <= set(words)
    assert any("$P$ = 40 N" in text and "smooth" in text for text in words)
    words = check_texts(figures.overview(rough))
    assert axes <= set(words)
    assert any("4500 MPa" in text for text in words)


def test_both_cases_are_in_every_panel_and_ratios_are_told(smooth, rough, check_texts):
    figure = figures.compare_cases({"A": smooth, "B": rough})
    words = check_texts(figure)
    ratio = float(rough["wear_volume"][-1] / smooth["wear_volume"][-1])
    told = {"A: elastic, smooth", "B: $p_\\mathrm{lim}$ = 4500 MPa, $h_\\mathrm{a}$ = 0.3 µm"}
    assert told | {"Profiles and ratios at cycle 1000", f"×{ratio:.3g}"} <= set(words)
    for axes in figure.axes[:5]:
        labels = {str(line.get_label()).split(",")[0] for line in axes.get_lines()}
        assert {"A", "B"} <= labels
    again = figures.compare_cases({"A": smooth, "again": smooth})
    ratios, ones = (
        next(n for n in each.axes[5].get_lines() if n.get_label() == "ratio").get_xdata()
        for each in (figure, again)
    )
    assert ratio in ratios
    np.testing.assert_array_equal(ones, 1.0)
    with pytest.raises(ValueError, match="compare_cases takes two cases, not 3; compare_profiles"):
        figures.compare_cases(dict.fromkeys("abc", smooth))


def test_curves_go_through_every_step_and_marks_are_snapshots(small_study):
    at = {"load": 1, "friction": 1, "roughness_amplitude": 0, "plastic_limit": 0}
    snapshots = small_study.summary.isel(at)
    with open_history(small_study.cases.parent / "summary.nc") as history:
        plot = CyclePlot(small_study.summary, "wear_volume", history)
        steps = history.isel(at).dropna("step").load()
    (line,) = (line for line in plot.lines if line.point == at)
    np.testing.assert_array_equal([line.cycles, line.quantity], [steps.cycle, steps.wear_volume])
    np.testing.assert_array_equal(line.marks, [snapshots.cycle, snapshots.wear_volume])
    drawn = [line for axes in plot.draw().axes for line in axes.get_lines()]
    assert [line.get_label() for line in drawn].count("_snapshots") == 16
    assert len(line.cycles) in [len(line.get_xdata()) for line in drawn]


def test_a_sample_with_two_snapshots_shows_every_point():
    volumes = np.geomspace(1e-16, 1e-14, 32)
    (axes, *_) = figures.wear_volume(sampled(np.linspace(0.0, 1.0, 32)[:, None], volumes)).axes
    marked = [line for line in axes.get_lines() if line.get_marker() not in ("", "None")]
    points = np.concatenate([line.get_xydata() for line in marked])
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    inside = (points >= (left, low)) & (points <= (right, high))
    shown = np.sort(points[inside.all(axis=1), 1])
    np.testing.assert_allclose(shown[-32:] / shown[-1], volumes / volumes[-1], rtol=1e-9)


def test_a_case_of_blocks_is_named_by_the_values_of_its_blocks(smooth):
    blocks = [{"cycles": 20, "tangential_ratio": 0.3}, {"cycles": 30, "tangential_ratio": 0.9}]
    given = json.dumps(json.loads(smooth.attrs["parameters"]) | {"blocks": blocks})
    assert "0.3 → 0.9" in headline(smooth.assign_attrs(parameters=given))
    blocks[1] = {"cycles": 30, "tangential_load": 9.0}
    given = json.dumps(json.loads(smooth.attrs["parameters"]) | {"blocks": blocks})
    assert "Q/" not in headline(smooth.assign_attrs(parameters=given))
