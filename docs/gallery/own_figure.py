"""Panels in a figure of your own.

Every single-panel figure can be drawn into existing axes.
"""

import matplotlib.pyplot as plt
import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
smooth = summary.sel(roughness_amplitude=0, plastic_limit=4.5e9)
point = smooth.sel(normal_load=40)
case = fretwear.open_case(f"results/gallery/cases/{point['case_id'].item()}.nc")
with fretwear.figures.style_context():
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.5, 2.8), layout="constrained")
fretwear.figures.field_profiles(case, "pressure", cycles=[0, 1000, 7000], ax=left)
fretwear.figures.scalar_history(smooth, "wear_volume", ax=right)
