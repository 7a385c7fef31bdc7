"""Cases that ask for an accuracy are judged by runs on far narrower cells."""

from benchmarks.accuracy import cases, compared
from benchmarks.verification.coverage import CYCLES, FAMILIES


def test_a_case_of_each_family_comes_first_and_a_smooth_one_keeps_its_accuracy():
    drawn = list(cases())
    first = [name.split(",")[0] for name, *_ in drawn[: len(FAMILIES)]]
    assert sorted(first) == sorted(FAMILIES)
    assert len(drawn) == sum(FAMILIES.values())
    _, case, true = drawn[0]
    asked = case.replace(accuracy=0.02, output_cycles=[int(cycle) for cycle in CYCLES])
    errors, estimates, told, spent = compared(asked, true)
    assert not told
    assert 0.0 < max(errors.values()) < 0.02
    assert all(errors[name] <= max(estimates[name], 1e-4) for name in errors)
    assert spent < 1.1
