"""The merged study, and the fields of all its cases as one dataset, read piece by piece."""

import json
import math
import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import dask
import netCDF4
import numpy as np
import pytest
import xarray as xr

from fretwear.data.files import (
    add_checksum,
    open_case,
    open_history,
    open_summary,
    write_case,
    write_group,
)
from fretwear.data.merge import PROFILES, Tally, merge_study
from fretwear.data.safe import CaseFilesError, DataFileError, _host
from fretwear.data.stack import (
    MOST_POSITIONS,
    NOT_DONE,
    _StackedField,
    common_positions,
    open_study,
)
from fretwear.vocabulary import FIELDS, SCALARS, PointStatus

from ..studies import WAVES, flip

LOADS = {"load": ["20 N", "50 N", "40 N"], "plastic_limit": ["none", "4500 MPa"]}
ROUGH = {**WAVES, "amplitude": "0.1 um", "slope_x": "0.2 deg", "slope_y": "0.2 deg"}


@pytest.fixture
def summary_of(merged):
    def summary(study, remove=()):
        with open_summary(merged(study, remove) / "summary.nc") as opened:
            return opened.load()

    return summary


def test_dimensions_are_the_varied_names_in_the_order_of_the_study(make_study, summary_of):
    summary = summary_of(make_study(LOADS))
    for variable in SCALARS:
        assert summary[variable.name].dims == ("load", "plastic_limit", "cycle")
        assert summary[variable.name].attrs["units"] == variable.si_unit
    for name in PROFILES:
        assert summary[name].dims == ("load", "plastic_limit", "cycle", "x")
        assert summary[name].dtype == np.float32
    assert summary["load"].values.tolist() == [20.0, 50.0, 40.0]
    assert summary.plastic_limit.values.tolist() == [math.inf, 4.5e9]
    assert (summary["load"].attrs["units"], summary.plastic_limit.attrs["units"]) == ("N", "Pa")
    assert summary.cycle.values.tolist() == [0.0, 100.0, 1000.0]
    # Parameters that all cases share are scalars.
    assert summary.radius.ndim == 0
    assert summary.radius.attrs["units"] == "m"
    assert summary.slip_model == "jaeger"
    assert summary.cycles.dtype == summary.radius.dtype == np.float64
    assert summary.tangential_load.dims == ("load", "plastic_limit")
    assert "tangential_load" not in summary.coords
    assert summary.attrs["title"] == "Loads and limits"
    assert json.loads(summary.attrs["study_file"])["vary"] == LOADS


LISTS = {"friction": [0.6, 0.3], "load": ["20 N", "50 N"]}
RANGES = {"load": {"from": "20 N", "to": "50 N"}, "friction": {"from": 0.3, "to": 0.6}}
DRAWN = {"kind": "latin_hypercube", "points": 3, "seed": 1}


@pytest.mark.parametrize(
    ("vary", "design", "dims"),
    [
        ({"plastic_limit": ["none"], **LISTS}, "grid", ("plastic_limit", "friction", "load")),
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
            assert summary[name].dims == ("point",)
            expected = [getattr(case, name) for case in study.cases().values()]
            assert summary[name].values.tolist() == expected


@pytest.mark.parametrize("design", ["grid", "zip"])
def test_friction_tables_that_start_alike_stay_apart(make_study, summary_of, design):
    tables = [([0, 500], [0.2, 0.6]), ([0, 500], [0.2, 0.8]), ([0, 300, 500], [0.2, 0.5, 0.6])]
    given = [0.2, *({"cycles": list(n), "values": list(v)} for n, v in tables)]
    study = make_study({"friction": given}, design=design)
    summary = summary_of(study)
    assert len(set(summary.friction.values)) == len(set(summary.case_id.values)) == len(given)
    for point in study.points():
        chosen = summary.friction == point.labels["friction"]
        assert summary.case_id.values[chosen] == [point.id]
        volume = summary.wear_volume.isel(cycle=-1).values[chosen]
        assert np.isfinite(volume).all()


def test_every_point_has_the_values_of_its_case_and_outside_a_window_nothing_touches(
    make_study, summary_of, tmp_path
):
    study = make_study(LOADS)
    summary = summary_of(study)
    largest = max(case.hertz_radius for case in study.cases().values())
    assert summary.sizes["x"] == math.ceil(1.3 * largest / 10e-6)
    for point in study.points():
        here = summary.sel(load=point.case.load, plastic_limit=point.case.plastic_limit)
        assert here.case_id == point.id
        with open_case(tmp_path / "cases" / f"{point.id}.nc") as case:
            for variable in SCALARS:
                np.testing.assert_array_equal(here[variable.name], case[variable.name])
            assert here.hertz_radius == case.hertz_radius
            # Cases of one spacing keep their profiles to the last bit.
            np.testing.assert_array_equal(here.x[: case.sizes["x"]], case.x)
            for name, field in PROFILES.items():
                inside = here[name][:, : case.sizes["x"]]
                np.testing.assert_array_equal(inside, case[field.name].isel(y=0))
    summary = summary_of(make_study(LOADS))
    small = summary.isel(load=0, plastic_limit=0)
    outside = small.x > 1.3 * small.hertz_radius + 10e-6
    assert outside.any()
    for name in ("pressure_profile", "shear_profile", "wear_profile", "wear_rate_profile"):
        assert (small[name][:, outside] == 0.0).all()
    assert small.gap_profile[:, outside].isnull().all()
    assert small.gap_profile[:, ~outside].notnull().all()
    assert summary.isel(load=1).gap_profile.notnull().all()


def test_cases_of_different_spacing_are_interpolated_on_the_finest(make_study, summary_of):
    study = make_study({"cell": [["10 um", "12 um"], ["4 um", "12 um"]]})
    summary = summary_of(study)
    np.testing.assert_allclose(np.diff(summary.x), 4e-6, rtol=1e-9)
    assert float(summary.x[0]) == pytest.approx(2e-6, rel=1e-12)
    coarse, fine = (summary.pressure_profile.isel(cycle=0, cell=i) for i in (0, 1))
    peak = float(fine.max())
    case = next(iter(study.cases().values()))
    smooth = summary.x.values < 0.9 * case.hertz_radius
    # Linear interpolation of p0 sqrt(1 - r²/a²) errs by h²/8 of its second derivative, which at
    # 0.9 a is 12 p0/a²; nearer than its first cell the coarse case has the value of that cell.
    bound = (10e-6 / case.hertz_radius) ** 2 / 8 * 12 * peak
    np.testing.assert_allclose(coarse[smooth], fine[smooth], rtol=0, atol=bound)
    fine, wide = (1e-6, 30.5e-6, False), (3e-6, 99e-6, False)
    np.testing.assert_allclose(common_positions([fine, wide]), (np.arange(99) + 0.5) * 1e-6)
    extreme = common_positions([(1e-10, 1e-6, False), wide])
    assert extreme.size == MOST_POSITIONS
    assert extreme[-1] < 99e-6 < extreme[-1] + (extreme[1] - extreme[0])
    both = common_positions([fine, (3e-6, 9e-6, True)])
    assert both.size == 2 * 31
    np.testing.assert_array_equal(both, -both[::-1])


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


def test_what_is_not_done_is_nan_and_says_why(make_study, run_study, tmp_path):
    study = make_study(
        {"tangential_load": ["8 N", "16 N"], "load": ["20 N", "50 N"]}, invalid="skip"
    )
    cases = run_study(study)
    failed = next(p for p in study.points() if p.case and p.case.load == 50.0)
    (cases / f"{failed.id}.nc").unlink()
    # Left beside a case that is done, which nobody writes again, and by a process that is at work.
    left, live = (cases / f".a.nc.{_host()}.{pid}.0123abcd.tmp" for pid in (999_999_999, 1))
    left.touch()
    live.touch()
    tally = merge_study(study, cases, tmp_path / "summary.nc")
    assert tally == Tally(done=2, failed=1, invalid=1)
    assert not left.exists()
    live.unlink()
    with open_summary(tmp_path / "summary.nc") as summary:
        assert summary.status.dtype == np.int8
        assert summary.status.sel(load=50.0, tangential_load=8.0) == PointStatus.FAILED
        assert summary.status.sel(load=20.0, tangential_load=16.0) == PointStatus.INVALID
        assert summary.status.attrs["flag_meanings"] == "done failed invalid"
        done = summary.status == PointStatus.DONE
        for name in (*(variable.name for variable in SCALARS), "pressure_profile"):
            inner = [dim for dim in summary[name].dims if dim not in done.dims]
            np.testing.assert_array_equal(summary[name].notnull().all(inner), done)
        assert summary.case_id.sel(load=20.0, tangential_load=16.0) == ""
        assert math.isnan(summary.hertz_radius.sel(load=20.0, tangential_load=16.0))
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


@pytest.mark.parametrize(
    "lose",
    [
        lambda file: file["wear_volume"].delncattr("units"),
        lambda file: file["gap_profile"].delncattr("comment"),
        lambda file: file["pressure_profile"].__setitem__((0, 0, 2, 0), 1.0),
        lambda file: file["history/cycle"].__setitem__((2, 1, 0), 1.0),
    ],
)
def test_what_the_library_loses_without_a_word_is_found_out(make_study, run_study, tmp_path, lose):
    def losing(file, dataset):
        write_group(file, dataset)
        lose(file)

    study = make_study(LOADS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fretwear.data.merge.write_group", losing)
        with pytest.raises(DataFileError, match="reads back differently"):
            merge_study(study, run_study(study), tmp_path / "summary.nc")
    assert list(tmp_path.glob("*summary*")) == []


def test_every_file_that_cannot_be_used_is_named_and_nothing_is_written(
    make_study, run_study, tmp_path
):
    study = make_study(LOADS)
    cases = run_study(study)
    short, flipped, another, source, fewer, older = (cases / f"{name}.nc" for name in study.cases())
    short.write_bytes(short.read_bytes()[:-1000])
    flip(flipped)
    another.write_bytes(source.read_bytes())
    with open_case(fewer) as case, open_history(fewer) as history:
        write_case(case.isel(cycle=[0, 2]), history, fewer)
    with open_case(older) as case, open_history(older) as history:
        write_case(case.assign_attrs(code_digest="0"), history, older)
    with pytest.raises(CaseFilesError) as error:
        merge_study(study, cases, tmp_path / "summary.nc")
    wrong = {
        short: "cut short",
        flipped: "its checksum does not match",
        another: f"holds another case, {source.stem}",
        fewer: "no snapshot at cycle 100",
        older: "another version of the code",
    }
    assert {found.path for found in error.value.errors} == wrong.keys()
    lines = str(error.value).splitlines()
    for line, (path, problem) in zip(lines, wrong.items(), strict=True):
        assert line.startswith(str(path))
        assert problem in line
    assert not (tmp_path / "summary.nc").exists()


def test_a_damaged_or_older_summary_is_not_opened(make_study, merged, tmp_path):
    path = tmp_path / "summary.nc"
    with pytest.raises(DataFileError, match="no such file"):
        open_summary(path)
    merged(make_study({}))
    older = tmp_path / "older.nc"
    with xr.open_dataset(path, engine="netcdf4") as summary:
        summary.drop_vars("contact_state_profile").to_netcdf(older)
    add_checksum(older)
    with pytest.raises(DataFileError, match=r"lacks contact_state_profile.*Merge the study again"):
        open_summary(older)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(DataFileError, match=r"cut short.*Merge the study again"):
        open_summary(path)


GRID = {"load": ["20 N", "50 N"], "plastic_limit": ["none", "4500 MPa"]}


def test_the_stack_holds_the_fields_of_every_case_to_the_last_bit(make_study, merged):
    study = make_study(GRID)
    folder = merged(study)
    with open_study(folder) as stack:
        assert stack.pressure.dims == ("load", "plastic_limit", "cycle", "x", "y")
        for point in study.points():
            here = stack.sel(load=point.case.load, plastic_limit=point.case.plastic_limit)
            with open_case(folder / "cases" / f"{point.id}.nc") as case:
                nx, ny = case.sizes["x"], case.sizes["y"]
                for field in FIELDS:
                    window = here[field.name][:, :nx, :ny]
                    np.testing.assert_array_equal(window, case[field.name])
                    assert window.dtype == case[field.name].dtype
                assert (here.pressure[:, nx:] == 0.0).all()
                assert (here.contact_state[:, :, ny:] == 0).all()
                assert here.gap[:, nx:].isnull().all()


def test_nothing_is_read_before_it_is_used_and_then_by_threads(make_study, merged):
    with open_study(merged(make_study(GRID))) as stack:
        assert all(dask.is_dask_collection(stack[field.name].data) for field in FIELDS)
        with dask.config.set(scheduler="threads", num_workers=8):
            peak = stack.pressure.max(("x", "y")).compute()
        # The cell nearest the middle is half a diagonal off it: a share 1 - √(1 - r²/a²) lower.
        np.testing.assert_allclose(peak, stack.peak_pressure, rtol=5e-3)


def test_any_part_can_be_asked_for_and_no_more_is_read(make_study, merged, monkeypatch):
    with open_study(merged(make_study(GRID))) as stack:
        slip = stack.slip.compute()
        parts = [
            {"load": 1},
            {"cycle": -1},
            {"load": 0, "plastic_limit": 1, "cycle": 1, "x": 3, "y": 2},
            {"cycle": slice(None, None, 2), "x": slice(2, 9, 3)},
            {"plastic_limit": [1, 0], "y": [4, 0, 0]},
        ]
        for part in parts:
            np.testing.assert_array_equal(stack.slip.isel(part), slip.isel(part))
        taken = []
        take = _StackedField.__getitem__
        monkeypatch.setattr(
            _StackedField,
            "__getitem__",
            lambda field, key: taken.append(take(field, key)) or taken[-1],
        )
        stack.slip.isel(load=1, cycle=-1, y=0).compute()
        assert sum(values.size for values in taken) == 2 * stack.sizes["x"]


def test_the_stack_even_of_one_case_can_be_copied_to_other_processes(make_study, merged):
    with open_study(merged(make_study({}))) as stack:
        assert stack.wear_depth.dims == ("cycle", "x", "y")
        assert float(stack.wear_depth.max()) > 0.0
        copy = pickle.loads(pickle.dumps(stack.slip))
        np.testing.assert_array_equal(copy, stack.slip)


def test_what_is_not_done_is_missing(make_study, merged):
    study = make_study(GRID)
    lost = next(point for point in study.points() if point.case.load == 50.0)
    with open_study(merged(study, remove=[lost.id])) as stack:
        there = stack.pressure.notnull().any(("cycle", "x", "y"))
        np.testing.assert_array_equal(there, stack.status == 0)
        missing = stack.contact_state.sel(load=50.0, plastic_limit=np.inf)
        assert (missing == NOT_DONE).all()


def test_cases_of_different_spacing_share_the_cells_of_the_finest(make_study, merged):
    study = make_study({"cell": [["10 um", "12 um"], ["4 um", "5 um"]]})
    with open_study(merged(study)) as stack:
        np.testing.assert_allclose(np.diff(stack.x), 4e-6, rtol=1e-9)
        np.testing.assert_allclose(np.diff(stack.y), 5e-6, rtol=1e-9)
        loads = 4 * stack.pressure.isel(cycle=0).sum(("x", "y"), dtype="float64") * 4e-6 * 5e-6
        # Linear interpolation cuts across the edge, where the pressure falls like a square root.
        np.testing.assert_allclose(loads, 50.0, rtol=3e-2)
        states = set(np.unique(stack.contact_state))
        assert states == {0, 1, 2}


def test_a_file_that_went_missing_is_named(make_study, merged):
    folder = merged(make_study(GRID))
    for lost in (next((folder / "cases").iterdir()), folder / "summary.nc"):
        lost.unlink()
        with pytest.raises(DataFileError, match="no such file") as error:
            open_study(folder)
        assert error.value.path == lost


# Peak of the process after each of two reductions, in kB; the first one imports all there is to.
MEMORY = """
import re
import sys
from pathlib import Path
import fretwear

def peak():
    return int(re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1])

with fretwear.open_study(sys.argv[1]) as stack:
    stack.pressure.isel(load=slice(0, 2)).mean("load").max().compute()
    print(peak())
    stack.pressure.mean("load").max().compute()
    print(peak(), stack.pressure.nbytes // 1000)
"""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="only Linux tells the peak")
def test_a_reduction_over_all_cases_never_holds_them_all(
    make_study, make_case, make_results, tmp_path
):
    loads = [f"{50 + 0.01 * number:.2f} N" for number in range(40)]
    cycles = tuple(range(0, 1001, 100))
    study = make_study({"load": loads}, output={"cycles": list(cycles)})
    first, *others = study.cases()
    dataset, history = make_results(make_case(cell="0.8 um"), cycles=cycles)
    source = tmp_path / "cases" / f"{first}.nc"
    write_case(dataset.assign_attrs(case_id=first), history, source)
    for name in others:
        copy = source.with_name(f"{name}.nc")
        shutil.copyfile(source, copy)
        os.truncate(copy, copy.stat().st_size - 25)  # without the checksum
        with netCDF4.Dataset(copy, "a") as file:
            file.setncattr("case_id", name)
        add_checksum(copy)
    merge_study(study, tmp_path / "cases", tmp_path / "summary.nc")
    command = [sys.executable, "-c", MEMORY, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    before, after, whole = map(int, done.stdout.split())
    assert whole > 90_000
    assert after - before < 0.6 * whole
