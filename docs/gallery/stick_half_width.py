"""Width of the stick zone.

It shrinks if its edge yields, and stays the same to the last bit if not. This is a part of the
study, over one column of a journal.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
figure = fretwear.figures.scalar_history(
    summary.sel(normal_load=40), "stick_half_width_x", columns=1
)
