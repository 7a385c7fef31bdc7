import numpy as np
import pytest

from fretwear.data.merge import Resampling

NODES = (np.arange(6) + 0.5) * 3.0


@pytest.fixture
def values():
    return np.random.default_rng(1).random((6, 4)).astype(np.float32)


def test_at_cell_centres_values_are_kept_to_the_last_bit(values):
    assert (Resampling(NODES, NODES).linear(values, 0) == values).all()
    assert (Resampling(NODES, NODES).nearest(values, 0) == values).all()


def test_between_cells_a_straight_line_stays_straight():
    positions = np.linspace(1.5, 16.5, 31)
    straight = np.stack([2.0 * NODES - 1.0] * 2)
    resampled = Resampling(NODES, positions).linear(straight, 1)
    np.testing.assert_allclose(resampled, [2.0 * positions - 1.0] * 2, rtol=1e-14)


def test_it_agrees_with_numpy_on_both_sides_of_the_middle(values):
    positions = np.linspace(-20.0, 20.0, 101)
    resampled = Resampling(NODES, positions).linear(values, 0)
    for column in range(4):
        expected = np.interp(np.abs(positions), NODES, values[:, column])
        np.testing.assert_allclose(resampled[:, column], expected, rtol=1e-6)


def test_a_whole_contact_is_not_taken_for_a_quarter():
    nodes = np.r_[-NODES[::-1], NODES]
    resampled = Resampling(nodes, np.array([-6.0, 6.0])).linear(nodes, 0)
    np.testing.assert_allclose(resampled, [-6.0, 6.0], rtol=1e-14)


def test_states_are_those_of_the_nearest_cell():
    states = np.array([2, 2, 1, 1, 0, 0], dtype=np.int8)
    resampled = Resampling(NODES, np.array([0.1, 5.9, 6.1, 11.9, 12.1, 30.0])).nearest(states, 0)
    assert resampled.tolist() == [2, 2, 1, 1, 0, 0]
    assert resampled.dtype == np.int8


def test_outside_begins_after_the_last_cell_centre():
    outside = Resampling(NODES, np.array([0.0, 16.5, 16.6, -16.6])).is_outside
    assert outside.tolist() == [False, False, True, True]
