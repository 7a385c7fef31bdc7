"""Lives by constants of the material, and Miner's sum of points that wear brings to the surface."""

import numpy as np
import pytest

from fretwear_cracks import StressError
from fretwear_cracks.fatigue import _life, _outcomes
from fretwear_cracks.life import Damage, StrainLife, summed_damage
from fretwear_cracks.variables import FATIGUE_OUTCOMES

from ..studies import near

E = 200e9
STEEL = StrainLife(1000e6, -0.1, 0.5, -0.6)
ELASTIC = StrainLife(1000e6, -0.1)


def test_a_life_solves_the_equation_of_strain_and_life():
    lives = np.geomspace(1.0, 1e12, 25)
    reversals = 2 * lives
    elastic = (1000e6) ** 2 / E * reversals**-0.2
    parameter = elastic + 1000e6 * 0.5 * reversals**-0.7
    np.testing.assert_allclose(STEEL.cycles(parameter, E), lives, rtol=1e-9)
    np.testing.assert_allclose(ELASTIC.cycles(elastic, E), lives, rtol=1e-9)
    assert np.isinf(STEEL.cycles(np.array([0.0, -1.0]), E)).all()


@pytest.mark.parametrize(
    ("pair", "reason"),
    [("-1 MPa, -0.1", "larger than 0"), ((1e9, 0.1), "less than 0"), ("1 K, -1", "a temperature")],
)
def test_constants_have_the_ranges_and_units_of_a_study_file(pair, reason):
    assert _life("1000 MPa, -0.1", (0.5, -0.6)) == STEEL
    with pytest.raises(StressError, match=f"basquin = .*{reason}"):
        _life(pair, None)


DEPTHS = np.linspace(1e-6, 60e-6, 60)


def damage(worn, parameters, cycles=(0.0, 1e5, 2e5), life=STEEL):
    return summed_damage(np.array(cycles), parameters, DEPTHS, worn, DEPTHS, life, E)


def test_without_wear_damage_is_the_part_of_life_spent():
    parameters = np.full((3, 2, DEPTHS.size), 3e6)
    parameters[:, 1] = 0.0
    life = float(STEEL.cycles(np.array(3e6), E))
    found = damage(np.zeros((3, 2)), parameters, life * np.array([0.0, 0.5, 1.5]))
    np.testing.assert_allclose(found.sums[:, 0, 0], [0.0, 0.5, 1.5])
    np.testing.assert_allclose(found.first_crack[0], life, rtol=1e-9)
    assert not found.sums[:, 1].any()
    assert np.isinf(found.first_crack[1]).all()
    assert not found.removed.any()


def test_a_point_lives_through_the_layers_that_wear_brings_to_it():
    """Stresses that fall with depth, and a surface that sinks evenly: an integral in closed form.

    With P ~ exp(−z/L) and 2b the only exponent, the rate is exp(−z/(L·2·0.1)) of that of z = 0.
    """
    decay = 30e-6
    parameters = np.tile(3e6 * np.exp(-DEPTHS / decay), (3, 1, 1))
    total, worn = 2e5, 20.4e-6
    surface = worn * np.array([[0.0], [0.5], [1.0]])
    found = damage(surface, parameters, life=ELASTIC)
    scale = decay * 0.2
    first = float(ELASTIC.cycles(np.array(3e6), E))
    for place in (25, 30):
        z = DEPTHS[place]
        expected = total / worn / first * scale * (np.exp(-(z - worn) / scale) - np.exp(-z / scale))
        assert found.sums[-1, 0, place] == near(expected, rel=0.02)
    assert found.removed[-1, 0].sum() == 20
    # What is removed has the damage of its time.
    gone = found.sums[:, 0, 4]
    assert gone[1] == near(gone[2])
    assert gone[1] > 0


def test_wear_removes_material_before_it_cracks():
    """Only the depth at which a crack is faster than wear cracks."""
    parameters = np.full((3, 2, DEPTHS.size), 3e6)
    life = float(STEEL.cycles(np.array(3e6), E))
    cycles = life * np.array([0.0, 0.8, 1.6])
    worn = np.array([[0.0, 0.0], [5e-6, 40e-6], [10e-6, 80e-6]])
    found = damage(worn, parameters, cycles)
    assert np.isfinite(found.first_crack[0, 20:]).all()
    assert found.first_crack[0, 20] == near(life, rel=1e-6)
    # At 80 µm in 1.6 lives all above 50 µm is removed before its life ends.
    assert np.isinf(found.first_crack[1, DEPTHS < 48e-6]).all()
    assert np.isfinite(found.first_crack[1, DEPTHS > 52e-6]).all()
    assert found.removed[-1, 1].all()
    # A crack that wear has removed is none.
    removed = Damage(found.sums[:, 1:], found.removed[:, 1:], found.first_crack[1:])
    both = (_outcomes(cycles, each, np.full(1, 1.0 / life)) for each in (found, removed))
    last = [FATIGUE_OUTCOMES[outcomes["fatigue_outcome"][-1]] for outcomes in both]
    assert last == ["crack wins", "wear wins"]
