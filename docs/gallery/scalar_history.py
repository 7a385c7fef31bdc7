"""Any result over the cycles.

Here the mean pressure in the stick zone, which carries more and more of the load.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
history = fretwear.open_history("results/gallery/summary.nc")
figure = fretwear.figures.scalar_history(summary, "mean_stick_pressure", history)
