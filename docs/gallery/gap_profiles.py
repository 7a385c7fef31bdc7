"""Gap around the edge of the contact.

The contact grows outwards as its slip zone wears.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
point = summary.sel(normal_load=40, roughness_amplitude=0, plastic_limit=float("inf"))
case = fretwear.open_case(f"results/gallery/cases/{point['case_id'].item()}.nc")
figure = fretwear.figures.field_profiles(case, "gap")
