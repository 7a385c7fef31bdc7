from fretwear.running.resources import machine_speed, transform_seconds
from fretwear.study.case import Case
from fretwear.study.cost import estimate

CASE = {
    "radius": 0.01,
    "youngs_modulus": 208e9,
    "poisson_ratio": 0.3,
    "load": 50.0,
    "tangential_ratio": 0.8,
    "friction": 0.5,
    "wear_coefficient": 7e-13,
    "cycles": 1000,
}


def test_a_larger_window_takes_longer_to_transform():
    assert 0.0 < transform_seconds(32, 32) < transform_seconds(512, 512)


def test_a_speed_is_measured_for_small_and_for_huge_windows():
    # What no machine can compute is timed at a size that it can.
    for cell in (10e-6, 1e-8):
        assert 1e-3 < machine_speed([estimate(Case(**CASE, cell=cell))]) < 1e3


def test_nothing_to_run_takes_no_measurement():
    assert machine_speed([]) == 1.0
