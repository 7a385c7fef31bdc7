"""Results where they mean nothing: singular peaks, zones that are not there, edges within cells."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fretwear.cli.show import case_lines, comparison_lines
from fretwear.data.effects import Points, final_results, results_table
from fretwear.data.files import open_case, open_history
from fretwear.data.labels import mirrored
from fretwear.mechanics.wear import grading
from fretwear.run.simulate import run, steps
from fretwear.study.reading import load_study

from ..studies import SELF_AFFINE, WAVES, base, line_contact, near, run_study, steel, write_study

pytestmark = pytest.mark.slow

CYLINDER = line_contact("6 mm", "50 N/mm")
GROSS = {"tangential_ratio": None, "displacement_ratio": 1.3}


def peaks(**changes):
    """The peak pressure and its estimated error at cycles 0, 100 and 3000, Pa."""
    case = steel(**{"cycles": 3000, "output_cycles": (100,), **changes})
    found = run(case).dataset
    assert "inf" not in found.attrs["warnings"]
    return found.peak_pressure.values, found.peak_pressure_error.values


def test_a_peak_that_grows_with_the_inverse_root_of_the_cells_has_an_infinite_error():
    """The limit of many cycles presses like a flat punch at the edge of its stick zone."""
    fine, coarse = (peaks(cell=cell, slip_model="jaeger") for cell in ("2 um", "4 um"))
    assert math.inf == fine[1][-1] == coarse[1][-1]
    assert fine[0][-1] / coarse[0][-1] == near(math.sqrt(2.0), rel=0.06)
    # At first it is regular and known.
    for place in (0, 1):
        assert fine[1][place] < 0.05 * fine[0][place]
        assert abs(fine[0][place] - coarse[0][place]) <= coarse[1][place]


def test_a_peak_that_narrow_rings_still_resolve_lies_within_its_error(monkeypatch):
    """A mean over cells misses 13 %; slip that is fixed never makes the peak singular."""
    cycles = {"cycles": 1000, "output_cycles": (600,)}
    for model in ("jaeger", "cattaneo_mindlin"):
        pressure, error = peaks(**cycles, slip_model=model, cell="4 um")
        with monkeypatch.context() as narrower:
            narrower.setattr(grading, "NARROWEST_RING", grading.NARROWEST_RING / 4.0)
            *_, last = steps(steel(**cycles, slip_model=model, error_estimate=False))
        true = float(last.state.pressure.max())
        assert 1.2 < true / steel().hertz_pressure < 2.0
        # Steps of both runs leave a thousandth.
        assert abs(true - pressure[-1]) <= error[-1] + 1e-3 * true
        assert error[-1] < 0.5 * pressure[-1]


@pytest.mark.parametrize(
    ("changes", "unresolved"),
    [
        ({**CYLINDER, "load": "200 N/mm"}, math.inf),
        ({"tangential_ratio": None, "displacement_ratio": 0.9}, math.inf),
        ({"roughness": WAVES, "cell": ["1 um", "4 um"]}, math.inf),
        ({"roughness": WAVES, "cell": ["1 um", "4 um"], "plastic_limit": "90 GPa"}, 9e10),
        ({"plastic_limit": "1.5 GPa", "cycles": 1000}, 1.5e9),
        (GROSS, 0.0),
        ({**CYLINDER, "tangential_ratio": None, "sliding_amplitude": "2 um"}, 0.0),
    ],
    ids=["cylinder", "displacement", "waves", "high limit", "limit", "gross slip", "stroke"],
)
def test_the_error_of_a_peak_reaches_to_what_bounds_it(changes, unresolved):
    """To the plastic limit, where that does not act, or without end; to nothing in gross slip."""
    rough = "roughness" in changes
    pressure, error = peaks(**({"cycles": 200, "output_cycles": ()} if rough else {}), **changes)
    if unresolved > 1e10:
        assert pressure[-1] + error[-1] == near(unresolved, rel=0.01)
    else:
        assert error[-1] < 0.05 * pressure[-1]
    assert error[0] < (1.0 if rough else 0.05) * pressure[0]


@pytest.fixture(scope="module")
def fading(tmp_path_factory):
    """A study of two points: friction falls, and where it falls far nothing sticks any more."""
    folder = tmp_path_factory.mktemp("fading")
    changes = {"tangential_ratio": None, "displacement_amplitude": "1 um", "cycles": 2000}
    content = {
        "title": "Fading",
        "base": base(**{**changes, "cell": "6 um", "friction": None}),
        "vary": {"friction": [{"cycles": [0, 1500], "values": [0.7, end]} for end in (0.3, 0.69)]},
        "output": {"cycles": [0, 1000, 2000]},
    }
    study = load_study(write_study(folder / "fading.yaml", content))
    run_study(study, folder)
    return study, folder


LACKING = ("mean_stick_pressure", "stick_load_share")


def test_what_a_zone_that_is_not_there_has_is_missing_in_files_tables_and_figures(fading):
    study, folder = fading
    paths = [folder / "cases" / f"{each}.nc" for each in study.cases()]
    with open_case(paths[0]) as slid, open_case(paths[1]) as stuck:
        assert list(slid.regime) == [0, 0, 1]
        for name in LACKING:
            assert np.isnan(slid[name][-1])
            assert np.isnan(slid[f"{name}_error"][-1])
            assert np.isfinite(slid[name][:-1]).all()
            assert np.isfinite(stuck[name]).all()
            assert "NaN where nothing sticks" in slid[name].comment
        assert float(slid.stick_area[-1]) == float(slid.stick_half_width_x[-1]) == 0.0
        rows = [line for line in comparison_lines(stuck, slid) if "stick share" in line]
        assert len(rows) == 1
        assert "–" in rows[0]
    summary = xr.load_dataset(folder / "summary.nc")
    rows = [*csv.DictReader(results_table(summary).splitlines())]
    final, points = final_results(summary), Points.of(summary)
    for name in LACKING:
        # Not what it was while there was a zone.
        assert rows[0][name] == rows[0][f"{name}_error"] == ""
        assert float(rows[1][name]) > 0.0
        assert list(np.isnan(final[name])) == [True, False]
        assert list(np.isnan(points.results[name])) == [True, False]


def test_an_infinite_error_is_told_in_show_and_tables_and_its_result_is_not_ranked(fading):
    study, folder = fading
    stuck = [*study.cases()][1]
    with (
        open_case(folder / "cases" / f"{stuck}.nc") as case,
        open_history(folder / "cases" / f"{stuck}.nc") as history,
    ):
        assert float(case.peak_pressure_error[-1]) == math.inf
        assert "singular" in case.peak_pressure.comment
        assert "infinite where" in case.peak_pressure_error.comment
        (row,) = (each for each in case_lines(case, history) if "  peak pressure" in each)
    assert "± ∞" in row
    summary = xr.load_dataset(folder / "summary.nc")
    rows = [*csv.DictReader(results_table(summary).splitlines())]
    assert rows[1]["peak_pressure_error"] == "inf"
    assert list(np.isnan(Points.of(summary).results["peak_pressure"])) == [False, True]


def test_an_open_centre_has_no_pressure_and_is_not_ranked(tmp_path):
    """Waves are added to the gap: the origin is a valley, its neighbours half a wave away tips."""
    content = {
        "title": "Waves",
        "base": base(roughness=WAVES, cell=["1 um", "4 um"], cycles=2, load=None),
        "vary": {"load": ["20 N", "30 N"]},
    }
    study = load_study(write_study(tmp_path / "waves.yaml", content))
    run_study(study, tmp_path)
    first = next(iter(study.cases().values()))
    with open_case(tmp_path / "cases" / f"{first.case_id}.nc") as case:
        assert not case.central_pressure.any()
        assert "valley" in case.central_pressure.comment
        half = 0.5 * first.roughness.finest[0]
        at_tip = case.pressure[0].sel(x=half, y=0.0, method="nearest")
        assert float(at_tip) > 0.5 * float(case.peak_pressure[0])
    points = Points.of(xr.load_dataset(tmp_path / "summary.nc"))
    assert np.isnan(points.results["central_pressure"]).all()


@pytest.mark.parametrize(
    "changes",
    [
        {"cell": "6 um", "slip_model": "jaeger"},
        {"plastic_limit": "1.5 GPa", "cell": "5 um"},
        {"roughness": WAVES, "cell": ["1 um", "4 um"]},
        {"roughness": {**SELF_AFFINE, "shortest_wavelength": "50 um", "seed": 3}, "cell": "6 um"},
        CYLINDER,
        {**CYLINDER, "roughness": {**WAVES, "slope_y": "0 deg"}},
        {**GROSS, "cell": "9 um"},
    ],
    ids=["rings", "yielding rings", "waves", "uneven", "strips", "rough strips", "gross slip"],
)
def test_fractions_of_cells_add_up_to_the_stored_areas(changes):
    """Within single precision, at every snapshot."""
    case = steel(**{"cycles": 100, "error_estimate": False, **changes})
    found = run(case).dataset
    whole = mirrored(found)
    dims = [name for name in ("x", "y") if name in whole.sizes]
    cell = math.prod(float(whole[name][1] - whole[name][0]) for name in dims)
    for zone in ("contact", "stick"):
        part = whole[f"{zone}_fraction"].astype(float)
        assert float(part.min()) >= 0.0
        assert float(part.max()) <= 1.0
        area = found[f"{zone}_area"].values
        np.testing.assert_allclose(part.sum(dims).values * cell, area, rtol=1e-6)
    # Where all of a tip sticks, its two edges are known to a part of a cell.
    assert float((whole.stick_fraction - whole.contact_fraction).max()) <= 1e-2
    # Stored areas and mean pressures give each other exactly, sums over states do not.
    share = found.mean_stick_pressure * found.stick_area / found.normal_force
    np.testing.assert_allclose(share, found.stick_load_share, rtol=1e-9)


def test_a_contact_of_pressures_ten_orders_of_magnitude_apart_converges():
    """A step keeps the load to the last digit of the highest pressure, not of the lowest."""
    study = load_study(Path(__file__).parents[2] / "studies" / "paper.yaml")
    case = next(
        case
        for case in study.cases().values()
        if case.slip_model.kind == "jaeger" and case.roughness and np.isinf(case.plastic_limit)
    )
    *_, last = steps(case)
    assert last.state.cycle == case.cycles
    assert last.state.pressure.max() > 1e10 * last.state.pressure[last.state.pressure > 0].min()
