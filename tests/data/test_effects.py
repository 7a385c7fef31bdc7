"""Factors between pairs of cases are those worked out by hand; Sobol indices are closed forms."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import qmc

from fretwear.data.effects import SEED, Points, effects_table, sobol_indices

from ..studies import near, sampled

FIRST, TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)
"""Sobol indices of Ishigami's function with a = 7 and b = 0.1 (Ishigami and Homma 1990)."""


def ishigami(unit):
    x = np.pi * (2.0 * unit - 1.0)
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


@pytest.mark.parametrize("engine", [qmc.Sobol, qmc.LatinHypercube])
def test_indices_of_ishigami_are_those_of_the_closed_form(engine):
    unit = engine(3, seed=1).random(512)
    found = Points.of(sampled(unit, ishigami(unit))).indices["wear_volume"]
    assert found.first == pytest.approx(FIRST, abs=0.01)
    assert found.total == pytest.approx(TOTAL, abs=0.01)
    assert found.quality > 0.98


def test_noise_tells_nothing():
    unit = qmc.Sobol(3, seed=4).random(16)
    noise = np.random.default_rng(5).standard_normal((16, 1))
    assert sobol_indices(unit, noise)[0].quality < 0.5


def test_indices_of_listed_values_are_those_of_the_variance_of_the_levels():
    unit = qmc.Sobol(2, seed=3).random(512)
    levels = np.array([0.0, 1.0, 5.0])
    place = (3 * unit[:, 1]).astype(int)
    values = levels[place] + 2.0 * unit[:, 0]
    # Points of a study lie in the middle of the part of their level.
    points = np.column_stack([unit[:, 0], (place + 0.5) / 3])
    (found,) = sobol_indices(points, values[:, None], (0, 3))
    parts = np.array([4.0 / 12.0, levels.var()])
    assert found.first == pytest.approx(parts / parts.sum(), abs=0.01)


def test_a_power_law_is_told_by_its_logarithm_from_the_summary_of_a_study():
    unit = qmc.Sobol(2, seed=7).random(32)
    load, wear = 10.0 + 40.0 * unit[:, 0], 10.0 ** unit[:, 1]
    points = Points.of(sampled(unit, 1e-13 * load**3 * wear))
    assert list(points.drawn) == ["load", "friction"]
    found = points.indices["wear_volume"]
    # Variance of 3 log P for P even from 10 to 50, by quadrature, and of a logarithm that is even.
    grid = np.log(10.0 + 40.0 * (np.arange(20000) + 0.5) / 20000)
    parts = np.array([9.0 * grid.var(), np.log(10.0) ** 2 / 12.0])
    assert found.first == pytest.approx(parts / parts.sum(), abs=0.005)


def listed(volume, levels, status=0, ids=None):
    """A merged study of listed values, with wear volumes after the last cycle."""
    dims, shape = tuple(levels), volume.shape
    ids = np.arange(volume.size).astype(str).reshape(shape) if ids is None else ids
    return xr.Dataset(
        {
            "status": (dims, np.broadcast_to(np.int8(status), shape).copy()),
            "wear_volume": ((*dims, "cycle"), np.stack([0.0 * volume, volume], axis=-1)),
        },
        {"case_id": (dims, ids), "cycle": [0.0, 100.0], **levels},
    )


def test_factors_run_from_the_first_to_the_last_level_and_split_where_they_depend_on_another():
    """Volumes P at µ = 0.3, 1/P at µ = 0.6; the level between does not count."""
    load = np.array([10.0, 20.0, 80.0])
    summary = listed(load[:, None] ** np.array([1.0, -1.0]), {"load": load, "friction": [0.3, 0.6]})
    table = effects_table(Points.of(summary))
    of_load = table[table["parameter"] == "load"].to_dict("records")
    whole, *parts = of_load
    assert (whole["result"], whole["from"], whole["to"], whole["where"]) == (
        "wear_volume", 10.0, 80.0, {},
    )  # fmt: skip
    assert (whole["pairs"], whole["undefined"]) == (2, 0)
    assert whole["factor"] == near(1.0)
    assert (whole["lowest_factor"], whole["highest_factor"]) == (near(1 / 8), near(8.0))
    assert [(part["where"], part["factor"]) for part in parts] == [
        ({"friction": 0.3}, near(8.0)),
        ({"friction": 0.6}, near(1 / 8)),
    ]
    (friction,) = table[table["parameter"] == "friction"].query("pairs == 3").to_dict("records")
    # Geometric mean of P⁻² over the loads.
    assert friction["factor"] == near(float(np.exp(-2.0 * np.log(load).mean())))


@pytest.mark.parametrize(
    ("others", "factor", "rows"), [(1, 1.04, 1), (1, 1.06, 3), (3, 2.0, 3), (4, 2.0, 1)]
)
def test_a_factor_splits_if_it_spreads_by_5_percent_and_one_parameter_explains_30(
    others, factor, rows
):
    """Of parameters that change it alike, one of three explains a third, one of four a quarter."""
    names = ["load", *"abcd"[:others]]
    steps = sum(np.meshgrid(*[[0, 1]] * others, indexing="ij"))
    volume = np.stack([1.0 + 0.0 * steps, factor ** (steps / others)])
    table = effects_table(Points.of(listed(volume, {name: [1.0, 2.0] for name in names})))
    assert (table["parameter"] == "load").sum() == rows


def test_zeros_appear_and_vanish_and_points_without_results_make_no_pairs():
    volume = np.array([[0.0, 1.0], [2.0, 0.0], [3.0, 6.0], [0.0, 0.0], [1.0, np.nan]])
    status = np.array([[0, 0], [0, 0], [0, 0], [0, 0], [0, 1]])
    summary = listed(volume, {"friction": [0.1, 0.2, 0.3, 0.4, 0.5], "load": [20.0, 40.0]}, status)
    table = effects_table(Points.of(summary))
    row = table[(table["parameter"] == "load") & (table["where"].map(len) == 0)].iloc[0]
    assert (row["pairs"], row["undefined"], row["appears"], row["vanishes"]) == (4, 3, 1, 1)
    assert row["factor"] == row["lowest_factor"] == row["highest_factor"] == near(2.0)


def test_points_that_share_a_case_count_once():
    """A slope means nothing on a smooth surface: both slopes of it are one case."""
    ids = np.array([["smooth", "smooth"], ["rough a", "rough b"]])
    volume = np.array([[2.0, 2.0], [4.0, 6.0]])
    levels = {"roughness_amplitude": [0.0, 1e-7], "roughness_slope_x": [0.1, 0.2]}
    table = effects_table(Points.of(listed(volume, levels, ids=ids)))
    pairs = table[table["where"].map(len) == 0].set_index("parameter")["pairs"]
    assert dict(pairs) == {"roughness_amplitude": 2, "roughness_slope_x": 1}


def test_seeds_are_compared_with_their_mean():
    volume = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0]])
    summary = listed(volume, {"load": [20.0, 40.0], SEED: [1.0, 2.0, 3.0]})
    table = effects_table(Points.of(summary))
    (row,) = table[table["parameter"] == SEED].to_dict("records")
    assert np.isnan([row["from"], row["to"]]).all()
    assert row["pairs"] == 6
    assert (row["lowest_factor"], row["highest_factor"]) == (near(0.5), near(1.5))
