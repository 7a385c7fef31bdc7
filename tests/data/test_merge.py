"""The merged study, and the fields of all its cases as one dataset, read piece by piece."""

import json
import math
import re
import shutil
import tracemalloc
from io import StringIO
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import pandas as pd
import psutil
import pytest
import xarray as xr

import fretwear
from fretwear.data.arrays import Headers, read_case, survey
from fretwear.data.atomic import DataFileError
from fretwear.data.effects import results_table
from fretwear.data.files import (
    MERGED_HISTORIES,
    MERGED_PROFILES,
    open_case,
    open_history,
    open_summary,
    reading,
    write_case,
)
from fretwear.data.merge import check_belongs, merge_study
from fretwear.data.stack import NOT_DONE, open_study
from fretwear.results import FIELDS, RESULTS, SCALARS, PointStatus
from fretwear.run.accuracy import ASKED
from fretwear.study.plan import write_points

from ..studies import WAVES, base, computed, near, run_study, steel
from .conftest import COARSE, study_in
from .test_files import unreadable

pytestmark = pytest.mark.slow

LOADS = {"load": ["20 N", "50 N", "40 N"], "plastic_limit": ["none", "4500 MPa"]}
ROUGH = {**WAVES, "amplitude": "0.1 um", "slope_x": "0.2 deg", "slope_y": "0.2 deg"}


@pytest.fixture
def summary_of(merged):
    def summary(study):
        with open_summary(merged(study) / "summary.nc") as opened:
            return opened.load()

    return summary


@pytest.fixture(scope="module")
def loads(tmp_path_factory):
    """The results of six cases."""
    folder = tmp_path_factory.mktemp("loads")
    return run_study(study_in(folder, LOADS), folder)


@pytest.fixture
def copied(loads, make_study, tmp_path):
    """The study of six cases, and a copy of their files to change."""
    return make_study(LOADS), Path(shutil.copytree(loads / "cases", tmp_path / "cases"))


@pytest.fixture
def stack(loads):
    with open_study(loads) as opened:
        yield opened


def test_dimensions_are_the_varied_names_in_the_order_of_the_study(stack):
    summary = stack.load()
    for variable in SCALARS:
        assert summary[variable.name].dims == ("normal_load", "plastic_limit", "cycle")
        assert summary[variable.name].attrs["units"] == variable.si_unit
    for name in MERGED_PROFILES:
        assert summary[name].dims == ("normal_load", "plastic_limit", "cycle", "x")
        assert summary[name].dtype == np.float32
    # Levels rise, whatever their order in the study.
    assert summary["normal_load"].values.tolist() == [20.0, 40.0, 50.0]
    assert summary.plastic_limit.values.tolist() == [4.5e9, math.inf]
    assert summary.indexes["plastic_limit"].is_monotonic_increasing
    nearest = summary.wear_volume.sel(normal_load=44.0, method="nearest")
    assert nearest.normal_load == 40.0
    assert (summary["normal_load"].attrs["units"], summary.plastic_limit.attrs["units"]) == (
        "N",
        "Pa",
    )
    assert summary.cycle.values.tolist() == [0.0, 100.0, 1000.0]
    # Parameters that all cases share are scalars.
    assert summary.radius.ndim == 0
    assert summary.radius.attrs["units"] == "m"
    assert summary.slip_model == "cerruti"
    assert summary.cycles.dtype == summary.radius.dtype == np.float64
    assert summary.tangential_load.dims == ("normal_load", "plastic_limit")
    assert "tangential_load" not in summary.coords
    assert summary.attrs["title"] == "Two loads"
    assert json.loads(summary.attrs["study_file"])["vary"] == LOADS


def test_points_are_opened_and_drawn_as_cases(make_study, stack, loads):
    """Both in the exact cells of the file and as they lie in the study."""
    case = stack.fretwear.point(load="40 N", plastic_limit="none")
    with case, xr.open_dataset(loads / "summary.nc") as plain:
        assert case.fretwear.case.load == 40.0
        assert case.fretwear.full().sizes["x"] == 2 * case.sizes["x"]
        with plain.fretwear.point(normal_load=40.0, plastic_limit=math.inf) as again:
            assert again.attrs["case_id"] == case.attrs["case_id"]
    with pytest.raises(ValueError, match="2 points are left, which differ in plastic_limit:"):
        stack.fretwear.point(load="40 N")
    here = stack.fretwear.sel(load="40 N", plastic_limit="none")
    assert here.symmetry == "even_xy"
    assert here.fretwear.full().sizes["x"] == 2 * here.sizes["x"]
    for figure in (fretwear.figures.overview(here), fretwear.figures.wear_map(here)):
        (axes, *_) = figure.axes
        assert axes.lines or axes.images or axes.collections


LISTS = {"friction": [0.6, 0.3], "load": ["20 N", "50 N"]}
RANGES = {"load": {"from": "20 N", "to": "50 N"}, "friction": {"from": 0.3, "to": 0.6}}
DRAWN = {"kind": "sobol", "points": 2, "seed": 1}


@pytest.mark.parametrize(
    ("vary", "design", "dims"),
    [
        ({**LISTS, "friction": [0.6]}, "grid", ("friction", "normal_load")),
        ({}, "grid", ()),
        (LISTS, "zip", ("point",)),
        (RANGES, DRAWN, ("point",)),
    ],
)
def test_dimensions_follow_from_the_design(make_study, summary_of, vary, design, dims):
    study = make_study(vary, design=design)
    summary = summary_of(study)
    assert summary.wear_volume.dims == (*dims, "cycle")
    assert summary.gap_profile.dims == (*dims, "cycle", "x")
    assert (summary.status == PointStatus.DONE).all()
    if "point" in dims:
        assert summary.point.values.tolist() == list(range(len(study.cases())))
        for name in vary:
            column = summary["normal_load" if name == "load" else name]
            assert column.dims == ("point",)
            expected = [getattr(case, name) for case in study.cases().values()]
            assert column.values.tolist() == expected


def test_every_point_has_its_case_to_the_last_bit_and_outside_its_window_nothing_touches(
    make_study, stack, loads
):
    cases = make_study(LOADS).cases()
    sizes = []
    assert stack.pressure.dims == ("normal_load", "plastic_limit", "cycle", "x", "y")
    for name, parameters in cases.items():
        here = stack.sel(normal_load=parameters.load, plastic_limit=parameters.plastic_limit)
        assert here.case_id == name
        with open_case(loads / "cases" / f"{name}.nc") as case:
            nx, ny = case.sizes["x"], case.sizes["y"]
            for variable in SCALARS:
                np.testing.assert_array_equal(here[variable.name], case[variable.name])
            assert here.hertz_radius == case.hertz_radius
            np.testing.assert_array_equal(here.x[:nx], case.x)
            for name, field in MERGED_PROFILES.items():
                np.testing.assert_array_equal(here[name][:, :nx], case[field.name].isel(y=0))
            for field in FIELDS:
                window = here[field.name][:, :nx, :ny]
                np.testing.assert_array_equal(window, case[field.name])
                assert window.dtype == case[field.name].dtype
        sizes.append(nx)
        for name in ("pressure_profile", "shear_profile", "wear_profile", "wear_rate_profile"):
            assert (here[name][:, nx:] == 0.0).all()
        assert (here.pressure[:, nx:] == 0.0).all()
        assert (here.contact_state[:, :, ny:] == 0).all()
        for gap in (here.gap_profile, here.gap[:, :, 0]):
            assert gap[:, nx:].isnull().all()
            assert gap[:, :nx].notnull().all()
    assert min(sizes) < max(sizes) == stack.sizes["x"]
    with open_history(loads / "summary.nc") as merged:
        for name, parameters in cases.items():
            steps = merged.sel(normal_load=parameters.load, plastic_limit=parameters.plastic_limit)
            with open_history(loads / "cases" / f"{name}.nc") as history:
                number = history.sizes["step"]
                for each in ("cycle", "wear_volume", "tangential_force"):
                    np.testing.assert_array_equal(steps[each][:number], history[each])
                    assert steps[each][number:].isnull().all()


def test_a_study_keeps_open_its_summary_alone_and_closes_it(loads):
    process = psutil.Process()

    def open_files():
        return [file.path for file in process.open_files() if str(loads) in file.path]

    with open_study(loads) as stack:
        assert open_files() == [str(loads / "summary.nc")]
        worn = stack.wear_depth.max(("x", "y"))
        np.testing.assert_array_equal(worn.compute()[..., 0], 0.0)
        part = stack.wear_depth[1, :, -1, ::2, 3].compute()
        np.testing.assert_array_equal(part, stack.wear_depth.compute()[1, :, -1, ::2, 3])
        assert open_files() == [str(loads / "summary.nc")]
    assert open_files() == []


def test_cases_of_different_spacing_share_the_cells_of_the_finest(make_study, merged):
    study = make_study({"cell": [["10 um", "12 um"], ["4 um", "5 um"]]})
    folder = merged(study)
    with open_study(folder) as stack:
        stack.load()
    for axis, spacing in ("x", 4e-6), ("y", 5e-6):
        np.testing.assert_allclose(np.diff(stack[axis]), spacing, rtol=1e-9)
        assert float(stack[axis][0]) == near(spacing / 2, rel=1e-12)
    coarse = next(iter(study.cases()))
    with open_case(folder / "cases" / f"{coarse}.nc") as case:
        inside = stack.x.values <= float(case.x.max())
        expected = np.interp(stack.x[inside], case.x, case.pressure[0, :, 0])
        found = stack.pressure_profile.isel(cycle=0, cell=0)[inside]
        np.testing.assert_allclose(found, expected, rtol=1e-6)
    loads = 4 * stack.pressure.isel(cycle=0).sum(("x", "y"), dtype="float64") * 4e-6 * 5e-6
    # Linear interpolation cuts across the edge, where the pressure falls like a square root.
    np.testing.assert_allclose(loads, 50.0, rtol=3e-2)
    assert set(np.unique(stack.contact_state)) == {0, 1, 2}


def test_words_stand_for_values_that_are_not_numbers(make_study, summary_of):
    summary = summary_of(make_study({"roughness": ["none", ROUGH], "slip_model": ["jaeger"]}))
    assert summary.wear_volume.dims == ("roughness", "slip_model", "cycle")
    assert summary.slip_model.values.tolist() == ["jaeger"]
    assert summary.roughness.values[0] == "none"
    assert "0.1 um" in str(summary.roughness.values[1])
    assert "units" not in summary.roughness.attrs
    np.testing.assert_allclose(summary.roughness_amplitude, [[0.0], [1e-7]], rtol=1e-12)
    dotted = summary_of(make_study({"roughness.amplitude": ["0 um", "0.1 um"]}))
    assert dotted.wear_volume.dims == ("roughness_amplitude", "cycle")
    np.testing.assert_allclose(dotted.roughness_amplitude, [0.0, 1e-7], rtol=1e-12)
    assert dotted.roughness_amplitude.attrs["units"] == "m"
    # What a single point has is not shared by all.
    one = summary_of(make_study({"counterface": ["none", ROUGH]}))
    np.testing.assert_allclose(one.counterface_amplitude, [math.nan, 1e-7], rtol=1e-12)


def test_a_study_of_words_is_numbers_and_flags_in_its_file_which_lazy_operations_bear(
    make_study, merged
):
    words = {"slip_model": ["jaeger", "cerruti"], "roughness": ["none", ROUGH]}
    path = merged(make_study(words)) / "summary.nc"
    with netCDF4.Dataset(path) as file:
        assert [*unreadable(file)] == []
        assert file["slip_model"].flag_meanings == "jaeger cerruti"
        assert len(file["roughness"].flag_meanings.split()) == 2
    with open_summary(path) as text, xr.open_dataset(path) as raw:
        assert text.slip_model.values.tolist() == ["jaeger", "cerruti"]
        assert text.case_id.values.ravel().tolist() == raw.case_id.values.ravel().tolist()
        np.testing.assert_array_equal(raw.slip_model, [0, 1])
        along = "slip_model", "roughness"
        for volume in (raw.wear_volume, text.wear_volume):
            stacked = volume.stack(place=along).load()
            turned = volume.transpose("cycle", "roughness", "slip_model").load()
            for each in (stacked.unstack(), turned):
                np.testing.assert_array_equal(each.transpose(*volume.dims), text.wear_volume)


@pytest.mark.parametrize(
    "vary",
    [
        {"load": ["20 N"], "slip_model": ["jaeger"]},
        {"wear_coefficient": ["7e-13 / Pa", ["1e-13 / Pa", "2e-13 / Pa"]], "cycles": [1000]},
    ],
)
def test_points_and_results_have_the_same_columns_of_the_same_type(make_study, summary_of, vary):
    study = make_study(vary)
    file = study.file.with_name("points.csv")
    write_points(study, file)
    points = pd.read_csv(file, index_col="case_id")
    results = pd.read_csv(StringIO(results_table(summary_of(study))), index_col="case_id")
    shared = [name for name in points if name in results]
    assert {"load", "error_estimate", "cycles", "slip_model"} < {*shared}
    pd.testing.assert_frame_equal(points[shared], results[shared], check_exact=True)


def virtual(path, group):
    """A file as references of VirtualiZarr to its bytes, read by the library of Zarr."""
    virtualizarr = pytest.importorskip("virtualizarr", reason="virtualizarr: every night")
    from obspec_utils.registry import ObjectStoreRegistry
    from obstore.store import LocalStore

    parser = virtualizarr.parsers.HDFParser(group=group)
    store = parser(path.resolve().as_uri(), ObjectStoreRegistry({"file://": LocalStore()}))
    return xr.open_zarr(store, consolidated=False, zarr_format=3)


def kerchunked(path, group):
    """A file as references of kerchunk, likewise."""
    hdf = pytest.importorskip("kerchunk.hdf", reason="kerchunk: every night")
    references = hdf.SingleHdf5ToZarr(str(path)).translate()["refs"]
    # A group of references is empty to `open_zarr`, without a word; its part is a file of its own.
    place = f"{group}/" if group else ""
    part = {n.removeprefix(place): each for n, each in references.items() if n.startswith(place)}
    options = {"consolidated": False, "zarr_format": 2, "storage_options": {"fo": part}}
    return xr.open_zarr("reference://", **options)


@pytest.mark.parametrize("referred", [virtual, kerchunked])
def test_references_to_a_file_give_the_numbers_that_xarray_reads(make_study, merged, referred):
    """Every variable of cases and summaries: fields, single numbers, words and histories."""
    words = {"slip_model": ["jaeger", "cerruti"], "plastic_limit": ["none", "4500 MPa"]}
    folder = merged(make_study({**words, "roughness": ["none", ROUGH]}))
    for path in (folder / "summary.nc", *(folder / "cases").iterdir()):
        for group in (None, "history"):
            with xr.open_dataset(path, group=group) as expected:
                found = referred(path, group)
                assert found.variables.keys() == expected.variables.keys()
                for name, values in expected.variables.items():
                    np.testing.assert_array_equal(found[name], values, name)


def test_the_documented_cube_of_references_keeps_the_parameters_of_every_case(
    make_study, merged, monkeypatch, tmp_path
):
    pytest.importorskip("icechunk", reason="icechunk: every night")
    folder = merged(make_study({"friction": [0.5, 0.6]}))
    page = Path(__file__).parents[2] / "docs/how-to/other-programs.md"
    _, section = page.read_text(encoding="utf-8").split("## A study in the cloud")
    (script,) = re.findall(r"```python\n(.*?)```", section, flags=re.DOTALL)
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(script.replace("results/small", str(folder)), names)
    cube = xr.open_zarr(names["repository"].readonly_session("main").store, consolidated=False)
    for number, file in enumerate(names["files"]):
        with xr.open_dataset(file) as case:
            for name, values in case.variables.items():
                stored = cube[name].isel(case=number, missing_dims="ignore")
                np.testing.assert_array_equal(stored, values, name)
    assert sorted(cube.friction.values) == [0.5, 0.6]


def test_what_is_not_done_is_missing_and_says_why(make_study, merged, tmp_path):
    loads = {"tangential_load": ["8 N", "16 N"], "load": ["20 N", "50 N"]}
    study = make_study(loads, invalid="skip")
    cases = merged(study) / "cases"
    lost = next(p for p in study.points() if p.case and p.case.load == 50.0)
    (cases / f"{lost.id}.nc").unlink()
    count = merge_study(study, cases, tmp_path / "summary.nc")
    assert count == {"done": 2, "failed": 1, "invalid": 1}
    failed, invalid = (
        {"normal_load": n, "tangential_load": q} for n, q in ((50.0, 8.0), (20.0, 16.0))
    )
    with open_study(tmp_path) as stack:
        assert stack.status.dtype == np.int8
        assert stack.status.sel(failed) == PointStatus.FAILED
        assert stack.status.sel(invalid) == PointStatus.INVALID
        assert stack.status.attrs["flag_meanings"] == "done failed invalid"
        done = stack.status == PointStatus.DONE
        for name in (*(variable.name for variable in SCALARS), "pressure_profile", "pressure"):
            inner = [dim for dim in stack[name].dims if dim not in done.dims]
            np.testing.assert_array_equal(stack[name].notnull().all(inner), done)
        assert (stack.contact_state.sel(failed) == NOT_DONE).all()
        assert stack.case_id.sel(invalid) == ""
        assert math.isnan(stack.hertz_radius.sel(invalid))
    with pytest.raises(DataFileError, match="no case of the study is done"):
        merge_study(make_study(LOADS), tmp_path / "none", tmp_path / "other.nc")
    assert not (tmp_path / "other.nc").exists()


def test_snapshots_that_a_case_does_not_have_are_nan(make_study, summary_of):
    summary = summary_of(make_study({"cycles": [500, 1000]}, output={"cycles": [0, 100]}))
    assert summary.wear_volume.dims == ("cycles", "cycle")
    assert summary.cycle.values.tolist() == [0.0, 100.0, 500.0, 1000.0]
    there = summary.wear_volume.notnull().values.tolist()
    assert there == [[True, True, True, False], [True, True, False, True]]
    assert summary.pressure_profile[0, 3].isnull().all()


def test_every_file_that_cannot_be_used_is_named_and_nothing_is_written(copied, tmp_path):
    study, cases = copied
    short, another, source, fewer, older, odd = (cases / f"{name}.nc" for name in study.cases())
    short.write_bytes(short.read_bytes()[:-1000])
    another.write_bytes(source.read_bytes())
    with open_case(fewer) as case, open_history(fewer) as history:
        write_case(case.isel(cycle=[0, 2]), history, fewer)
    with open_case(older) as case, open_history(older) as history:
        write_case(case.assign_attrs(code_digest="0"), history, older)
    with h5py.File(odd, "a") as file:
        del file["wear_volume"]
        file["wear_volume"] = [0.0, 1.0]
    with pytest.raises(DataFileError) as error:
        merge_study(study, cases, tmp_path / "summary.nc")
    wrong = {
        short: "damaged",
        another: f"holds another case, {source.stem}",
        fewer: "no snapshot at cycle 100",
        older: "another version of the code",
        odd: "damaged",
    }
    for line, (path, problem) in zip(str(error.value).splitlines(), wrong.items(), strict=True):
        assert line.startswith(str(path))
        assert problem in line
    assert not (tmp_path / "summary.nc").exists()


def test_cases_of_one_code_share_the_headers_of_one_and_their_units_are_those_of_the_format(
    copied, monkeypatch, tmp_path
):
    (study, cases), opened = copied, []

    def read_by_the_library(path):
        opened.append(path)
        return reading(path)

    monkeypatch.setattr("fretwear.data.arrays.reading", read_by_the_library)
    merge_study(study, cases, tmp_path / "summary.nc")
    assert len(opened) == 1
    first, second, *_ = (cases / f"{name}.nc" for name in study.cases())
    for path, code in ((first, {}), (second, {"code_digest": "0"})):
        with netCDF4.Dataset(path, "a") as file:
            file.setncatts(code)
            file["wear_volume"].units = "mm3"
    with pytest.raises(DataFileError) as error:
        merge_study(study, cases, tmp_path / "summary.nc", keep_older=True)
    assert str(error.value).count("wear_volume is in mm3") == 2


def test_cases_are_read_in_a_third_of_the_time_that_plain_h5py_takes(loads):
    from time import process_time

    files, headers = [*(loads / "cases").glob("*.nc")], Headers()

    def plain(path):
        with h5py.File(path) as file:
            names = [*file, *(f"history/{name}" for name in MERGED_HISTORIES)]
            return [file[name][()] for name in names if isinstance(file.get(name), h5py.Dataset)]

    def seconds(read):
        begin = process_time()
        for path in files:
            read(path)
        return process_time() - begin

    code = survey(files[0], headers)[0]["code_digest"]

    def merged(path):
        survey(path, headers)
        read_case(path, code, headers)

    ratios = [seconds(merged) / seconds(plain) for _ in range(9)]
    assert min(ratios) < 1 / 3


def test_a_merge_takes_no_memory_for_the_arrays_of_the_cases(make_study, tmp_path, monkeypatch):
    """A case adds its texts and parameters, a few kB, whatever its arrays."""
    monkeypatch.setattr("fretwear.data.merge._POINTS_AT_A_TIME", 16)
    result, peaks = computed(steel(**COARSE, output_cycles=(0, 100, 1000))), []
    for count in (32, 160):
        frictions = {"friction": [round(0.5 + 1e-4 * i, 4) for i in range(count // 8)]}
        study = make_study({"load": [f"{50 + i} N" for i in range(8)], **frictions})
        for case_id in study.cases():
            dataset = result.dataset.assign_attrs(case_id=case_id)
            write_case(dataset, result.history, tmp_path / "cases" / f"{case_id}.nc")
        tracemalloc.start()
        merge_study(study, tmp_path / "cases", tmp_path / "summary.nc", keep_older=True)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    with open_summary(tmp_path / "summary.nc") as summary:
        stored = sum(each.nbytes for each in summary.variables.values()) / 160
    assert (peaks[1] - peaks[0]) / 128 < 0.5 * stored


def test_a_summary_of_another_study_is_refused_and_cases_of_other_code_are_told(
    make_study, loads, monkeypatch, tmp_path
):
    study, told = make_study(LOADS), []
    with open_summary(loads / "summary.nc") as summary:
        assert summary.attrs["warnings"] == ""
        check_belongs(summary, study)
        softer = make_study({**LOADS, "plastic_limit": ["none", "4400 MPa"]})
        for wrong in (make_study({"load": ["20 N"]}), softer):
            with pytest.raises(DataFileError, match=r"summary\.nc: it has other points"):
                check_belongs(summary, wrong)
    monkeypatch.setattr("fretwear.data.merge.case_digest", lambda _: "newer")
    file = tmp_path / "other.nc"
    merge_study(study, loads / "cases", file, keep_older=True, tell=told.append)
    with open_summary(file) as summary:
        assert [summary.attrs["warnings"]] == told
    assert "cases computed by another version of the code: 6 of 6" in told[0]


def test_what_is_less_accurate_than_asked_for_is_told_with_its_case_in_summary_and_table(
    make_study, merged
):
    keys = base(accuracy=None, budget=1.0, cycles=100)
    vary = {"load": ["20 N", "50 N"], "accuracy": ["none", 0.001]}
    study = make_study(vary, base=keys, output={"cycles": [0, 100]})
    with open_summary(merged(study) / "summary.nc") as summary:
        table = pd.read_csv(StringIO(results_table(summary)), keep_default_na=False)
        lines = summary.attrs["warnings"].splitlines()
        for load in (20.0, 50.0):
            (line,) = (line for line in lines if f" in {load:.0f} N, accuracy 0.001: " in line)
            assert line.endswith(": raise `budget`")
            words, error = re.match(r"(.*?) ± ([\d.]+) %", line).groups()
            assert words.lower() in {RESULTS[name].words for name in ASKED}
            assert float(error) > 0.1
            rows = table[table["load"] == load].set_index("accuracy")["warnings"]
            assert f"({words[:1].lower()}{words[1:]} ± {error} %" in rows.iloc[0]
            assert rows.iloc[1] == ""


def test_a_scalar_that_some_cases_lack_is_nan_there_and_one_more_is_merged(copied, tmp_path):
    """Cases of an older version and of a newer one merge into one study."""
    study, cases = copied
    older, newer, *_ = (cases / f"{name}.nc" for name in study.cases())
    for path, change in (
        (older, lambda case: case.drop_vars("sliding_criterion")),
        (newer, lambda case: case.assign(wear_speed=2.0 * case.wear_volume)),
    ):
        with open_case(path) as case, open_history(path) as history:
            write_case(change(case.load()), history.load(), path)
    merge_study(study, cases, tmp_path / "summary.nc")
    with open_study(tmp_path) as merged:
        lacking = merged.sliding_criterion.isnull().all("cycle").values
        assert lacking.ravel().tolist() == [True, *5 * [False]]
        known = merged.wear_speed.notnull().all("cycle").values
        assert known.ravel().tolist() == [False, True, *4 * [False]]
        np.testing.assert_array_equal(
            merged.wear_speed.values[known], 2.0 * merged.wear_volume.values[known]
        )


def test_a_file_that_is_missing_or_damaged_is_named(make_study, merged):
    folder = merged(make_study({}))
    path = folder / "summary.nc"
    (case,) = (folder / "cases").iterdir()
    with pytest.raises(DataFileError, match="not a merged study"):
        open_summary(case)
    case.unlink()
    with pytest.raises(DataFileError, match="no such file") as error:
        open_study(path)
    assert error.value.path == case
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(DataFileError, match=r"damaged.*merge it again"):
        open_summary(path)
