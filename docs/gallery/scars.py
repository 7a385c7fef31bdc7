"""Scars of both bodies.

Wear of the sphere upwards and of the flat, here twice as fast, downwards.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/rig/summary.nc")
point = summary.sel(normal_load=20, displacement_amplitude=2.4e-6)
case = fretwear.open_case(f"results/rig/cases/{point['case_id'].item()}.nc")
figure = fretwear.figures.scars(case)
