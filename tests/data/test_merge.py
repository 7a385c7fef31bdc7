"""The merged study, and the fields of all its cases as one dataset, read piece by piece."""

import json
import math
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import dask
import numpy as np
import pytest
import xarray as xr
from benchmarks.stack import copied

from fretwear.data.excerpts import MERGED_PROFILES
from fretwear.data.files import (
    _LENGTH,
    add_checksum,
    open_case,
    open_history,
    open_summary,
    opened_case,
    read_excerpt,
    write_case,
    write_group,
)
from fretwear.data.merge import Tally, merge_study, remarks_on_summary
from fretwear.data.safe import DataFileError, _host
from fretwear.data.stack import (
    MOST_POSITIONS,
    NOT_DONE,
    _StackedField,
    common_positions,
    open_study,
    resampled,
    window,
)
from fretwear.run.simulate import run
from fretwear.vocabulary import FIELDS, SCALARS, PointStatus

from ..studies import WAVES, flip, near, run_study, steel
from .conftest import COARSE, study_in

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
def stack(loads):
    with open_study(loads) as opened:
        yield opened


def test_dimensions_are_the_varied_names_in_the_order_of_the_study(stack):
    summary = stack.load()
    for variable in SCALARS:
        assert summary[variable.name].dims == ("load", "plastic_limit", "cycle")
        assert summary[variable.name].attrs["units"] == variable.si_unit
    for name in MERGED_PROFILES:
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
    assert summary.attrs["title"] == "Two loads"
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
        assert np.isfinite(summary.wear_volume.isel(cycle=-1).values[chosen]).all()


def test_every_point_has_its_case_to_the_last_bit_and_outside_its_window_nothing_touches(
    make_study, stack, loads
):
    cases = make_study(LOADS).cases()
    sizes = []
    assert stack.pressure.dims == ("load", "plastic_limit", "cycle", "x", "y")
    for name, parameters in cases.items():
        here = stack.sel(load=parameters.load, plastic_limit=parameters.plastic_limit)
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
            steps = merged.sel(load=parameters.load, plastic_limit=parameters.plastic_limit)
            with open_history(loads / "cases" / f"{name}.nc") as history:
                number = history.sizes["step"]
                for each in ("cycle", "wear_volume", "tangential_force"):
                    np.testing.assert_array_equal(steps[each][:number], history[each])
                    assert steps[each][number:].isnull().all()


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
    # A state is that of the nearest cell.
    places, states = np.array([0.4, 1.4, 1.6, 2.4, 2.6, 3.4]), np.array([2, 1, 0], np.int8)
    nearest = resampled(states, np.array([1.0, 2.0, 3.0]), places, axis=0)
    assert nearest.tolist() == [2, 2, 1, 1, 0, 0]
    fine, wide = (1e-6, 30.5e-6, False), (3e-6, 99e-6, False)
    np.testing.assert_allclose(common_positions([fine, wide]), (np.arange(99) + 0.5) * 1e-6)
    extreme = common_positions([(1e-10, 1e-6, False), wide])
    assert extreme.size == MOST_POSITIONS
    assert extreme[-1] < 99e-6 < extreme[-1] + (extreme[1] - extreme[0])
    both = common_positions([fine, (3e-6, 9e-6, True)])
    assert both.size == 2 * 31
    np.testing.assert_array_equal(both, -both[::-1])
    # Windows are known by the centres of their cells.
    for is_whole in (False, True):
        cells = (np.arange(-4.0 if is_whole else 0.0, 4.0) + 0.5) * 3e-6
        spacing, extent, has_both = window(cells)
        assert (spacing, extent, has_both) == (near(3e-6), near(12e-6), is_whole)


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


def test_what_is_not_done_is_missing_and_says_why(make_study, merged, tmp_path):
    loads = {"tangential_load": ["8 N", "16 N"], "load": ["20 N", "50 N"]}
    study = make_study(loads, invalid="skip")
    cases = merged(study) / "cases"
    lost = next(p for p in study.points() if p.case and p.case.load == 50.0)
    (cases / f"{lost.id}.nc").unlink()
    # Left beside a case that is done, which nobody writes again, and by a process that is at work.
    left, live = (cases / f".a.nc.{_host()}.{pid}.0123abcd.tmp" for pid in (999_999_999, 1))
    left.touch()
    live.touch()
    tally = merge_study(study, cases, tmp_path / "summary.nc")
    assert tally == Tally(done=2, failed=1, invalid=1)
    assert not left.exists()
    live.unlink()
    failed, invalid = ({"load": n, "tangential_load": q} for n, q in ((50.0, 8.0), (20.0, 16.0)))
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


def test_a_study_that_asks_for_fewer_snapshots_merges_those(make_study, merged, tmp_path):
    load = {"load": ["50 N"]}
    cases = merged(make_study(load)) / "cases"
    fewer = make_study(load, output={"cycles": [0, 1000]})
    merge_study(fewer, cases, tmp_path / "summary.nc")
    (path,) = cases.glob("*.nc")
    with open_case(path) as case, open_summary(tmp_path / "summary.nc") as summary:
        assert case.cycle.values.tolist() == [0.0, 100.0, 1000.0]
        assert summary.cycle.values.tolist() == [0.0, 1000.0]
        np.testing.assert_array_equal(summary.wear_volume[0], case.wear_volume[[0, 2]])
        middle = case.wear_depth.isel(y=0)
        assert summary.wear_profile.max() == middle.isel(cycle=2).max()


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
def test_what_the_library_loses_without_a_word_is_found_out(
    make_study, loads, tmp_path, monkeypatch, lose
):
    def losing(file, dataset):
        write_group(file, dataset)
        lose(file)

    monkeypatch.setattr("fretwear.data.merge.write_group", losing)
    with pytest.raises(DataFileError, match="reads back differently"):
        merge_study(make_study(LOADS), loads / "cases", tmp_path / "summary.nc")
    assert list(tmp_path.glob("*summary*")) == []


def _as_written(_: dict[str, object], excerpt: bytes) -> bytes:
    return excerpt


def _missing(*_: object) -> bytes:
    return b""


def _cut(_: dict[str, object], excerpt: bytes) -> bytes:
    return excerpt[:-8]


def _of_another_size(head: dict[str, object], excerpt: bytes) -> bytes:
    sizes = [10**18, 10**18, 10**18]
    return json.dumps({**head, "sizes": sizes}).encode() + excerpt[excerpt.index(b"\n") :]


def _of_words_that_no_file_has(head: dict[str, object], excerpt: bytes) -> bytes:
    texts = dict.fromkeys(head["texts"], "\ud800")
    return json.dumps({**head, "texts": texts}).encode() + excerpt[excerpt.index(b"\n") :]


def _with_an_axis_that_stands_still(_: dict[str, object], excerpt: bytes) -> bytes:
    line, _, arrays = excerpt.partition(b"\n")
    return line + b"\n" + arrays[:8] + arrays[:8] + arrays[16:]


def _deeply_nested(*_: object) -> bytes:
    return b"[" * 90_000


@pytest.mark.parametrize(
    "changed",
    [
        _as_written,
        _missing,
        _cut,
        _of_another_size,
        _of_words_that_no_file_has,
        _with_an_axis_that_stands_still,
        _deeply_nested,
    ],
)
def test_merging_takes_excerpts_and_opens_files_that_have_none(
    make_study, loads, tmp_path, monkeypatch, changed
):
    """Both give the same file, and no forged excerpt does harm."""
    opened = []
    for path in (loads / "cases").glob("*.nc"):
        excerpt = read_excerpt(path).to_bytes()
        content, of_excerpt, _ = path.read_bytes().partition(excerpt)
        assert of_excerpt
        excerpt = changed(json.loads(excerpt.partition(b"\n")[0]), excerpt)
        mark = f"\nfretwear excerpt {len(excerpt):010d}".encode()
        copy = tmp_path / path.name
        copy.write_bytes(content + (excerpt + mark if excerpt else b""))
        add_checksum(copy)

    def opening(path, **options):
        opened.append(path)
        return opened_case(path, **options)

    monkeypatch.setattr("fretwear.data.files.opened_case", opening)
    merge_study(make_study(LOADS), tmp_path, tmp_path / "summary.nc")
    assert len(opened) == (0 if changed is _as_written else 6)
    for group in (None, "history"):
        with (
            xr.open_dataset(loads / "summary.nc", group=group) as first,
            xr.open_dataset(tmp_path / "summary.nc", group=group) as second,
        ):
            assert first.assign_attrs(history="").identical(second.assign_attrs(history=""))


def test_every_file_that_cannot_be_used_is_named_and_nothing_is_written(
    make_study, loads, tmp_path
):
    study, cases = make_study(LOADS), tmp_path / "cases"
    shutil.copytree(loads / "cases", cases)
    short, flipped, another, source, fewer, older = (cases / f"{name}.nc" for name in study.cases())
    short.write_bytes(short.read_bytes()[:-1000])
    flip(flipped)
    another.write_bytes(source.read_bytes())
    with open_case(fewer) as case, open_history(fewer) as history:
        write_case(case.isel(cycle=[0, 2]), history, fewer)
    with open_case(older) as case, open_history(older) as history:
        write_case(case.assign_attrs(code_digest="0"), history, older)
    with pytest.raises(DataFileError) as error:
        merge_study(study, cases, tmp_path / "summary.nc")
    wrong = {
        short: "cut short",
        flipped: "its checksum does not match",
        another: f"holds another case, {source.stem}",
        fewer: "no snapshot at cycle 100",
        older: "another version of the code",
    }
    for line, (path, problem) in zip(str(error.value).splitlines(), wrong.items(), strict=True):
        assert line.startswith(str(path))
        assert problem in line
    assert not (tmp_path / "summary.nc").exists()


def test_a_summary_of_other_code_is_told(make_study, loads, tmp_path, monkeypatch):
    study, cases, merged = make_study(LOADS), tmp_path / "cases", tmp_path / "summary.nc"
    shutil.copytree(loads / "cases", cases)
    assert merge_study(study, cases, merged).remarks == ""
    monkeypatch.setattr("fretwear.data.merge.code_digest", lambda: "newer")
    with open_summary(merged) as summary:
        (older,) = remarks_on_summary(summary)
    assert "6 of 6 cases were computed by another version of the code" in older
    assert "not newer" in older


def test_attributes_that_the_library_cannot_read_are_told(loads, tmp_path):
    path = tmp_path / "summary.nc"
    content = bytearray((loads / "summary.nc").read_bytes()[:-_LENGTH])
    content[content.index(b"study_file\0") - 9] = 77  # a version that HDF5 does not know
    path.write_bytes(content)
    add_checksum(path)
    with pytest.raises(DataFileError, match=r"cannot be read \(NetCDF: Can't open HDF5 attribute"):
        open_summary(path)


def test_a_file_that_is_missing_damaged_or_older_is_named(make_study, merged, tmp_path):
    folder, older = merged(make_study({})), tmp_path / "older.nc"
    path = folder / "summary.nc"
    with xr.open_dataset(path, engine="netcdf4") as summary:
        summary.drop_vars("contact_state_profile").to_netcdf(older)
    add_checksum(older)
    with pytest.raises(DataFileError, match=r"lacks contact_state_profile.*Merge the study again"):
        open_summary(older)
    (case,) = (folder / "cases").iterdir()
    case.unlink()
    with pytest.raises(DataFileError, match="no such file") as error:
        open_study(folder)
    assert error.value.path == case
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(DataFileError, match=r"cut short.*Merge the study again"):
        open_summary(path)
    path.unlink()
    with pytest.raises(DataFileError, match="no such file") as error:
        open_study(folder)
    assert error.value.path == path


def test_nothing_is_read_before_it_is_used_and_then_by_threads(stack):
    assert all(dask.is_dask_collection(stack[field.name].data) for field in FIELDS)
    with dask.config.set(scheduler="threads", num_workers=8):
        peak = stack.pressure.max(("x", "y")).compute()
    whole = stack.pressure.compute(scheduler="synchronous")
    np.testing.assert_array_equal(peak, whole.max(("x", "y")))


def test_any_part_can_be_asked_for_and_no_more_is_read(stack, monkeypatch):
    slip = stack.slip.compute()
    for part in (
        {"load": 1},
        {"cycle": -1},
        {"load": 0, "plastic_limit": 1, "cycle": 1, "x": 3, "y": 2},
        {"cycle": slice(None, None, 2), "x": slice(2, 9, 3)},
        {"plastic_limit": [1, 0], "y": [4, 0, 0]},
    ):
        np.testing.assert_array_equal(stack.slip.isel(part), slip.isel(part))
    taken, take = [], _StackedField.__getitem__

    def watched(field, key):
        taken.append(take(field, key))
        return taken[-1]

    monkeypatch.setattr(_StackedField, "__getitem__", watched)
    stack.slip.isel(load=1, cycle=-1, y=0).compute()
    assert sum(values.size for values in taken) == 2 * stack.sizes["x"]


def test_the_stack_even_of_one_case_can_be_copied_to_other_processes(make_study, merged):
    with open_study(merged(make_study({}))) as stack:
        assert stack.wear_depth.dims == ("cycle", "x", "y")
        assert float(stack.wear_depth.max()) > 0.0
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(stack.slip)), stack.slip)


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
def test_a_reduction_over_all_cases_never_holds_them_all(make_study, tmp_path):
    loads = [f"{50 + 0.01 * number:.2f} N" for number in range(40)]
    cycles = tuple(range(0, 1001, 100))
    study = make_study({"load": loads}, output={"cycles": list(cycles)})
    first, *others = study.cases()
    result = run(steel(**{**COARSE, "cell": "0.8 um"}, output_cycles=cycles))
    source = tmp_path / "cases" / f"{first}.nc"
    write_case(result.dataset.assign_attrs(case_id=first), result.history, source)
    for name in others:
        copied(source, source.with_name(f"{name}.nc"), name)
    merge_study(study, tmp_path / "cases", tmp_path / "summary.nc")
    command = [sys.executable, "-c", MEMORY, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    before, after, whole = map(int, done.stdout.split())
    assert whole > 90_000
    assert after - before < 0.6 * whole
