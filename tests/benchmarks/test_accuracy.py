"""Cases that ask for an accuracy are judged by runs on far narrower cells."""

from itertools import islice

from benchmarks.accuracy import COUNT, KINDS, cases, compared, costs_figure, costs_text
from benchmarks.verification.coverage import CYCLES, FAMILIES


def test_a_case_of_each_family_comes_first_and_a_smooth_one_keeps_its_accuracy():
    drawn = list(islice(cases(), COUNT))
    first = [name.split(",")[0] for name, *_ in drawn[: len(FAMILIES)]]
    assert sorted(first) == sorted(FAMILIES)
    assert len({name for name, *_ in drawn}) == COUNT == 60
    _, case, true = drawn[0]
    asked = case.replace(accuracy=0.02, output_cycles=[int(cycle) for cycle in CYCLES])
    errors, estimates, told, spent = compared(asked, true)
    assert not told
    assert 0.0 < max(errors.values()) < 0.02
    assert all(errors[name] <= max(estimates[name], 1e-4) for name in errors)
    assert spent < 1.1


def test_the_cost_of_each_accuracy_is_drawn_in_units_of_the_default_run():
    def of_run(accuracy, seconds, error):
        about = {"accuracy": accuracy, "seconds": seconds, "told": accuracy == 0.005}
        return about | {"error": error, "estimate": 2.0 * error}

    runs = [of_run(None, 2.0, 0.01), of_run(0.02, 1.0, 0.015), of_run(0.005, 14.0, 0.006)]
    data = {"kinds": [{"name": f"{kind}, sphere", "runs": runs} for kind in KINDS]}
    text = costs_text(data)
    assert "| rough capped | 0.5 %, not reached | 14 | 7 | 0.6 % | 1.2 % |" in text
    figure = costs_figure(data)
    lines = [line for line in figure.axes[0].lines if len(line.get_xdata()) == 2]
    assert len(lines) == len(KINDS)
    assert list(lines[0].get_xdata()) == [0.5, 7.0]
    assert [round(value, 3) for value in lines[0].get_ydata()] == [1.5, 0.6]
