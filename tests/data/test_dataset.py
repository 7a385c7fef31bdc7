"""The dataset of one case: what it holds, what it refuses, where it comes from, comparisons."""

import json
import math
import re
from datetime import UTC, datetime

import numpy as np
import pytest
import xarray as xr

from fretwear.data.labels import history_line
from fretwear.data.stack import representative_cycles, resampled
from fretwear.results import DEPTH, RESULTS, SCALARS, of_steps
from fretwear.study.case import Case

CONTRACT_UNITS = {
    "Pa": "pressure shear_traction peak_pressure central_pressure mean_stick_pressure",
    "m": "slip wear_depth wear_rate plastic_depth gap approach tangential_displacement "
    "contact_radius stick_radius scar_half_width_x scar_half_width_y "
    "contact_half_width_x contact_half_width_y stick_half_width_x stick_half_width_y "
    "maximum_wear_depth",
    "m2": "contact_area stick_area",
    "m3": "wear_volume plastic_volume",
    "J": "dissipated_energy",
    "N": "normal_force tangential_force",
    "1": "stick_load_share regime sliding_ratio sliding_criterion contact_fraction stick_fraction",
}


def test_every_variable_and_coordinate_of_the_contract_has_its_units_and_type(results, case):
    dataset, state = results.dataset, results.dataset.contact_state
    expected = {name: units for units, names in CONTRACT_UNITS.items() for name in names.split()}
    assert set(dataset.data_vars) == {*expected, "contact_state"}
    for name, units in expected.items():
        on_surface = dataset[name].dims == ("cycle", "x", "y")
        assert on_surface or dataset[name].dims == ("cycle",)
        assert dataset[name].dtype == ("float32" if on_surface else "float64")
        assert dataset[name].attrs["units"] == units
        assert dataset[name].attrs["long_name"]
    assert state.dtype == state.attrs["flag_values"].dtype == np.int8
    assert "units" not in state.attrs
    assert state.attrs["flag_meanings"].split() == ["open", "slip", "stick"]
    assert state.attrs["flag_values"].tolist() == [0, 1, 2]
    for name, spacing in zip(("x", "y"), case.grid_spacing, strict=True):
        assert dataset[name].dtype == "float64"
        assert (dataset[name].attrs["axis"], dataset[name].attrs["units"]) == (name.upper(), "m")
        assert dataset[name][0] == spacing / 2


def test_every_parameter_is_a_scalar_coordinate_and_attributes_give_the_case_back(results, case):
    for name, (value, units, long_name) in case.scalar_coordinates().items():
        coordinate = results.dataset.coords[name]
        assert coordinate.ndim == 0
        assert coordinate.item() == value
        assert coordinate.attrs["long_name"] == long_name
        assert coordinate.attrs.get("units", "") == units
        assert isinstance(value, str) or coordinate.dtype == np.float64
    assert math.isinf(results.dataset.plastic_limit)
    assert results.dataset.roughness_amplitude == 0.0
    attributes = results.dataset.attrs
    assert attributes["Conventions"].startswith("CF-1.11")
    assert attributes["case_id"] == case.case_id
    assert attributes["symmetry"] == "even_xy"
    assert attributes["source"].startswith("fretwear ")
    assert Case(**json.loads(attributes["parameters"])).case_id == case.case_id


def test_history_has_every_scalar_along_the_steps(results):
    history = results.history
    assert {variable.name for variable in of_steps(SCALARS)} < set(history.data_vars)
    assert all(history[name].dims == ("step",) for name in (*history.data_vars, "cycle"))
    assert history.step.values.tolist() == list(range(history.sizes["step"]))
    assert history.convolutions.dtype == np.int32
    time, command = history_line("fretwear run demo.yaml").split(" ", 1)
    assert abs((datetime.now(UTC) - datetime.fromisoformat(time)).total_seconds()) < 60
    assert command == "fretwear run demo.yaml"


def test_values_are_kept_at_cell_centres_and_interpolated_between_them_on_both_sides():
    values, centres = np.random.default_rng(1).random((6, 4)), (np.arange(6) + 0.5) * 3.0
    for kind in ("float32", "int8"):
        whole = (100 * values).astype(kind)
        for some in ([0, 1, 2, 3, 4, 5], [0, 5, 3]):
            kept = resampled(whole.T, [centres], [centres[some]], -1).T
            assert kept.dtype == kind
            assert (kept == whole[some]).all()
    positions = np.linspace(-20.0, 20.0, 101)
    between = resampled(values.T, [centres], [positions], -1.0)
    expected = [np.interp(np.abs(positions), centres, column, right=-1.0) for column in values.T]
    np.testing.assert_allclose(between, expected, rtol=1e-12)
    # A whole contact is not taken for a quarter.
    cells = np.r_[-centres[::-1], centres]
    between = resampled(cells[None], [cells], [np.array([-6.0, 6.0])], 0.0)
    np.testing.assert_allclose(between, [[-6.0, 6.0]], rtol=1e-14)
    # States are those of the nearest cell.
    states, positions = np.int8([2, 2, 1, 1, 0, 0]), np.array([0.1, 5.9, 6.1, 11.9, 12.1, 30.0])
    assert resampled(states, [centres], [positions], -1).tolist() == [2, 2, 1, 1, 0, -1]


def test_the_accessor_gives_the_case_and_values_in_units_for_people(results, case):
    quarter = results.dataset
    assert quarter.fretwear.case.case_id == case.case_id
    with pytest.raises(ValueError, match=r"lacks 'parameters'; point\("):
        quarter.drop_attrs().fretwear.case.case_id  # noqa: B018
    read = quarter.fretwear.in_units()
    assert {read[name].attrs["units"] for name in ("x", "y")} == {"µm"}
    np.testing.assert_allclose(read.x, 1e6 * quarter.x)
    assert 1.0 <= read.wear_volume.max() < 1000.0
    assert read.wear_volume.attrs["units"].endswith("µm³")
    assert read.pressure.attrs["units"] == "GPa"
    np.testing.assert_allclose(read.pressure, 1e-9 * quarter.pressure, rtol=1e-6)
    assert read.friction == quarter.friction
    assert quarter.x.attrs["units"] == "m"


def test_a_map_has_the_slip_direction_to_the_right_and_names_its_cycle_alone(results):
    quarter = results.dataset
    wear = quarter.fretwear.map("wear_depth")
    assert wear.dims == ("y", "x")
    assert wear.attrs["units"] == "nm"
    assert {*wear.coords} == {"x", "y", "cycle"}
    np.testing.assert_allclose(wear.values.max(), 1e9 * quarter.wear_depth[-1].max(), rtol=1e-6)
    assert quarter.fretwear.map("pressure", cycle=0).cycle == 0
    with pytest.raises(ValueError, match="wear_volume is no map; maps are pressure, "):
        quarter.fretwear.map("wear_volume")
    with pytest.raises(ValueError, match="wear_depth is no map; maps are none, because a line"):
        quarter.isel(y=0).fretwear.map("wear_depth")


def test_a_point_is_selected_in_the_words_of_a_study_file():
    """Loads of a dataset without y are per length."""
    loads, limits = np.array([2e7, 5e7]), np.array([4.5e9, np.inf])
    coords = {
        "normal_load": ("normal_load", loads),
        "plastic_limit": ("plastic_limit", limits),
        "slip_model": ("slip_model", [0, 1], {"levels": "jaeger\ncerruti"}),
    }
    dims = (*coords,)
    study = xr.Dataset({"wear_volume": (dims, np.arange(8.0).reshape(2, 2, 2))}, coords)
    chosen = study.fretwear.sel(load="50 kN/mm", plastic_limit="none", slip_model="jaeger")
    assert chosen.wear_volume == 6.0
    between = study.fretwear.sel(plastic_limit=["4500 MPa"], slip_model=slice("jaeger", "cerruti"))
    assert between.wear_volume.values.ravel().tolist() == [0.0, 1.0, 4.0, 5.0]
    zipped = study.isel(normal_load=0, plastic_limit=0).rename_dims(slip_model="point")
    zipped = zipped.reset_index("slip_model")
    assert zipped.fretwear.sel(slip_model="cerruti").wear_volume == [1.0]
    rows = study.isel(normal_load=0, slip_model=0, drop=True).rename_dims(plastic_limit="point")
    rows = rows.reset_index("plastic_limit")
    for ends, expected in (
        (("1 GPa", "5 GPa"), [0.0]),
        (("5 GPa", None), [2.0]),
        ((None,) * 2, [0, 2]),
    ):
        found = rows.fretwear.sel(plastic_limit=slice(*ends))
        assert found.wear_volume.values.tolist() == expected
    flags = xr.Dataset(
        {"wear_volume": ("error_estimate", [1.0, 2.0])}, {"error_estimate": [0.0, 1.0]}
    )
    words = flags.assign_coords(error_estimate=["false", "true"])
    for level in (True, "true", 1):
        assert flags.fretwear.sel(error_estimate=level).wear_volume == 2.0
    assert words.fretwear.sel(error_estimate="true").wear_volume == 2.0
    # Words of messages select as well.
    assert study.fretwear.sel(plastic_limit="elastic").sizes == {"normal_load": 2, "slip_model": 2}
    text = study.assign_coords(slip_model=["jaeger", "cerruti"])
    with pytest.raises(ValueError, match="slip_model = 'jager': the study has jaeger, cerruti"):
        text.fretwear.sel(slip_model="jager")
    for levels, sentence in (
        ({"load": "30 kN/mm"}, "load = '30 kN/mm': the study has 20000 N/mm, 50000 N/mm"),
        ({"slip_model": "jaegr"}, "slip_model = 'jaegr': the study has jaeger, cerruti"),
        ({"friction": 0.5}, "friction does not vary; coordinates are normal_load, plastic_limit"),
        ({"plastic_limt": "none"}, "plastic_limt does not vary; did you mean 'plastic_limit'?"),
    ):
        with pytest.raises(ValueError, match=re.escape(sentence)):
            study.fretwear.sel(**levels)


def test_drawn_cycles_are_even_in_their_fourth_root():
    assert representative_cycles([n**4 for n in range(21)]) == (0, 4**4, 8**4, 12**4, 16**4, 20**4)


def test_depths_and_regimes_say_how_they_are_read():
    assert DEPTH.attributes["positive"] == "down"
    assert DEPTH.attributes["axis"] == "Z"
    regime = RESULTS["regime"]
    assert regime.attributes["flag_values"].tolist() == [0.0, 1.0]
    assert regime.attributes["flag_values"].dtype == regime.dtype  # as CF asks
    assert regime.attributes["flag_meanings"] == "partial_slip gross_slip"
    assert "flag_values" not in regime.error.attributes
