"""Wear in one cycle.

At first the middle of the slip zone wears fastest; later the whole zone wears alike, and only as
fast as the stick zone lets it.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
point = summary.sel(normal_load=40, roughness_amplitude=0, plastic_limit=4.5e9)
case = fretwear.open_case(f"results/gallery/cases/{point['case_id'].item()}.nc")
figure = fretwear.figures.wear_rate_profiles(case, cycles=[0, 100, 1000, 7000])
