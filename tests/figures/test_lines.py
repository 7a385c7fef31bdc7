"""Any number of varied names becomes panels, colours and styles; a few cases stand for all."""

import numpy as np
import pytest
import xarray as xr

from fretwear.figures.lines import choose_layout, representative_cases, shown_lines, study_lines


def _grid(levels):
    shape = tuple(len(values) for values in levels.values())
    cycles = [0.0, 10.0, 100.0]
    table = np.arange(np.prod(shape, dtype=int) * 3, dtype=float).reshape(*shape, 3)
    coords = {name: list(values) for name, values in levels.items()}
    return xr.Dataset({"wear_volume": ((*levels, "cycle"), table)}, {**coords, "cycle": cycles})


def _list(values):
    count = len(next(iter(values.values())))
    coords = {name: ("point", list(column)) for name, column in values.items()}
    coords["case_id"] = ("point", [f"case-{i}" for i in range(count)])
    table = np.ones((count, 2))
    return xr.Dataset(
        {"wear_volume": (("point", "cycle"), table)},
        {**coords, "point": np.arange(count), "cycle": [0.0, 10.0]},
    )


DEMO = {
    "load": [20.0, 40.0],
    "friction": [0.3, 0.6],
    "roughness_amplitude": [0.0, 1e-7, 2e-7],
    "plastic_limit": [np.inf, 4.5e9],
}


@pytest.mark.parametrize(
    ("levels", "rows", "across", "color", "style"),
    [
        (DEMO, ("load",), ("friction",), "roughness_amplitude", "plastic_limit"),
        ({}, (), (), None, None),
        ({"load": [1.0, 2.0]}, (), (), "load", None),
        ({"load": [1.0, 2.0, 3.0], "friction": [0.3, 0.5]}, (), (), "load", "friction"),
        ({"radius": range(1, 9), "load": range(1, 10)}, (), ("radius",), "load", None),
        ({"load": [1.0, 2.0], "slip_model": ["a", "b"]}, (), (), "load", "slip_model"),
        (
            {"load": [1.0, 2.0], "friction": [0.1, 0.2, 0.3], "radius": [1.0, 2.0, 3.0, 4.0]},
            (),
            ("friction",),
            "radius",
            "load",
        ),
    ],
)
def test_names_find_their_places(levels, rows, across, color, style):
    layout = choose_layout(study_lines(_grid(levels), "wear_volume"))
    assert (layout.rows, layout.across, layout.color, layout.style) == (rows, across, color, style)
    assert not layout.thinned


def test_many_values_are_thinned_evenly_and_a_fifth_name_is_held_at_its_last():
    study = _grid({"load": np.arange(20.0), "friction": np.arange(30.0), "radius": np.arange(70.0)})
    lines = study_lines(study, "wear_volume")
    layout = choose_layout(lines)
    assert layout.levels["load"][0] == 0.0
    assert layout.levels["load"][-1] == 19.0
    assert layout.thinned == {"load": 20, "friction": 30, "radius": 70}
    shown = shown_lines(lines, layout)
    assert 0 < len(shown) <= 5 * 4 * 60
    study = _grid({**DEMO, "radius": [1.0, 2.0, 3.0]})
    lines = study_lines(study, "wear_volume")
    layout = choose_layout(lines)
    shown = shown_lines(lines, layout)
    assert layout.thinned == {"radius": 3}
    assert {line.values["radius"] for line in shown} == {3.0}
    assert len(shown) == 24
    with pytest.raises(ValueError, match="'stick_area'"):
        study_lines(_grid(DEMO), "stick_area")


def test_points_drawn_at_random_are_told_by_panels_and_one_colour_bar():
    loads, ratios = np.linspace(20.0, 60.0, 30), np.linspace(0.9, 0.5, 30)
    sampled = xr.Dataset(
        {"wear_volume": (("point", "cycle"), np.ones((30, 3)))},
        {
            "load": ("point", loads),
            "tangential_ratio": ("point", ratios),
            "plastic_limit": ("point", [np.inf, 4.5e9] * 15),
            "cycle": [0.0, 10.0, 100.0],
        },
    )
    lines = study_lines(sampled, "wear_volume")
    layout = choose_layout(lines)
    assert (layout.across, layout.color, layout.style) == (("plastic_limit",), "load", None)
    assert layout.paired == ("tangential_ratio",)
    assert len(shown_lines(lines, layout)) == 30
    study = _list({"load": [1.0, 2.0, 3.0, 4.0, 5.0], "friction": [0.1, 0.2, 0.3, 0.4, 0.5]})
    layout = choose_layout(study_lines(study, "wear_volume"))
    assert (layout.rows, layout.across) == ((), ())
    assert layout.color in ("load", "friction")


def test_the_demo_gives_the_four_corners_of_roughness_and_plastic_limit(small_study):
    chosen = representative_cases(small_study.summary)
    assert chosen.contrasts == ("roughness_amplitude", "plastic_limit")
    assert list(chosen.ids) == [
        "smooth, elastic",
        r"smooth, $p_\mathrm{lim}$ = 4500 MPa",
        "$A$ = 0.3 µm, elastic",
        r"$A$ = 0.3 µm, $p_\mathrm{lim}$ = 4500 MPa",
    ]
    assert chosen.common == "normal load 40 N, coefficient of friction 0.6"
    assert representative_cases(small_study.summary) == chosen
    for title, case_id in chosen.ids.items():
        assert case_id.startswith("P40N-Q19.2N-mu0.6-")
        assert ("elastic" in case_id) is ("elastic" in title)
    summary = small_study.summary.copy(deep=True)
    summary["wear_volume"].loc[{"load": 40.0, "friction": 0.6, "plastic_limit": 4.5e9}] = np.nan
    chosen = representative_cases(summary)
    assert len(chosen.ids) == 4
    assert chosen.common == "normal load 40 N, coefficient of friction 0.3"


def test_a_study_of_other_names_takes_the_extremes_of_its_first_two(small_study):
    summary = small_study.summary.isel(roughness_amplitude=0, plastic_limit=0)
    chosen = representative_cases(summary)
    assert chosen.contrasts == ("load", "friction")
    assert next(iter(chosen.ids)) == "$P$ = 30 N, $µ$ = 0.3"
    assert len(chosen.ids) == 4
    summary = small_study.summary.isel(load=0, friction=0, roughness_amplitude=0, plastic_limit=0)
    chosen = representative_cases(summary)
    assert chosen.contrasts == ()
    assert list(chosen.ids.values()) == [str(summary["case_id"].item())]
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
    with pytest.raises(ValueError, match="no case to choose"):
        representative_cases(small_study.summary.where(False))


@pytest.mark.parametrize("models", [["jaeger", "cattaneo_mindlin"], ["cattaneo_mindlin", "jaeger"]])
def test_slip_that_follows_the_worn_shape_is_shown_whatever_the_order(small_study, models):
    of_one_load = small_study.summary.isel(load=1, friction=1).drop_vars(
        "slip_model", errors="ignore"
    )
    summary = xr.concat([of_one_load] * 2, xr.Variable("slip_model", models), coords=["case_id"])
    chosen = representative_cases(summary)
    assert len(chosen.ids) == 4
    assert chosen.common == "slip of the worn shape"
