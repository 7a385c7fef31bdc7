"""Width of the stick zone.

It shrinks if its edge yields, and hardly changes if not; at the width of one journal column.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
figure = fretwear.figures.scalar_history(
    summary.sel(normal_load=40), "stick_half_width_x", columns=1
)
