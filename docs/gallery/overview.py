"""Overview of one case.

The figure of `fretwear plot`: profiles, scar, and zones over the cycles.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
point = summary.sel(normal_load=40, roughness_amplitude=2e-7, plastic_limit=4.5e9)
file = f"results/gallery/cases/{point['case_id'].item()}.nc"
figure = fretwear.figures.overview(fretwear.open_case(file))
