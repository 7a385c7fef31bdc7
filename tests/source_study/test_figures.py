"""The figures of the source study, from short real runs of its cases on a coarse grid."""

import numpy as np
import pytest

from fretwear.source_study.figures import source_figures

NUMBERS = (4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 15, 16)


@pytest.fixture(scope="module")
def figures(merged):
    return {figure.name: figure for figure in source_figures(merged.summary, merged.folder)}


def found(figures, number):
    return next(figure for name, figure in figures.items() if name.startswith(f"fig{number:02d}_"))


def test_every_figure_of_the_source_study_is_there_under_its_number(figures, merged):
    numbers = [int(name[3:5]) for name in figures if name.startswith("fig")]
    assert tuple(numbers) == NUMBERS
    assert list(figures)[-1] == "slip_models"
    assert "as the grid is refined" in found(figures, 4).caption
    assert "mean over one wavelength" in found(figures, 9).caption
    summary = merged.summary.isel(slip_model=[0])
    names = [figure.name for figure in source_figures(summary, merged.folder)]
    assert len(names) == len(NUMBERS)


@pytest.mark.parametrize("name", [*(f"fig{number:02d}_" for number in NUMBERS), "slip_models"])
def test_no_text_of_a_figure_is_cut_off_or_covered(figures, check_texts, name):
    (whole,) = (each for each in figures if each.startswith(name))
    words = check_texts(figures[whole].figure)
    if name[3:5].isdigit() and int(name[3:5]) not in (7, 15, 16):
        assert {"cycle", "0", "100", "1000", "x (µm)"} <= set(words)


@pytest.mark.parametrize("number", [5, 6, 9, 11, 14])
def test_rough_profiles_come_with_their_mean_and_a_zoom(figures, number):
    panels = found(figures, number).figure.axes
    for whole, zoom in zip(panels[::2], panels[1::2], strict=True):
        assert zoom.get_title(loc="left").endswith("zoom")
        assert np.ptp(zoom.get_xlim()) < 0.35 * np.ptp(whole.get_xlim())
        labels = [line.get_label() for line in whole.lines]
        assert labels.count("_raw") == len(labels) / 2


def test_pressure_of_the_smooth_elastic_contact_is_drawn_as_computed(merged, figures):
    line = found(figures, 4).figure.axes[0].lines[0]
    picked = merged.summary.isel(roughness_amplitude=0, plastic_limit=0, slip_model=0)
    profile = picked["pressure_profile"].sel(cycle=0)
    drawn = np.interp(1e6 * profile["x"], *line.get_data())
    np.testing.assert_allclose(drawn, 1e-6 * profile, rtol=1e-6, atol=1e-3)
    whole, zoom = (found(figures, number).figure.axes[0] for number in (15, 16))
    low, high = zoom.get_ylim()
    assert whole.get_ylim()[0] == 0.0
    for line in zoom.lines[:2]:
        values = np.asarray(line.get_ydata())
        assert low < values.min()
        assert values.max() < high
