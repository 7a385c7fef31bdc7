"""Shear traction.

The traction along x while the tangential force pulls with +Q. It follows the pressure in the slip
zone and is lower in the stick zone.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
point = summary.sel(normal_load=40, roughness_amplitude=0, plastic_limit=4.5e9)
case = fretwear.open_case(f"results/gallery/cases/{point['case_id'].item()}.nc")
figure = fretwear.figures.shear_profiles(case)
