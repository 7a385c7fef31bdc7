"""``fretwear stress``: a case file in, a file of stresses out."""

import pytest
import xarray as xr


@pytest.mark.slow
def test_stresses_of_a_snapshot_are_written_and_the_largest_are_told(desk, case_file):
    options = ("--cycle", 20, "--depth", "10 um, 30 um,60um")
    constants = ("--fatemi-socie", "1, 1000 MPa", "--crossland", 0.2)
    said = desk.call("stress", case_file, "-o", "stress.nc", *options, *constants).stdout
    assert "Fatemi–Socie parameter" in said
    assert "plane" in said
    assert said.splitlines()[-1] == "stress.nc"
    with xr.open_dataset("stress.nc", decode_timedelta=False) as stored:
        assert stored.stress_xx.dims == ("phase", "x", "y", "z")
        assert stored.z.values == pytest.approx([1e-5, 3e-5, 6e-5])
        assert {"von_mises", "crossland", "fatemi_socie_normal"} <= set(stored.data_vars)
        assert float(stored.cycle) == 20.0
    assert desk.files() == ["stress.nc", "tiny.yaml"]
    pytest.importorskip("pyevtk")
    said = desk.call("export", "stress.nc", "--to", "vtk").stdout
    assert said.splitlines()[-1] == "stress.pvd"


@pytest.mark.slow
def test_where_a_crack_is_expected_is_told_for_each_snapshot(desk, case_file):
    constants = ("--basquin", "1000 MPa, -0.1", "--manson-coffin", "0.5,-0.6")
    options = ("-o", "fatigue.nc", "--depth", "0.2 mm")
    said = desk.call("fatigue", case_file, *constants, *options).stdout
    head, *rows, note, path = said.splitlines()
    assert head.split()[0] == "cycle"
    assert note.endswith("–: not known")
    assert [row.split()[0] for row in rows] == ["0", "20", "200"]
    assert all(row.endswith("no crack") for row in rows)
    assert path == "fatigue.nc"
    with xr.open_dataset("fatigue.nc") as stored:
        assert stored.damage.dims == ("cycle", "x", "material_z")
        assert stored.fatigue_strength == 1e9
    reason = "manson_coffin = '0.5': must be two constants, such as '0.5, -0.6'"
    assert reason in desk.call("fatigue", case_file, "--manson-coffin", 0.5, status=2).stderr
    said = desk.call("export", "fatigue.nc", "--to", "csv").stdout.splitlines()
    assert "fatigue-cycle-x-z.csv" in said
