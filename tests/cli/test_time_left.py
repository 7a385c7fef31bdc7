import pytest

from fretwear.cli.progress import TimeLeft


def growing_steps(factor, largest, last):
    """Cycles of a run whose steps grow by a factor until they are as large as they may be."""
    cycle, size, cycles = 0.0, 1.0, []
    while cycle < last:
        cycle = min(cycle + size, last)
        size = min(factor * size, largest)
        cycles.append(cycle)
    return cycles


def begun(clock, planned, cycles):
    """The time left of a single case, which has just begun."""
    left = TimeLeft({"one": planned}, clock)
    left.begin("one", cycles)
    return left


@pytest.mark.parametrize(("factor", "largest"), [(1.5, 100.0), (1.3, 1e9), (2.0, 50.0), (1.0, 1.0)])
@pytest.mark.parametrize("misjudged", [0.5, 1.0, 2.0])
def test_time_left_is_right_within_a_factor_of_four_all_along(clock, factor, largest, misjudged):
    # Every step takes 1 s, as real ones nearly do. The speed in cycles alone is a hundredfold off.
    cycles = growing_steps(factor, largest, 7000.0)
    left = begun(clock, misjudged * len(cycles), 7000)
    for number, cycle in enumerate(cycles[:-1], start=1):
        clock.now += 1.0
        left.note(cycle)
        expected = len(cycles) - number
        assert expected / 4.0 - 1.0 <= left.seconds_left <= 4.0 * expected + 1.0


def test_time_left_runs_down_between_steps_and_never_below_zero(clock):
    left = begun(clock, 10.0, 100)
    left.note(0.0)
    clock.now = 4.0
    assert left.seconds_left == pytest.approx(6.0)
    clock.now = 40.0
    assert left.seconds_left == 0.0


def test_the_share_of_time_that_is_over_never_falls_and_ends_at_one(clock):
    left = begun(clock, 1.0, 1000)
    shares = []
    for cycle in (0.0, 1.0, 2.0, 500.0, 501.0, 502.0, 1000.0):
        clock.now += 1.0
        left.note(cycle)
        shares.append(left.share)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_a_run_that_resumes_from_a_checkpoint_has_less_to_do(clock):
    whole, rest = begun(clock, 60.0, 1000), begun(clock, 60.0, 1000)
    whole.note(0.0)
    rest.note(900.0)
    assert rest.seconds_left == pytest.approx(0.1 * whole.seconds_left)


def test_a_batch_learns_from_its_first_cases_how_fast_the_machine_is(clock):
    left = TimeLeft({"first": 2.0, "second": 5.0}, clock)
    left.begin("first", 200)
    assert (left.number, left.batch_seconds_left) == (1, pytest.approx(2.0 + 5.0))
    clock.now = 3.0 * 2.0
    left.note(200)
    left.end()
    assert left.batch_seconds_left == pytest.approx(3.0 * 5.0)
    left.begin("second", 200)
    assert (left.number, left.count) == (2, 2)
    assert left.seconds_left == left.batch_seconds_left == pytest.approx(3.0 * 5.0)
