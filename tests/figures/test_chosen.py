"""The cases chosen for profiles span the study and are always the same."""

import numpy as np
import pytest
import xarray as xr

from fretwear.figures.lines import representative_cases


def test_the_demo_gives_the_four_corners_of_roughness_and_plastic_limit(small_study) -> None:
    chosen = representative_cases(small_study.summary)
    assert chosen.contrasts == ("roughness_amplitude", "plastic_limit")
    assert list(chosen.ids) == [
        "smooth, elastic",
        r"smooth, $p_\mathrm{lim}$ = 4500 MPa",
        "$A$ = 0.3 µm, elastic",
        r"$A$ = 0.3 µm, $p_\mathrm{lim}$ = 4500 MPa",
    ]
    assert chosen.common == "load 40 N, friction 0.6"
    assert representative_cases(small_study.summary) == chosen
    for title, case_id in chosen.ids.items():
        assert case_id.startswith("P40N-Q19.2N-mu0.6-")
        assert ("elastic" in case_id) is ("elastic" in title)


def test_where_a_corner_is_missing_other_loads_are_taken(small_study) -> None:
    summary = small_study.summary.copy(deep=True)
    summary["wear_volume"].loc[{"load": 40.0, "friction": 0.6, "plastic_limit": 4.5e9}] = np.nan
    chosen = representative_cases(summary)
    assert len(chosen.ids) == 4
    assert chosen.common == "load 40 N, friction 0.3"


def test_a_study_of_other_names_takes_the_extremes_of_its_first_two(small_study) -> None:
    summary = small_study.summary.isel(roughness_amplitude=0, plastic_limit=0)
    chosen = representative_cases(summary)
    assert chosen.contrasts == ("load", "friction")
    assert next(iter(chosen.ids)) == "$P$ = 30 N, $µ$ = 0.3"
    assert len(chosen.ids) == 4


@pytest.mark.parametrize("models", [["jaeger", "cattaneo_mindlin"], ["cattaneo_mindlin", "jaeger"]])
def test_slip_that_follows_the_worn_shape_is_shown_whatever_the_order(small_study, models) -> None:
    of_one_load = small_study.summary.isel(load=1, friction=1).drop_vars(
        "slip_model", errors="ignore"
    )
    summary = xr.concat([of_one_load] * 2, xr.Variable("slip_model", models), coords=["case_id"])
    chosen = representative_cases(summary)
    assert len(chosen.ids) == 4
    assert chosen.common == "slip of the worn shape"


def test_a_study_of_one_case_has_that_case(small_study) -> None:
    summary = small_study.summary.isel(load=0, friction=0, roughness_amplitude=0, plastic_limit=0)
    chosen = representative_cases(summary)
    assert chosen.contrasts == ()
    assert list(chosen.ids.values()) == [str(summary["case_id"].item())]


def test_of_points_drawn_at_random_those_of_least_and_most_wear_are_taken() -> None:
    loads, frictions = [20.0, 40.0, 30.0, 25.0], [0.3, 0.4, 0.5, 0.6]
    volumes = np.array([[0.0, 3.0], [0.0, 9.0], [0.0, 1.0], [0.0, 2.0]])
    sampled = xr.Dataset(
        {"wear_volume": (("point", "cycle"), volumes)},
        {
            "load": ("point", loads),
            "friction": ("point", frictions),
            "case_id": ("point", ["a", "b", "c", "d"]),
            "cycle": [0.0, 10.0],
        },
    )
    assert list(representative_cases(sampled).ids.values()) == ["c", "b"]


def test_without_results_there_is_nothing_to_choose(small_study) -> None:
    with pytest.raises(ValueError, match="no case to choose"):
        representative_cases(small_study.summary.where(False))
