import pytest

from fretwear.cli.progress import BatchTime, CaseTime, clock_text, planned_seconds
from fretwear.study.study import load_study


def growing_steps(factor, largest, last):
    """Cycles of a run whose steps grow by a factor until they are as large as they may be."""
    cycle, size, cycles = 0.0, 1.0, []
    while cycle < last:
        cycle = min(cycle + size, last)
        size = min(factor * size, largest)
        cycles.append(cycle)
    return cycles


@pytest.mark.parametrize(("factor", "largest"), [(1.5, 100.0), (1.3, 1e9), (2.0, 50.0), (1.0, 1.0)])
@pytest.mark.parametrize("misjudged", [0.5, 1.0, 2.0])
def test_time_left_is_right_within_a_factor_of_four_all_along(clock, factor, largest, misjudged):
    # Every step takes 1 s, as real ones nearly do. The pace in cycles alone is a hundredfold off.
    cycles = growing_steps(factor, largest, 7000.0)
    pace = CaseTime(7000, misjudged * len(cycles), clock)
    for number, cycle in enumerate(cycles[:-1], start=1):
        clock.now += 1.0
        pace.note(cycle)
        left = len(cycles) - number
        assert left / 4.0 - 1.0 <= pace.seconds_left <= 4.0 * left + 1.0


def test_time_left_runs_down_between_steps_and_never_below_zero(clock):
    pace = CaseTime(100, 10.0, clock)
    pace.note(0.0)
    clock.now = 4.0
    assert pace.seconds_left == pytest.approx(6.0)
    clock.now = 40.0
    assert pace.seconds_left == 0.0


def test_the_share_of_time_that_is_over_never_falls_and_ends_at_one(clock):
    pace = CaseTime(1000, 1.0, clock)
    shares = []
    for cycle in (0.0, 1.0, 2.0, 500.0, 501.0, 502.0, 1000.0):
        clock.now += 1.0
        pace.note(cycle)
        shares.append(pace.share)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_a_run_that_goes_on_from_a_checkpoint_has_less_to_do(clock):
    whole, rest = CaseTime(1000, 60.0, clock), CaseTime(1000, 60.0, clock)
    whole.note(0.0)
    rest.note(900.0)
    assert rest.seconds_left == pytest.approx(0.1 * whole.seconds_left)


def test_a_batch_learns_from_its_first_cases_how_fast_the_machine_is(desk, clock):
    del desk
    cases = load_study("tiny.yaml").cases()
    first, second = cases.values()
    batch = BatchTime(cases, clock)
    pace = batch.begin(first)
    assert batch.number == 1
    assert batch.seconds_left == pytest.approx(planned_seconds(first) + planned_seconds(second))
    clock.now = 3.0 * planned_seconds(first)
    pace.note(first.cycles)
    batch.end(first, pace)
    assert batch.seconds_left == pytest.approx(3.0 * planned_seconds(second))
    pace = batch.begin(second)
    assert (batch.number, batch.count) == (2, 2)
    assert batch.seconds_left == pytest.approx(3.0 * planned_seconds(second))


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.4, "0:00"), (59.6, "1:00"), (125.4, "2:05"), (7325, "2:02:05"), (90000, "1 d 1:00:00")],
)
def test_times_are_written_as_on_a_clock(seconds, text):
    assert clock_text(seconds) == text
