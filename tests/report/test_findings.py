"""Sentences and effects say what the numbers are."""

import math

import pytest

from fretwear.report.findings import effects, key_numbers, summary_sentences
from fretwear.report.results import INVALID, PointResult, point_results


@pytest.fixture(scope="module")
def results(finished) -> list[PointResult]:
    return point_results(finished.plan, finished.summary, {})


def _point(number: int, **values: float) -> PointResult:
    given = {
        "half_width_first": 100e-6,
        "half_width": 120e-6,
        "stick_first": 50e-6,
        "stick": 50e-6,
        "central_first": 1e9,
        "central": 1.5e9,
        "peak": 3e9,
        "depth": 1e-6,
        "volume": 2e-15,
        "energy_first": 4e-6,
        "energy": 1e-6,
    }
    title = f"load {number} N"
    return PointResult(
        number, f"case-{number}", "done", "", {"load": f"{number} N"}, title, given | values,
        smooth=True,
    )  # fmt: skip


def test_extremes_are_named_with_their_points() -> None:
    points = [_point(1), _point(2, volume=8e-15, depth=3e-6), _point(3, volume=4e-15)]
    wear = next(summary_sentences(points))
    assert "between 2 × 10³ µm³ (load 1 N) and 8 × 10³ µm³ (load 2 N)" in wear
    assert "3 µm, is that of load 2 N" in wear


def test_growth_and_shrinking_are_told_apart() -> None:
    text = " ".join(summary_sentences([_point(1), _point(2, half_width=150e-6, stick=40e-6)]))
    assert "grows by 20.0 to 50.0 %, to 120 to 150 µm" in text
    assert "without a plastic limit the stick half-width shrinks by 0.0 to 20.0 %" in text
    mixed = " ".join(summary_sentences([_point(1), _point(2, half_width=90e-6)]))
    assert "changes by −10.0 to +20.0 %" in mixed


def test_a_constant_stick_zone_is_called_so() -> None:
    text = " ".join(summary_sentences([_point(1), _point(2)]))
    assert "In the 2 cases without a plastic limit the stick zone keeps its half-width." in text
    nearly = " ".join(summary_sentences([_point(1, stick=50.1e-6)]))
    assert "keeps its half-width within 0.2 %" in nearly


def test_energy_that_has_vanished_is_said_to_and_makes_no_factors() -> None:
    text = " ".join(summary_sentences([_point(1), _point(2, energy=4e-20)]))
    assert "becomes 0.250 times that; in 1 case it vanishes, wear has come to its end." in text
    gone = " ".join(summary_sentences([_point(1, energy=0.0)]))
    assert "vanishes: wear has come to its end." in gone


def test_without_results_that_is_said() -> None:
    nothing = [PointResult(1, "", INVALID, "Q is too large", {}, "the case")]
    assert list(summary_sentences(nothing)) == ["No point of this study has results."]
    assert key_numbers(nothing, "1000") == []


def test_key_numbers_span_all_cases() -> None:
    numbers = key_numbers([_point(1), _point(2, volume=8e-15)], "30 000")
    assert [item.value for item in numbers] == ["2", "30 000", "(2 to 8) × 10³ µm³", "+20.0 %"]


def test_an_effect_is_the_geometric_mean_over_pairs_that_differ_in_one_name(
    finished, results: list[PointResult]
) -> None:
    found = {effect.name: effect for effect in effects(finished.plan, results)}
    assert set(found) == {"load", "friction", "roughness_amplitude", "plastic_limit"}
    by_index = {
        planned.point.index: result
        for planned, result in zip(finished.plan.points, results, strict=True)
    }
    pairs = [
        (by_index[index], by_index[(*index[:3], 1)])
        for index in by_index
        if index[3] == 0 and by_index[index].done and by_index[(*index[:3], 1)].done
    ]
    logs = [math.log(b.values["volume"] / a.values["volume"]) for a, b in pairs]
    effect = found["plastic_limit"]
    assert effect.change == "elastic → 3000 MPa"
    assert effect.pairs == len(pairs) == 5
    factor = float(effect.factors[0].removeprefix("× "))
    assert factor == pytest.approx(math.exp(sum(logs) / len(logs)), rel=6e-3)


def test_results_follow_the_order_of_the_study(finished, results: list[PointResult]) -> None:
    assert [result.number for result in results] == list(range(1, 17))
    assert [result.id for result in results] == [point.id for point in finished.plan.points]
    assert results[0].title.startswith("load 20 N, friction 0.2, smooth, elastic")
    assert results[0].status == INVALID
    assert "less than" in results[0].reason
    failed = next(result for result in results if result.id == finished.failed)
    assert not failed.done
    assert "log" in failed.reason
