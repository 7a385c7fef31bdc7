"""Sentences and effects say what the numbers are."""

import math

import pytest

from fretwear.report.findings import effects, key_numbers, summary_sentences
from fretwear.report.results import FIRST, LAST, Level, PointResult, point_results
from fretwear.vocabulary import PointStatus


@pytest.fixture(scope="module")
def results(finished) -> list[PointResult]:
    return point_results(finished.plan, finished.summary, {})


def _point(number: int, **last: float) -> PointResult:
    first = {
        "contact_half_width_x": 100e-6,
        "stick_half_width_x": 50e-6,
        "central_pressure": 1e9,
        "dissipated_energy": 4e-6,
    }
    given = {
        "contact_half_width_x": 120e-6,
        "stick_half_width_x": 50e-6,
        "central_pressure": 1.5e9,
        "peak_pressure": 3e9,
        "maximum_wear_depth": 1e-6,
        "wear_volume": 2e-15,
        "dissipated_energy": 1e-6,
    } | last
    return PointResult(
        number,
        f"case-{number}",
        PointStatus.DONE,
        "",
        {"load": Level(f"{number} N", f"load {number} N", number)},
        {(name, FIRST): value for name, value in first.items()}
        | {(name, LAST): value for name, value in given.items()},
        smooth=True,
    )


def _told(*points: PointResult) -> str:
    return " ".join(summary_sentences(points)).replace("\u00a0", " ")


def test_extremes_are_named_with_their_points() -> None:
    deeper = _point(2, wear_volume=8e-15, maximum_wear_depth=3e-6)
    text = _told(_point(1), deeper, _point(3, wear_volume=4e-15))
    assert "between 2 × 10³ µm³ (load 1 N) and 8 × 10³ µm³ (load 2 N)" in text
    assert "the maximum wear depth reaches 3 µm (load 2 N)" in text


def test_growth_and_shrinking_are_told_apart() -> None:
    text = _told(_point(1), _point(2, contact_half_width_x=150e-6, stick_half_width_x=40e-6))
    assert "grows by 20.0 to 50.0 %, to 120 to 150 µm" in text
    assert "without a plastic limit the stick half-width along x shrinks by 0.0 to 20.0 %" in text
    assert "changes by −10.0 to +20.0 %" in _told(_point(1), _point(2, contact_half_width_x=90e-6))


def test_a_constant_stick_zone_is_called_so() -> None:
    told = "the stick half-width along x does not change"
    assert f"In the 2 cases without a plastic limit {told}." in _told(_point(1), _point(2))
    assert f"{told}, within 0.2 %" in _told(_point(1, stick_half_width_x=50.1e-6))


def test_energy_that_has_vanished_is_said_to_and_makes_no_factors() -> None:
    text = _told(_point(1), _point(2, dissipated_energy=4e-20))
    assert "finally 0.250 times that; in 1 case it vanishes, as wear has ceased." in text
    assert "finally vanishes: wear has ceased." in _told(_point(1, dissipated_energy=0.0))


def test_without_results_that_is_said() -> None:
    nothing = [PointResult(1, "", PointStatus.INVALID, "Q is too large", {})]
    assert list(summary_sentences(nothing)) == ["No point of this study has results."]
    assert key_numbers(nothing, "1000") == {}


def test_key_numbers_span_all_cases() -> None:
    numbers = key_numbers([_point(1), _point(2, wear_volume=8e-15)], "30 000")
    expected = ["2", "30 000", "(2 to 8) × 10³ µm³", "+20.0\u00a0%"]
    assert list(numbers.values()) == expected


def test_an_effect_is_the_geometric_mean_over_pairs_that_differ_in_one_name(
    finished, results: list[PointResult]
) -> None:
    found = {effect.name: effect for effect in effects(finished.plan, results)}
    assert set(found) == {"load", "friction", "roughness_amplitude", "plastic_limit"}
    by_index = {
        planned.index: result for planned, result in zip(finished.plan.points, results, strict=True)
    }
    pairs = [
        (by_index[index], by_index[(*index[:3], 1)])
        for index in by_index
        if index[3] == 0 and by_index[index].done and by_index[(*index[:3], 1)].done
    ]
    logs = [math.log(b.last("wear_volume") / a.last("wear_volume")) for a, b in pairs]
    effect = found["plastic_limit"]
    assert effect.change == "elastic → 3000 MPa"
    assert effect.pairs == len(pairs) == 5
    factor = float(effect.factors[0].removeprefix("× "))
    assert factor == pytest.approx(math.exp(sum(logs) / len(logs)), rel=6e-3)


def test_results_follow_the_order_of_the_study(finished, results: list[PointResult]) -> None:
    assert [result.number for result in results] == list(range(1, 17))
    assert [result.id for result in results] == [point.id for point in finished.plan.points]
    assert results[0].title.startswith(
        "normal load 20 N, coefficient of friction 0.2, smooth, elastic"
    )
    assert results[0].status == PointStatus.INVALID
    assert "less than" in results[0].reason
    failed = next(result for result in results if result.id == finished.failed)
    assert not failed.done
    assert "log" in failed.reason
