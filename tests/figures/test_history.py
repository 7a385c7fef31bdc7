"""Quantities over the cycles: every case is there, in its panel, with units and a key."""

import numpy as np
import pytest
import xarray as xr

from fretwear import figures

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
    assert sum(len(_lines(axes)) for axes in figure.axes) == 24
    words = check_texts(figure)
    assert label in words
    assert {"smooth", "elastic", "$P$ = 30 N, $µ$ = 0.3", "Cycle"} <= set(words)
    drawn = _lines(figure.axes[3])[0]
    point = small_study.summary[variable].isel(
        load=1, friction=1, roughness_amplitude=0, plastic_limit=0
    )
    np.testing.assert_allclose(drawn / drawn[-1], point.values / point.values[-1], rtol=1e-12)


def test_what_is_not_done_is_left_out_and_lines_go_on_over_missing_snapshots(small_study):
    summary = small_study.summary.copy(deep=True)
    summary["wear_volume"][0, 0, 1, 1] = np.nan
    figure = figures.wear_volume(summary)
    assert sum(len(_lines(axes)) for axes in figure.axes) == 23
    summary = small_study.summary.isel(friction=0, roughness_amplitude=0, plastic_limit=0)
    summary = summary.copy(deep=True)
    summary["wear_volume"][0, 2] = np.nan
    (axes,) = figures.wear_volume(summary).axes
    lengths = [line.size for line in _lines(axes)]
    assert lengths == [4, 5]
    assert np.isfinite(np.concatenate(_lines(axes))).all()
    summary["wear_volume"][0] = np.nan
    summary["wear_volume"][1, 0] = np.nan
    figure = figures.wear_volume(summary)
    assert sum(len(_lines(axes)) for axes in figure.axes) == 6
    with pytest.raises(ValueError, match="nothing to draw"):
        figures.wear_volume(summary.where(False))


def test_one_case_and_its_dense_history_have_one_line(smooth_run, check_texts):
    for dataset in (smooth_run.dataset, smooth_run.history):
        figure = figures.contact_half_width(dataset, columns=1)
        (line,) = _lines(figure.axes[0])
        np.testing.assert_allclose(line, dataset["contact_half_width_x"].values * 1e6)
        check_texts(figure)


def test_wear_and_energy_over_decades_are_on_logarithmic_axes_and_widths_from_zero(smooth):
    (axes,) = figures.wear_volume(smooth).axes
    assert axes.get_yscale() == "log"
    low, _ = axes.get_xlim()
    assert 0.5 < low <= 1.0
    volumes = smooth["wear_volume"].values[1:] * 1e18
    bottom, top = axes.get_ylim()
    assert bottom < volumes.min() < volumes.max() < top
    energy = smooth[["dissipated_energy"]].copy(deep=True)
    energy["dissipated_energy"][:] = [1e-5, 1e-5, 8e-6, 1e-7, 1e-12]
    (axes,) = figures.dissipated_energy(energy).axes
    assert axes.get_yscale() == "log"
    low, high = axes.get_ylim()
    assert high / low < 1e7
    (axes,) = figures.stick_half_width(smooth).axes
    assert axes.get_ylim()[0] == 0.0
    (axes,) = figures.contact_half_width(smooth).axes
    assert axes.get_ylim()[0] > 0.0


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
    summary = small_study.summary.rename(roughness_amplitude="roughness_seed")
    summary = summary.isel(friction=0, plastic_limit=0, drop=True)
    figure = figures.wear_volume(summary)
    among = summary["wear_volume"].sel(load=40.0)
    mean, deviation = among.mean("roughness_seed"), among.std("roughness_seed", ddof=1)
    (axes,) = (each for each in figure.axes if each.get_lines())
    drawn = _lines(axes)[-1]
    np.testing.assert_allclose(drawn / drawn[-1], mean.values / mean.values[-1], rtol=1e-9)
    size = drawn[-1] / float(mean[-1])
    band = axes.collections[-1].get_paths()[0].vertices
    highest = band[np.isclose(band[:, 0], 1000.0), 1].max()
    assert highest == pytest.approx(size * float(mean[-1] + deviation[-1]), rel=1e-9)
    assert any("means of 3 seeds" in text for text in check_texts(figure))
