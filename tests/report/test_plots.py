"""Cells of the matrix and curves of the report have the numbers of the study."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import qmc

from fretwear.data.effects import Points, effects_table
from fretwear.report import answer_text
from fretwear.report.matrix import build_matrix
from fretwear.report.plots import courses, curve, explorer, log_ticks

from ..data.test_effects import listed
from ..studies import sampled

LOADS, LEVELS = np.array([10.0, 20.0, 80.0]), {"load": [10.0, 20.0, 80.0], "friction": [0.3, 0.6]}


@pytest.fixture
def crossing():
    """Volumes P/N µm³ at µ = 0.3, their inverse at µ = 0.6."""
    points = Points.of(listed(1e-18 * LOADS[:, None] ** np.array([1.0, -1.0]), LEVELS))
    return points, effects_table(points)


def test_a_cell_has_the_mean_factor_its_range_and_a_mark_where_directions_differ(crossing):
    matrix = build_matrix(*crossing)
    (row,) = matrix.rows
    load, friction = row.cells
    assert matrix.columns[0] == ("Normal load", "10 N → 80 N")
    assert (load.text, load.spread, load.is_opposed, load.shade) == ("×1.00", "0.12–8.00", True, 0)
    # P⁻² of 10, 20 and 80 N: 1/100, 1/400 and 1/6400.
    assert (friction.text, friction.spread) == ("×0.0016", "0.00016–0.01")
    assert (friction.grows, friction.is_opposed) == (False, False)
    assert matrix.opening == load  # though friction changes the volume more
    assert row.values == "0.0125 µm³ to 80 µm³"


def test_a_curve_runs_through_the_values_of_each_level(crossing):
    figure = curve(*crossing, "wear_volume", "load")
    assert [trace["name"] for trace in figure["data"]] == ["0.3  ×8.00", "0.6  ×0.13"]
    for trace, power in zip(figure["data"], (1.0, -1.0), strict=True):
        assert trace["x"] == [10.0, 20.0, 80.0]
        assert trace["y"] == pytest.approx(LOADS**power, rel=1e-3)
    assert figure["layout"]["xaxis"]["title"]["text"] == "Normal load (N)"


def test_the_key_of_a_curve_has_the_mean_factor_and_the_range_over_the_other_parameters():
    powers = np.array([[1.0, 2.0], [-1.0, -2.0]])  # of the load, by friction and radius
    levels = {**LEVELS, "radius": [1e-3, 2e-3]}
    points = Points.of(listed(1e-18 * LOADS[:, None, None] ** powers, levels))
    lines = curve(points, effects_table(points), "wear_volume", "load")["data"]
    named = [line["name"] for line in lines if "name" in line]
    assert named == ["0.3  ×22.6 (8.00–64)", "0.6  ×0.044 (0.016–0.12)"]  # 8^1.5 and its inverse


def test_a_sampled_study_has_shares_of_the_variance_and_dots():
    unit = qmc.LatinHypercube(2, seed=3).random(64)
    points = Points.of(sampled(unit, 1e-18 * np.exp(2.0 * unit[:, 0] - unit[:, 1])))
    matrix = build_matrix(points, effects_table(points))
    load, friction = matrix.rows[0].cells
    # The logarithm is a sum with variances 4/12 and 1/12.
    assert (load.text, friction.text) == ("80\xa0%", "20\xa0%")
    assert (load.grows, friction.grows) == (True, False)
    # ρ of 2a − b: shares of the variance and rank correlations stand in tables of their own.
    assert [words for words, _ in matrix.tables] == [
        "Share of the variance (95 % interval)",
        "Rank correlation",
    ]
    assert all(cell.text.startswith("ρ") for cell in matrix.ranks[0].cells)
    rows = json.loads(answer_text(effects_table(points), points))
    assert [row["parameter"] for row in rows] == ["load", "friction"]
    for row, share in zip(rows, (0.8, 0.2), strict=True):
        assert row["total_low"] < share < row["total_high"]
        assert row["total_high"] - row["first_low"] < 0.1
        assert (row["from"], row["to"]) == (0.0, 1.0)
    reference = Path(__file__).parents[2] / "docs/reference/dataset.md"
    assert all(f"`{key}`" in reference.read_text(encoding="utf-8") for key in rows[0])
    (dots,) = curve(points, effects_table(points), "wear_volume", "load")["data"]
    assert len(dots["x"]) == 64
    assert dots["mode"] == "markers"


def test_a_result_of_a_sample_over_the_cycles_has_the_curve_of_every_dot():
    unit = qmc.LatinHypercube(2, seed=3).random(16)
    summary = sampled(unit, 1e-18 * (1.0 + 99.0 * unit[:, 0]))
    points, history = Points.of(summary), summary.rename_dims(cycle="step")
    (dots,) = curve(points, effects_table(points), "wear_volume", "load")["data"]
    figure = courses(points, history, "wear_volume")
    assert figure["layout"]["title"]["text"] == "Wear volume (µm³)"
    for case_id, volume in zip(dots["customdata"], dots["y"], strict=True):
        assert figure["curves"][case_id] == {"x": [100.0], "y": [volume]}
    *_, median, chosen = figure["data"]
    assert median["y"] == pytest.approx([np.median(dots["y"])], rel=1e-3)
    assert chosen["x"] == []
    assert figure["layout"]["xaxis"]["range"][1] > 2.0  # room for the label of the last cycle


@pytest.mark.parametrize("span", [(2.1, 90.0), (3.0, 30.0), (1.0, 9.0), (0.3, 5e4)])
def test_a_logarithmic_axis_has_at_least_three_ticks(span):
    ticks = np.array(log_ticks(np.array(span))["tickvals"])
    assert 3 <= ((ticks >= span[0]) & (ticks <= span[1])).sum() <= 7


def test_the_explorer_has_profiles_of_every_case_and_cycle(finished):
    figure = explorer(finished.summary)
    cycles = finished.summary.sizes["cycle"]
    assert len(figure["data"]) == 2 * 3 * cycles
    assert len(figure["cases"]) == int((finished.summary["status"] == 0).sum())
    ends = [*figure["cases"].values()][:: len(figure["cases"]) - 1]
    for traces, first in zip(ends, (0, 3 * cycles), strict=True):
        drawn = figure["data"][first : first + 3 * cycles]
        assert traces == {axis: [trace[axis] for trace in drawn] for axis in "xy"}
    assert len(figure["layout"]["sliders"][0]["steps"]) == cycles
    # The pressure after the last cycle of the case shown first.
    first = finished.summary["pressure_profile"].isel(normal_load=0, friction=1)
    shown = figure["data"][cycles - 1]
    pressure = first.isel(plastic_limit=0, cycle=-1).sel(
        x=1e-6 * np.array(shown["x"]), method="nearest"
    )
    assert float(pressure.max()) > 1e8
    np.testing.assert_allclose(1e6 * np.array(shown["y"]), pressure, rtol=1e-3)
