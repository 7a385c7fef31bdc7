"""Fretting loops.

Tangential force against displacement over a cycle; the enclosed area is the dissipated energy.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/rig/summary.nc")
point = summary.sel(normal_load=20, displacement_amplitude=2.4e-6)
loops = fretwear.open_loops(f"results/rig/cases/{point['case_id'].item()}.nc")
figure = fretwear.figures.fretting_loops(loops)
