"""Any field along the direction of slip.

Here the plastic depth, the permanent sinking since the first loading.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
point = summary.sel(normal_load=40, roughness_amplitude=0, plastic_limit=4.5e9)
case = fretwear.open_case(f"results/gallery/cases/{point['case_id'].item()}.nc")
figure = fretwear.figures.field_profiles(case, "plastic_depth")
