"""Any number of varied names becomes panels, colours and line styles that can be read."""

from collections.abc import Mapping, Sequence

import numpy as np
import pytest
import xarray as xr

from fretwear.figures.lines import choose_layout, shown_lines, study_lines


def _grid(levels: Mapping[str, Sequence[object]]) -> xr.Dataset:
    shape = tuple(len(values) for values in levels.values())
    cycles = [0.0, 10.0, 100.0]
    table = np.arange(np.prod(shape, dtype=int) * 3, dtype=float).reshape(*shape, 3)
    coords = {name: list(values) for name, values in levels.items()}
    return xr.Dataset({"wear_volume": ((*levels, "cycle"), table)}, {**coords, "cycle": cycles})


def _list(values: Mapping[str, Sequence[object]]) -> xr.Dataset:
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


def test_the_demo_is_panels_of_load_and_friction() -> None:
    layout = choose_layout(study_lines(_grid(DEMO), "wear_volume"))
    assert (layout.rows, layout.across) == (("load",), ("friction",))
    assert (layout.color, layout.style) == ("roughness_amplitude", "plastic_limit")
    assert not layout.thinned


@pytest.mark.parametrize(
    ("levels", "rows", "across", "color", "style"),
    [
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
def test_names_find_their_places(
    levels: Mapping[str, Sequence[object]],
    rows: tuple[str, ...],
    across: tuple[str, ...],
    color: str | None,
    style: str | None,
) -> None:
    layout = choose_layout(study_lines(_grid(levels), "wear_volume"))
    assert (layout.rows, layout.across, layout.color, layout.style) == (rows, across, color, style)


def test_every_line_of_a_small_study_is_shown_once() -> None:
    lines = study_lines(_grid(DEMO), "wear_volume")
    shown = shown_lines(lines, choose_layout(lines))
    assert len(shown) == 24
    first = next(line for line in shown if line.values["load"] == 40.0)
    np.testing.assert_array_equal(first.quantity, [36.0, 37.0, 38.0])


def test_points_that_are_not_done_are_left_out() -> None:
    study = _grid(DEMO)
    study["wear_volume"][0, 1, 2, 0] = np.nan
    lines = study_lines(study, "wear_volume")
    assert len(lines) == 23
    assert {"load": 0, "friction": 1, "roughness_amplitude": 2, "plastic_limit": 0} not in [
        dict(line.point) for line in lines
    ]


def test_many_values_are_thinned_evenly_ends_included() -> None:
    study = _grid({"load": np.arange(20.0), "friction": np.arange(30.0), "radius": np.arange(70.0)})
    lines = study_lines(study, "wear_volume")
    layout = choose_layout(lines)
    assert layout.levels["load"][0] == 0.0
    assert layout.levels["load"][-1] == 19.0
    assert layout.thinned == {"load": 20, "friction": 30, "radius": 70}
    shown = shown_lines(lines, layout)
    assert 0 < len(shown) <= 5 * 4 * 60


def test_a_fifth_name_is_held_at_its_last_value() -> None:
    study = _grid({**DEMO, "radius": [1.0, 2.0, 3.0]})
    lines = study_lines(study, "wear_volume")
    layout = choose_layout(lines)
    shown = shown_lines(lines, layout)
    assert layout.thinned == {"radius": 3}
    assert {line.values["radius"] for line in shown} == {3.0}
    assert len(shown) == 24


def test_paired_lists_are_told_by_colour_alone() -> None:
    study = _list({"load": [1.0, 2.0, 3.0, 4.0, 5.0], "friction": [0.1, 0.2, 0.3, 0.4, 0.5]})
    layout = choose_layout(study_lines(study, "wear_volume"))
    assert (layout.rows, layout.across) == ((), ())
    assert layout.color in ("load", "friction")


def test_case_ids_and_point_numbers_are_no_parameters() -> None:
    lines = study_lines(_list({"load": [1.0, 2.0]}), "wear_volume")
    assert all(set(line.values) == {"load"} for line in lines)


def test_a_missing_quantity_is_named() -> None:
    with pytest.raises(ValueError, match="'stick_area'"):
        study_lines(_grid(DEMO), "stick_area")


def test_points_drawn_at_random_are_told_by_panels_and_one_colour_bar() -> None:
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
    assert layout.followers == ("tangential_ratio",)
    assert len(shown_lines(lines, layout)) == 30
