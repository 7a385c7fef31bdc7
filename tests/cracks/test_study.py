"""Stresses that a study asks for: beside its cases, in the merged study, drawn and reported."""

import numpy as np
import pytest
import xarray as xr

from fretwear.data.files import open_summary, write_case
from fretwear.data.merge import merge_study
from fretwear.run.simulate import run
from fretwear.study.reading import load_study
from fretwear_cracks.figures import crack_figures, fatigue_map

from ..studies import base, write_study

pytestmark = pytest.mark.slow

STRESS = {
    "depth": "0.3 mm",
    "fatigue_strength": "1000 MPa",
    "strength_exponent": -0.1,
    "fatigue_ductility": 0.5,
    "ductility_exponent": -0.6,
}


@pytest.fixture(scope="module")
def cracked(tmp_path_factory):
    """A study of two displacements, in partial and in gross slip, and the folder of its results."""
    folder = tmp_path_factory.mktemp("cracked")
    content = {
        "title": "Cracks",
        "base": base(cycles=20_000, cell="15 um", tangential_ratio=None, error_estimate=False),
        "vary": {"displacement_amplitude": ["1 um", "3 um"]},
        "output": {"cycles": [0, 2000], "stress": STRESS},
    }
    study = load_study(write_study(folder / "cracks.yaml", content))
    for case_id, case in study.cases().items():
        result = run(case)
        write_case(result.dataset, result.history, folder / f"cases/{case_id}.nc", result.loops)
    told = []
    merge_study(study, folder / "cases", folder / "summary.nc", tell=told.append)
    assert not told
    return study, folder


def test_a_merged_study_has_the_fatigue_of_its_cases(cracked):
    study, folder = cracked
    with open_summary(folder / "summary.nc") as merged:
        swt = merged.largest_smith_watson_topper
        assert swt.dims == ("displacement_amplitude", "cycle")
        assert swt.notnull().all()
        assert merged.fatigue_outcome.values[:, -1].tolist() == [2.0, 1.0]
        for case_id, row in zip(study.cases(), swt.values, strict=True):
            file = folder / f"fatigue/{case_id}.nc"
            with xr.open_dataset(file) as stored:
                np.testing.assert_array_equal(stored.largest_smith_watson_topper, row)
                assert float(stored.z[-1]) == pytest.approx(0.3e-3)
            stamp = file.stat().st_mtime_ns
            study.added["output.stress"].stored(folder / f"cases/{case_id}.nc")
            assert file.stat().st_mtime_ns == stamp


def test_figures_show_who_wins_and_where(cracked):
    _, folder = cracked
    with open_summary(folder / "summary.nc") as merged:
        figures = {each.name: each.figure for each in crack_figures(merged, folder / "cases")}
        assert {"largest_smith_watson_topper", "largest_damage", "fatigue_map"} <= {*figures}
        (outcome,) = fatigue_map(merged).axes[0].get_images()
        assert np.asarray(outcome.get_array()).ravel().tolist() == [2.0, 1.0]
        unworn, worn, *_ = figures["crack_map_1"].axes
        for axes, cycle in ((unworn, 0), (worn, -1)):
            marks = [line for line in axes.get_lines() if line.get_marker() == "+"]
            expected = merged.isel(displacement_amplitude=0, cycle=cycle)
            place = np.ravel(marks[0].get_data())
            np.testing.assert_allclose(place * 1e-6, [expected.crack_x, expected.crack_depth])
