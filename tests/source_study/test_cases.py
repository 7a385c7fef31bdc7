"""Which points of a merged study are cases of the source study."""

import numpy as np
import xarray as xr

from fretwear.source_study.cases import TITLES, reference_cases


def test_the_cases_of_both_slip_models_are_found_and_are_what_they_are_called(merged, cases):
    groups = reference_cases(merged.summary, merged.folder)
    assert [group.slip_model for group in groups] == ["jaeger", "cattaneo_mindlin"]
    backwards = merged.summary.isel(slip_model=[1, 0])
    assert reference_cases(backwards, merged.folder) == groups
    assert tuple(cases) == TITLES
    for title, case in cases.items():
        surface, body = title.split()
        assert (case.parameter("roughness_amplitude") > 0.0) is (surface == "rough")
        limit = case.parameter("plastic_limit")
        assert limit == (np.inf if body == "elastic" else 4.5e9)
        assert str(case.dataset["slip_model"].values) == "jaeger"


def test_the_radius_nearest_10_mm_comes_first(merged):
    radii = [merged.summary.assign_coords(radius=radius) for radius in (0.04, 0.008, 0.005)]
    summary = xr.concat(radii, "radius", data_vars="all", coords="minimal")
    groups = reference_cases(summary, merged.folder)
    assert [group.radius for group in groups] == [0.008, 0.008, 0.04, 0.04, 0.005, 0.005]


def test_other_parameters_make_another_study_and_cases_not_done_none(merged, tmp_path):
    for name in ("load", "tangential_load", "friction", "wear_coefficient", "roughness_slope_y"):
        other = merged.summary.assign_coords({name: merged.summary[name] * 1.01})
        assert reference_cases(other, merged.folder) == [], name
    other = merged.summary.assign_coords(youngs_modulus="208 GPa, 70 GPa")
    assert reference_cases(other, merged.folder) == []
    assert reference_cases(xr.Dataset(), tmp_path) == []
    status = merged.summary["status"].copy()
    status[dict.fromkeys(status.dims, 0)] = 1
    groups = reference_cases(merged.summary.assign(status=status), merged.folder)
    assert [group.slip_model for group in groups] == ["cattaneo_mindlin"]
