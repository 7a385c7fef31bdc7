import json
import math

import numpy as np
import pytest

from fretwear.data.dataset import case_dataset, history_dataset
from fretwear.study.case import Case
from fretwear.vocabulary import FIELDS, SCALARS

CONTRACT_UNITS = {
    "pressure": "Pa",
    "shear_traction": "Pa",
    "slip": "m",
    "wear_depth": "m",
    "wear_rate": "m",
    "plastic_depth": "m",
    "gap": "m",
    "approach": "m",
    "tangential_displacement": "m",
    "contact_half_width_x": "m",
    "contact_half_width_y": "m",
    "stick_half_width_x": "m",
    "stick_half_width_y": "m",
    "contact_area": "m2",
    "stick_area": "m2",
    "peak_pressure": "Pa",
    "central_pressure": "Pa",
    "wear_volume": "m3",
    "plastic_volume": "m3",
    "dissipated_energy": "J",
}


def test_every_variable_of_the_contract_has_its_units_and_type(results):
    dataset = results.dataset
    assert set(dataset.data_vars) == {*CONTRACT_UNITS, "contact_state"}
    for name, units in CONTRACT_UNITS.items():
        on_surface = dataset[name].dims == ("cycle", "x", "y")
        assert on_surface or dataset[name].dims == ("cycle",)
        assert dataset[name].dtype == ("float32" if on_surface else "float64")
        assert dataset[name].attrs["units"] == units
        assert dataset[name].attrs["long_name"]


def test_contact_state_explains_its_flags(results):
    state = results.dataset.contact_state
    assert state.dtype == np.int8
    assert "units" not in state.attrs
    assert state.attrs["flag_meanings"].split() == ["open", "slip", "stick"]
    assert state.attrs["flag_values"].dtype == np.int8
    assert state.attrs["flag_values"].tolist() == [0, 1, 2]


def test_coordinates_are_float64_cell_centres_with_axes(results, case):
    x, y = results.dataset.x, results.dataset.y
    assert (x.dtype, y.dtype) == ("float64", "float64")
    assert (x.attrs["axis"], y.attrs["axis"]) == ("X", "Y")
    assert (x.attrs["units"], y.attrs["units"]) == ("m", "m")
    assert (x[0], y[0]) == (case.grid_spacing[0] / 2, case.grid_spacing[1] / 2)


def test_every_parameter_is_a_scalar_coordinate(results, case):
    for name, (value, units, long_name) in case.scalar_coordinates().items():
        coordinate = results.dataset.coords[name]
        assert coordinate.ndim == 0
        assert coordinate.item() == value
        assert coordinate.attrs["long_name"] == long_name
        assert coordinate.attrs.get("units", "") == units
        assert isinstance(value, str) or coordinate.dtype == np.float64
    assert math.isinf(results.dataset.plastic_limit)
    assert results.dataset.roughness_amplitude == 0.0


def test_attributes_give_the_case_back(results, case):
    attributes = results.dataset.attrs
    assert attributes["Conventions"] == "CF-1.11"
    assert attributes["case_id"] == case.case_id
    assert attributes["symmetry"] == "even_xy"
    assert attributes["source"].startswith("fretwear ")
    assert Case(**json.loads(attributes["parameters"])).case_id == case.case_id


def test_history_has_every_scalar_along_the_steps(results):
    history = results.history
    assert {variable.name for variable in SCALARS} < set(history.data_vars)
    assert all(history[name].dims == ("step",) for name in history.data_vars)
    assert history.cycle.dims == ("step",)
    assert history.step.values.tolist() == [0, 1, 2, 3, 4]
    assert history.convolutions.dtype == np.int32


@pytest.mark.parametrize("name", [variable.name for variable in (*FIELDS, *SCALARS)])
def test_a_missing_variable_is_named(case, make_arrays, name):
    arrays = make_arrays(case)
    arrays.fields.pop(name, None)
    arrays.scalars.pop(name, None)
    with pytest.raises(ValueError, match=rf"missing (field|scalar) {name}\b"):
        case_dataset(case, *arrays)


def test_all_problems_are_told_at_once(case, make_arrays):
    arrays = make_arrays(case)
    arrays.fields["presure"] = arrays.fields.pop("pressure")
    arrays.fields["gap"] = arrays.fields["gap"][:, :-1]
    arrays.fields["slip"][0, 0, 0] = np.nan
    arrays.fields["contact_state"][0, 0, 0] = 3
    with pytest.raises(ValueError, match="not be whole") as error:
        case_dataset(case, *arrays)
    for part in (
        "missing field pressure",
        "unknown field presure",
        "gap has shape",
        "slip holds values that are not finite",
        "contact_state holds other values than open slip stick",
    ):
        assert part in str(error.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda a: a._replace(x=a.x[::-1]), "x does not increase"),
        (lambda a: a._replace(y=a.y - a.y[3]), "a quarter has only y > 0"),
        (lambda a: a._replace(cycles=a.cycles - 1.0), "cycle begins at -1"),
        (lambda a: a._replace(cycles=a.cycles * 0.0), "cycle does not increase"),
    ],
)
def test_coordinates_that_make_no_sense_are_refused(case, make_arrays, change, message):
    with pytest.raises(ValueError, match=message):
        case_dataset(case, *change(make_arrays(case)))


def test_unknown_symmetry_is_refused(case, make_arrays):
    with pytest.raises(ValueError, match="symmetry is 'even', expected one of even_xy, none"):
        case_dataset(case, *make_arrays(case), symmetry="even")


def test_arguments_are_neither_aliased_nor_changed(case, make_arrays):
    arrays = make_arrays(case)
    dataset = case_dataset(case, *arrays)
    dataset.wear_volume[:] = -1.0
    dataset.pressure[:] = -1.0
    assert arrays.scalars["wear_volume"].min() >= 0.0
    assert arrays.fields["pressure"].min() >= 0.0


def test_history_of_unequal_lengths_is_refused(results):
    scalars = {name: results.history[name].values for name in (v.name for v in SCALARS)}
    with pytest.raises(ValueError, match=r"error_estimate has shape \(4,\), expected \(5,\)"):
        history_dataset(np.arange(5.0), scalars, np.zeros(4), np.zeros(5))
