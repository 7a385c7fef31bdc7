"""Figures of a rig."""

import numpy as np
import xarray as xr

from fretwear import figures

LOADS = [10.0, 20.0, 35.0, 50.0, 75.0, 100.0, 150.0, 200.0]
WAYS = [2e-7, 4e-7, 6e-7, 8e-7, 1.2e-6, 1.6e-6, 2.4e-6, 3.2e-6]


def test_dots_of_a_crowded_fretting_map_do_not_overlap():
    load, way = np.meshgrid(LOADS, WAYS, indexing="ij")
    dims = ("load", "displacement_amplitude")
    summary = xr.Dataset(
        {
            "status": (dims, np.zeros(load.shape, dtype="int8")),
            "regime": ((*dims, "cycle"), np.where(way < 1e-6, 0.0, 1.0)[..., None]),
            "wear_volume": ((*dims, "cycle"), np.full((*load.shape, 1), 1e-13)),
        },
        {"load": LOADS, "displacement_amplitude": WAYS, "cycle": [1000.0]},
    )
    figure = figures.fretting_map(summary)
    (axes,) = figure.axes
    assert axes.get_ylabel() == "Normal load (N)"
    of_lines = summary.assign_coords(load=("load", 1e3 * np.array(LOADS), {"units": "N m-1"}))
    of_lines["wear_volume"] = of_lines.wear_volume.assign_attrs(units="m2")
    (line,) = figures.fretting_map(of_lines).axes
    assert line.get_ylabel() == "Normal load per length (N/mm)"
    assert "wear volume per length" in line.get_title("left")
    assert "100" in [tick.get_text() for tick in line.get_yticklabels()]
    assert [each.get_label() for each in axes.collections] == ["partial slip", "gross slip"]
    figure.draw_without_rendering()
    for at, values in ((0, WAYS), (1, LOADS)):
        ticks = (axes.xaxis, axes.yaxis)[at].get_ticklocs()
        assert len(ticks) == len(values)
        points = np.full((len(ticks), 2), 10.0)
        points[:, at] = ticks
        apart = np.diff(axes.transData.transform(points)[:, at]).min() * 72.0 / figure.dpi
        for dots in axes.collections:
            assert 2.0 < np.sqrt(dots.get_sizes().max()) < apart
