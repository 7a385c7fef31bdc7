"""Wear volume.

All cases of a study on logarithmic axes.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
figure = fretwear.figures.scalar_history(summary, "wear_volume")
