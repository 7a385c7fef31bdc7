"""Cases that ask for an accuracy: which cells they get, what is told, and how they resume."""

import re

import numpy as np
import pytest

import fretwear
from fretwear.mechanics.wear.state import State
from fretwear.run import accuracy
from fretwear.run.accuracy import (
    ASKED,
    GridRun,
    next_width,
    relative_errors,
    unreached,
)
from fretwear.run.checkpoint import Checkpoint
from fretwear.run.simulate import RunRecord, run
from fretwear.study.case import Case
from fretwear.study.case_warnings import CaseWarning
from fretwear.study.discretisation import WIDEST

from ..studies import near
from .conftest import make_case

WAVES = {"kind": "wavy", "amplitude": "0.1 um", "slope_x": "2 deg", "slope_y": "1 deg"}
SNAPSHOTS = [0, 10, 300, 3000]


def make(**changes):
    keys = {"cycles": 3000, "output_cycles": SNAPSHOTS, "accuracy": 0.02, "cell": None}
    return make_case(**keys | changes)


def finished(width, order=1.0, size=1.0, growth=3.0):
    """A run whose errors grow with a power of the width of cells, and work with its inverse."""
    error = size * width**order
    rows = [dict.fromkeys(ASKED, value + 1e-3 * error) for value in (1.0, 3.0)]
    errors = {name: np.array([0.5 * error, error]) for name in ASKED}
    return GridRun(width, rows, errors, width**-growth)


@pytest.fixture(scope="module")
def smooth():
    case, record = make(slip_model="jaeger"), RunRecord()
    return case, record, run(case, record=record).dataset


@pytest.mark.slow
def test_a_smooth_contact_keeps_an_accuracy_on_cells_wider_than_usual(smooth):
    case, record, ds = smooth
    narrow = fretwear.simulate(case.replace(accuracy="none", tolerance=0.0025), quarter=True)
    assert [each.width for each in record.rounds] == []
    assert ds.attrs["warnings"] == ""
    assert float(ds.tolerance) == near(0.04)  # of the run, where the case asked for none
    for name in ASKED:
        apart = np.abs(ds[name] - narrow[name]).values
        assert (apart <= 0.02 * np.abs(narrow[name]).max().item()).all(), name
        counts = (narrow[name] > 0.01 * narrow[name].max()).values
        assert (apart <= ds[f"{name}_error"].values + 1e-3 * narrow[name].values)[counts].all(), (
            name
        )


def test_the_id_says_what_was_asked_for_and_the_dataset_what_came_out(smooth):
    case, _, ds = smooth
    assert ds.attrs["case_id"] == case.case_id == ds.fretwear.case.case_id
    assert ds.fretwear.case.accuracy == case.accuracy
    ids = (case.replace(accuracy=accuracy).case_id for accuracy in (None, 0.02, 0.01))
    assert [each == case.case_id for each in ids] == [True, True, False]
    assert float(ds.accuracy) == 0.02
    assert "cell" not in case.canonical_parameters()
    assert case.accuracy == Case.accuracy
    assert make(accuracy="none").canonical_parameters()["cell"] == [*case.grid_spacing]


def test_a_written_cell_and_a_written_tolerance_stay_whatever_the_accuracy():
    written = make(cell=["2 um", "2 um"], accuracy=0.001)
    runs = [finished(1.0, size=0.002)]
    assert next_width(written, []) == 1.0
    assert next_width(written, runs) is None
    assert unreached(written, runs).remedy == "set a narrower `cell`, or none"
    alone = written.replace(cell="3 um")
    assert unreached(alone, runs) is None
    for case in (written, alone, alone.replace(error_estimate=False)):
        again = Case(**case.canonical_parameters())
        assert (again.case_id, again.accuracy) == (case.case_id, case.accuracy)
    assert make(tolerance=0.003).on_cells(2.0).tolerance == 0.003


@pytest.mark.slow
def test_both_remedies_of_a_written_cell_reach_the_accuracy():
    narrow = make(output_cycles=[0, 100, 300], cycles=300, slip_model="jaeger", accuracy=0.0033)
    wide, told = narrow.replace(cell="8 um", accuracy=0.0033), []
    ds = run(wide, warn=told.append).dataset
    assert told == [ds.attrs["warnings"]]
    assert "less accurately than the 0.33 % asked for" in told[0]
    assert ds.fretwear.case.accuracy == wide.accuracy
    for remedied in (wide.replace(cell="1 um", accuracy=0.0033), narrow):
        assert not run(remedied).dataset.attrs["warnings"]


def test_cells_become_narrower_by_what_errors_that_fall_with_the_width_need():
    case, smooth = make(roughness=WAVES), make(slip_model="jaeger")  # on rings
    assert (next_width(case, []), next_width(smooth, [])) == (1.4, 2.0)
    first = GridRun(1.4, finished(1.4).rows, {}, 0.36)
    assert next_width(case, [first]) == 1.0
    assert next_width(smooth, [finished(2.0, size=0.005)]) is None
    assert next_width(smooth, [finished(2.0, size=0.04)]) == 1.0
    assert next_width(case, [first, finished(1.0, size=0.02)]) is None
    last = finished(1.0, size=0.025)
    assert next_width(case, [first, last]) == near(0.64)
    assert next_width(case, [first, finished(1.0, size=0.021)]) == near(1.0 / 1.4)
    growth = np.log(1 / 0.36) / np.log(1.4) + 0.5
    # A budget that errors exceed is used up, if cells can become enough narrower.
    assert next_width(case, [first, finished(1.0, size=0.2)]) == near(8.64 ** (-1 / growth))
    third = finished(0.5, size=0.05)
    assert next_width(case, [first, last, third]) is None
    assert next_width(case.replace(budget=100), [first, last, third]) == near(0.5 * 0.64)


@pytest.mark.parametrize("growth", [2.0, 3.0, 4.5])
def test_all_runs_of_a_case_together_keep_the_budget_by_the_work_counted_so_far(growth):
    """Even where work grows by a power larger by 0.5 from the second run to the third."""
    needed = 0.5 ** -(growth + 0.5) + 1.0 + 1.4**-growth
    runs = [finished(width, size=0.032, growth=growth) for width in (1.4, 1.0)]
    assert next_width(make(roughness=WAVES, budget=1.001 * needed), runs) == near(0.5)
    width = next_width(make(roughness=WAVES, budget=0.9 * needed), runs)
    assert width ** -(growth + 0.5) + 1.0 + 1.4**-growth == near(0.9 * needed)
    assert next_width(make(roughness=WAVES, budget=1.0), runs) is None


def test_a_missed_accuracy_names_results_and_a_remedy_that_allows_narrower_cells(monkeypatch):
    runs = [finished(width, size=0.025) for width in (1.4, 1.0)]
    for narrowest, remedy in ((0.0, "raise `budget`"), (1.0, "set a narrower `cell`")):
        monkeypatch.setattr(accuracy, "affordable_width", lambda _, width=narrowest: width)
        found = unreached(make(roughness=WAVES, budget=1.0), runs)
        assert found.remedy == remedy
        assert "± 2.5 % at cycle " in found.detail
        assert found.detail.endswith(f"and {len(ASKED) - 3} more")
        assert CaseWarning.read(str(found)) == found
    assert unreached(make(roughness=WAVES, accuracy=0.03), runs) is None


def test_an_accuracy_of_the_energy_is_relative_to_its_largest_value_all_others_to_the_value():
    values, error = np.array([4.0, 1.0, 1e-3]), np.array([0.1, 0.1, 0.1])
    names = ("wear_volume", "dissipated_energy")
    found = relative_errors(dict.fromkeys(names, values), dict.fromkeys(names, error))
    np.testing.assert_allclose(found["wear_volume"], [0.025, 0.1, 0.0])
    np.testing.assert_allclose(found["dissipated_energy"], [0.025, 0.025, 0.0])


@pytest.mark.slow
def test_a_rough_contact_that_cannot_reach_its_accuracy_says_what_it_has_reached():
    case = make(roughness=WAVES, accuracy=0.001, budget=1.0, cycles=100, output_cycles=[])
    told, record = [], RunRecord()
    ds = run(case, record=record, warn=told.append).dataset
    assert [each.width for each in record.rounds] == [1.4]
    assert float(ds.cell_x) == near(case.grid_spacing[0])
    (doubt,) = told
    assert doubt in ds.attrs["warnings"]
    assert "less accurately than the 0.1 % asked for" in doubt
    assert doubt.endswith(": raise `budget`")
    reached = float(re.search(r"± (\S+) %", doubt)[1])
    errors = [float((ds[f"{n}_error"] / ds[n].max()).max()) for n in ASKED if float(ds[n].max())]
    assert reached >= 99.0 * max(errors)


@pytest.mark.slow
@pytest.mark.parametrize("rounds", [(0, 2), (1, 2)])
def test_a_run_killed_in_any_round_resumes_to_the_same_bits(tmp_path, rounds):
    case = make(roughness=WAVES, accuracy=0.05, budget=1.0, cycles=10, output_cycles=[3])
    whole = run(case).dataset
    path, told = tmp_path / "case.checkpoint", []

    def kill(_):
        record = checkpoint.record
        if (len(record.rounds), len(record.history)) == rounds:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), Checkpoint(path, case, told.append) as checkpoint:
        run(case, [checkpoint, kill], record=checkpoint.record)
    kept = Checkpoint(path, case, told.append).record
    assert (len(kept.rounds), len(kept.history)) == rounds
    assert isinstance(kept.last, State)
    resumed = run(case, record=kept).dataset
    for name in ("wear_depth", "wear_volume", "wear_volume_error", "stick_area_error"):
        np.testing.assert_array_equal(resumed[name], whole[name])


def test_fields_of_rings_are_written_on_default_cells_however_wide_the_rings(smooth):
    case, record, dataset = smooth
    assert record.width == WIDEST
    assert float(dataset["cell_x"]) == near(float(dataset.x.diff("x")[0])) == case.grid_spacing[0]
    wide = case.on_cells(WIDEST)
    assert (wide.cell, wide.tolerance) == (case.grid_spacing, near(WIDEST**2 * case.tolerance))
    written = case.replace(accuracy="none")
    for apart, times in ((case, 0.5), (make(roughness=WAVES), 2.0), (written, 2.0)):
        assert apart.on_cells(times).cell == tuple(times * width for width in apart.grid_spacing)
