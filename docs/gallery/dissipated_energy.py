"""Energy dissipated in one cycle.

It vanishes where the worn shape sticks everywhere, and grows where the stick zone shrinks.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
figure = fretwear.figures.dissipated_energy(summary)
