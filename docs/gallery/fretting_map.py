"""A fretting map.

Partial, mixed and gross slip over load and displacement; dots grow with the wear volume.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/rig/summary.nc")
figure = fretwear.figures.fretting_map(summary)
