"""Wear depth.

The scar of a rough surface, drawn downwards, early and at the end. The strip shows stick and slip.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
point = summary.sel(normal_load=40, roughness_amplitude=2e-7, plastic_limit=4.5e9)
case = fretwear.open_case(f"results/gallery/cases/{point['case_id'].item()}.nc")
figure = fretwear.figures.field_profiles(case, "wear_depth")
