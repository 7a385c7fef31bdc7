import json
import math

import numpy as np
import pytest

from fretwear.data.files import open_case, open_history, open_summary, write_case
from fretwear.data.merge import PROFILES, Tally, merge_study
from fretwear.data.safe import CaseFilesError, DataFileError
from fretwear.vocabulary import SCALARS, PointStatus

LOADS = {"load": ["20 N", "50 N", "40 N"], "plastic_limit": ["none", "4500 MPa"]}


@pytest.fixture
def merge(tmp_path, run_study):
    def merged(study):
        tally = merge_study(study, run_study(study), tmp_path / "summary.nc")
        with open_summary(tmp_path / "summary.nc") as summary:
            return summary.load(), tally

    return merged


def test_dimensions_are_the_varied_names_in_the_order_of_the_study(make_study, merge):
    summary, tally = merge(make_study(LOADS))
    assert tally == Tally(done=6, failed=0, invalid=0)
    for variable in SCALARS:
        assert summary[variable.name].dims == ("load", "plastic_limit", "cycle")
        assert summary[variable.name].attrs["units"] == variable.si_unit
    for profile in PROFILES:
        assert summary[profile.name].dims == ("load", "plastic_limit", "cycle", "x")
        assert summary[profile.name].dtype == np.float32
    assert summary["load"].values.tolist() == [20.0, 50.0, 40.0]
    assert summary.plastic_limit.values.tolist() == [math.inf, 4.5e9]
    assert (summary["load"].attrs["units"], summary.plastic_limit.attrs["units"]) == ("N", "Pa")
    assert summary.cycle.values.tolist() == [0.0, 100.0, 1000.0]


def test_the_order_of_the_study_is_kept_whatever_it_is(make_study, merge):
    vary = {"plastic_limit": ["none", "4500 MPa"], "friction": [0.6, 0.3], "load": ["50 N"]}
    summary, _ = merge(make_study(vary))
    assert summary.wear_volume.dims == ("plastic_limit", "friction", "load", "cycle")
    assert summary.gap_profile.dims == ("plastic_limit", "friction", "load", "cycle", "x")


def test_every_point_has_the_values_of_its_case(make_study, merge, tmp_path):
    study = make_study(LOADS)
    summary, _ = merge(study)
    for point in study.points():
        here = summary.sel(load=point.case.load, plastic_limit=point.case.plastic_limit)
        assert here.case_id == point.id
        with open_case(tmp_path / "cases" / f"{point.id}.nc") as case:
            for variable in SCALARS:
                np.testing.assert_array_equal(here[variable.name], case[variable.name])
            assert here.hertz_radius == case.hertz_radius


def test_cases_of_one_spacing_keep_their_profiles_to_the_last_bit(make_study, merge, tmp_path):
    study = make_study(LOADS)
    summary, _ = merge(study)
    largest = max(case.hertz_radius for case in study.cases().values())
    assert summary.sizes["x"] == math.ceil(1.3 * largest / 10e-6)
    for point in study.points():
        here = summary.sel(load=point.case.load, plastic_limit=point.case.plastic_limit)
        with open_case(tmp_path / "cases" / f"{point.id}.nc") as case:
            np.testing.assert_array_equal(here.x[: case.sizes["x"]], case.x)
            for profile in PROFILES:
                row = case[profile.field.name].isel(y=0)
                inside = here[profile.name][:, : case.sizes["x"]]
                np.testing.assert_array_equal(inside, row)


def test_outside_a_window_nothing_touches_and_the_gap_is_not_known(make_study, merge):
    summary, _ = merge(make_study(LOADS))
    small = summary.isel(load=0, plastic_limit=0)
    outside = small.x > 1.3 * small.hertz_radius + 10e-6
    assert outside.any()
    for name in ("pressure_profile", "shear_profile", "wear_profile", "wear_rate_profile"):
        assert (small[name][:, outside] == 0.0).all()
    assert small.gap_profile[:, outside].isnull().all()
    assert small.gap_profile[:, ~outside].notnull().all()
    assert summary.isel(load=1).gap_profile.notnull().all()


def test_cases_of_different_spacing_are_interpolated_on_the_finest(make_study, merge):
    study = make_study({"cell": [["10 um", "12 um"], ["4 um", "12 um"]]})
    summary, _ = merge(study)
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


def test_words_stand_for_values_that_are_not_numbers(make_study, merge):
    rough = {"kind": "wavy", "amplitude": "0.1 um", "slope_x": "0.2 deg", "slope_y": "0.2 deg"}
    summary, _ = merge(make_study({"roughness": ["none", rough], "slip_model": ["jaeger"]}))
    assert summary.wear_volume.dims == ("roughness", "slip_model", "cycle")
    assert summary.slip_model.values.tolist() == ["jaeger"]
    assert summary.roughness.values[0] == "none"
    assert "0.1 um" in str(summary.roughness.values[1])
    assert "units" not in summary.roughness.attrs
    np.testing.assert_allclose(summary.roughness_amplitude, [[0.0], [1e-7]], rtol=1e-12)


def test_a_dotted_name_becomes_one_word(make_study, merge):
    summary, _ = merge(make_study({"roughness.amplitude": ["0 um", "0.1 um"]}))
    assert summary.wear_volume.dims == ("roughness_amplitude", "cycle")
    np.testing.assert_allclose(summary.roughness_amplitude, [0.0, 1e-7], rtol=1e-12)
    assert summary.roughness_amplitude.attrs["units"] == "m"


def test_pairs_lie_along_the_points(make_study, merge):
    vary = {"load": ["20 N", "50 N"], "friction": [0.3, 0.6]}
    summary, _ = merge(make_study(vary, design="zip"))
    assert summary.wear_volume.dims == ("point", "cycle")
    assert summary.point.values.tolist() == [0, 1]
    assert summary["load"].dims == summary.friction.dims == ("point",)
    assert summary["load"].values.tolist() == [20.0, 50.0]
    assert summary.friction.values.tolist() == [0.3, 0.6]


def test_samples_lie_along_the_points(make_study, merge):
    vary = {"load": {"from": "20 N", "to": "50 N"}, "friction": {"from": 0.3, "to": 0.6}}
    study = make_study(vary, design={"kind": "latin_hypercube", "points": 3, "seed": 1})
    summary, _ = merge(study)
    assert summary.wear_volume.dims == ("point", "cycle")
    assert summary["load"].values.tolist() == [case.load for case in study.cases().values()]
    assert summary.friction.values.tolist() == [c.friction for c in study.cases().values()]


def test_a_study_that_varies_nothing_has_no_dimension_of_its_own(make_study, merge):
    summary, tally = merge(make_study({}))
    assert summary.wear_volume.dims == ("cycle",)
    assert summary.pressure_profile.dims == ("cycle", "x")
    assert summary.status == PointStatus.DONE
    assert tally == Tally(1, 0, 0)


def test_what_is_not_done_is_nan_and_says_why(make_study, run_study, tmp_path):
    study = make_study(
        {"tangential_load": ["8 N", "16 N"], "load": ["20 N", "50 N"]}, invalid="skip"
    )
    cases = run_study(study)
    failed = next(p for p in study.points() if p.case and p.case.load == 50.0)
    (cases / f"{failed.id}.nc").unlink()
    tally = merge_study(study, cases, tmp_path / "summary.nc")
    assert tally == Tally(done=2, failed=1, invalid=1)
    with open_summary(tmp_path / "summary.nc") as summary:
        assert summary.status.dtype == np.int8
        assert summary.status.sel(load=50.0, tangential_load=8.0) == PointStatus.FAILED
        assert summary.status.sel(load=20.0, tangential_load=16.0) == PointStatus.INVALID
        assert summary.status.attrs["flag_meanings"] == "done failed invalid"
        done = summary.status == PointStatus.DONE
        for name in (*(variable.name for variable in SCALARS), "pressure_profile"):
            whole = (
                summary[name].notnull().all([d for d in summary[name].dims if d not in done.dims])
            )
            np.testing.assert_array_equal(whole, done)
        assert summary.case_id.sel(load=20.0, tangential_load=16.0) == ""


def test_snapshots_that_a_case_does_not_have_are_nan(make_study, merge):
    summary, _ = merge(make_study({"cycles": [500, 1000]}, output={"cycles": [0, 100]}))
    assert summary.wear_volume.dims == ("cycles", "cycle")
    assert summary.cycle.values.tolist() == [0.0, 100.0, 500.0, 1000.0]
    there = summary.wear_volume.notnull().values.tolist()
    assert there == [[True, True, True, False], [True, True, False, True]]
    assert summary.pressure_profile[0, 3].isnull().all()


def test_parameters_that_all_cases_share_are_scalars(make_study, merge):
    study = make_study(LOADS)
    summary, _ = merge(study)
    assert summary.radius.ndim == 0
    assert summary.radius.attrs["units"] == "m"
    assert summary.slip_model == "jaeger"
    assert summary.cycles.dtype == summary.radius.dtype == np.float64
    assert summary.tangential_load.dims == ("load", "plastic_limit")
    assert "tangential_load" not in summary.coords
    assert summary.attrs["title"] == study.title
    assert json.loads(summary.attrs["study_file"])["vary"] == LOADS


def test_a_missing_study_is_told(make_study, tmp_path):
    with pytest.raises(DataFileError, match="no case of the study is done"):
        merge_study(make_study(LOADS), tmp_path / "cases", tmp_path / "summary.nc")
    assert not (tmp_path / "summary.nc").exists()


def test_every_damaged_file_is_named_and_nothing_is_written(make_study, run_study, tmp_path):
    study = make_study(LOADS)
    cases = run_study(study)
    short, flipped, *_ = (cases / f"{name}.nc" for name in study.cases())
    short.write_bytes(short.read_bytes()[:-1000])
    content = bytearray(flipped.read_bytes())
    content[len(content) // 2] ^= 1
    flipped.write_bytes(content)
    with pytest.raises(CaseFilesError) as error:
        merge_study(study, cases, tmp_path / "summary.nc")
    assert {found.path for found in error.value.errors} == {short, flipped}
    assert str(short) in str(error.value)
    assert str(flipped) in str(error.value)
    assert not (tmp_path / "summary.nc").exists()


def test_a_file_of_another_case_or_other_snapshots_is_refused(make_study, run_study, tmp_path):
    study = make_study(LOADS)
    cases = run_study(study)
    first, second, third, *_ = (cases / f"{name}.nc" for name in study.cases())
    first.write_bytes(second.read_bytes())
    with open_case(third) as case, open_history(third) as history:
        write_case(case.isel(cycle=[0, 2]), history, third)
    with pytest.raises(CaseFilesError) as error:
        merge_study(study, cases, tmp_path / "summary.nc")
    lines = str(error.value).splitlines()
    assert [f"holds another case, {second.stem}" in lines[0], "cycle 100" in lines[1]] == [True] * 2


def test_a_damaged_summary_is_not_opened(make_study, run_study, tmp_path):
    study, path = make_study({}), tmp_path / "summary.nc"
    with pytest.raises(DataFileError, match="no such file"):
        open_summary(path)
    merge_study(study, run_study(study), path)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(DataFileError, match=r"cut short.*Merge the study again"):
        open_summary(path)
