"""Where a case is expected to crack, and whether wear removes the crack first."""

import json

import numpy as np
import pytest

import fretwear
from fretwear_cracks import StressError
from fretwear_cracks.fatigue import fatigue_table
from fretwear_cracks.variables import FATIGUE_OUTCOMES

from ..studies import line_contact, near, steel

pytestmark = pytest.mark.slow

CONSTANTS = {"basquin": ("1000 MPa", -0.1), "manson_coffin": (0.5, -0.6)}
CELL = "12 um"


def simulated(**changes):
    return fretwear.simulate(steel(cell=CELL, error_estimate=False, **changes), quarter=True)


@pytest.fixture(scope="module")
def partial():
    return simulated(cycles=10_000, output_cycles=(300, 3000))


@pytest.fixture(scope="module")
def gross():
    sliding = {"tangential_ratio": None, "displacement_amplitude": "3 um"}
    return simulated(cycles=10_000, output_cycles=(300,), **sliding)


def outcome(found):
    return FATIGUE_OUTCOMES[int(found.fatigue_outcome[-1])]


def test_partial_slip_cracks_at_the_new_edge_of_stick_and_gross_slip_wears_cracks_away(
    partial, gross
):
    """Wear brings the worst place inwards in partial slip, and outwards in gross slip."""
    found, slid = (fretwear.fatigue(ds, phases=8, **CONSTANTS) for ds in (partial, gross))
    assert (outcome(found), outcome(slid)) == ("crack wins", "wear wins")
    swt, slid_swt = found.largest_smith_watson_topper, slid.largest_smith_watson_topper
    assert float(swt[-1]) > 1.5 * float(swt[0])
    assert float(slid_swt[-1]) < 0.1 * float(slid_swt[0])
    stuck = float(partial.stick_half_width_x[0])
    assert abs(float(found.crack_x[0])) == near(float(partial.hertz_radius), rel=0.05)
    assert abs(float(found.crack_x[-1])) < 1.25 * stuck
    assert abs(float(slid.crack_x[-1])) > 1.5 * float(gross.hertz_radius)
    crack = float(found.crack_cycle[-1])
    assert 300 < crack < 10_000
    assert np.isnan(found.crack_cycle[:2]).all()
    assert found.largest_damage.values.tolist() == sorted(found.largest_damage.values)
    rows = fatigue_table(found)
    assert rows[0][:3] == ("cycle", "tension (MPa)", "SWT (MPa)")
    assert rows[-1][-1] == "crack wins"


def test_values_are_those_of_the_stresses_of_each_snapshot(partial):
    found = fretwear.fatigue(partial, [0], phases=8, depth="0.2 mm")
    assert found.sizes["cycle"] == 1
    assert float(found.z[-1]) == near(0.2e-3)
    alone = fretwear.stress(partial, 0, phases=8, depths=found.z.values)
    np.testing.assert_array_equal(found.smith_watson_topper[0], alone.smith_watson_topper.isel(y=0))
    assert float(found.largest_tension[0]) == float(alone.edge_stress_xx.max())
    assert "life" not in found


def test_the_bulk_stress_of_a_case_is_that_of_its_stresses():
    plain, pulled = (simulated(cycles=1, bulk_stress=stress) for stress in (0.0, "80 MPa"))
    assert float(pulled.bulk_stress) == 80e6
    assert pulled.case_id != plain.case_id
    point = {"points": [(0, 0, 5e-5)], "phases": 2}
    own = fretwear.stress(pulled, **point)
    keys = json.loads(pulled.parameters) | {"bulk_stress": 0.0}
    without = fretwear.stress(pulled.assign_attrs(parameters=json.dumps(keys)), **point)
    added = (own - without).stress_xx.values.ravel()
    assert added == near([80e6, -80e6], rel=1e-5)


def test_wear_of_the_flat_alone_counts(gross):
    """Half of the wear of both bodies, unless the file says what the flat lost."""
    half = gross.assign(wear_depth_flat=0.5 * gross.wear_depth)
    told, own = (fretwear.fatigue(ds, phases=4, **CONSTANTS) for ds in (gross, half))
    assert "half of it is taken" in told.warnings
    assert "half of it is taken" not in own.warnings
    np.testing.assert_allclose(told.damage, own.damage)
    gone = np.isnan(told.damage[-1]).any("material_z")
    worn = 0.5 * gross.wear_depth[-1].isel(y=0)
    reached = worn.values > float(told.material_z[0])
    np.testing.assert_array_equal(gone[gone.size // 2 :], reached)
    assert reached.any()


def test_a_mean_stress_shifts_the_loop_and_shortens_lives(partial):
    """Along x by σ_m, at R by σ_a (1 + R)/(1 − R); P_H,max grows by a third of it."""
    keys = json.loads(partial.parameters) | {"bulk_stress": 90e6}
    pulled = partial.assign_attrs(parameters=json.dumps(keys))
    asked = {"points": [(-1.4e-4, 0, 2e-5)], "phases": 8, "crossland": 0.3}
    found = {ratio: fretwear.stress(pulled, **asked, stress_ratio=ratio) for ratio in (-1.0, 0.1)}
    mean = 90e6 * 1.1 / 0.9
    shift = found[0.1] - found[-1.0]
    np.testing.assert_allclose(shift.stress_xx, mean, rtol=1e-5)
    np.testing.assert_allclose(shift.stress_zz, 0.0, atol=1.0)
    assert shift.crossland.values == near(0.3 * mean / 3)
    assert (shift.smith_watson_topper > 0.0).all()
    same = fretwear.stress(pulled, **asked, mean_stress="110 MPa")
    np.testing.assert_array_equal(same.stress_xx, found[0.1].stress_xx)
    lives = [
        float(fretwear.fatigue(pulled, [0], phases=8, stress_ratio=ratio, **CONSTANTS).life[0])
        for ratio in (-1.0, 0.1)
    ]
    assert lives[1] < 0.9 * lives[0]
    with pytest.raises(StressError, match="not both"):
        fretwear.stress(pulled, **asked, stress_ratio=0.1, mean_stress="1 MPa")
    with pytest.raises(StressError, match="less than 1"):
        fretwear.stress(pulled, **asked, stress_ratio=1.0)


def test_a_parameter_that_is_largest_at_the_shallowest_depth_is_said_to_depend_on_it(partial):
    """The values of the warning are those at the two depths; at a chosen depth it is silent."""
    found = fretwear.fatigue(partial, [0], phases=8)
    (told,) = (line for line in found.warnings.splitlines() if "shallowest" in line)
    first, second = (1e-6 * float(found.smith_watson_topper[0, :, n].max()) for n in (0, 1))
    assert f"{first:.3g} MPa at" in told
    assert f"{second:.3g} MPa at" in told
    chosen = fretwear.stress(partial, 0, phases=8, depths=["20 um"])
    assert "shallowest" not in chosen.warnings


def test_without_wear_a_case_keeps_its_stresses_and_sums_damage_evenly():
    """Damage is cycles over life, on the fields that a wearing case has at cycle 0."""
    changes = {"cycles": 2000, "output_cycles": (1000,)}
    kept, worn = simulated(wear_coefficient=0, **changes), simulated(**changes)
    assert kept.wear_volume.values.tolist() == [0.0] * 3
    assert not kept.wear_depth.any()
    for cycle in range(3):
        for name in ("pressure", "shear_traction", "slip"):
            of_kept, unworn = kept[name][cycle].values, worn[name][0].values
            np.testing.assert_allclose(of_kept, unworn, rtol=1e-5, atol=1e-5 * unworn.max())
    found = fretwear.fatigue(kept, phases=8, **CONSTANTS)
    assert found.largest_damage.values == near(found.cycle / found.life.values[0], rel=1e-4)


@pytest.mark.parametrize(
    "changes",
    [
        line_contact("10 mm", "100 N/mm")
        | {"tangential_ratio": None, "sliding_amplitude": "30 um", "wear_coefficient": [0, 0]},
        {"pulsating_load": 0.9, "slip_model": "jaeger"},
        {"wear_coefficient": None, "energy_wear_coefficient": 0},
    ],
    ids=["stroke", "pulsating", "energy"],
)
def test_contacts_that_do_not_wear_have_no_volume_and_a_loop(changes):
    ds = fretwear.simulate(steel(**{"cycles": 100, "cell": CELL, "wear_coefficient": 0} | changes))
    assert ds.wear_volume.values.tolist() == [0.0] * ds.sizes["cycle"]
    assert ds.wear_volume_error.values.tolist() == [0.0] * ds.sizes["cycle"]
    energy = ds.dissipated_energy.values
    assert energy[0] > 0.0
    # Contacts are solved to 1e-5.
    assert energy == near(energy[0], rel=1e-5)
