"""Cases, figures and sections of the source study, from short real runs on a coarse grid."""

import html

import numpy as np
import pytest
import xarray as xr

from fretwear_source_study.claims import CLAIMS, source_sections
from fretwear_source_study.figures import source_figures
from fretwear_source_study.parameters import TITLES
from fretwear_source_study.reference_cases import reference_cases

pytestmark = pytest.mark.slow


def test_the_section_has_the_numbers_behind_every_answer(merged, cases):
    (section,) = source_sections(merged.summary, merged.folder)
    body = html.unescape(section.body)
    for claim in CLAIMS:
        for finding in claim.judge(cases).values():
            assert f"<td>{finding.text}</td>" in body


def test_the_cases_of_both_slip_models_are_found_and_are_what_they_are_called(merged, cases):
    for order in ([0, 1, 2], [2, 1, 0]):
        groups = reference_cases(merged.summary.isel(slip_model=order), merged.folder)
        assert [model for model, *_ in groups] == ["cerruti", "jaeger", "cattaneo_mindlin"]
    # The radius nearest 10 mm comes first.
    several = reference_cases(with_radii(merged.summary, 0.04, 0.008, 0.005), merged.folder)
    assert [radius for _, radius, _ in several] == [0.008, 0.005, 0.04] * 3
    assert tuple(cases) == TITLES
    for title, case in cases.items():
        surface, body = title.split()
        assert (case.parameter("roughness_amplitude") > 0.0) is (surface == "rough")
        limit = case.parameter("plastic_limit")
        assert limit == (np.inf if body == "elastic" else 4.5e9)
        assert str(case.dataset["slip_model"].values) == "jaeger"


def with_radii(summary, *radii):
    several = [summary.assign_coords(radius=radius) for radius in radii]
    return xr.concat(several, "radius", data_vars="all", coords="minimal")


def test_other_parameters_make_another_study_and_cases_not_done_none(merged, tmp_path):
    changed = merged.summary.assign_coords(friction=merged.summary["friction"] * 1.01)
    assert not [*reference_cases(changed, merged.folder)]
    changed = merged.summary.assign_coords(youngs_modulus="208 GPa, 70 GPa")
    assert not [*reference_cases(changed, merged.folder)]
    assert not [*reference_cases(xr.Dataset(), tmp_path)]
    status = merged.summary["status"].copy()
    status[dict.fromkeys(status.dims, 0)] = 1
    left = reference_cases(merged.summary.assign(status=status), merged.folder)
    assert [model for model, *_ in left] == ["cerruti", "cattaneo_mindlin"]


NUMBERS = (4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 15, 16)


@pytest.fixture(scope="module")
def figures(merged):
    return {figure.name: figure for figure in source_figures(merged.summary, merged.folder)}


def found(figures, number):
    return next(figure for name, figure in figures.items() if name.startswith(f"fig{number:02d}_"))


def test_every_figure_of_the_source_study_is_there_under_its_number(figures):
    numbers = [int(name[3:5]) for name in figures if name.startswith("fig")]
    assert tuple(numbers) == NUMBERS
    assert "as the grid is refined" in found(figures, 4).caption
    assert "over a strip of its zones" in found(figures, 9).caption


def test_pressure_of_the_smooth_elastic_contact_is_drawn_as_computed(merged, figures):
    line = found(figures, 4).figure.axes[0].lines[0]
    picked = merged.summary.sel(roughness_amplitude=0.0, plastic_limit=np.inf)
    picked = picked.isel(slip_model=[*picked["slip_model"].values].index("cerruti"))
    profile = picked["pressure_profile"].sel(cycle=0)
    drawn = np.interp(1e6 * profile["x"], *line.get_data())
    np.testing.assert_allclose(drawn, 1e-6 * profile, rtol=1e-6, atol=1e-3)


def test_claim_12_is_drawn_as_results_of_rough_over_those_of_smooth_contacts(merged, figures):
    elastic, _ = figures["claim12_rough_over_smooth"].figure.axes
    picked = merged.summary.sel(plastic_limit=np.inf).isel(cycle=-1)
    picked = picked.isel(slip_model=[*picked["slip_model"].values].index("cerruti"))
    names = ("wear_volume", "maximum_wear_depth", "stick_area", "contact_area")
    for line, name in zip(elastic.lines, names, strict=False):
        smooth, rough = picked[name].values
        np.testing.assert_allclose(line.get_ydata()[-1], rough / smooth, rtol=1e-6)


def test_widths_begin_at_zero_and_the_zoom_fits_the_elastic_ones(figures):
    whole, zoom = (found(figures, number).figure.axes[0] for number in (15, 16))
    low, high = zoom.get_ylim()
    assert whole.get_ylim()[0] == 0.0
    for line in zoom.lines[:2]:
        values = np.asarray(line.get_ydata())
        assert low < values.min()
        assert values.max() < high
