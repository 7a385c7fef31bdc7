"""Fretting loops.

Tangential force against displacement round a cycle, which dissipates the energy enclosed.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/rig/summary.nc")
point = summary.sel(normal_load=20, displacement_amplitude=2.4e-6)
loops = fretwear.open_loops(f"results/rig/cases/{point['case_id'].item()}.nc")
figure = fretwear.figures.fretting_loops(loops)
