"""What the page on reading results says of other programs holds for a file."""

import re
from pathlib import Path

import netCDF4
import numpy as np
import pytest

import fretwear
from fretwear.data.files import write_case
from fretwear.running.simulate import run

from ..studies import steel

PAGE = (Path(__file__).resolve().parents[2] / "docs/how-to/reading.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def case_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("reading") / "case.nc"
    result = run(steel(cycles=300, cell="6 um"))
    write_case(result.dataset, result.history, path)
    return path


def test_names_that_matlab_reads_are_in_the_file(case_file):
    names = re.findall(r"ncread\(file, '([^']+)'\)", PAGE)
    assert len(names) >= 7
    with netCDF4.Dataset(case_file) as file:
        for name in names:
            assert file[name].shape is not None
        assert file["wear_depth"].dimensions == ("cycle", "x", "y")
        for attribute in re.findall(r"ncreadatt\(file, '/', '([^']+)'\)", PAGE):
            assert file.getncattr(attribute)


def test_paraview_takes_the_cycles_of_its_copy_for_time(case_file, tmp_path, monkeypatch):
    vtk = pytest.importorskip("vtk", reason="VTK is not installed")
    monkeypatch.chdir(tmp_path)
    (recipe,) = re.findall(r"```python\n(case = .*?to_netcdf\(\"paraview.nc\"\)\n)```", PAGE, re.S)
    target = tmp_path / "results/small/cases/case.nc"
    target.parent.mkdir(parents=True)
    target.write_bytes(case_file.read_bytes())
    exec(recipe, {"fretwear": fretwear, "name": "case"})
    reader = vtk.vtkNetCDFCFReader()
    reader.SetFileName("paraview.nc")
    reader.UpdateMetaData()
    reader.SphericalCoordinatesOff()
    reader.SetDimensions("(y, x)")
    reader.UpdateInformation()
    steps = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert steps == (0.0, 300.0)
    reader.UpdateTimeStep(300.0)
    depth = reader.GetOutput().GetPointData().GetArray("wear_depth")
    with fretwear.open_case(case_file) as case:
        expected = float(case["wear_depth"].isel(cycle=-1).max())
    assert depth.GetRange()[1] == pytest.approx(expected, rel=1e-6)
    assert np.isfinite(depth.GetRange()).all()
