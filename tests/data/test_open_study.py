"""The fields of all cases as one dataset, read piece by piece."""

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

from fretwear.data import merge
from fretwear.data.files import add_checksum, open_case, write_case
from fretwear.data.merge import NOT_DONE, merge_study, open_study
from fretwear.data.safe import DataFileError
from fretwear.vocabulary import FIELDS

LOADS = {"load": ["20 N", "50 N"], "plastic_limit": ["none", "4500 MPa"]}


def test_the_stack_holds_the_fields_of_every_case_to_the_last_bit(make_study, merged):
    study = make_study(LOADS)
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
    with open_study(merged(make_study(LOADS))) as stack:
        assert all(dask.is_dask_collection(stack[field.name].data) for field in FIELDS)
        with dask.config.set(scheduler="threads", num_workers=8):
            peak = stack.pressure.max(("x", "y")).compute()
        # The cell nearest the middle is half a diagonal off it: a share 1 - √(1 - r²/a²) lower.
        np.testing.assert_allclose(peak, stack.peak_pressure, rtol=5e-3)


def test_any_part_can_be_asked_for_and_no_more_is_read(make_study, merged, monkeypatch):
    with open_study(merged(make_study(LOADS))) as stack:
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
        take = merge._StackedField.__getitem__
        monkeypatch.setattr(
            merge._StackedField,
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
    study = make_study(LOADS)
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
    folder = merged(make_study(LOADS))
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
