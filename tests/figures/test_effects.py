"""Figures of effects show every pair of cases, and what a design cannot show is refused."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import qmc

from fretwear.figures.effects import (
    effect_map,
    effects,
    parallel_coordinates,
    scatter_matrix,
    sensitivity,
)


def drawn(count):
    """Return a sampled study whose wear volume is a power law."""
    unit = qmc.Sobol(2, seed=1).random(count)
    load, friction = 10.0 + 40.0 * unit[:, 0], 0.2 + 0.6 * unit[:, 1]
    volume = 1e-16 * load**2 * friction
    return xr.Dataset(
        {
            "status": ("point", np.zeros(count, dtype="int8")),
            "wear_volume": (("point", "cycle"), np.stack([0 * load, volume], axis=1)),
        },
        {
            "case_id": ("point", [str(place) for place in range(count)]),
            "cycle": [0.0, 100.0],
            "load": ("point", load, {"drawn_from": 10.0, "drawn_to": 50.0, "drawn_on": "linear"}),
            "friction": (
                "point",
                friction,
                {"drawn_from": 0.2, "drawn_to": 0.8, "drawn_on": "linear"},
            ),
        },
    )


def test_a_line_joins_every_two_cases_that_differ_in_one_parameter(small_study, check_texts):
    summary = small_study.summary
    figure = effects(summary, ["wear_volume"])
    check_texts(figure)
    final = summary["wear_volume"].isel(cycle=-1)
    for axes, dim in zip(figure.axes, final.dims, strict=True):
        drawn = [each.get_ydata() for each in axes.get_lines() if each.get_label() == "_lines"]
        values = np.concatenate(drawn)
        assert np.isnan(values).sum() == final.size // final.sizes[dim]
        paths, expected = np.sort(values[np.isfinite(values)]), np.sort(final.values, axis=None)
        np.testing.assert_allclose(paths / paths.max(), expected / expected.max())
    one = small_study.summary.isel(load=0, friction=0, roughness_amplitude=0, plastic_limit=0)
    with pytest.raises(ValueError, match="varies nothing"):
        effects(one)
    with pytest.raises(ValueError, match="two parameters"):
        effect_map(drawn(32))
    with pytest.raises(ValueError, match="sampled study"):
        sensitivity(small_study.summary)


def test_a_heat_map_has_the_final_values_over_both_parameters(small_study):
    part = small_study.summary.isel(friction=0, plastic_limit=0)
    (axes, _) = effect_map(part).axes
    (image,) = axes.images
    shown, expected = np.asarray(image.get_array()), part["wear_volume"].isel(cycle=-1).values
    ratio = shown / (expected if shown.shape == expected.shape else expected.T)
    np.testing.assert_allclose(ratio, ratio[0, 0])


def test_indices_of_a_sample_are_drawn_with_their_convergence():
    figure = sensitivity(drawn(64))
    _, curves = figure.axes
    assert len(curves.lines) == 2
    assert [line.get_xdata().tolist() for line in curves.lines] == [[16, 32, 64]] * 2
    assert curves.lines[0].get_ydata()[-1] > curves.lines[1].get_ydata()[-1]
    lines = parallel_coordinates(drawn(64)).axes[0].collections[0]
    assert len(lines.get_paths()) == 64


def test_a_scatter_matrix_has_every_two_parameters_and_the_result():
    summary = drawn(32)
    figure = scatter_matrix(summary)
    pairs, by_load, by_friction, _ = figure.axes
    final = summary["wear_volume"].values[:, -1]
    for axes, (x, y) in {
        pairs: ("load", "friction"),
        by_load: ("load", None),
        by_friction: ("friction", None),
    }.items():
        (dots,) = axes.collections
        points, values = np.asarray(dots.get_offsets()), np.asarray(dots.get_array())
        np.testing.assert_allclose(points[:, 0], summary[x].values)
        np.testing.assert_allclose(values / values.max(), final / final.max())
        np.testing.assert_allclose(points[:, 1], summary[y].values if y else values)
    with pytest.raises(ValueError, match="two varied parameters"):
        scatter_matrix(summary.assign_coords(load=("point", np.full(32, 20.0))))
