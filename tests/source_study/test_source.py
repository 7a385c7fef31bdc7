"""Which points of a merged study are cases of the source study."""

import numpy as np
import pytest
import xarray as xr

from fretwear.source_study.source import reference_cases, simpler_cases, source_cases


def test_both_slip_models_are_found_with_all_four_cases(finished):
    groups = source_cases(finished.summary)
    assert [group.slip_model for group in groups] == ["jaeger", "cattaneo_mindlin"]
    reference, simpler = reference_cases(finished.summary), simpler_cases(finished.summary)
    assert (reference, simpler) == tuple(groups)


def test_cases_are_what_they_are_called(quartet):
    wanted = {
        "smooth elastic": (False, np.inf),
        "rough elastic": (True, np.inf),
        "smooth plastic": (False, 4.5e9),
        "rough plastic": (True, 4.5e9),
    }
    for title, case in quartet.each():
        rough, limit = wanted[title]
        assert case.is_rough is rough
        assert case.parameter("plastic_limit") == limit
        assert str(case.dataset["slip_model"].values) == "jaeger"
    assert [pair.subject for pair in quartet.pairs()] == ["elastic", "plastic"]


@pytest.mark.parametrize("name", ["load", "tangential_load", "friction", "wear_coefficient"])
def test_other_parameters_make_another_study(finished, name):
    other = finished.summary.assign_coords({name: finished.summary[name] * 1.01})
    assert source_cases(other) == []
    assert reference_cases(other) is None
    assert simpler_cases(other) is None


def test_another_radius_is_the_same_study(finished):
    other = finished.summary.assign_coords(radius=0.04)
    assert {group.radius for group in source_cases(other)} == {0.04}


def test_a_group_with_a_case_that_is_not_done_is_left_out(finished):
    status = finished.summary["status"].copy()
    status[dict.fromkeys(status.dims, 0)] = 1
    groups = source_cases(finished.summary.assign(status=status))
    assert [group.slip_model for group in groups] == ["cattaneo_mindlin"]


def test_a_dataset_that_is_no_merged_study_has_none():
    assert source_cases(xr.Dataset()) == []
