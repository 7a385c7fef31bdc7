"""Estimated errors of results: that they hold, and are no larger than they must be."""

import numpy as np
import pytest

from fretwear import Case
from fretwear.running.simulate import estimated_errors, run

DEMO = {
    "radius": "10 mm", "youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "load": "40 N",
    "friction": 0.6, "tangential_ratio": 0.8, "wear_coefficient": "7e-13 / Pa", "cycles": 7000,
    "output_cycles": (10, 100, 1000, 3000),
}  # fmt: skip


def estimates(deviations, times=2.0, values=None):
    """Estimates of a scalar, 1 by default, whose twin deviates at the snapshots as given."""
    values = np.array(values or [1.0] * len(deviations))
    twin = values - deviations
    return estimated_errors({"approach": values}, {"approach": twin}, times)["approach"]


def test_an_estimate_takes_what_two_runs_usually_differ_by_and_nothing_of_a_hard_snapshot():
    (usual,) = estimates([1e-3])
    easy, hard = estimates([1e-4] * 5), estimates([1e-4] * 4 + [0.1])
    np.testing.assert_allclose(hard[:4], easy[:4])
    assert hard[4] > 0.1
    assert estimates([1e-5, 0.1])[0] < 0.02, "even where there is only one other"
    # Runs that agree by chance are no more accurate than usual.
    assert estimates([1e-3, 0.0, 1e-3, 2e-3])[1] == pytest.approx(usual)
    # What has just begun says nothing of the errors of the end.
    begun = estimates([2e-3, 1e-3], values=[4e-3, 1.0])
    assert begun[1] == pytest.approx(usual)
    assert begun[0] > 2e-3
    # The wider the cells of the twin, the less of the difference counts.
    assert 0.5 * usual < estimates([1e-3], 3.0)[0] < usual / np.sqrt(2.0)


def test_smooth_results_are_within_errors_that_are_small_at_first_loading():
    case = Case(**DEMO)
    dataset = run(case).dataset
    finer = run(case.replace(tolerance=0.1 * case.tolerance, error_estimate=False)).dataset
    for name in ("approach", "wear_volume", "dissipated_energy", "stick_area"):
        found, error = (np.asarray(dataset[each]) for each in (name, f"{name}_error"))
        assert (np.abs(found - finer[name]) <= error + 1e-4 * np.abs(found)).all()
        assert error[0] <= 1e-3 * np.abs(found[0])
    # The energy falls to a tenth of a percent, and its error grows from snapshot to snapshot.
    energy = dataset.dissipated_energy_error / dataset.dissipated_energy
    assert float(energy[-1]) < 0.05
    assert dataset.attrs["warnings"] == ""
