"""Sobol indices agree with closed forms, and say how well they are known."""

import math

import numpy as np
import pytest
import xarray as xr
from scipy.stats import qmc, spearmanr

from fretwear.data.effects import Points, _terms, _within, rank_correlations, sobol_indices
from fretwear.vocabulary import PointStatus

from ..studies import near, sampled

FIRST, TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)
"""Sobol indices of Ishigami's function with a = 7 and b = 0.1 (Ishigami and Homma 1990)."""


def ishigami(unit):
    x = np.pi * (2.0 * unit - 1.0)
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def test_an_expansion_has_all_products_of_a_degree_and_fewer_where_interactions_cost_more():
    """C(d + p, p) products of degree p of d variables; powers of one variable in any norm."""
    pure = {(5, 0, 0), (0, 5, 0), (0, 0, 5)}
    whole, hyperbolic = (_terms(5, norm, (9, 9, 9)) for norm in (1.0, 0.5))
    assert len(whole) == len({*whole}) == math.comb(3 + 5, 5)
    assert pure < {*hyperbolic} < {*whole}


@pytest.mark.parametrize("engine", [qmc.Sobol, qmc.LatinHypercube])
def test_indices_of_ishigami_are_those_of_the_closed_form(engine):
    unit = engine(3, seed=1).random(4096)
    found = Points.of(sampled(unit, ishigami(unit))).indices["wear_volume"]
    assert not found.of_logarithm
    assert found.first == pytest.approx(FIRST, abs=0.002)
    assert found.total == pytest.approx(TOTAL, abs=0.002)
    assert found.quality > 0.9999


def test_indices_settle_their_intervals_hold_the_closed_form_and_noise_tells_nothing():
    errors = []
    for count in (128, 512):
        unit = qmc.Sobol(3, seed=2).random(count)
        (found,) = sobol_indices(unit, ishigami(unit)[:, None])
        errors.append(np.abs(found.total - TOTAL).max())
        margin = 0.01 if count == 512 else 0.05
        for exact, (low, high) in zip(TOTAL, found.total_range.T, strict=True):
            assert low - margin <= exact <= high + margin
        # Alone, the third has no effect: noise counts for none.
        assert found.first_range[0, 2] == 0.0
    assert errors[1] < errors[0]
    unit = qmc.Sobol(3, seed=4).random(16)
    noise = np.random.default_rng(5).standard_normal((16, 1))
    assert sobol_indices(unit, noise)[0].quality < 0.5


def test_indices_of_listed_values_are_those_of_the_variance_of_the_levels():
    unit = qmc.Sobol(2, seed=3).random(512)
    levels = np.array([0.0, 1.0, 5.0])
    values = levels[(3 * unit[:, 1]).astype(int)] + 2.0 * unit[:, 0]
    (found,) = sobol_indices(unit, values[:, None], (0, 3))
    parts = np.array([4.0 / 12.0, levels.var()])
    assert found.first == pytest.approx(parts / parts.sum(), abs=0.01)


def test_rank_correlations_are_those_of_spearman():
    rng = np.random.default_rng(6)
    unit, values = rng.random((40, 2)), rng.integers(0, 5, (40, 3)).astype(float)
    expected = spearmanr(unit, values).statistic[:2, 2:]
    np.testing.assert_allclose(rank_correlations(unit, values), expected, atol=1e-12)


def test_a_power_law_is_told_by_its_logarithm_from_the_summary_of_a_study():
    unit = qmc.Sobol(2, seed=7).random(32)
    load, wear = 10.0 + 40.0 * unit[:, 0], 10.0 ** unit[:, 1]
    points = Points.of(sampled(unit, 1e-13 * load**3 * wear))
    assert list(points.drawn) == ["load", "friction"]
    found = points.indices["wear_volume"]
    assert found.of_logarithm
    # Variance of 3 log P for P even from 10 to 50, by quadrature, and of a logarithm that is even.
    grid = np.log(10.0 + 40.0 * (np.arange(20000) + 0.5) / 20000)
    parts = np.array([9.0 * grid.var(), np.log(10.0) ** 2 / 12.0])
    assert found.first == pytest.approx(parts / parts.sum(), abs=0.005)


def test_an_effect_is_divided_by_the_parameter_on_which_its_factor_depends():
    """Among factors of the same step, however much those of other steps differ."""
    load, exponent = np.array([10.0, 20.0, 80.0])[:, None], np.array([1.0, 1.5])
    points, volume = ("load", "friction"), load**exponent
    summary = xr.Dataset(
        {
            "status": (points, np.zeros(volume.shape, np.int8)),
            "wear_volume": ((*points, "cycle"), np.stack([0.0 * volume, volume], axis=-1)),
        },
        {
            "case_id": (points, np.arange(6).reshape(3, 2).astype(str)),
            "cycle": [0.0, 100.0],
            "load": load[:, 0],
            "friction": [0.3, 0.6],
        },
    )
    assert Points.of(summary).effect("load", "wear_volume").divider == "friction"


def test_an_effect_keeps_no_more_pairs_than_points_and_finds_those_of_any_two_levels():
    """Of 300 levels, 45 000 pairs a line would be; the points of the middle level have no value."""
    load, friction = np.linspace(10.0, 40.0, 300), np.array([0.3, 0.6])
    points, volume = ("load", "friction"), load[:, None] * friction
    status = np.where(np.arange(300) == 150, np.int8(PointStatus.INVALID), np.int8(0))
    summary = xr.Dataset(
        {
            "status": (points, np.tile(status[:, None], 2)),
            "wear_volume": ((*points, "cycle"), np.stack([0.0 * volume, volume], axis=-1)),
        },
        {
            "case_id": (points, np.arange(600).reshape(300, 2).astype(str)),
            "cycle": [0.0, 100.0],
            "load": load,
            "friction": friction,
        },
    )
    effect = Points.of(summary).effect("load", "wear_volume")
    assert effect.low.size == 2 * 298
    assert effect.factors.max() == near(4.0)
    # Levels are those of finished points: the 200th is the 201st of the study.
    assert effect.between(50, 200).factors == near(load[201] / load[50])
    assert effect.between(50, 200).low.size == 2


def test_the_rest_of_a_variance_within_groups_is_that_about_their_means():
    values, groups = np.random.default_rng(6).standard_normal(60), np.arange(60) % 7 * 3
    expected = sum(values[groups == g].var() * (groups == g).sum() for g in np.unique(groups))
    assert _within(values, groups) == near(expected)
